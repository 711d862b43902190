// SPDX-License-Identifier: MIT
// What a program sees of the analog comparator, at known cycles. Each RESULT[] word is one
// experiment; the expected values and their reckoning are in test_comparator.py, by the same
// numbers.
//
// Reckoning: as in registers.c. `cbi` takes two cycles and writes in its second (a); the pin is low
// from a + 1 on. ADC0 and ADC1 are outputs here, so that the program makes its own edges.

#include <avr/io.h>
#include <avr/wdt.h>

#include "result.h"

#define NOPS(count) ".rept " #count "\n\tnop\n\t.endr\n\t"

#if defined(__AVR_ATmega2560__)
#define ADC_PORT PORTF
#define ADC_DDR  DDRF
#define ICP_BIT  4 // PD4
#define ICP_PORT PORTD
#define ICP_DDR  DDRD
#elif defined(__AVR_ATmega1284P__)
#define ADC_PORT PORTA
#define ADC_DDR  DDRA
#define ICP_BIT  6 // PD6
#define ICP_PORT PORTD
#define ICP_DDR  DDRD
#else
#define ADC_PORT PORTC
#define ADC_DDR  DDRC
#define ICP_BIT  0 // PB0
#define ICP_PORT PORTB
#define ICP_DDR  DDRB
#endif

#define NOTHING  0xFFFFU
#define RISING   ((uint8_t)(1U << ICES1))
#define FALLING  0U
#define CANCELER ((uint8_t)(1U << ICNC1))
#define COMPARE  ((uint8_t)(1U << ACBG))
#define CAPTURE  ((uint8_t)((1U << ACBG) | (1U << ACIC)))
#define REGISTERS                                                                        \
    [acsr] "I"(_SFR_IO_ADDR(ACSR)), [port] "I"(_SFR_IO_ADDR(ADC_PORT)),                  \
        [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)), [tifr] "I"(_SFR_IO_ADDR(TIFR1)),             \
        [admux] "n"(_SFR_MEM_ADDR(ADMUX))

// Timer 1 at rest at 0, ADC0 high (output of the comparator 0), ADC1 low, ICP1 low, no flags.
static void prepare(uint8_t acsr)
{
    TCCR1B = 0;
    TCCR1A = 0;
    TCNT1 = 0;
    ICP_DDR |= (uint8_t)(1U << ICP_BIT);
    ICP_PORT &= (uint8_t)~(1U << ICP_BIT);
    ADC_DDR = 3U;
    ADC_PORT = 1U;
    ADCSRB = (uint8_t)(1U << ACME);
    ADMUX = 0;
    ACSR = acsr;
    __asm__ volatile(NOPS(16));
    ACSR = (uint8_t)(acsr | (1U << ACI));
    TIFR1 = 0xFFU;
}

// 0 to 3: ACSR's ACO and ACI in the cycle in which the pin falls, and 1, 2, 3 later.
#define SEE_OUTPUT(index, nops)                                                          \
    do {                                                                                 \
        uint8_t seen;                                                                    \
        prepare(COMPARE);                                                                \
        __asm__ volatile("cbi %[port], 0\n\t" NOPS(nops) "in %[seen], %[acsr]\n\t"       \
                         : [seen] "=r"(seen)                                             \
                         : REGISTERS);                                                   \
        RESULT[index] = seen;                                                            \
    } while (0)

// ACSR some time after the pin has fallen, or after it has risen again, by ACIS1:0.
static uint8_t flag(uint8_t mode, uint8_t level)
{
    prepare((uint8_t)(COMPARE | mode));
    ADC_PORT = 0;
    __asm__ volatile(NOPS(8));
    if (level != 0U) {
        ACSR = (uint8_t)(COMPARE | mode | (1U << ACI));
        ADC_PORT = 1U;
        __asm__ volatile(NOPS(8));
    }
    return ACSR;
}

// ICR1, or NOTHING if there was no capture. The edge is in the cycle of TCNT1 = 2, if not otherwise
// said.
static uint16_t captured(void)
{
    return ((TIFR1 & (1U << ICF1)) != 0U) ? ICR1 : NOTHING;
}

static uint16_t capture(uint8_t timer, uint8_t acsr)
{
    prepare(acsr);
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t"
        "cbi %[port], 0\n\t" NOPS(32)::[on] "r"((uint8_t)(timer | (1U << CS10))),
        REGISTERS);
    return captured();
}

// The pin falls, and rises again so many cycles later: 2 or 4.
static uint16_t short_pulse(void)
{
    prepare(CAPTURE);
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "cbi %[port], 0\n\t"
                     "sbi %[port], 0\n\t" NOPS(32)::[on] "r"(
                         (uint8_t)(RISING | CANCELER | (1U << CS10))),
                     REGISTERS);
    return captured();
}

static uint16_t long_pulse(void)
{
    prepare(CAPTURE);
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "cbi %[port], 0\n\t" NOPS(2) "sbi %[port], 0\n\t" NOPS(32)::[on] "r"(
                         (uint8_t)(RISING | CANCELER | (1U << CS10))),
                     REGISTERS);
    return captured();
}

// The flag in the third cycle after the edge, and one before.
#define SEE_FLAG(index, nops)                                                            \
    do {                                                                                 \
        uint8_t seen;                                                                    \
        prepare(CAPTURE);                                                                \
        __asm__ volatile("sts %[tccrb], %[on]\n\t"                                       \
                         "cbi %[port], 0\n\t" NOPS(nops) "in %[seen], %[tifr]\n\t"       \
                         : [seen] "=r"(seen)                                             \
                         : [on] "r"((uint8_t)(RISING | (1U << CS10))), REGISTERS);       \
        RESULT[index] = seen & (1U << ICF1);                                             \
    } while (0)

// Another channel is chosen: ADC1 is low.
static uint16_t other_channel(void)
{
    prepare(CAPTURE);
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t"
        "sts %[admux], %[one]\n\t" NOPS(32)::[on] "r"((uint8_t)(RISING | (1U << CS10))),
        [one] "r"((uint8_t)1U),
        REGISTERS);
    return captured();
}

// Another source is chosen while the comparator's output is 1 and ICP1 is low.
static uint16_t other_source(uint8_t from, uint8_t to, uint8_t timer)
{
    prepare(from);
    ADC_PORT = 0;
    __asm__ volatile(NOPS(16));
    TIFR1 = 0xFFU;
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t"
        "out %[acsr], %[to]\n\t" NOPS(32)::[on] "r"((uint8_t)(timer | (1U << CS10))),
        [to] "r"(to),
        REGISTERS);
    return captured();
}

// The output is 1 and its flag not yet read when the watchdog resets the part.
static void reset_with_output(void)
{
    prepare(COMPARE);
    wdt_enable(WDTO_15MS);
    ADC_PORT = 0;
    for (;;) {
    }
}

int main(void)
{
    uint8_t after_reset = ACSR;

    if ((MCUSR & (1U << WDRF)) != 0U) {
        MCUSR = 0;
        wdt_disable();
        RESULT[22] = after_reset;
        RESULT[23] = 0x600DU;
        for (;;) {
        }
    }
    SEE_OUTPUT(0, 0);
    SEE_OUTPUT(1, 1);
    SEE_OUTPUT(2, 2);
    SEE_OUTPUT(3, 3);
    RESULT[4] = flag(0, 0);
    RESULT[5] = flag(0, 1);
    RESULT[6] = flag((uint8_t)(1U << ACIS1), 0);
    RESULT[7] = flag((uint8_t)(1U << ACIS1), 1);
    RESULT[8] = flag((uint8_t)((1U << ACIS1) | (1U << ACIS0)), 0);
    RESULT[9] = flag((uint8_t)((1U << ACIS1) | (1U << ACIS0)), 1);
    RESULT[10] = capture(RISING, CAPTURE);
    RESULT[11] = capture(FALLING, CAPTURE);
    RESULT[12] = capture(RISING, COMPARE);
    RESULT[13] = capture((uint8_t)(RISING | CANCELER), CAPTURE);
    RESULT[14] = short_pulse();
    RESULT[15] = long_pulse();
    SEE_FLAG(16, 2);
    SEE_FLAG(17, 3);
    RESULT[18] = other_channel();
    RESULT[19] = other_source(COMPARE, CAPTURE, RISING);
    RESULT[20] = other_source(CAPTURE, COMPARE, FALLING);
    RESULT[21] = other_source(CAPTURE, (uint8_t)(CAPTURE | (1U << ACIS1)), FALLING);
    reset_with_output();
}
