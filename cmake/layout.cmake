# SPDX-License-Identifier: MIT
# layout.h: what the assembly has to know of C's structs and constants (firmware/avr/layout.c). The
# compiler makes assembly of that file; each line there of the form `;layout NAME value` becomes a
# #define. As a script this file does the second half:
#     cmake -DFROM=<assembly> -DTO=<header> -P layout.cmake
if(CMAKE_SCRIPT_MODE_FILE)
    file(STRINGS "${FROM}" lines REGEX "^;layout [A-Z0-9_]+ -?[0-9]+$")
    if(NOT lines)
        message(FATAL_ERROR "${FROM}: no layout in it")
    endif()
    list(TRANSFORM lines REPLACE "^;layout ([A-Z0-9_]+) (-?[0-9]+)$" "#define \\1 \\2")
    list(JOIN lines "\n" text)
    set(head "// Made of firmware/avr/layout.c (cmake/layout.cmake).\n#pragma once\n")
    file(CONFIGURE OUTPUT "${TO}" CONTENT "${head}\n${text}\n" @ONLY)
    return()
endif()

# pixstep_layout(<name> <definition>...): make the header for sources that are compiled with these
# definitions. Target <name>_header brings it up to date; PIXSTEP_LAYOUT_FOLDER has it.
function(pixstep_layout name)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/${name}")
    add_library(${name} OBJECT "${CMAKE_SOURCE_DIR}/firmware/avr/layout.c")
    target_include_directories(
        ${name} PRIVATE "${CMAKE_SOURCE_DIR}/firmware" "${CMAKE_SOURCE_DIR}/firmware/core"
    )
    target_compile_definitions(${name} PRIVATE ${ARGN})
    # Assembly in the place of an object: nothing for the rules that read objects.
    target_compile_options(${name} PRIVATE -S)
    set_target_properties(${name} PROPERTIES EXPORT_COMPILE_COMMANDS OFF)
    target_link_libraries(${name} PRIVATE pixstep_warnings)
    add_custom_command(
        OUTPUT "${folder}/layout.h"
        COMMAND "${CMAKE_COMMAND}" "-DFROM=$<TARGET_OBJECTS:${name}>" "-DTO=${folder}/layout.h"
                -P "${CMAKE_CURRENT_FUNCTION_LIST_FILE}"
        DEPENDS ${name} $<TARGET_OBJECTS:${name}> "${CMAKE_CURRENT_FUNCTION_LIST_FILE}"
        COMMENT "Layout of structs for the assembly"
        VERBATIM
    )
    add_custom_target(${name}_header DEPENDS "${folder}/layout.h")
    set(PIXSTEP_LAYOUT_FOLDER "${folder}" PARENT_SCOPE)
endfunction()
