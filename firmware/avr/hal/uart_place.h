// SPDX-License-Identifier: MIT
// Where the bytes of the serial line come from and go to: what its interrupts (uart.c,
// uart_receive.S) and the main loop share.
#pragma once

#include <stdint.h>

// One object, so that the main loop reaches all of it by one pointer.
struct uart_place {
    // The buffer's front.
    uint8_t *first_byte;
    // The place of the next byte to receive or to send, and the end of that data.
    uint8_t *volatile next_byte;
    uint8_t *volatile end_byte;
    // The place behind which the first silence came; the buffer's front: no silence yet.
    uint8_t *volatile first_silence;
    // Bytes that were lost; wraps.
    volatile uint8_t overruns;
    // What UCSR0B gets at the end of a handler.
    volatile uint8_t control_after;
};

extern struct uart_place uart_place;
