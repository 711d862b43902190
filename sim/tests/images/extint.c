// SPDX-License-Identifier: MIT
// The e-stop's external interrupt: INT0 on the Uno (PD2), INT3 on the Mega (PD3), INT2 on the
// m1284 (PB2). GPIOR2 (the test pokes it): bits 1:0 the sense, bit 4: not enabled at first. The
// handler pulses ENABLE of axis 0.
// With bit 4: RESULT[0] = INTF some time later, RESULT[1] = after a zero has been written to it,
// RESULT[2] = after a one; with a one in bit 5 the interrupt is enabled instead of these. With bit
// 6 the pin is an output, which goes low and some time later high. With bit 7 the program clears
// the flag before it lets interrupts in.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#if defined(__AVR_ATmega2560__)
#define LINE    3
#define VECTOR  INT3_vect
#define ENABLE  "0x02, 1" // PORTA, bit 1
#define SET_DDR (DDRA = (uint8_t)(1U << 1))
#define PULL_UP (PORTD |= (uint8_t)(1U << 3))
#define RELEASE (PORTD &= (uint8_t)~(1U << 3))
#define OUTPUT  (DDRD |= (uint8_t)(1U << 3))
#elif defined(__AVR_ATmega1284P__)
#define LINE    2
#define VECTOR  INT2_vect
#define ENABLE  "0x08, 1" // PORTC, bit 1
#define SET_DDR (DDRC = (uint8_t)(1U << 1))
#define PULL_UP (PORTB |= (uint8_t)(1U << 2))
#define RELEASE (PORTB &= (uint8_t)~(1U << 2))
#define OUTPUT  (DDRB |= (uint8_t)(1U << 2))
#else
#define LINE    0
#define VECTOR  INT0_vect
#define ENABLE  "0x0B, 5" // PORTD, bit 5
#define SET_DDR (DDRD = (uint8_t)(1U << 5))
#define PULL_UP (PORTD |= (uint8_t)(1U << 2))
#define RELEASE (PORTD &= (uint8_t)~(1U << 2))
#define OUTPUT  (DDRD |= (uint8_t)(1U << 2))
#endif

ISR(VECTOR, ISR_NAKED)
{
    __asm__ volatile("sbi " ENABLE "\n\t"
                     "cbi " ENABLE "\n\t"
                     "reti\n\t");
}

static void look(void)
{
    RESULT[0] = EIFR & (1U << LINE);
    EIFR = 0;
    RESULT[1] = EIFR & (1U << LINE);
    EIFR = (uint8_t)(1U << LINE);
    RESULT[2] = EIFR & (1U << LINE);
    RESULT[3] = 0x600D;
}

int main(void)
{
    uint8_t what = GPIOR2;

    SET_DDR;
    PULL_UP;
    EICRA = (uint8_t)((what & 3U) << (2 * LINE));
    EIFR = 0xFF;
    sei();
    if ((what & 0x80U) != 0) {
        cli();
        EIMSK = (uint8_t)(1U << LINE);
        __builtin_avr_delay_cycles(30000);
        EIFR = (uint8_t)(1U << LINE);
        sei();
    }
    if ((what & 0x10U) != 0) {
        __builtin_avr_delay_cycles(5000);
        if ((what & 0x20U) == 0) {
            look();
        }
    }
    if ((what & 0x10U) == 0 || (what & 0x20U) != 0) {
        EIMSK = (uint8_t)(1U << LINE);
    }
    if ((what & 0x40U) != 0) {
        RELEASE;
        OUTPUT;
        __builtin_avr_delay_cycles(5000);
        PULL_UP;
    }
    for (;;) {
        __asm__ volatile("nop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\t");
    }
}
