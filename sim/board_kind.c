// SPDX-License-Identifier: MIT
//
// Compiled once for each board file, BOARD_FILE, as the object BOARD_KIND.

#include "board_kind.h"

#include BOARD_FILE

#define TEXT_OF(word) #word
#define TEXT(word)    TEXT_OF(word)

static const struct board_pin pins[] = {
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    {SIGNAL_##signal, (axis), #port[0], (bit)},
#include BOARD_FILE
};

extern const struct board_kind BOARD_KIND;
const struct board_kind BOARD_KIND = {
    .name = BOARD_NAME,
    .mcu = TEXT(BOARD_MCU),
    .cpu_hz = BOARD_CPU_HZ,
    .axes = BOARD_AXES,
    .axis_timer =
        {
#define BOARD_AXIS(axis, timer) [axis] = '0' + (timer),
#include BOARD_FILE
        },
    .clock_out_is_oc0b = BOARD_CLOCK_OUT_IS_OC0B != 0,
    .pins = pins,
    .pin_count = sizeof pins / sizeof pins[0],
};
