// SPDX-License-Identifier: MIT
// Which features of build_features.def this image has: all of them on a board with flash for them; the
// smaller board's default keeps everything that a printer's axis needs and leaves out what only
// other Modbus masters use. The build may set any of them to 0 or 1 (-DFEATURE_HOMING=0).
#pragma once

#if defined(BOARD_FILE)
#include BOARD_FILE // BOARD_FLASH_BYTES
#endif

#if BOARD_FLASH_BYTES < 65536
#define FEATURES_ALL 0
#else
#define FEATURES_ALL 1
#endif

#ifndef FEATURE_HOMING
#define FEATURE_HOMING 1
#endif
#ifndef FEATURE_BACKLASH
#define FEATURE_BACKLASH 1
#endif
#ifndef FEATURE_BITS
#define FEATURE_BITS FEATURES_ALL
#endif
#ifndef FEATURE_DIAGNOSIS
#define FEATURE_DIAGNOSIS FEATURES_ALL
#endif
#ifndef FEATURE_EVENTS
#define FEATURE_EVENTS FEATURES_ALL
#endif
#ifndef FEATURE_CLOCK_STATISTICS
#define FEATURE_CLOCK_STATISTICS 1
#endif
#ifndef FEATURE_STORE
#define FEATURE_STORE 1
#endif
#ifndef FEATURE_TOKENS
#define FEATURE_TOKENS 1
#endif
#ifndef FEATURE_DRIVER_TIMING
#define FEATURE_DRIVER_TIMING 1
#endif
#ifndef FEATURE_FILES
#define FEATURE_FILES FEATURES_ALL
#endif
#ifndef FEATURE_NARROW_CURVES
#define FEATURE_NARROW_CURVES FEATURES_ALL
#endif

// Input register `features`.
#define FEATURES_BITS                                                                    \
    (FEATURE_HOMING << 0 | FEATURE_BACKLASH << 1 | FEATURE_BITS << 2 |                   \
     FEATURE_DIAGNOSIS << 3 | FEATURE_EVENTS << 4 | FEATURE_CLOCK_STATISTICS << 5 |      \
     FEATURE_STORE << 6 | FEATURE_TOKENS << 7 | FEATURE_DRIVER_TIMING << 8 |             \
     FEATURE_FILES << 9 | FEATURE_NARROW_CURVES << 10)
