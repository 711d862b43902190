// SPDX-License-Identifier: MIT
// PINx behind its synchronizer: sixteen IN instructions, a cycle each, read pin C3 while the test
// changes the pin's level. The ENABLE edge of axis 0 marks the cycle in which the first IN begins.
// RESULT[0]: the samples, the first one in bit 15. RESULT[1] = 0x600D.

#include <avr/io.h>

#include "result.h"

#if defined(__AVR_ATmega2560__)
#define ENABLE  "0x02, 1" // PORTA, bit 1
#define SET_DDR (DDRA = (uint8_t)(1U << 1))
#elif defined(__AVR_ATmega1284P__)
#define ENABLE  "0x08, 1" // PORTC, bit 1
#define SET_DDR (DDRC = (uint8_t)(1U << 1))
#else
#define ENABLE  "0x0B, 5" // PORTD, bit 5
#define SET_DDR (DDRD = (uint8_t)(1U << 5))
#endif

#define BIT 3

int main(void)
{
    uint16_t samples = 0;

    SET_DDR;
    __builtin_avr_delay_cycles(2000);
    // All sixteen go into registers first, so that nothing stands between two of them.
    __asm__ volatile("sbi " ENABLE "\n\t"
                     ".irp n, 0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16\n\t"
                     "in r\\n, %[pin]\n\t"
                     ".endr\n\t"
                     ".irp n, 0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16\n\t"
                     "lsl %A[samples]\n\t"
                     "rol %B[samples]\n\t"
                     "sbrc r\\n, %[bit]\n\t"
                     "ori %A[samples], 1\n\t"
                     ".endr\n\t"
                     : [samples] "+d"(samples)
                     : [pin] "I"(_SFR_IO_ADDR(PINC)), [bit] "I"(BIT)
                     : "r0",
                       "r2",
                       "r3",
                       "r4",
                       "r5",
                       "r6",
                       "r7",
                       "r8",
                       "r9",
                       "r10",
                       "r11",
                       "r12",
                       "r13",
                       "r14",
                       "r15",
                       "r16");
    RESULT[0] = samples;
    RESULT[1] = 0x600D;
    for (;;) {
    }
}
