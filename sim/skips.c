// SPDX-License-Identifier: MIT

#include "skips.h"

#include <stdlib.h>

struct opcode {
    uint16_t mask, value;
};

static const struct opcode skip_opcodes[] = {
    {0xFE08, 0xFE00}, // SBRS
    {0xFE08, 0xFC00}, // SBRC
    {0xFF00, 0x9B00}, // SBIS
    {0xFF00, 0x9900}, // SBIC
    {0xFC00, 0x1000}, // CPSE
};

static uint16_t word_at(const avr_t *avr, avr_flashaddr_t word)
{
    const uint8_t *bytes = &avr->flash[(size_t)word * 2];

    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static bool is_skip(uint16_t opcode)
{
    bool found = false;

    for (size_t i = 0; i < sizeof skip_opcodes / sizeof skip_opcodes[0]; i++) {
        found = found || (opcode & skip_opcodes[i].mask) == skip_opcodes[i].value;
    }
    return found;
}

// ADIW and SBIW: 1001 011x KKdd KKKK.
static bool is_taken_for_two_words(uint16_t opcode)
{
    return (opcode & 0xFE00) == 0x9600 && (opcode & 0x0F) >= 12;
}

bool skips_find(struct skips *s, const avr_t *avr)
{
    avr_flashaddr_t words = (avr->flashend + 1U) / 2;

    s->wrong = NULL;
    for (avr_flashaddr_t word = 0; word + 1 < words; word++) {
        if (!is_skip(word_at(avr, word)) ||
            !is_taken_for_two_words(word_at(avr, word + 1))) {
            continue;
        }
        if (s->wrong == NULL) {
            s->wrong = calloc(words, sizeof *s->wrong);
        }
        if (s->wrong == NULL) {
            return false;
        }
        s->wrong[word] = true;
    }
    return true;
}

void skips_free(struct skips *s)
{
    free(s->wrong);
    s->wrong = NULL;
}
