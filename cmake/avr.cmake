# SPDX-License-Identifier: MIT
# avr-gcc as a toolchain. The part and its clock come from the file of the preset's board.
include("${CMAKE_CURRENT_LIST_DIR}/board.cmake")
pixstep_read_board("${PIXSTEP_BOARD}")

set(CMAKE_SYSTEM_NAME Generic-ELF)
set(CMAKE_SYSTEM_PROCESSOR avr)

set(CMAKE_C_COMPILER avr-gcc)
set(CMAKE_ASM_COMPILER avr-gcc)

# A test program cannot be linked before the part's start-up code is known: try a library instead,
# and tell the trial project the board.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PIXSTEP_BOARD)

set(part "-mmcu=${BOARD_MCU} -DF_CPU=${BOARD_CPU_HZ}UL -mrelax")
# These registers belong to the step interrupt, which changes them without saving
# (firmware/avr/hal/step_isr.S); the rule `symbols` looks for uses of them in the images.
set(reserved "-ffixed-r2 -ffixed-r3 -ffixed-r4 -ffixed-r5 -ffixed-r6")
set(CMAKE_C_FLAGS_INIT "${part} -fshort-enums ${reserved}")
set(CMAKE_ASM_FLAGS_INIT "${part}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,--gc-sections")

# Programs come from the machine, headers and libraries only from the toolchain.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
