// SPDX-License-Identifier: MIT
// Runs a Unity suite on a simulated board: text leaves by UART 0, the verdict by GPIOR0, and sleep
// with interrupts off ends the simulation. The build renames the suite's main().

#include <avr/interrupt.h> // cli
#include <avr/io.h>        // UART 0, GPIOR0
#include <avr/sleep.h>     // sleep_mode
#include <stdint.h>        // uint8_t

#include "unity.h" // board_put_char, suite_main, by way of unity_config.h

// Most failures that are reported: a larger number would wrap in GPIOR0 and could become 0.
#define FAILURES_MAX 255

// The simulated port carries any rate: at 2 MBd the text takes little simulated time.
static void uart_open(void)
{
    UBRR0 = 0;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0C = (uint8_t)((1U << UCSZ01) | (1U << UCSZ00));
    UCSR0B = (uint8_t)(1U << TXEN0);
}

void board_put_char(int character)
{
    while ((UCSR0A & (1U << UDRE0)) == 0) {
    }
    // Writing a one clears the flag, on which the end of the test waits.
    UCSR0A |= (uint8_t)(1U << TXC0);
    UDR0 = (uint8_t)character;
}

int main(void)
{
    int failures;

    uart_open();
    failures = suite_main();
    while ((UCSR0A & (1U << TXC0)) == 0) {
    }
    GPIOR0 = (uint8_t)(failures < FAILURES_MAX ? failures : FAILURES_MAX);
    cli();
    for (;;) {
        sleep_mode();
    }
}

void board_run_test(void (*test)(void), int line)
{
    Unity.CurrentTestName = "";
    Unity.CurrentTestLineNumber = (UNITY_LINE_TYPE)line;
    Unity.NumberOfTests++;
    if (TEST_PROTECT()) {
        setUp();
        test();
    }
    if (TEST_PROTECT()) {
        tearDown();
    }
    UnityConcludeTest();
}
