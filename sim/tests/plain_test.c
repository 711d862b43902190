// SPDX-License-Identifier: MIT
//
// Every opcode that the simulator executes itself (plain.h) beside simavr's core: from the same
// random states of the part both must come to the same registers, RAM, flags, program counter and
// cycle. Fails too if fewer opcodes are plain than there should be.

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <sim_avr.h>

#include <sim_core.h>

#include "../noise.h"
#include "../plain.h"

#define STATES    24 // of each opcode
#define OPCODES   0x10000U
#define PLAIN     55000U // opcodes at least
#define PLACE     0x1F00U
#define REGISTERS 32U
#define POINTERS  26U // X, Y, Z: r26 to r31

struct pair {
    avr_t *simavr, *ours;
    struct plain_program program;
    struct noise noise;
    uint32_t plain; // opcodes that were executed
};

static uint32_t below(struct pair *p, uint32_t limit)
{
    return (uint32_t)(noise_next(&p->noise) >> 32) % limit;
}

static bool open_pair(struct pair *p, const char *part)
{
    memset(p, 0, sizeof *p);
    noise_seed(&p->noise, 1, 0);
    p->simavr = avr_make_mcu_by_name(part);
    p->ours = avr_make_mcu_by_name(part);
    return p->simavr != NULL && p->ours != NULL && avr_init(p->simavr) == 0 &&
           avr_init(p->ours) == 0 && plain_decode(&p->program, p->ours);
}

static void close_pair(struct pair *p)
{
    plain_free(&p->program);
    avr_terminate(p->simavr);
    avr_terminate(p->ours);
}

// ADIW and SBIW behind a skip, of which simavr has a wrong idea (skips.h), come from an image of
// their own: images/skips.c.
static bool is_misread_by_simavr(uint32_t opcode)
{
    return (opcode & 0xFE0CU) == 0x960CU;
}

static void write_flash(struct pair *p, uint16_t opcode)
{
    uint32_t next = (below(p, 2) == 0) ? below(p, p->ours->ramend) : below(p, OPCODES);
    uint8_t words[] = {(uint8_t)opcode, (uint8_t)(opcode >> 8), 0, 0};

    next = is_misread_by_simavr(next) ? 0 : next;
    words[2] = (uint8_t)next;
    words[3] = (uint8_t)(next >> 8);
    memcpy(&p->simavr->flash[PLACE], words, sizeof words);
    memcpy(&p->ours->flash[PLACE], words, sizeof words);
    plain_patched(&p->program, p->ours, PLACE + 2U);
}

static void draw_ram_address(struct pair *p, uint32_t low)
{
    const avr_t *avr = p->ours;
    uint32_t address =
        avr->ioend + 1U + below(p, (uint32_t)avr->ramend - avr->ioend - 4U);

    avr->data[low] = (uint8_t)address;
    avr->data[low + 1] = (uint8_t)(address >> 8);
    avr->data[address + 1] &= 1U; // a return address that the flash has
}

// Registers and flags at random; pointers mostly in RAM, and the stack pointer too.
static void draw_state(struct pair *p)
{
    avr_t *avr = p->ours;

    noise_fill(&p->noise, avr->data, REGISTERS);
    noise_fill(&p->noise, &avr->data[R_SPL], 2);
    for (uint32_t low = POINTERS; low < REGISTERS; low += 2) {
        if (below(p, 4) != 0) {
            draw_ram_address(p, low);
        }
    }
    if (below(p, 4) != 0) {
        draw_ram_address(p, R_SPL);
    }
    for (int bit = 0; bit < 8; bit++) {
        avr->sreg[bit] = (uint8_t)below(p, 2);
    }
    avr->pc = PLACE;
    avr->cycle = below(p, OPCODES);
}

static void copy_state(struct pair *p)
{
    avr_t *to = p->simavr;

    memcpy(to->data, p->ours->data, (size_t)to->ramend + 1U);
    memcpy(to->sreg, p->ours->sreg, sizeof to->sreg);
    to->pc = p->ours->pc;
    to->cycle = p->ours->cycle;
    to->state = cpu_Running;
    to->interrupt_state = 0;
    to->run_cycle_count = 0; // one instruction
}

static bool is_same_state(const struct pair *p)
{
    return memcmp(p->simavr->data, p->ours->data, (size_t)p->ours->ramend + 1U) == 0 &&
           memcmp(p->simavr->sreg, p->ours->sreg, sizeof p->ours->sreg) == 0 &&
           p->simavr->pc == p->ours->pc && p->simavr->cycle == p->ours->cycle;
}

static bool try_opcode(struct pair *p, uint16_t opcode)
{
    bool is_plain = false;

    for (int i = 0; i < STATES; i++) {
        write_flash(p, opcode);
        draw_state(p);
        copy_state(p);
        if (plain_run(&p->program, p->ours, p->ours->cycle)) {
            is_plain = true;
            p->simavr->pc = avr_run_one(p->simavr);
        }
        // Of an instruction that is left to simavr nothing has been done.
        if (!is_same_state(p)) {
            (void)fprintf(
                stderr, "opcode %04X differs from simavr's\n", (unsigned)opcode);
            return false;
        }
    }
    p->plain += is_plain;
    return true;
}

static bool try_part(const char *part)
{
    struct pair p;
    bool same = open_pair(&p, part);

    for (uint32_t opcode = 0; same && opcode < OPCODES; opcode++) {
        same = try_opcode(&p, (uint16_t)opcode);
    }
    (void)printf("%s: %u plain opcodes, each in %d states\n", part, p.plain, STATES);
    same = same && p.plain >= PLAIN;
    close_pair(&p);
    return same;
}

int main(void)
{
    bool small = try_part("atmega328p");
    bool large = try_part("atmega2560");

    return small && large ? 0 : 1;
}
