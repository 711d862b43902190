// SPDX-License-Identifier: MIT
#include "app/settings/settings.h"

#include <stddef.h> // offsetof

#include "base/apart.h"        // APART
#include "base/flash.h"        // IN_FLASH
#include "base/multiply.h"     // multiply_u32_u16
#include "config.h"            // CONFIG_TIMER_HZ
#include "wire/baud.h"         // baud_possible
#include "wire/bytes.h"        // get_word, put_word
#include "wire/register_map.h" // REG_HOLDING_*

#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define COMMAND(address, name, type, unit, min, max, initial, meaning)

// Each word of a 32-bit setting has limits of its own; the whole value is checked where it is used.
struct settings_limits {
    uint16_t max;
    char min; // 0 to 127
};

#define HIGH(value)          ((uint16_t)((uint32_t)(value) >> 16))
#define LOW(value)           ((uint16_t)((uint32_t)(value) & 0xFFFFu))
#define WORDS_u16(value)     (value),
#define WORDS_u32(value)     HIGH(value), LOW(value),
#define LIMITS_u16(min, max) {(max), (min)},
#define LIMITS_u32(min, max) {HIGH(max), 0}, {LOW(max), 0},
// A setting of a feature that the image was built without can only be 0.
#define IS_ABSENT(address)                                                               \
    ((!FEATURE_SHARED_SWITCH && (address) == REG_HOLDING_home_is_limit) ||               \
     (!FEATURE_LINE_ENDS && (address) == REG_HOLDING_silence_waits) ||                   \
     (!FEATURE_CLOCK_OUT && (address) == REG_HOLDING_clock_out_hz))
static const struct settings_limits settings_limits[SETTINGS_WORDS] IN_FLASH = {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    LIMITS_##type(min, IS_ABSENT(address) ? 0 : (max))
#include "wire/registers.def"
#undef HOLDING
};
static const uint16_t settings_initial[SETTINGS_WORDS] IN_FLASH = {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    WORDS_##type(initial)
#include "wire/registers.def"
#undef HOLDING
};

#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    _Static_assert(offsetof(struct settings, name) ==                                    \
                       offsetof(struct settings, words) + 2u * (address),                \
                   "settings lie at their addresses, without a gap");
#include "wire/registers.def"
#undef HOLDING

static struct settings current_settings;

const struct settings *settings_now(void)
{
    return &current_settings;
}

struct settings *settings_record(void)
{
    return &current_settings;
}

void settings_set_defaults(void)
{
    flash_copy(current_settings.words, settings_initial, sizeof settings_initial);
}

void settings_override_address(uint8_t address)
{
    if (address != 0) {
        current_settings.unit_address = address;
    }
}

static bool in_range(void)
{
    for (uint8_t i = 0; i < (uint8_t)SETTINGS_WORDS; i++) {
        uint16_t word = current_settings.words[i];
        if (word < (uint8_t)flash_char(&settings_limits[i].min) ||
            word > flash_word(&settings_limits[i].max)) {
            return false;
        }
    }
    return true;
}

APART bool settings_period(struct pixel_period *period, uint16_t edges)
{
    uint32_t den = settings_u32(current_settings.pixel_hz_den);

    return den <= UINT32_MAX / edges &&
           pixel_period_set(period,
                            CONFIG_TIMER_HZ,
                            settings_u32(current_settings.pixel_hz_num),
                            multiply_u32_u16(den, edges));
}

// A pixel that follows the clock may become longer than the period of the settings.
static bool pixel_is_possible(const struct pixel_period *pixel)
{
    return current_settings.sync != SYNC_LOCK ||
           pixel->whole_ticks <= PIXEL_PERIOD_MAX_TICKS / 16u * 15u;
}

bool settings_are_possible(void)
{
    struct pixel_period period;

    return in_range() && baud_possible(current_settings.baud_100) &&
           settings_period(&period, 1) &&
           settings_period(&period, current_settings.divider) &&
           pixel_is_possible(&period);
}

void settings_exchange(uint8_t first, uint8_t count, uint8_t *words)
{
    for (; count != 0; count--) {
        uint16_t word = current_settings.words[first];

        current_settings.words[first] = get_word(words);
        put_word(words, word);
        words += 2;
        first++;
    }
}
