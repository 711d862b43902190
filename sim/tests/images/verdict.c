// SPDX-License-Identifier: MIT
// Ends like a Unity image: a line of text, three failures in GPIOR0, sleep with interrupts off.

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

int main(void)
{
    static const char text[] = "three failures\n";

    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0B = (uint8_t)(1U << TXEN0);
    for (const char *c = text; *c != '\0'; c++) {
        while ((UCSR0A & (1U << UDRE0)) == 0) {
        }
        UDR0 = (uint8_t)*c;
    }
    GPIOR0 = 3;
    cli();
    for (;;) {
        sleep_mode();
    }
}
