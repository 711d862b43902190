// SPDX-License-Identifier: MIT
#include "hal/avr/pins.h"

#include <avr/io.h>
#include <util/atomic.h> // ports above 0x1F need a read and a write

#include "hal/avr/board.h" // BOARD_FILE
#include "hal/pins.h"      // pins_start

#define OUTPUT_LOW(port, bit)                                                            \
    do {                                                                                 \
        PORT##port &= (uint8_t)~_BV(bit);                                                \
        DDR##port |= (uint8_t)_BV(bit);                                                  \
    } while (0)
#define OUTPUT_HIGH(port, bit)                                                           \
    do {                                                                                 \
        PORT##port |= (uint8_t)_BV(bit);                                                 \
        DDR##port |= (uint8_t)_BV(bit);                                                  \
    } while (0)
#define INPUT_PULLED_UP(port, bit) PORT##port |= (uint8_t)_BV(bit)

#define START_STEP             OUTPUT_LOW
#define START_DIR              OUTPUT_LOW
#define START_ENABLE           OUTPUT_HIGH
#define START_HOME             INPUT_PULLED_UP
#define START_LIMIT_MINUS      INPUT_PULLED_UP
#define START_LIMIT_PLUS       INPUT_PULLED_UP
#define START_PIXEL_CLOCK      INPUT_PULLED_UP
#define START_PIXEL_CLOCK_COPY INPUT_PULLED_UP
#define START_ESTOP            INPUT_PULLED_UP
#define START_RS485_DE         OUTPUT_LOW
#define START_PERMIT           OUTPUT_LOW

// NOLINTNEXTLINE(readability-function-size): two statements for each row of the board file
void pins_start(void)
{
#define BOARD_AXIS(axis, timer)
#define BOARD_PIN(signal, axis, port, bit, header_pin) START_##signal(port, bit);
#include BOARD_FILE
#undef BOARD_PIN
}

// One writer for one signal of a given axis; the board file's other rows expand to nothing.
#define WRITE(port, bit)                                                                 \
    if (high) {                                                                          \
        PORT##port |= (uint8_t)_BV(bit);                                                 \
    } else {                                                                             \
        PORT##port &= (uint8_t)~_BV(bit);                                                \
    }
#define WRITE_CASE(number, port, bit)                                                    \
    case (number):                                                                       \
        WRITE(port, bit)                                                                 \
        break;
#define NO_CASE(number, port, bit)

#define CASE_STEP                                      NO_CASE
#define CASE_HOME                                      NO_CASE
#define CASE_LIMIT_MINUS                               NO_CASE
#define CASE_LIMIT_PLUS                                NO_CASE
#define CASE_PIXEL_CLOCK                               NO_CASE
#define CASE_PIXEL_CLOCK_COPY                          NO_CASE
#define CASE_ESTOP                                     NO_CASE
#define BOARD_PIN(signal, axis, port, bit, header_pin) CASE_##signal(axis, port, bit)

static void write_direction(uint8_t axis, bool high)
{
    switch (CONFIG_INDEX(axis)) {
#define CASE_DIR      WRITE_CASE
#define CASE_ENABLE   NO_CASE
#define CASE_RS485_DE NO_CASE
#define CASE_PERMIT   NO_CASE
#include BOARD_FILE
#undef CASE_DIR
#undef CASE_ENABLE
#undef CASE_RS485_DE
#undef CASE_PERMIT
    default:
        break;
    }
}

static void write_enable(uint8_t axis, bool high)
{
    switch (CONFIG_INDEX(axis)) {
#define CASE_DIR      NO_CASE
#define CASE_ENABLE   WRITE_CASE
#define CASE_RS485_DE NO_CASE
#define CASE_PERMIT   NO_CASE
#include BOARD_FILE
#undef CASE_DIR
#undef CASE_ENABLE
#undef CASE_RS485_DE
#undef CASE_PERMIT
    default:
        break;
    }
}

static void write_rs485(bool high)
{
#define CASE_DIR                       NO_CASE
#define CASE_ENABLE                    NO_CASE
#define CASE_PERMIT                    NO_CASE
#define CASE_RS485_DE(axis, port, bit) WRITE(port, bit)
#include BOARD_FILE
#undef CASE_RS485_DE
#undef CASE_PERMIT
}

static void write_permit(bool high)
{
#define CASE_RS485_DE                NO_CASE
#define CASE_PERMIT(axis, port, bit) WRITE(port, bit)
#include BOARD_FILE
}

// Called in the step interrupt, and from main with the axis at rest.
void pins_write_direction(uint8_t axis, bool negative)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        write_direction(axis, negative);
    }
}

void pins_write_enable(uint8_t axis, bool on)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        write_enable(axis, !on);
    }
}

void pins_write_rs485(bool sending)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        write_rs485(sending);
    }
}

void pins_write_permit(bool on)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        write_permit(on);
    }
}
