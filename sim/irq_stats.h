// SPDX-License-Identifier: MIT
//
// What interrupts cost: adds the response cycles that simavr leaves out, measures every handler,
// and shares the main program's cycles out to its sections (GPIOR1).
//
//   flag set      service: the running instruction has ended
//     |<-latency->|<-response->|<-jmp->|<- handler ... reti ->|
//                 |<------------ cycles of the handler ------>|  less those of nested handlers
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#define IRQ_VECTORS  64
#define IRQ_NESTING  16
#define IRQ_SECTIONS 6

// Data sheet, Interrupt Response Time: 4 cycles minimum, 5 on parts with a 22-bit program counter.
#define IRQ_RESPONSE_16_BIT_PC 4
#define IRQ_RESPONSE_22_BIT_PC 5
// "If an interrupt occurs when the MCU is in sleep mode, the response time is increased by four."
#define IRQ_RESPONSE_FROM_SLEEP 4

struct irq_vector_stats {
    char name[16];
    uint32_t count;
    uint64_t cycles_sum;
    uint32_t cycles_min, cycles_max;
    uint32_t latency_max;
    uint64_t flag_cycle;
    bool flagged;
};

struct irq_stats {
    avr_t *avr;
    struct irq_vector_stats vector[IRQ_VECTORS];
    struct {
        uint8_t vector;
        uint64_t start, nested;
    } running[IRQ_NESTING];
    int depth;
    uint64_t interrupt_cycles; // in handlers, all together
    bool woken;                // set by the run loop: the next service ends a sleep
    bool returned; // for the run loop: the instruction that has ended was a RETI

    uint64_t section_cycles[IRQ_SECTIONS];
    uint64_t section_entries[IRQ_SECTIONS];
    unsigned section;
    uint64_t section_since, section_interrupts_since;

    uint64_t off_since; // interrupts are off since this cycle
    bool off,
        started; // started: the program has enabled interrupts, its start-up is over
    bool
        off_in_main; // switched off by the main program, not by the service of an interrupt
    uint64_t off_max, off_main_max;
};

// Names the part's vectors and hooks into them. Call once, between the part's init and first reset.
void irq_stats_attach(struct irq_stats *stats, avr_t *avr);

// Forgets the handlers that were running: the part was reset.
void irq_stats_reset(struct irq_stats *stats);

// Begins the handlers' counts, means and extremes anew; the sums that only grow go on.
void irq_stats_mark(struct irq_stats *stats);

// An interrupt flag was set at this very cycle.
void irq_stats_flag(struct irq_stats *stats, uint8_t vector, uint64_t cycle);

// GPIOR1 was written (section id), or the run ends here: closes the account of the section so far.
void irq_stats_section(struct irq_stats *stats, unsigned section, uint64_t cycle);

// The I bit changed at avr->cycle.
void irq_stats_i_bit(struct irq_stats *stats, bool off);

// Called between instructions by the run loop, with the state of the I bit.
static inline void irq_stats_interrupts_off(struct irq_stats *stats, bool off)
{
    if (off != stats->off) {
        irq_stats_i_bit(stats, off);
    }
}
