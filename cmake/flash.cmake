# SPDX-License-Identifier: MIT
# Targets `flash` (avrdude through the Arduino boot loader) and `size` of a cross build. The port is
# known only when the target runs, so `flash` runs this same file as a script:
#     cmake --build --preset mega --target flash
#     PIXSTEP_PORT=/dev/ttyACM1 cmake --build --preset mega --target flash
if(NOT CMAKE_SCRIPT_MODE_FILE)
    set(PIXSTEP_PORT ""
        CACHE STRING
        "Serial port of the board; empty: $PIXSTEP_PORT, or the only one there"
    )
    set(image pixstep-${PIXSTEP_BOARD})
    add_custom_target(
        flash
        COMMAND "${CMAKE_COMMAND}" "-DIMAGE=$<TARGET_FILE_DIR:${image}>/${image}.hex"
                -DBOARD=${PIXSTEP_BOARD} "-DPORT=${PIXSTEP_PORT}" -P "${CMAKE_CURRENT_LIST_FILE}"
        DEPENDS ${image}
        USES_TERMINAL VERBATIM
    )
    find_program(PIXSTEP_AVR_SIZE avr-size)
    add_custom_target(
        size
        COMMAND "${PIXSTEP_AVR_SIZE}" "$<TARGET_FILE:${image}>"
        DEPENDS ${image}
        USES_TERMINAL VERBATIM
    )
    return()
endif()

if(NOT PORT)
    set(PORT "$ENV{PIXSTEP_PORT}")
endif()
if(NOT PORT)
    file(GLOB ports /dev/ttyACM* /dev/ttyUSB*)
    list(LENGTH ports count)
    if(NOT count EQUAL 1)
        message(FATAL_ERROR "flash: ${count} serial ports found (${ports}): name the board's one, "
                            "as in PIXSTEP_PORT=/dev/ttyACM0")
    endif()
    set(PORT "${ports}")
endif()

include("${CMAKE_CURRENT_LIST_DIR}/board.cmake")
pixstep_read_board(${BOARD})
find_program(AVRDUDE avrdude)
if(NOT AVRDUDE)
    message(FATAL_ERROR "flash: avrdude is missing: run tools/setup, or install it")
endif()
message(STATUS "flash: ${IMAGE} to the ${BOARD} on ${PORT}")
execute_process(
    COMMAND "${AVRDUDE}" -p ${BOARD_AVRDUDE_PART} -c ${BOARD_AVRDUDE_PROGRAMMER}
            -b ${BOARD_AVRDUDE_BAUD} -P "${PORT}" -D -U "flash:w:${IMAGE}:i"
    RESULT_VARIABLE failed
)
if(failed)
    message(FATAL_ERROR "flash: avrdude failed (exit status ${failed})")
endif()
