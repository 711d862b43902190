// SPDX-License-Identifier: MIT
// The part under the firmware, as far as the step engine can tell: registers, a 16-bit timer in
// mode 15 for each axis, interrupts. With one axis time is not counted: what the timer does next
// happens where the search places it, at one of the points of a piece of program.
//
// With several axes time is counted in ticks, so that timers, pixel clock and coarse clock agree.
// What is timed, the ends of periods and the edges of the pixel clock, happens in the order of
// time, and the search places the next of them. Between them time stands still: just before the
// next one from the beginning of a piece of program on, just after it once it has happened. A piece
// waits no longer than PIECE_TICKS for the next one, NEAR_TICKS with interrupts off and
// HANDLER_TICKS in a handler (part.c).
//
// A point lies before every access of the firmware to an object that an interrupt handler uses too,
// before interrupts are switched off, and behind every handler. Between two points nothing that the
// firmware does can be told apart from outside: all places for an event between them are one.
//
// What is kept from the part: an interrupt is served at the first point at which it is pending,
// enabled and interrupts are on, in the order of vectors; no period ends before the interrupt of
// the one before it was entered, and none ends inside its own handler unless it is shorter than
// LATE_TICKS (part.c). Such a period may end while the handler loads its successor: too late. One
// instruction of the main program between SEI or RETI and the next interrupt is left out.
//
// Compiled C of the PC stands for the AVR's machine code, a statement of C for each of the
// assembly's accesses (step_isr.c). The AVR accesses words byte by byte: each shared word must be
// accessed with interrupts off (JUDGE_WIDE), but for those that board_excused() names.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "config.h" // CONFIG_AXES

enum part_event {
    // A timer wraps: buffers take effect, a STEP edge if the period has one. With several axes: the
    // next of all that is timed, two at once if they come in the same tick.
    PART_PERIOD_ENDS,
    PART_PIN_CHANGES, // the emergency stop's pin
    PART_EVENT_KINDS,
};

// Of a timer, what the program cannot see.
struct part_timer {
    uint16_t buffer_top, buffer_edge; // OCRnA, OCRnB as last written
    uint16_t top, edge;               // in effect
    bool in_fast;    // in the part of the step handler that looks whether it is late
    bool in_command; // in the part that executes a command
    bool edge_waits; // a STEP edge that the handler may still prevent
#if CONFIG_AXES > 1
    bool running;
    bool looked_at;       // the main loop has cleared its flag, and will look at it
    uint32_t began_ticks; // the running period
#endif
};

// What the program cannot see. Part of the state that the search saves.
struct part_state {
    struct part_timer timers[CONFIG_AXES];
    bool interrupts_on;
    uint8_t depth;       // handlers entered and not left
    uint8_t effect;      // side effect of the last access, due before anything else
    uint8_t effect_axis; // of which timer
    uint8_t kept_flags;  // TIFRn before that access
    bool looking;        // the last access was a look at the emergency stop's pin
    uint16_t points;     // passed in this piece of program
    const void *pc;      // of the program at the last one
#if CONFIG_AXES > 1
    uint32_t now_ticks;
    uint32_t clock_ticks; // when the pixel clock's next edge is captured
    uint32_t clock_every; // its period; 0: it rests
#endif
};

extern struct part_state part;

// An access of the firmware to memory, and where in the program.
struct part_access {
    const volatile void *address;
    const void *pc;
    uint32_t bytes;
    bool writes;
};

// The judge asks the firmware: nothing of that is a point. Not part of the state.
extern bool *part_reception_off;

void part_open(void); // once, before anything is saved
void part_power_on(void);
void part_cli(void);
void part_sei(void);
unsigned char part_interrupts_on(void);

// The step handler of an axis executes a command, with interrupts on.
void part_command_begins(uint8_t axis);
void part_command_ends(uint8_t axis);

// A point of its own, for what is not an access: the end of a piece of program.
void part_point(void);
// Bring everything about that the last write still has to bring about.
void part_settle(void);
// The same as placed events, at once.
bool part_possible(enum part_event event);
void part_happen(enum part_event event);

bool part_permit_high(void);
bool part_estop_pressed(void);

#if CONFIG_AXES > 1
// A piece of program begins: just before what is timed next, if that comes within PIECE_TICKS.
void part_pass_time(void);
// So long before what is timed next, whenever that comes.
void part_pass_long_time(uint32_t before_ticks);
#define PART_BEFORE_TICKS 4u
// The pixel clock: edges from here on, every so many ticks.
void part_start_clock(uint32_t every_ticks);
// SBI and CBI on GPIOR0 by assembly: one instruction each.
void part_set_flag(uint8_t bit);
void part_clear_flag(uint8_t bit);
#else
static inline void part_pass_time(void)
{
}
#endif

// An object that interrupts and the main loop share.
void part_share(const volatile void *object, uint32_t bytes);
// The bodies of naked handlers (part/avr/interrupt.h).
int explored_estop_look(void);

// The state that the search saves lies here.
extern uint8_t part_memory[] __asm__("__data_start");
extern uint8_t part_memory_end[] __asm__("_end");
static inline size_t part_memory_bytes(void)
{
    return (size_t)((uintptr_t)part_memory_end - (uintptr_t)part_memory);
}
