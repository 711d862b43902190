// SPDX-License-Identifier: MIT
// What the parts of the reference share; targets use reference.h.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "reference.h"

#define ILLEGAL_FUNCTION 1u
#define ILLEGAL_ADDRESS  2u
#define ILLEGAL_VALUE    3u

struct asked {
    const uint8_t *bytes;
    uint16_t count;
    struct model *world;
    struct expected *expected;
};

uint16_t asked_word(const struct asked *asked, uint16_t at);

void reply_byte(struct expected *expected, uint16_t byte);
void reply_word(struct expected *expected, uint16_t value);
void reply_text(struct expected *expected, const char *text, uint8_t length);
// Address and function; what was there before is forgotten.
void reply_start(const struct asked *asked);
// The request's first bytes come back.
void reply_echo(const struct asked *asked, uint16_t count);
// The word at a mapped address.
void reply_data(const struct asked *asked, uint16_t address, bool input);

// The functions that are no plain reads and writes; each returns an exception or 0.
uint8_t reference_diagnose(const struct asked *asked);
uint8_t reference_identify(const struct asked *asked);
uint8_t reference_read_files(const struct asked *asked);
uint8_t reference_read_device(const struct asked *asked);
