# SPDX-License-Identifier: MIT
# What CMake knows about a board: the constants of firmware/avr/boards/<name>.def. The list of
# boards is the list of these files.
set(PIXSTEP_BOARD_FOLDER "${CMAKE_CURRENT_LIST_DIR}/../firmware/avr/boards")

# The size of a step ring (firmware/core/ring/step_ring.h).
set(PIXSTEP_RING_BYTES 512)

# pixstep_read_board(<name>): set each BOARD_... constant of the file, texts without their quotes,
# and what follows from them:
#   BOARD_RINGS_AT, BOARD_DATA_AT   where the step rings and all other data begin in avr-gcc's
#                                   address space; rings lie on 256-byte boundaries
#   BOARD_RUNS_SUITES               the part's RAM holds the Unity suites
#   BOARD_IS_SMALL                  the part's flash holds the firmware only if it is built for size
#   BOARD_DEFINITIONS               the preprocessor's, for core and app
function(pixstep_read_board name)
    set(file "${PIXSTEP_BOARD_FOLDER}/${name}.def")
    if(NOT EXISTS "${file}")
        message(FATAL_ERROR "there is no board '${name}': ${file} is missing")
    endif()
    file(STRINGS "${file}" lines REGEX "^#define BOARD_[A-Z_]+ +[^ ]")
    foreach(line IN LISTS lines)
        string(REGEX MATCH "^#define (BOARD_[A-Z_]+) +\"?([^\"/]*[^\" /])" found "${line}")
        set(constant "${CMAKE_MATCH_1}")
        set(${constant} "${CMAKE_MATCH_2}")
        set(${constant} "${CMAKE_MATCH_2}" PARENT_SCOPE)
    endforeach()

    math(EXPR rings "0x800000 + (${BOARD_RAM_START} + 255) / 256 * 256" OUTPUT_FORMAT HEXADECIMAL)
    math(EXPR data "${rings} + ${PIXSTEP_RING_BYTES} * ${BOARD_AXES}" OUTPUT_FORMAT HEXADECIMAL)
    set(BOARD_RINGS_AT "${rings}" PARENT_SCOPE)
    set(BOARD_DATA_AT "${data}" PARENT_SCOPE)
    set(suites OFF)
    if(BOARD_RAM_BYTES GREATER_EQUAL 8192)
        set(suites ON)
    endif()
    set(BOARD_RUNS_SUITES ${suites} PARENT_SCOPE)
    set(small OFF)
    if(BOARD_FLASH_BYTES LESS 65536)
        set(small ON)
    endif()
    set(BOARD_IS_SMALL ${small} PARENT_SCOPE)
    math(EXPR baud_clock_100 "${BOARD_CPU_HZ} / 800")
    set(grid_edges 16)
    if(BOARD_AXES EQUAL 1)
        set(grid_edges 1)
    endif()
    set(BOARD_DEFINITIONS
        "BOARD_FILE=<avr/boards/${name}.def>" "RECORDS_KEPT=${BOARD_RECORDS}"
        "BAUD_CLOCK_100=${baud_clock_100}u"
        "LOCK_GRID_EDGES=${grid_edges}"
        PARENT_SCOPE
    )
endfunction()

# pixstep_list_boards(<variable>): the names of all boards in the order of their BOARD_ID.
function(pixstep_list_boards variable)
    file(GLOB files RELATIVE "${PIXSTEP_BOARD_FOLDER}" CONFIGURE_DEPENDS
         "${PIXSTEP_BOARD_FOLDER}/*.def")
    set(ordered "")
    foreach(file IN LISTS files)
        get_filename_component(name "${file}" NAME_WE)
        pixstep_read_board("${name}")
        list(APPEND ordered "${BOARD_ID} ${name}")
    endforeach()
    list(SORT ordered COMPARE NATURAL)
    list(TRANSFORM ordered REPLACE "^[0-9]+ " "")
    set(${variable} "${ordered}" PARENT_SCOPE)
endfunction()
