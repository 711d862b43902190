// SPDX-License-Identifier: MIT
// Which features of build_features.def this image has: all of them on a board with flash for them; the
// smaller board's default keeps everything that a printer's axis needs and leaves out what only
// other Modbus masters use. The build may set any of them to 0 or 1 (-DFEATURE_HOMING=0).
#pragma once

#include BOARD_FILE // BOARD_ALL_FEATURES

#ifndef FEATURE_HOMING
#define FEATURE_HOMING 1
#endif
#ifndef FEATURE_BACKLASH
#define FEATURE_BACKLASH 1
#endif
#ifndef FEATURE_BITS
#define FEATURE_BITS BOARD_ALL_FEATURES
#endif
#ifndef FEATURE_DIAGNOSIS
#define FEATURE_DIAGNOSIS BOARD_ALL_FEATURES
#endif
#ifndef FEATURE_EVENTS
#define FEATURE_EVENTS BOARD_ALL_FEATURES
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
#define FEATURE_FILES BOARD_ALL_FEATURES
#endif
#ifndef FEATURE_NARROW_CURVES
#define FEATURE_NARROW_CURVES BOARD_ALL_FEATURES
#endif

// Input register `features`.
#define FEATURES_BITS                                                                    \
    (FEATURE_HOMING << 0 | FEATURE_BACKLASH << 1 | FEATURE_BITS << 2 |                   \
     FEATURE_DIAGNOSIS << 3 | FEATURE_EVENTS << 4 | FEATURE_CLOCK_STATISTICS << 5 |      \
     FEATURE_STORE << 6 | FEATURE_TOKENS << 7 | FEATURE_DRIVER_TIMING << 8 |             \
     FEATURE_FILES << 9 | FEATURE_NARROW_CURVES << 10)
