// SPDX-License-Identifier: MIT
// The input is on an external interrupt: INT0 on the Uno, INT3 on the Mega.
#include "hal/estop.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "config.h"         // CONFIG_BOARD_*
#include "hal/avr/board.h"  // BOARD_FILE
#include "hal/avr/pins.h"   // pins_write_permit
#include "hal/step_timer.h" // step_timer_halt

#if defined(CONFIG_BOARD_UNO)
#define ESTOP_VECTOR   INT0_vect
#define ESTOP_BIT      INT0
#define ESTOP_ANY_EDGE _BV(ISC00)
#else
#define ESTOP_VECTOR   INT3_vect
#define ESTOP_BIT      INT3
#define ESTOP_ANY_EDGE _BV(ISC30)
#endif

// Looks at the pin, 8 cycles apart.
#define CONFIRM_LOOKS 20u

static volatile bool latched;
static volatile bool high_trips;
static bool tripped_before; // in the last round

// The pin's level.
static inline bool is_high(void)
{
#define IS_ESTOP(port, bit) return (PIN##port & _BV(bit)) != 0;
#define BOARD_AXIS(axis, timer)
#define BOARD_PIN(signal, axis, port, bit, header_pin) LOOK_##signal(port, bit)
#define LOOK_STEP(port, bit)
#define LOOK_DIR(port, bit)
#define LOOK_ENABLE(port, bit)
#define LOOK_HOME(port, bit)
#define LOOK_LIMIT_MINUS(port, bit)
#define LOOK_LIMIT_PLUS(port, bit)
#define LOOK_PIXEL_CLOCK(port, bit)
#define LOOK_PIXEL_CLOCK_COPY(port, bit)
#define LOOK_RS485_DE(port, bit)
#define LOOK_PERMIT(port, bit)
#define LOOK_ESTOP(port, bit) IS_ESTOP(port, bit)
#include BOARD_FILE
}

static void stop_all(void)
{
    pins_write_permit(false);
    latched = true;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        step_timer_halt(i);
    }
}

static void estop_body(void) __asm__("__vector_estop_body") __attribute__((signal, used));

// Masks itself until the main loop comes by, so that a chattering input costs one look a round, and
// lets the step interrupts in after 9 cycles.
ISR(ESTOP_VECTOR, ISR_NAKED)
{
    __asm__ volatile("cbi %[mask], %[bit]\n\t"
                     "sei\n\t"
                     "rjmp __vector_estop_body"
                     :
                     : [mask] "I"(_SFR_IO_ADDR(EIMSK)), [bit] "I"(ESTOP_BIT));
}

// Budget: 450 cycles, 1000 on the Mega, once a round at most; interrupts are off for 45 of them at
// a time.
static void estop_body(void)
{
    bool trips = high_trips;

    for (uint8_t looks = CONFIRM_LOOKS; looks != 0; looks--) {
        if (is_high() != trips) {
            return;
        }
    }
    stop_all();
}

void estop_start(bool tripped_high)
{
    high_trips = tripped_high;
    EICRA = (uint8_t)ESTOP_ANY_EDGE;
    EIFR = (uint8_t)_BV(ESTOP_BIT);
    EIMSK = (uint8_t)_BV(ESTOP_BIT);
}

void estop_poll(bool tripped_high)
{
    high_trips = tripped_high;
    bool tripped = estop_tripped();

    // Latched: a line may have begun at the very instant.
    if (latched || (tripped && tripped_before)) {
        stop_all();
    }
    tripped_before = tripped;
    EIMSK |= (uint8_t)_BV(ESTOP_BIT);
}

bool estop_tripped(void)
{
    return is_high() == high_trips;
}

bool estop_latched(void)
{
    return latched;
}

void estop_release(void)
{
    latched = false;
}

void permit_write(bool on)
{
    // The interrupt comes before or after this, never between the decision and the pin.
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        pins_write_permit(on && !latched);
    }
}
