// SPDX-License-Identifier: MIT
// Asks for what the simulator does not model; which, the test pokes into GPIOR2.

#include <avr/io.h>

static void fast_pwm(uint16_t top)
{
    OCR1A = top;
    TCCR1A = (uint8_t)((1U << WGM11) | (1U << WGM10));
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
}

static void ask(uint8_t what)
{
    switch (what) {
    case 1: // mode 14, started
        TCCR1A = (uint8_t)(1U << WGM11);
        TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
        break;
    case 2: // prescaler 8
        TCCR1B = (uint8_t)(1U << CS11);
        break;
    case 3: // toggle
        OCR1A = 99;
        TCCR1A = (uint8_t)((1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
        TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
        break;
    case 4: // TOP below 3
        fast_pwm(2);
        break;
    case 5: // force compare
        TCCR1C = (uint8_t)(1U << FOC1B);
        break;
    case 6: // synchronous UART
        UCSR0C = (uint8_t)(1U << UMSEL00);
        break;
    case 7: // TCNT beyond TOP
        fast_pwm(999);
        TCNT1 = 2000;
        break;
    case 8: // OCR1A written too late for the first period
        TCCR1A = (uint8_t)((1U << WGM11) | (1U << WGM10));
        TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12));
        OCR1A = 999;
        TCCR1B |= (uint8_t)(1U << CS10);
        break;
    default:
        break;
    }
}

int main(void)
{
    ask(GPIOR2);
    for (;;) {
    }
}
