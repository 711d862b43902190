// SPDX-License-Identifier: MIT
// The bus driver switched off too early: answers each character with 0x5A and switches the driver
// off eight cycles for each unit of what came later. 117647 baud (136 cycles a bit), 8E1.

#include <avr/io.h>

#if defined(__AVR_ATmega2560__)
#define DRIVER_PORT "0x0E, 5" // PORTE, bit 5
#define DRIVER_OUT  (DDRE = (uint8_t)(1U << 5))
#else
#define DRIVER_PORT "0x0B, 3" // PORTD, bit 3
#define DRIVER_OUT  (DDRD = (uint8_t)(1U << 3))
#endif

int main(void)
{
    DRIVER_OUT;
    UBRR0 = 16;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01) | (1U << UCSZ00));
    UCSR0B = (uint8_t)((1U << RXEN0) | (1U << TXEN0));
    for (;;) {
        uint8_t units;

        while ((UCSR0A & (1U << RXC0)) == 0) {
        }
        units = UDR0;
        __asm__ volatile("sbi " DRIVER_PORT "\n\t"
                         "sts %[udr], %[byte]\n\t"
                         "1:\n\t"
                         ".rept 5\n\tnop\n\t.endr\n\t"
                         "dec %[units]\n\t"
                         "brne 1b\n\t"
                         "cbi " DRIVER_PORT "\n\t"
                         : [units] "+r"(units)
                         : [byte] "r"((uint8_t)0x5A), [udr] "n"(_SFR_MEM_ADDR(UDR0)));
    }
}
