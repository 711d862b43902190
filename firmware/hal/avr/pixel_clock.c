// SPDX-License-Identifier: MIT
// Input capture of the pixel clock. The counter restarts in every period, so the handler also says
// in which period the edge fell.
#include "hal/pixel_clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "config.h"           // CONFIG_BOARD_*
#include "hal/avr/step_isr.h" // step_engines

#if defined(CONFIG_BOARD_UNO)
#define CAPTURE_VECTOR   TIMER1_CAPT_vect
#define CAPTURE_REGISTER ICR1
#define COUNTER          TCNT1
#define TEMP             OCR1AH
#define FLAGS            TIFR1
#define OVERFLOW_BIT     TOV1
#else
#define CAPTURE_VECTOR   TIMER5_CAPT_vect
#define CAPTURE_REGISTER ICR5
#define COUNTER          TCNT5
#define TEMP             OCR5AH
#define FLAGS            TIFR5
#define OVERFLOW_BIT     TOV5
#endif

// Bits of GPIOR0.
#define EDGE_BUSY    0 // from the edge on, until the main loop has taken it
#define EDGE_OVERRUN 1 // another edge came meanwhile

// A counter read between two looks at the overflow flag has wrapped before it was read, if the flag
// appeared between them and the counter is still below this.
#define JUST_WRAPPED_TICKS 16u

static volatile bool waiting; // `newest` is complete
static struct pixel_capture newest;

// As short as can be with interrupts off, 13 cycles: the step interrupts come first. An edge that
// finds the one before it not taken is noted only, so that a noisy clock cannot nest this.
static void capture_body(void) __asm__("__vector_capture_body")
    __attribute__((signal, used));

ISR(CAPTURE_VECTOR, ISR_NAKED)
{
    __asm__ volatile("sbic %[flags], %[busy]\n\t"
                     "rjmp 1f\n\t"
                     "sbi %[flags], %[busy]\n\t"
                     "sei\n\t"
                     "rjmp __vector_capture_body\n"
                     "1: sbi %[flags], %[overrun]\n\t"
                     "reti"
                     :
                     : [flags] "I"(_SFR_IO_ADDR(GPIOR0)),
                       [busy] "I"(EDGE_BUSY),
                       [overrun] "I"(EDGE_OVERRUN));
}

// m is the period whose interrupt was served last; it loaded m + 1.
//
//     served:      m         (m + 1 begins, overflow pending)
//     counter   ---|---------------|------
//     edge in m: no overflow pending, or the captured value is beyond the counter
//     edge in m + 1: overflow pending and the captured value is not beyond the counter
//
// The sample, the flag and the counter belong together: 19 cycles with interrupts off. Right as
// long as no more than one period began since the edge: up to about 150 cycles may lie between. In
// shorter periods the edge error that is reported may be off by periods; line zero never is,
// because an axis at rest has long ones.
//
// Reading ICRn and TCNTn disturbs TEMP, which belongs to a run (step_isr.S): it is put back.
// Budget: 160 cycles, once a pixel.
static void capture_body(void)
{
    const struct step_engine *engine = &step_engines[CONFIG_PIXEL_CLOCK_AXIS];
    uint16_t captured = 0;
    uint16_t counter = 0;
    uint8_t flags_before = 0;
    uint8_t flags_after = 0;
    uint8_t tail = 0;
    int8_t left = 0;
    uint16_t idle_count = 0;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        captured = CAPTURE_REGISTER;
        TEMP = engine->run_high;
    }
    // The instruction behind an SEI runs before any interrupt: it must not be the next CLI.
    __asm__ volatile("nop");
    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        tail = engine->tail;
        left = engine->left;
        idle_count = engine->idle_count;
        flags_before = FLAGS;
        counter = COUNTER;
        flags_after = FLAGS;
        TEMP = engine->run_high;
    }
    bool wrapped =
        (flags_before & _BV(OVERFLOW_BIT)) != 0 ||
        ((flags_after & _BV(OVERFLOW_BIT)) != 0 && counter < JUST_WRAPPED_TICKS);

    newest.back = 1;
    if (wrapped && captured <= counter) {
        newest.back = 0;
    } else if (!wrapped && captured > counter) {
        newest.back = 2;
    }
    newest.ticks = captured;
    newest.sample = step_engine_sample_of(tail, left, 0, idle_count);
    waiting = true;
}

bool pixel_clock_waiting(void)
{
    return waiting;
}

bool pixel_clock_take(struct pixel_capture *capture, bool *lost)
{
    if (!waiting) {
        return false;
    }
    // The handler leaves an edge that waits alone.
    *capture = newest;
    waiting = false;
    // In this order: an edge from here on is either taken next or noted as one too many.
    GPIOR0 &= (uint8_t)~_BV(EDGE_BUSY);
    *lost = (GPIOR0 & _BV(EDGE_OVERRUN)) != 0;
    GPIOR0 &= (uint8_t)~_BV(EDGE_OVERRUN);
    return true;
}
