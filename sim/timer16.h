// SPDX-License-Identifier: MIT
//
// Exact model of the AVR's 16-bit timers, in the place of simavr's. The model computes counts
// instead of counting: TCNT(c) = c - bottom. Every effect therefore has its exact cycle, however
// late simavr delivers it (simavr delivers events at the ends of instructions).
//
//   cycle     bottom             bottom+OCRnx   +1              bottom+TOP   next bottom
//   TCNT      0       1     ...  OCRnx          OCRnx+1    ...  TOP          0
//   effects   buffers load,                     OCFnx set,                   TOVn set,
//             OCnx at BOTTOM                    OCnx changes                 and so on
//
// Rules, from the ATmega328P and ATmega2560 data sheets (16-bit Timer/Counter):
//  * mode 15 (fast PWM, TOP = OCRnA): TOVn is set in the step from TOP to BOTTOM; OCRnx is double-
//    buffered and loads at BOTTOM; a write in the very cycle of that step is one period late.
//  * a compare output changes one timer clock after its match; at BOTTOM, BOTTOM wins: OCRnx = TOP
//    holds an inverting output low. OCRnx above TOP never matches.
//  * reading OCRnx gives the buffer in PWM modes; OCRnx reads go past TEMP, TCNTn and ICRn reads
//    and all 16-bit writes go through the timer's one TEMP.
//  * a write to TCNTn blocks a compare match in the next timer clock, "even when the timer is
//    stopped": then in the first clock that it counts.
// Modelled: modes 0 and 15, prescaler 1 or stopped. Everything else is refused as soon as the timer
// would count with it; nothing is guessed.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_timer.h>
#include <sim_avr.h>

#include "peripheral.h"

#define TIMER16_CHANNELS 3
#define TIMER16_NEVER    UINT64_MAX

// From an edge on ICPn to ICRn and ICFn. The data sheet gives the synchronizer and edge detector
// 2.5 to 3.5 cycles from the edge to its effect; an edge exactly on a clock edge takes 3.
#define TIMER16_ICP_SYNC_CYCLES 3

// "When enabled, the input capture is delayed by four oscillator cycles" (noise canceler, ICNCn);
// "all four [samples] must be equal": a level that lasts less is not seen at all.
#define TIMER16_NOISE_CANCELER_CYCLES 4

struct timer16;

// What a timer reports to its board.
struct timer16_hooks {
    struct peripheral_host host;
    // OCnx (channel 0 = A) has a new level, or was connected or disconnected, at this cycle.
    void (*output)(void *board, struct timer16 *timer, int channel, uint64_t cycle);
};

struct timer16 {
    avr_t *avr;
    avr_timer_t *part; // register addresses and vectors, from simavr's description
    const struct timer16_hooks *hooks;
    char name; // '1', '3', '4' or '5'

    uint8_t tccra, tccrb, temp;
    uint16_t icr;
    uint16_t ocr[TIMER16_CHANNELS];        // what the comparator sees
    uint16_t ocr_buffer[TIMER16_CHANNELS]; // what the program sees
    // Levels of the compare outputs, whether or not they are connected to their pins.
    bool oc_level[TIMER16_CHANNELS];

    bool held;       // by GTCCR: counts only when released
    bool counting;   // clock selected and not held
    uint16_t frozen; // TCNT while not counting
    bool blocked;    // TCNT was written then: the first clock to come has no match
    uint64_t bottom; // cycle of TCNT = 0 while counting
    // The level at the input capture's front end since icp_cycle, and the last level before it that
    // the noise canceler let through.
    bool icp_level, icp_lasting;
    uint64_t icp_cycle;
    // Within the callback of simavr's event, whose result schedules the next one.
    bool delivering;

    // Cycles at which these take effect; TIMER16_NEVER when not due.
    uint64_t match_due[TIMER16_CHANNELS];
    uint64_t bottom_due;
    uint64_t capture_due;
    uint64_t
        second_capture_due; // of an edge so near that the first one is still on its way
};

// The timer has 16 bits.
bool timer16_is_16_bit(const avr_timer_t *part);

// Puts the model in place of simavr's timer. Call once, between the part's init and its first
// reset.
void timer16_attach(struct timer16 *timer,
                    avr_t *avr,
                    avr_timer_t *part,
                    const struct timer16_hooks *hooks);

// The part was reset: all registers are 0 and the timer is stopped.
void timer16_reset(struct timer16 *timer);

// Everything that takes effect up to and including this cycle happens now, in order.
void timer16_sync(struct timer16 *timer, uint64_t cycle);

// Schedules the next effect with simavr. Call after anything that may make an effect come sooner.
void timer16_schedule(struct timer16 *timer);

// GTCCR: from this cycle on all timers stand still (held) or count again.
void timer16_hold(struct timer16 *timer, bool held, uint64_t cycle);

// The level at the input capture's front end (ICPn; on timer 1 also the comparator) may have
// changed at this cycle, which may not be earlier than the last sync less
// TIMER16_ICP_SYNC_CYCLES.
void timer16_icp(struct timer16 *timer, bool level, uint64_t cycle);

// The bits COMnx1:0 of a channel (0: the pin follows PORT).
unsigned timer16_com(const struct timer16 *timer, int channel);

// The number of the waveform mode, WGMn3:0.
unsigned timer16_mode(const struct timer16 *timer);

// ---- between timer16.c (counting) and timer16_registers.c (the program's view) ----

// TCNT in this cycle; the timer must have been synced to it.
uint16_t timer16_count(const struct timer16 *timer, uint64_t cycle);

// Sets TCNT to `count` in this cycle.
void timer16_set_count(struct timer16 *timer, uint16_t count, uint64_t cycle);

// The control registers have changed and are valid from this cycle on.
void timer16_control_changed(struct timer16 *timer, uint64_t cycle);

// A compare register has changed outside PWM modes (without a buffer); it is compared from this
// cycle on.
void timer16_compare_changed(struct timer16 *timer, int channel, uint64_t cycle);
