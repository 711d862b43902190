// SPDX-License-Identifier: MIT
// Which board file this image is built from.
#pragma once

#include "config.h" // CONFIG_BOARD_*

#if defined(CONFIG_BOARD_UNO)
#define BOARD_FILE "hal/boards/uno.def"
#else
#define BOARD_FILE "hal/boards/mega.def"
#endif
