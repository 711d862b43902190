// SPDX-License-Identifier: MIT
#include "avr/hal/pins.h"

#include <avr/io.h>
#include <util/atomic.h> // ports above 0x1F need a read and a write

#include "avr/hal/board.h" // BOARD_KEEP
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

#define START_STEP                 OUTPUT_LOW
#define START_DIR                  OUTPUT_LOW
#define START_ENABLE               OUTPUT_HIGH
#define START_HOME                 INPUT_PULLED_UP
#define START_LIMIT_MINUS          INPUT_PULLED_UP
#define START_LIMIT_PLUS           INPUT_PULLED_UP
#define START_PIXEL_CLOCK          INPUT_PULLED_UP
#define START_PIXEL_CLOCK_COPY     INPUT_PULLED_UP
#define START_ESTOP                INPUT_PULLED_UP
#define START_RS485_DE             OUTPUT_LOW
#define START_PERMIT               OUTPUT_LOW
#define START_CLOCK_OUT(port, bit) // left alone until clock_out.c wants it

// NOLINTNEXTLINE(readability-function-size): two statements for each row of the board file
void pins_start(void)
{
#define BOARD_PIN(signal, axis, port, bit, header_pin) START_##signal(port, bit);
#include BOARD_FILE
}

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

static void write_direction(uint8_t axis, bool high)
{
    switch (CONFIG_INDEX(axis)) {
#define WANT_DIR BOARD_WANTED
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(WRITE_CASE(number, port, bit))
#include BOARD_FILE
#undef WANT_DIR
    default:
        break;
    }
}

static void write_enable(uint8_t axis, bool high)
{
    switch (CONFIG_INDEX(axis)) {
#define WANT_ENABLE BOARD_WANTED
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(WRITE_CASE(number, port, bit))
#include BOARD_FILE
#undef WANT_ENABLE
    default:
        break;
    }
}

static void write_rs485(bool high)
{
#define WANT_RS485_DE BOARD_WANTED
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(WRITE(port, bit))
#include BOARD_FILE
#undef WANT_RS485_DE
}

static void write_permit(bool high)
{
#define WANT_PERMIT BOARD_WANTED
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(WRITE(port, bit))
#include BOARD_FILE
#undef WANT_PERMIT
}

// Called in the step interrupt, and in the main loop while the axis is at rest.
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
