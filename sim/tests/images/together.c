// SPDX-License-Identifier: MIT
// All timers of the board set up while GTCCR holds them, then released by one write: periods of
// 1000 ticks that must stay in phase. After 40 periods of timer 1 they are held for a while, and
// go on.

#include <avr/interrupt.h>
#include <avr/io.h>

#define MODE_A ((uint8_t)((1U << 5) | (1U << 4) | 3U)) // COMnB = 3, WGMn1:0 = 3
#define MODE_B ((uint8_t)((3U << 3) | 1U))             // WGMn3:2 = 3, prescaler 1
#define HOLD   ((uint8_t)((1U << TSM) | (1U << PSRSYNC)))

#define SET_UP(n)                                                                        \
    do {                                                                                 \
        OCR##n##A = 999;                                                                 \
        OCR##n##B = 31;                                                                  \
        TCCR##n##A = MODE_A;                                                             \
        TCCR##n##B = MODE_B;                                                             \
    } while (0)

static volatile uint8_t periods;

ISR(TIMER1_OVF_vect)
{
    periods++;
}

int main(void)
{
    GTCCR = HOLD;
    SET_UP(1);
    TIMSK1 = (uint8_t)(1U << TOIE1);
#if defined(__AVR_ATmega2560__)
    SET_UP(3);
    SET_UP(4);
    SET_UP(5);
    DDRB = (uint8_t)(1U << 6);
    DDRE = (uint8_t)(1U << 4);
    DDRH = (uint8_t)(1U << 4);
    DDRL = (uint8_t)(1U << 4);
#else
    DDRB = (uint8_t)(1U << 2);
#endif
    GTCCR = 0;
    sei();
    while (periods < 40) {
    }
    GTCCR = HOLD;
    for (volatile uint16_t i = 0; i < 2000; i++) {
    }
    GTCCR = 0;
    for (;;) {
    }
}
