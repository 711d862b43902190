// SPDX-License-Identifier: MIT
//
// Programs gone astray, made to order: instructions in flash patched and put back, and the main
// program or all of it standing still (board_run.c runs these).

#include "board.h"

#include <stdio.h>

#include "board_run.h"

#define RETI       0x9518U
#define TO_ITSELF  0xCFFFU // rjmp .-2
#define WORD_BYTES 2U

static bool patch(struct board *b, uint32_t address, uint16_t opcode)
{
    struct board_hang *hang = &b->hang;
    uint8_t *flash = &b->avr->flash[address];

    if (hang->patches == BOARD_PATCHES) {
        return false;
    }
    hang->patch[hang->patches].address = address;
    hang->patch[hang->patches].before = (uint16_t)(flash[0] | flash[1] << 8);
    hang->patches++;
    flash[0] = (uint8_t)opcode;
    flash[1] = (uint8_t)(opcode >> 8);
    return true;
}

// The last first: one place may be patched twice.
static void unpatch(struct board *b)
{
    struct board_hang *hang = &b->hang;

    while (hang->patches > 0) {
        unsigned last = --hang->patches;
        uint8_t *flash = &b->avr->flash[hang->patch[last].address];

        flash[0] = (uint8_t)hang->patch[last].before;
        flash[1] = (uint8_t)(hang->patch[last].before >> 8);
    }
}

void board_end_hang(struct board *b, bool power_on)
{
    if (power_on || !b->hang.kept) {
        unpatch(b);
        b->hang = (struct board_hang){0};
    }
    b->avr->run = board_next_run(b);
}

void board_hang_main(struct board *b)
{
    b->hang.main = true;
    b->avr->run = board_next_run(b);
}

void board_hang_interrupts(struct board *b)
{
    b->hang.all = true;
    b->avr->run = board_next_run(b);
}

bool board_hang_axis(struct board *b, unsigned axis)
{
    const struct timer16 *timer = board_axis_timer(b, axis);

    return patch(b, (uint32_t)timer->part->overflow.vector * b->avr->vector_size, RETI);
}

bool board_hang_at(struct board *b, uint32_t address)
{
    return address % WORD_BYTES == 0 && address < b->avr->flashend &&
           patch(b, address, TO_ITSELF);
}
