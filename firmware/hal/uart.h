// SPDX-License-Identifier: MIT
// The RS-485 bus, half duplex: received bytes go straight into one buffer, the reply is sent from
// there, and the RS-485 driver is enabled exactly while the board sends. A silence is a time
// without a byte, as long as uart_set() was asked to make it. Main loop only.
//
//     bus        |request.....|    silence    |reply.........|    silence    |request...
//     reception  ^ enabled                    ^ disabled     ^ enabled when the last bit has left
//     RS-485 DE  ____________________________/~~~~~~~~~~~~~~~\________________________
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // CONFIG_TIMER_HZ

// The longest frame, and room for what follows it.
#define UART_BUFFER_BYTES 272u

// Without parity a byte has two stop bits.
enum uart_parity { UART_NONE = 0, UART_ODD = 1, UART_EVEN = 2 };

// A divisor counts eighths of the CPU clock a bit; at 9600 baud a faster clock needs more than 8
// bits.
#if CONFIG_TIMER_HZ / 8u / 9600u < 255u
#define UART_DIVISOR_BITS 8
typedef uint8_t uart_divisor;
#else
#define UART_DIVISOR_BITS 16
typedef uint16_t uart_divisor;
#endif

// Receive into this buffer of UART_BUFFER_BYTES from now on. uart_set() must follow.
void uart_start(uint8_t *bytes);

// Set rate, parity and silence. The silence is in counts of 256 CPU cycles, from the end of a byte
// to the end of the next. Settings that do not differ are left alone, so that a byte on its way is
// not damaged.
void uart_set(uart_divisor divisor, enum uart_parity parity, uint16_t silence_counts);

// *count: number of bytes received up to the first silence, 0 to UART_BUFFER_BYTES; further bytes
// are lost. Returns true when a silence follows them.
bool uart_received(uint16_t *count);

// Remove the first `count` bytes from the buffer. Bytes may arrive meanwhile.
void uart_drop(uint16_t count);

// Receive nothing until uart_enable_reception() or until the end of uart_send(): the buffer belongs
// to the caller.
void uart_disable_reception(void);

// The bus is silent.
bool uart_silent(void);

// Bytes were received and not dropped yet. False may come a moment too late or too early.
bool uart_holds(void);

// Units of the coarse clock (hal/clock.h) since the end of the newest received byte, up to 500
// counts of 256 CPU cycles (8 ms at 16 MHz; 1024 cycles and four times as long at rates whose
// silence does not fit 255 counts), late by a count at most.
uint16_t uart_age_units(void);

// Receive into an empty buffer, after uart_disable_reception().
void uart_enable_reception(void);

// Bytes that the receiver has lost since the last call.
uint8_t uart_take_overruns(void);

// After uart_disable_reception(): send the buffer's first bytes (1..256), then receive as after
// uart_enable_reception(). The buffer must not change until then.
void uart_send(uint16_t length);

// True until the last stop bit has left.
bool uart_sending(void);
