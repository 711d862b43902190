// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "board_pins.h"

#include <string.h>

#undef BOARD_AXES // each board file has its own

// A board's table is read twice, once for its pins and once for its axes.
#define BOARD_AXIS(axis, timer)
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    {SIGNAL_##signal, (axis), #port[0], (bit)},
static const struct board_pin uno_pins[] = {
#include "hal/boards/uno.def"
};
static const struct board_pin mega_pins[] = {
#include "hal/boards/mega.def"
};
#undef BOARD_AXIS
#undef BOARD_PIN

#define BOARD_AXIS(axis, timer) [axis] = '0' + (timer),
#define BOARD_PIN(signal, axis, port, bit, header_pin)
static const char uno_timers[BOARD_KIND_AXES] = {
#include "hal/boards/uno.def"
};
static const char mega_timers[BOARD_KIND_AXES] = {
#include "hal/boards/mega.def"
};
#undef BOARD_AXIS
#undef BOARD_PIN

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static struct board_kind kinds[] = {
    {.name = "uno", .mcu = "atmega328p", .pins = uno_pins, .pin_count = COUNT(uno_pins)},
    {.name = "mega",
     .mcu = "atmega2560",
     .pins = mega_pins,
     .pin_count = COUNT(mega_pins)},
};
static const char *const timers[] = {uno_timers, mega_timers};

static void fill_axes(struct board_kind *kind, const char *axis_timer)
{
    kind->axes = 0;
    for (int axis = 0; axis < BOARD_KIND_AXES && axis_timer[axis] != 0; axis++) {
        kind->axis_timer[axis] = axis_timer[axis];
        kind->axes++;
    }
}

const struct board_kind *board_kind_by_name(const char *name)
{
    for (size_t i = 0; i < COUNT(kinds); i++) {
        if (strcmp(kinds[i].name, name) == 0) {
            fill_axes(&kinds[i], timers[i]);
            return &kinds[i];
        }
    }
    return NULL;
}

const char *board_kind_names(void)
{
    return "uno, mega";
}

const struct board_pin *board_kind_pin(const struct board_kind *kind,
                                       enum board_signal signal,
                                       unsigned axis)
{
    for (size_t i = 0; i < kind->pin_count; i++) {
        if (kind->pins[i].signal == signal && kind->pins[i].axis == axis) {
            return &kind->pins[i];
        }
    }
    return NULL;
}
