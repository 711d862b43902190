# SPDX-License-Identifier: MIT
# One warning list for every compiler. Code of this project links `pixstep_warnings`; code of others
# (Unity) does not. avr-gcc 5.4, 7.3 and 14.2 must all stay silent: warnings that avr-gcc 5.4 does
# not know are asked for on the host only.
option(PIXSTEP_WERROR "A warning is an error" ON)

add_library(pixstep_warnings INTERFACE)
target_compile_options(
    pixstep_warnings
    INTERFACE
        -Wall
        -Wextra
        -Wpedantic
        -Wconversion
        -Wsign-conversion
        -Wshadow
        -Wundef
        -Wstrict-prototypes
        -Wmissing-prototypes
        -Wdouble-promotion
        -Wfloat-equal
        -Wcast-qual
        -Wpointer-arith
        -Wvla
        -Wswitch-enum
        -Wwrite-strings
        -Wformat=2
        $<$<BOOL:${PIXSTEP_WERROR}>:-Werror>
        $<$<C_COMPILER_ID:GNU>:-Wlogical-op>
)

if(CMAKE_CROSSCOMPILING)
    # Dead functions leave the image; the linker drops the sections (see avr.cmake).
    add_compile_options(-ffunction-sections -fdata-sections)
    # From version 12 on the compiler takes a register's fixed low address for an offset from a null
    # pointer, and warns of an array bound at every register access.
    if(CMAKE_C_COMPILER_VERSION VERSION_GREATER_EQUAL 12)
        add_compile_options(--param=min-pagesize=0)
    endif()
elseif(CMAKE_C_COMPILER_ID STREQUAL "GNU")
    target_compile_options(
        pixstep_warnings INTERFACE -Wduplicated-cond -Wduplicated-branches -Wimplicit-fallthrough
                                   -Wnull-dereference
    )
endif()
