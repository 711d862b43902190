// SPDX-License-Identifier: MIT
// A board on the shared line: takes frames of two bytes, address and value, and answers one that
// has its own address (GPIOR2 at reset, 0 stands for 1) with address and value + 1. 115200 baud
// 8E1.

#include <avr/interrupt.h>
#include <avr/io.h>

#if defined(__AVR_ATmega2560__)
#define DRIVER_ON()  (PORTE |= (uint8_t)(1U << 5))
#define DRIVER_OFF() (PORTE &= (uint8_t)~(1U << 5))
#define DRIVER_OUT() (DDRE |= (uint8_t)(1U << 5))
#else
#define DRIVER_ON()  (PORTD |= (uint8_t)(1U << 3))
#define DRIVER_OFF() (PORTD &= (uint8_t)~(1U << 3))
#define DRIVER_OUT() (DDRD |= (uint8_t)(1U << 3))
#endif

static uint8_t take(void)
{
    while ((UCSR0A & (1U << RXC0)) == 0) {
    }
    return UDR0;
}

static void give(uint8_t byte)
{
    while ((UCSR0A & (1U << UDRE0)) == 0) {
    }
    UDR0 = byte;
}

static void answer(uint8_t address, uint8_t value)
{
    DRIVER_ON();
    UCSR0A = (uint8_t)((1U << U2X0) | (1U << TXC0));
    give(address);
    give((uint8_t)(value + 1U));
    while ((UCSR0A & (1U << TXC0)) == 0) {
    }
    DRIVER_OFF();
}

int main(void)
{
    uint8_t mine = (GPIOR2 == 0) ? 1U : GPIOR2;

    DRIVER_OUT();
    UBRR0 = 16;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01) | (1U << UCSZ00));
    UCSR0B = (uint8_t)((1U << RXEN0) | (1U << TXEN0));
    for (;;) {
        uint8_t address = take();
        uint8_t value = take();

        if (address == mine) {
            answer(address, value);
        }
    }
}
