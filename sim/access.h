// SPDX-License-Identifier: MIT
//
// Accesses of instructions to I/O registers: in which cycle an access happens, and which bits it
// writes. simavr calls a register's callbacks while avr->cycle is still the instruction's first
// cycle. These functions are only for such callbacks.
//
//   cycle of the instruction   1st               2nd
//   IN, OUT, SBIC, SBIS        access
//   LDS, STS, LD, ST, SBI, CBI                   access
//
// A write takes effect in the cycle after its access.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

// The instruction that is being executed (avr->pc stays on it until it has ended).
static inline uint16_t access_opcode(const avr_t *avr)
{
    return (uint16_t)(avr->flash[avr->pc] | (avr->flash[avr->pc + 1U] << 8));
}

// The cycle in which the running instruction reads or writes. IN, OUT, SBIC and SBIS do it in their
// first cycle; LDS, STS, LD and ST, SBI and CBI take two and do it in the second.
static inline uint64_t access_cycle(const avr_t *avr)
{
    uint16_t opcode = access_opcode(avr);
    bool in_or_out = (opcode & 0xF000U) == 0xB000U;
    bool skip_on_bit = (opcode & 0xFD00U) == 0x9900U;

    return avr->cycle + ((in_or_out || skip_on_bit) ? 0U : 1U);
}

// A mask of the bits that the running instruction writes: one for SBI and CBI, all eight for every
// other instruction. (simavr reads, changes and writes all eight for SBI and CBI too.)
static inline uint8_t access_bits_written(const avr_t *avr)
{
    uint16_t opcode = access_opcode(avr);

    return (uint8_t)(((opcode & 0xFD00U) == 0x9800U) ? 1U << (opcode & 7U) : 0xFFU);
}

// The flags that a write clears in a register of flags that are cleared by writing one to them.
// `value` is what simavr would write. On the part, SBI writes its one bit only and CBI writes none;
// simavr reads, changes and writes all eight.
static inline uint8_t access_flags_written(const avr_t *avr, uint8_t value)
{
    uint16_t opcode = access_opcode(avr);

    if ((opcode & 0xFF00U) == 0x9A00U) {
        return (uint8_t)(1U << (opcode & 7U));
    }
    return ((opcode & 0xFF00U) == 0x9800U) ? 0 : value;
}

// Replaces the callbacks of a register at this data address, which belonged to simavr's own module.
// NULL: the register reads or is written as plain memory. `param` is passed to both callbacks.
static inline void access_take(avr_t *avr,
                               avr_io_addr_t address,
                               avr_io_read_t read,
                               avr_io_write_t write,
                               void *param)
{
    avr_io_addr_t io = (avr_io_addr_t)AVR_DATA_TO_IO(address);

    avr->io[io].r.c = read;
    avr->io[io].r.param = param;
    avr->io[io].w.c = write;
    avr->io[io].w.param = param;
}
