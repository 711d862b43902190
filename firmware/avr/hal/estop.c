// SPDX-License-Identifier: MIT
// The emergency stop input is on the external interrupt BOARD_ESTOP_INT.
#include "hal/estop.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "avr/hal/board.h"  // BOARD_KEEP
#include "avr/hal/pins.h"   // pins_write_permit
#include "base/apart.h"     // APART
#include "config.h"         // CONFIG_AXES
#include "hal/step_timer.h" // step_timer_halt

// The interrupt's vector and its bits in the registers. EICRA has two bits for the sense of each of
// the first four inputs.
#define VECTOR_OF_INT(number) INT##number##_vect
#define VECTOR_OF(number)     VECTOR_OF_INT(number)
#define ESTOP_VECTOR          VECTOR_OF(BOARD_ESTOP_INT)
#define ESTOP_BIT             BOARD_ESTOP_INT
#define ESTOP_ANY_EDGE        _BV(2 * BOARD_ESTOP_INT)
_Static_assert(BOARD_ESTOP_INT <= 3, "inputs from INT4 on have their sense in EICRB");

// The pin must be tripped at this many looks in a row, 8 cycles apart.
#define CONFIRM_LOOKS 20u
// Most interrupts of the input between two rounds of the main loop. A bouncing contact makes this
// many edges; a contact that chatters without end takes no more processor time than that.
#define EDGES_A_ROUND 16u
// Interrupts left in this round. Before estop_start() the start-up code uses this register (cpu.c).
#define EDGES_LEFT GPIOR2

static volatile bool is_latched;
static volatile bool trips_when_high;

// The pin's level.
static inline bool is_high(void)
{
#define WANT_ESTOP         BOARD_WANTED
#define IS_HIGH(port, bit) return (PIN##port & _BV(bit)) != 0;
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(IS_HIGH(port, bit))
#include BOARD_FILE
}

// Switch PERMIT off, latch the stop and halt every axis. Inline: one return address less on the
// stack of the interrupt.
static inline __attribute__((always_inline)) void stop_all(void)
{
    pins_write_permit(false);
    is_latched = true;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        step_timer_halt(i);
    }
}

// True when the input stays tripped for too long to be noise.
static bool stays_tripped(void)
{
    bool trips = trips_when_high;

    for (uint8_t looks = CONFIRM_LOOKS; looks != 0; looks--) {
        if (is_high() != trips) {
            return false;
        }
    }
    return true;
}

// Stop if the input stays tripped. Returns true when the next edge shall interrupt again. Budget:
// 450 cycles (1000 on the Mega) for a stop, at most once a round; 230 for each edge that proves to
// be noise. Interrupts are off for 25 cycles at a time.
static bool estop_look(void) __asm__("estop_look") __attribute__((used));
static bool estop_look(void)
{
    if (stays_tripped()) {
        stop_all();
        return false;
    }
    if (EDGES_LEFT == 0) {
        return false;
    }
    EDGES_LEFT--;
    return true;
}

// The handler masks its own source while it looks, and lets the step interrupts in after 9 cycles.
// It enables its source again only when it has left the stack except for 4 bytes, so that endless
// edges do not pile up there. Interrupts are off for 4 cycles at that point.
ISR(ESTOP_VECTOR, ISR_NAKED)
{
    __asm__ volatile("cbi %[mask], %[bit]\n\t"
                     "sei\n\t"
                     "push r1\n\t"
                     "push r0\n\t"
                     "in r0, __SREG__\n\t"
                     "push r0\n\t"
                     "clr r1\n\t"
                     "push r18\n\t"
                     "push r19\n\t"
                     "push r20\n\t"
                     "push r21\n\t"
                     "push r22\n\t"
                     "push r23\n\t"
                     "push r24\n\t"
                     "push r25\n\t"
                     "push r26\n\t"
                     "push r27\n\t"
                     "push r30\n\t"
                     "push r31\n\t"
                     "call estop_look\n\t"
                     "bst r24, 0\n\t"
                     "pop r31\n\t"
                     "pop r30\n\t"
                     "pop r27\n\t"
                     "pop r26\n\t"
                     "pop r25\n\t"
                     "pop r24\n\t"
                     "pop r23\n\t"
                     "pop r22\n\t"
                     "pop r21\n\t"
                     "pop r20\n\t"
                     "pop r19\n\t"
                     "pop r18\n\t"
                     "pop r0\n\t"
                     "brtc 1f\n\t"
                     "cli\n\t"
                     "sbi %[mask], %[bit]\n"
                     "1: out __SREG__, r0\n\t"
                     "pop r0\n\t"
                     "pop r1\n\t"
                     "reti"
                     :
                     : [mask] "I"(_SFR_IO_ADDR(EIMSK)), [bit] "I"(ESTOP_BIT));
}

void estop_start(bool tripped_high)
{
    trips_when_high = tripped_high;
    EICRA = (uint8_t)ESTOP_ANY_EDGE;
    EIFR = (uint8_t)_BV(ESTOP_BIT);
    EIMSK = (uint8_t)_BV(ESTOP_BIT);
}

void estop_poll(bool tripped_high)
{
    trips_when_high = tripped_high;
    // Stop once more while the stop is latched: a line may have begun at the very instant of the
    // interrupt. The input may also be tripped without an interrupt, when there was no edge or too
    // many of them.
    if (is_latched || stays_tripped()) {
        stop_all();
    }
    EDGES_LEFT = EDGES_A_ROUND;
    EIMSK |= (uint8_t)_BV(ESTOP_BIT);
}

bool estop_tripped(void)
{
    return is_high() == trips_when_high;
}

bool estop_latched(void)
{
    return is_latched;
}

void estop_release(void)
{
    is_latched = false;
}

APART void permit_write(bool on)
{
    if (!on) {
        pins_write_permit(false);
        return;
    }
    // Interrupts are off, so that the emergency stop cannot come between the decision and the pin.
    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        if (!is_latched) {
            pins_write_permit(true);
        }
    }
}
