// SPDX-License-Identifier: MIT
// Timer 1's input capture from the analog comparator, in mode 15, TOP = 9999: a STEP edge every
// period (so that the test knows BOTTOM), and every captured count in RESULT[1...]. RESULT[0]
// counts them. The test pokes before the start: GPIOR2 what to do (bits below), RESULT[62] the ADC
// channel; and later RESULT[63], the channel to change to.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define TOP_TICKS 9999U
#define RESULTS   60U

#define DO_RISING   0x01U // ICES1: the comparator's output rises, that is, the pin falls
#define DO_CANCELER 0x02U // ICNC1
#define DO_PIN      0x04U // ACIC = 0: ICP1 captures
#define DO_PULL_UP  0x08U

#define FIRST_CHANNEL RESULT[62]
#define CHANNEL       RESULT[63]

ISR(TIMER1_CAPT_vect)
{
    uint16_t at = RESULT[0];

    if (at < RESULTS) {
        RESULT[0] = at + 1U;
        RESULT[1U + at] = ICR1;
    }
}

static void select_channel(uint16_t channel)
{
#if defined(__AVR_ATmega2560__)
    ADCSRB = (uint8_t)((1U << ACME) | ((channel > 7U) ? (1U << MUX5) : 0U));
#else
    ADCSRB = (uint8_t)(1U << ACME);
#endif
    ADMUX = (uint8_t)(channel & 7U);
}

static void pull_up(void)
{
#if defined(__AVR_ATmega2560__)
    PORTF = 0xFF;
    PORTK = 0xFF;
#elif defined(__AVR_ATmega1284P__)
    PORTA = 0xFF;
#else
    PORTC = 0x3F;
#endif
}

static void start_timer(uint8_t what)
{
#if defined(__AVR_ATmega2560__)
    DDRB = (uint8_t)(1U << 6);
#elif defined(__AVR_ATmega1284P__)
    DDRD = (uint8_t)(1U << 4);
#else
    DDRB = (uint8_t)(1U << 2);
#endif
    OCR1A = TOP_TICKS;
    OCR1B = 31;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10) |
                       (((what & DO_RISING) != 0U) ? (1U << ICES1) : 0U) |
                       (((what & DO_CANCELER) != 0U) ? (1U << ICNC1) : 0U));
}

int main(void)
{
    uint8_t what = GPIOR2;
    uint16_t channel = FIRST_CHANNEL;

    CHANNEL = channel;
    RESULT[0] = 0;
    if ((what & DO_PULL_UP) != 0U) {
        pull_up();
    }
    start_timer(what);
    select_channel(channel);
    ACSR = (uint8_t)((1U << ACBG) | (((what & DO_PIN) == 0U) ? (1U << ACIC) : 0U));
    // "Changing trigger source can trigger a capture": seven cycles later with the noise canceler.
    __asm__ volatile("nop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\t");
    TIFR1 = (uint8_t)(1U << ICF1);
    TIMSK1 = (uint8_t)(1U << ICIE1);
    sei();
    for (;;) {
        if (CHANNEL != channel) {
            channel = CHANNEL;
            select_channel(channel);
        }
    }
}
