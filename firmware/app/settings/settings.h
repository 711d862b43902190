// SPDX-License-Identifier: MIT
// The settings of registers.def: 16-bit words in the order of their addresses, so that a word is
// found by its address, and with a head and a checksum around them the record that is stored.
//
//     offset   0       1     2      4                        ...                end
//             |version|bytes|serial| word 0 | word 1 | ... | word n |checksum|
//              head                  holding registers 0..n          CRC-16
//
// One struct is the settings in use and the image of the record, so that storing copies nothing.
// Writers check before a change is visible: settings_exchange(), settings_are_possible(), and
// settings_exchange() again where the answer is no. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "clock/pixel_period.h" // struct pixel_period

// The values of setting `sync`.
//
// No line waits for the clock.
#define SYNC_FREE 0u
// Line zero of a line that waits for the clock is on a clock edge; from there on the line keeps the
// time of the settings.
#define SYNC_START 1u
// Line zero and all pixel edges after it are on clock edges.
#define SYNC_LOCK 2u

// Version of the record's layout: a record with another version is not loaded.
#define SETTINGS_VERSION 1u
// What an erased EEPROM byte reads as; no record begins with it, because no version is 255.
#define SETTINGS_ERASED 0xFFu

// Only the HOLDING rows of registers.def are settings; the other rows expand to nothing here. A
// 32-bit setting takes two words and two addresses.
#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define COMMAND(address, name, type, unit, min, max, initial, meaning)
#define FIELD_u16(name) uint16_t name;
#define FIELD_u32(name) uint16_t name[2]; // high word first
#define COUNT_u16       1u
#define COUNT_u32       2u

// Number of 16-bit words of all settings; word n is holding register n.
enum {
    SETTINGS_WORDS = 0
// NOLINTNEXTLINE(bugprone-macro-parentheses): the sum goes on from row to row
#define HOLDING(address, name, type, unit, min, max, initial, meaning) +COUNT_##type
#include "wire/registers.def"
#undef HOLDING
};

// settings.c checks that every member lies at its address, without a gap. The unit and the range of
// each setting are columns of registers.def.
struct settings {
    // SETTINGS_VERSION in a record that is whole.
    uint8_t version;
    // Size of the record, bytes: a record of an image with other settings is not loaded.
    uint8_t bytes;
    // Number of the record: the higher one is newer. Compared as a difference, so that it may wrap.
    uint16_t serial;
    union {
        struct {
#define HOLDING(address, name, type, unit, min, max, initial, meaning) FIELD_##type(name)
#include "wire/registers.def"
        };
        // The same settings by their addresses.
        uint16_t words[SETTINGS_WORDS];
    };
    // CRC-16 of everything before it, low byte first. Only store.c keeps it right.
    uint16_t checksum;
};
#undef HOLDING
#undef COMMAND
#undef INPUT
#undef INPUT_AXIS
#undef FIELD_u16
#undef FIELD_u32
#undef COUNT_u16
#undef COUNT_u32

// The settings in use. Their ranges were checked when they were loaded or written. The object lasts
// as long as the program; whoever keeps something that follows from it computes it again in
// limits_apply_settings().
const struct settings *settings_now(void);

// Set every word to its default of registers.def; the record's head stays. Only while no line is
// queued and no record is being stored; limits_apply_settings() must follow.
void settings_set_defaults(void);

// Apply the address strap of the board: 0 keeps the address setting, any other value overrides it
// until the next reset. Once, after the settings were loaded.
void settings_override_address(uint8_t address);

// True when every word is within its limits, and when the baud rate, the pixel frequency and the
// length of a pixel are possible as a whole.
bool settings_are_possible(void);

// Set *period to the exact length of `edges` clock edges, 1 or more, by the settings in use.
// Returns false and changes nothing when no period can be as long or as short as that. Divides.
bool settings_period(struct pixel_period *period, uint16_t edges);

// Exchange `count` words of the settings, from word `first` on, with these, which are big-endian.
// The caller makes sure that the range exists, and asks settings_are_possible() afterwards. A
// second call with the same memory takes the exchange back.
void settings_exchange(uint8_t first, uint8_t count, uint8_t *words);

// The settings with their head and checksum, to be loaded and stored: for store.c alone.
struct settings *settings_record(void);

// The value of a 32-bit setting, whose high word comes first.
static inline uint32_t settings_u32(const uint16_t *words)
{
    // A union, because avr-gcc computes what could be two loads.
    union {
        uint16_t half[2];
        uint32_t whole;
    } value = {.half = {words[1], words[0]}};

    return value.whole;
}
