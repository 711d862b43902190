// SPDX-License-Identifier: MIT

#include "hang.h"

#define RETI       0x9518U
#define TO_ITSELF  0xCFFFU // rjmp .-2
#define WORD_BYTES 2U

static void write_word(avr_t *avr,
                       struct plain_program *program,
                       uint32_t address,
                       uint16_t opcode)
{
    avr->flash[address] = (uint8_t)opcode;
    avr->flash[address + 1U] = (uint8_t)(opcode >> 8);
    plain_patched(program, avr, address);
}

static bool patch(struct hang *h,
                  avr_t *avr,
                  struct plain_program *program,
                  uint32_t address,
                  uint16_t opcode)
{
    const uint8_t *flash = &avr->flash[address];

    if (h->patches == HANG_PATCHES) {
        return false;
    }
    h->patch[h->patches].address = address;
    h->patch[h->patches].before = (uint16_t)(flash[0] | flash[1] << 8);
    h->patches++;
    write_word(avr, program, address, opcode);
    return true;
}

// The last first: one place may be patched twice.
static void unpatch(struct hang *h, avr_t *avr, struct plain_program *program)
{
    while (h->patches > 0) {
        unsigned last = --h->patches;

        write_word(avr, program, h->patch[last].address, h->patch[last].before);
    }
}

void hang_end(struct hang *h, avr_t *avr, struct plain_program *program, bool power_on)
{
    if (power_on || !h->kept) {
        unpatch(h, avr, program);
        *h = (struct hang){0};
    }
}

bool hang_vector(struct hang *h,
                 avr_t *avr,
                 struct plain_program *program,
                 uint8_t vector)
{
    return patch(h, avr, program, (uint32_t)vector * avr->vector_size, RETI);
}

bool hang_at(struct hang *h, avr_t *avr, struct plain_program *program, uint32_t address)
{
    return address % WORD_BYTES == 0 && address < avr->flashend &&
           patch(h, avr, program, address, TO_ITSELF);
}
