# SPDX-License-Identifier: MIT
# Tests of the linked images, handler by handler, on libsimavr (handlers, late). The images are what
# is tested, so that no sanitizer or counter goes beside that.

find_path(SIMAVR_INCLUDE sim_avr.h PATH_SUFFIXES simavr)
find_library(SIMAVR_LIBRARY NAMES libsimavr.a simavr)
find_library(ELF_LIBRARY elf)

# A program that tests the image of a board, of these sources and those of the simulator that read
# an image. Sets `image` to the path of the image.
function(pixstep_image_test test board)
    set(sim "${CMAKE_SOURCE_DIR}/sim")
    add_executable(${test} ${ARGN} "${sim}/grow.c" "${sim}/skips.c" "${sim}/symbols.c")
    target_include_directories(
        ${test}
        PRIVATE "${CMAKE_SOURCE_DIR}/firmware" "${CMAKE_SOURCE_DIR}/firmware/core"
                "${CMAKE_SOURCE_DIR}/host_tests" "${sim}"
    )
    target_include_directories(${test} SYSTEM PRIVATE "${SIMAVR_INCLUDE}")
    target_compile_definitions(${test} PRIVATE "BOARD_FILE=<avr/boards/${board}.def>" _GNU_SOURCE)
    target_compile_options(${test} PRIVATE -O2)
    target_link_libraries(
        ${test} PRIVATE pixstep_warnings "${SIMAVR_LIBRARY}" "${ELF_LIBRARY}" m
    )
    string(TOUPPER "${board}" upper)
    set(image "${PIXSTEP_${upper}_BUILD}/firmware/pixstep-${board}.elf" PARENT_SCOPE)
endfunction()
