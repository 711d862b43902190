// SPDX-License-Identifier: MIT
//
// The parameters of the mechanics as text: "play=40,travel=-100..9000,..." (pixstep-sim --help
// describes them all).
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "plant.h"

// Reads parameters into the settings. Those that the text does not name stay as they are, or get
// their defaults if none were ever given. On an error returns false, with one line about it in
// `error`; the settings may then hold a part of the text. Changes the text.
bool plant_parse(struct plant_settings *settings,
                 char *text,
                 char *error,
                 size_t error_size);
