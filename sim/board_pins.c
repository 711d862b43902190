// SPDX-License-Identifier: MIT

#include "board_pins.h"

#include <string.h>

// BOARD_KINDS, a row KIND(object, name) for each board file, is made by CMake.
#define KIND(object, name) extern const struct board_kind object;
#include BOARD_KINDS
#undef KIND

#define KIND(object, name) &(object),
static const struct board_kind *const kinds[] = {
#include BOARD_KINDS
};
#undef KIND

#define KIND(object, name) ", " name
static const char names[] =
#include BOARD_KINDS
    ;
#undef KIND

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

const struct board_kind *board_kind_by_name(const char *name)
{
    for (size_t i = 0; i < COUNT(kinds); i++) {
        if (strcmp(kinds[i]->name, name) == 0) {
            return kinds[i];
        }
    }
    return NULL;
}

const char *board_kind_names(void)
{
    return names + strlen(", ");
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
