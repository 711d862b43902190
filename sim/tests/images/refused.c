// SPDX-License-Identifier: MIT
// Asks for what the simulator does not model; which, the test pokes into GPIOR2.

#include <avr/io.h>

#if defined(PRR0)
#define POWER PRR0
#else
#define POWER PRR
#endif

static void fast_pwm(uint16_t top)
{
    OCR1A = top;
    TCCR1A = (uint8_t)((1U << WGM11) | (1U << WGM10));
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
}

// Everything as it must be for the comparator to capture, but for `acsr`, `adcsra` and `admux`.
static void comparator(uint8_t acsr, uint8_t adcsra, uint8_t admux)
{
    ADCSRB = (uint8_t)(1U << ACME);
    ADCSRA = adcsra;
    ADMUX = admux;
    ACSR = acsr;
}

static void ask_comparator(uint8_t what)
{
    const uint8_t good = (uint8_t)((1U << ACBG) | (1U << ACIC));

    switch (what) {
    case 20:
        comparator((uint8_t)(good | (1U << ACIE)), 0, 0);
        break;
    case 21: // AIN0
        comparator((uint8_t)(1U << ACIC), 0, 0);
        break;
    case 22:
        comparator(good, (uint8_t)(1U << ADEN), 0);
        break;
    case 23: // AIN1, chosen when it already captures
        comparator(good, 0, 0);
        ADCSRB = 0;
        break;
    case 24:
        comparator((uint8_t)(good | (1U << ACD)), 0, 0);
        break;
    case 25: // no digital pin
        comparator(good, 0, 6);
        break;
    case 26: // the ADC's own bandgap input
        comparator(good, 0, 14);
        break;
    case 27:
        comparator(good, 0, 0);
        POWER = (uint8_t)(1U << PRADC);
        break;
    case 28:
        comparator((uint8_t)(good | (1U << ACIS0)), 0, 0);
        break;
    default: // as modelled: no complaint
        comparator(good, 0, 5);
        break;
    }
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
    case 9: // TCNT at TOP, behind which it would not turn
        fast_pwm(999);
        TCNT1 = 999;
        break;
    case 8: // OCR1A written too late for the first period
        TCCR1A = (uint8_t)((1U << WGM11) | (1U << WGM10));
        TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12));
        OCR1A = 999;
        TCCR1B |= (uint8_t)(1U << CS10);
        break;
    default:
        ask_comparator(what);
        break;
    }
}

int main(void)
{
    ask(GPIOR2);
    for (;;) {
    }
}
