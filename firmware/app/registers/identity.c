// SPDX-License-Identifier: MIT
// The identity of this board: the host finds it in the image, and functions 17 and 43/14 return it
// on the bus.
#include "app/registers/report.h" // report_status
#include "base/flash.h"           // IN_FLASH
#include "config.h"               // CONFIG_*, FEATURE_DIAGNOSIS
#include "wire/server_data.h"     // data_*

#define TEXT_OF(value)             #value
#define VERSION_TEXT(major, minor) TEXT_OF(major) "." TEXT_OF(minor)

// Every image has this text, whatever its features, because the host flashes no file without it.
__attribute__((used)) static const char identity[] IN_FLASH =
    "pixstep " CONFIG_BOARD_NAME
    " " VERSION_TEXT(CONFIG_VERSION_MAJOR, CONFIG_VERSION_MINOR);

#if FEATURE_DIAGNOSIS

uint8_t data_identity(uint8_t *text, uint8_t room)
{
    uint8_t length = (uint8_t)(sizeof identity - 1u);

    if (length > room) {
        length = room;
    }
    for (uint8_t i = 0; i < length; i++) {
        text[i] = (uint8_t)flash_char(&identity[i]);
    }
    return length;
}

bool data_running(void)
{
    return (report_status() & REPORT_RUNNING) != 0;
}

uint8_t data_server_id(void)
{
    return CONFIG_BOARD_ID;
}

#endif
