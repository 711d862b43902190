// SPDX-License-Identifier: MIT
//
// The cost of interrupts: adds the response cycles that simavr leaves out, measures every handler,
// and counts the main program's cycles by section (the program writes its section to GPIOR1). All
// figures are in cycles.
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
#define IRQ_SECTIONS 7
// Sections 1 to 3 are called by another one, which 7 goes back to.
#define IRQ_SECTION_CALLED_LAST 3
#define IRQ_SECTION_CALLER      7

// Data sheet, Interrupt Response Time: 4 cycles minimum, 5 on parts with a 22-bit program counter.
#define IRQ_RESPONSE_16_BIT_PC 4
#define IRQ_RESPONSE_22_BIT_PC 5
// "If an interrupt occurs when the MCU is in sleep mode, the response time is increased by four."
#define IRQ_RESPONSE_FROM_SLEEP 4

struct irq_vector_stats {
    char name[16];  // e.g. "TIMER1_OVF"
    uint32_t count; // handlers that have ended
    // Of all handlers that have ended, without the handlers nested in them.
    uint64_t cycles_sum;
    uint32_t cycles_min, cycles_max;
    uint32_t latency_max; // from the flag to the service
    uint64_t flag_cycle;  // of the flag that came up last
    bool flagged;         // that flag has not been served yet
};

struct irq_stats {
    avr_t *avr;
    struct irq_vector_stats vector[IRQ_VECTORS];
    // The handlers that are running, the outermost first: their start, and the cycles of handlers
    // nested in them.
    struct {
        uint8_t vector;
        uint64_t start, nested;
    } running[IRQ_NESTING];
    int depth;                 // handlers that are running, nested ones included
    uint64_t interrupt_cycles; // in all handlers
    bool woken;                // set by the run loop: the next service ends a sleep
    bool returned; // for the run loop: the instruction that has ended was a RETI

    // By section: the main program's cycles, and how often it has entered the section.
    uint64_t section_cycles[IRQ_SECTIONS];
    uint64_t section_entries[IRQ_SECTIONS];
    unsigned section; // in which the main program is, since these cycles:
    uint64_t section_since, section_interrupts_since;
    // The longest stay in each since irq_stats_mark(), with the sections that it called.
    uint64_t section_longest[IRQ_SECTIONS];
    // The section that calls the others, and the main program's cycles when the stay in it, and in
    // the one that it has called, began.
    unsigned calling;
    uint64_t calling_since, called_since;

    uint64_t off_since; // interrupts are off since this cycle
    bool off;           // interrupts are off
    bool off_in_main;   // by the main program, not by the service of an interrupt
    bool started;       // the program has enabled interrupts: its start-up is over
    // The longest time with interrupts off: any, and any that the main program began.
    uint64_t off_max, off_main_max;
};

// Names the part's vectors and follows them; takes GPIOR1 over. Call once, between the part's init
// and its first reset.
void irq_stats_attach(struct irq_stats *stats, avr_t *avr);

// Forgets the handlers that were running: the part was reset.
void irq_stats_reset(struct irq_stats *stats);

// Sets the handlers' counts, sums and extremes back to zero. interrupt_cycles, sections and their
// entries go on.
void irq_stats_mark(struct irq_stats *stats);

// An interrupt flag has come up at exactly this cycle; its interrupt is raised just afterwards.
void irq_stats_flag(struct irq_stats *stats, uint8_t vector, uint64_t cycle);

// Brings the sum of the present section up to this cycle.
void irq_stats_section(struct irq_stats *stats, uint64_t cycle);

// The I bit has changed at avr->cycle; off: interrupts are disabled.
void irq_stats_i_bit(struct irq_stats *stats, bool off);

// The run loop calls this between instructions, with the state of the I bit.
static inline void irq_stats_interrupts_off(struct irq_stats *stats, bool off)
{
    if (off != stats->off) {
        irq_stats_i_bit(stats, off);
    }
}
