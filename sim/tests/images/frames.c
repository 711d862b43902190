// SPDX-License-Identifier: MIT
// Frames that the firmware never sends: two stop bits, and a character written while the
// transmitter is off. 117647 baud (136 cycles a bit); the reckoning is in test_uart.py.

#include <avr/io.h>

#include "result.h"

#define FRAME_8E2 "1632" // 12 bits
#define FRAME_5N2 "1088" // 8 bits

#define FORMAT_8E2                                                                       \
    ((uint8_t)((1U << UPM01) | (1U << USBS0) | (1U << UCSZ01) | (1U << UCSZ00)))
#define FORMAT_5N2 ((uint8_t)(1U << USBS0))
#define SENDING    ((uint8_t)(1U << TXEN0))

static void open_uart(uint8_t format, uint8_t enabled)
{
    UBRR0 = 16;
    UCSR0A = (uint8_t)((1U << U2X0) | (1U << TXC0));
    UCSR0C = format;
    UCSR0B = enabled;
}

// TXC0 as it is read so many cycles after the first one of a frame, less one.
#define COMPLETE(at, format, cycles)                                                     \
    do {                                                                                 \
        uint8_t flags;                                                                   \
                                                                                         \
        open_uart(format, SENDING);                                                      \
        __asm__ volatile("sts %[udr], %[byte]\n\t"                                       \
                         ".rept " cycles "\n\tnop\n\t.endr\n\t"                          \
                         "lds %[flags], %[ucsra]\n\t"                                    \
                         : [flags] "=&r"(flags)                                          \
                         : [byte] "r"((uint8_t)0x15),                                    \
                           [udr] "n"(_SFR_MEM_ADDR(UDR0)),                               \
                           [ucsra] "n"(_SFR_MEM_ADDR(UCSR0A)));                          \
        RESULT[at] = flags & (1U << TXC0);                                               \
        __builtin_avr_delay_cycles(4000);                                                \
    } while (0)

// 4: UDRE0 while the transmitter is off and after a character was written then, 5: TXC0 some frames
// after it has been switched on.
static void written_while_off(void)
{
    open_uart(FORMAT_8E2, 0);
    UDR0 = 0x77;
    RESULT[4] = UCSR0A & (1U << UDRE0);
    UCSR0B = SENDING;
    __builtin_avr_delay_cycles(8000);
    RESULT[5] = UCSR0A & (1U << TXC0);
}

int main(void)
{
    COMPLETE(0, FORMAT_8E2, FRAME_8E2 " - 2");
    COMPLETE(1, FORMAT_8E2, FRAME_8E2 " - 1");
    COMPLETE(2, FORMAT_5N2, FRAME_5N2 " - 2");
    COMPLETE(3, FORMAT_5N2, FRAME_5N2 " - 1");
    written_while_off();
    UDR0 = 0x11; // one right behind the other
    UDR0 = 0x12;
    RESULT[6] = 0x600D;
    for (;;) {
    }
}
