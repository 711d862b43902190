// SPDX-License-Identifier: MIT
// The UART at known cycles: see test_uart.py for the reckoning. 117647 baud (136 cycles a bit),
// 8E1.

#include <avr/io.h>

#include "result.h"

#define FRAME_CYCLES "1496" // 11 bits of 136 cycles

static void open_uart(uint8_t enabled)
{
    UBRR0 = 16;
    UCSR0A = (uint8_t)((1U << U2X0) | (1U << TXC0));
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01) | (1U << UCSZ00));
    UCSR0B = enabled;
}

#define REGISTERS [udr] "n"(_SFR_MEM_ADDR(UDR0)), [ucsra] "n"(_SFR_MEM_ADDR(UCSR0A))

// 0, 1: TXC0 one cycle before the end of a frame, and at its end.
static void complete(void)
{
    uint8_t flags;

    open_uart((uint8_t)(1U << TXEN0));
    __asm__ volatile("sts %[udr], %[byte]\n\t"
                     ".rept " FRAME_CYCLES " - 2\n\tnop\n\t.endr\n\t"
                     "lds %[flags], %[ucsra]\n\t"
                     : [flags] "=&r"(flags)
                     : [byte] "r"((uint8_t)0x55), REGISTERS);
    RESULT[0] = flags & (1U << TXC0);
    open_uart((uint8_t)(1U << TXEN0));
    __asm__ volatile("sts %[udr], %[byte]\n\t"
                     ".rept " FRAME_CYCLES " - 1\n\tnop\n\t.endr\n\t"
                     "lds %[flags], %[ucsra]\n\t"
                     : [flags] "=&r"(flags)
                     : [byte] "r"((uint8_t)0x55), REGISTERS);
    RESULT[1] = flags & (1U << TXC0);
}

// 2, 3, 4: UDRE0 with a frame on its way, with one more waiting, and when that one has begun.
static void buffered(void)
{
    open_uart((uint8_t)(1U << TXEN0));
    UDR0 = 'a';
    RESULT[2] = UCSR0A & (1U << UDRE0);
    UDR0 = 'b';
    RESULT[3] = UCSR0A & (1U << UDRE0);
    __asm__ volatile(".rept " FRAME_CYCLES "\n\tnop\n\t.endr\n\t" ::);
    RESULT[4] = UCSR0A & (1U << UDRE0);
    __asm__ volatile(".rept " FRAME_CYCLES "\n\tnop\n\t.endr\n\t" ::);
}

// 6...: waits in RESULT[5] = 1 until the test has sent four bytes, then reads status and data.
static void overrun(void)
{
    open_uart((uint8_t)(1U << RXEN0));
    RESULT[5] = 1;
    while (RESULT[5] == 1) {
    }
    for (uint8_t i = 0; i < 4; i++) {
        RESULT[6U + 2U * i] = UCSR0A & ((1U << RXC0) | (1U << DOR0) | (1U << FE0));
        RESULT[7U + 2U * i] = UDR0;
    }
}

int main(void)
{
    RESULT[15] = UDR0; // as a reset leaves it
    complete();
    buffered();
    overrun();
    RESULT[14] = 0x600D;
    for (;;) {
    }
}
