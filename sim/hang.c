// SPDX-License-Identifier: MIT

#include "hang.h"

#define RETI       0x9518U
#define TO_ITSELF  0xCFFFU // rjmp .-2
#define WORD_BYTES 2U

static bool patch(struct hang *h, avr_t *avr, uint32_t address, uint16_t opcode)
{
    uint8_t *flash = &avr->flash[address];

    if (h->patches == HANG_PATCHES) {
        return false;
    }
    h->patch[h->patches].address = address;
    h->patch[h->patches].before = (uint16_t)(flash[0] | flash[1] << 8);
    h->patches++;
    flash[0] = (uint8_t)opcode;
    flash[1] = (uint8_t)(opcode >> 8);
    return true;
}

// The last first: one place may be patched twice.
static void unpatch(struct hang *h, avr_t *avr)
{
    while (h->patches > 0) {
        unsigned last = --h->patches;
        uint8_t *flash = &avr->flash[h->patch[last].address];

        flash[0] = (uint8_t)h->patch[last].before;
        flash[1] = (uint8_t)(h->patch[last].before >> 8);
    }
}

void hang_end(struct hang *h, avr_t *avr, bool power_on)
{
    if (power_on || !h->kept) {
        unpatch(h, avr);
        *h = (struct hang){0};
    }
}

bool hang_vector(struct hang *h, avr_t *avr, uint8_t vector)
{
    return patch(h, avr, (uint32_t)vector * avr->vector_size, RETI);
}

bool hang_at(struct hang *h, avr_t *avr, uint32_t address)
{
    return address % WORD_BYTES == 0 && address < avr->flashend &&
           patch(h, avr, address, TO_ITSELF);
}
