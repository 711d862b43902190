// SPDX-License-Identifier: MIT
// What an interrupt costs and when it comes, measured by timer 1 from inside. Reckoning and
// expected values in test_interrupts.py.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define NOPS(count) ".rept " #count "\n\tnop\n\t.endr\n\t"
#define STARTED     ((uint8_t)(1U << CS10))

// The handlers are naked: r23 to r25 carry what they see, and the programs below spare these.

// TCNT1 at its first instruction.
ISR(TIMER1_COMPA_vect, ISR_NAKED)
{
    __asm__ volatile("lds r24, 0x84\n\t" // TCNT1L
                     "reti\n\t");
}

// Ten cycles between the vector's jump and RETI.
ISR(TIMER1_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile(NOPS(10) "reti\n\t");
}

// How often r25 has been incremented so far.
ISR(TIMER1_CAPT_vect, ISR_NAKED)
{
    __asm__ volatile("mov r24, r25\n\t"
                     "reti\n\t");
}

ISR(TIMER1_OVF_vect, ISR_NAKED)
{
    __asm__ volatile("mov r23, r25\n\t"
                     "reti\n\t");
}

// An 8-bit timer, which libsimavr models itself.
ISR(TIMER0_OVF_vect, ISR_NAKED)
{
    __asm__ volatile("reti\n\t");
}

static void stop(void)
{
    TCCR1B = 0;
    TIMSK1 = 0;
    TCNT1 = 0;
    OCR1A = 100;
    OCR1B = 0xFFFF;
    TIFR1 = 0xFF;
}

// Sets ICF1: a falling edge on ICP1, made by the program on its own pin.
static void set_capture_flag(void)
{
#if defined(__AVR_ATmega2560__)
    DDRD = (uint8_t)(1U << 4);
    PORTD = (uint8_t)(1U << 4);
    PORTD = 0;
#else
    DDRB = (uint8_t)(1U << 0);
    PORTB = (uint8_t)(1U << 0);
    PORTB = 0;
#endif
    __asm__ volatile(NOPS(8)::);
}

// 0: the match at TCNT1 = 100, awake. 1: asleep.
static void response(void)
{
    uint8_t seen;

    stop();
    TIMSK1 = (uint8_t)(1U << OCIE1A);
    __asm__ volatile("sei\n\t"
                     "sts %[tccrb], %[on]\n\t" NOPS(150) "cli\n\t"
                                                         "mov %[seen], r24\n\t"
                     : [seen] "=r"(seen)
                     : [on] "r"(STARTED), [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B))
                     : "r24");
    RESULT[0] = seen;
    stop();
    TIMSK1 = (uint8_t)(1U << OCIE1A);
    SMCR = (uint8_t)(1U << SE); // idle
    __asm__ volatile("sei\n\t"
                     "sts %[tccrb], %[on]\n\t"
                     "sleep\n\t"
                     "nop\n\t"
                     "cli\n\t"
                     "mov %[seen], r24\n\t"
                     : [seen] "=r"(seen)
                     : [on] "r"(STARTED), [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B))
                     : "r24");
    RESULT[1] = seen;
}

// 2: instructions between SEI and the interrupt that waits for it. 3: between the RETI of one and
// the next, which waits too (ICF1 is served first, then TOV1).
static void one_instruction(void)
{
    uint8_t first;
    uint8_t second;

    stop();
    set_capture_flag();
    TCNT1 = 0xFFFF;
    TCCR1B = STARTED;
    __asm__ volatile(NOPS(4)::); // TOV1
    TIMSK1 = (uint8_t)((1U << ICIE1) | (1U << TOIE1));
    __asm__ volatile("clr r25\n\t"
                     "sei\n\t"
                     "inc r25\n\t"
                     "inc r25\n\t"
                     "inc r25\n\t"
                     "inc r25\n\t"
                     "cli\n\t"
                     "mov %[first], r24\n\t"
                     "mov %[second], r23\n\t"
                     : [first] "=r"(first), [second] "=r"(second)
                     :
                     : "r23", "r24", "r25");
    RESULT[2] = first;
    RESULT[3] = second;
}

// The handler of known length, served 20 times: its cycles are in the simulator's statistics.
static void known_length(void)
{
    stop();
    TIMSK1 = (uint8_t)(1U << OCIE1B);
    sei();
    for (uint8_t i = 0; i < 20; i++) {
        OCR1B = 50;
        TCNT1 = 0;
        TCCR1B = STARTED;
        __builtin_avr_delay_cycles(120);
        TCCR1B = 0;
    }
    cli();
}

// Section 3 for a known time: 4 + 1000 cycles, and an interrupt handler in it that does not count.
static void section(void)
{
    stop();
    OCR1B = 50;
    TIMSK1 = (uint8_t)(1U << OCIE1B);
    sei();
    TCCR1B = STARTED;
    GPIOR1 = 3;
    __asm__ volatile(NOPS(1000)::);
    GPIOR1 = 0;
    cli();
}

// TOV0 comes 6 cycles behind the write of the counter, and waits for 100 nops and SEI.
static void eight_bits(void)
{
    stop();
    TIMSK0 = (uint8_t)(1U << TOIE0);
    TCCR0B = (uint8_t)(1U << CS00);
    TCNT0 = 250;
    __asm__ volatile(NOPS(100) "sei\n\t"
                               "nop\n\t"
                               "cli\n\t" ::);
    TCCR0B = 0;
    TIMSK0 = 0;
}

int main(void)
{
    response();
    one_instruction();
    known_length();
    section();
    eight_bits();
    RESULT[4] = 0x600D;
    for (;;) {
    }
}
