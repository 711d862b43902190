// SPDX-License-Identifier: MIT
// The serial line, half duplex: received bytes go straight into one buffer, the reply leaves from
// there, the RS-485 driver enabled exactly while sending. A silence is a byte's absence for as long
// as uart_set() was told. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // CONFIG_TIMER_HZ

#define UART_BUFFER_BYTES 272u // the longest frame, and room for what comes behind it

enum uart_parity { UART_NONE = 0, UART_ODD = 1, UART_EVEN = 2 }; // none has two stop bits

// Counts of an eighth of the CPU clock a bit; at 9600 baud a faster clock needs more than 8 bits.
#if CONFIG_TIMER_HZ / 8u / 9600u < 255u
#define UART_DIVISOR_BITS 8
typedef uint8_t uart_divisor;
#else
#define UART_DIVISOR_BITS 16
typedef uint16_t uart_divisor;
#endif

// Listen into this buffer of UART_BUFFER_BYTES from now on; uart_set() must follow.
void uart_start(uint8_t *bytes);

// A silence is in counts of 256 CPU cycles, from the end of a byte to the end of the next. What is
// set already is left alone, and with it a byte that is on its way.
void uart_set(uart_divisor divisor, enum uart_parity parity, uint16_t silence_counts);

// Number of bytes at the buffer's front that no silence divides, 0 to UART_BUFFER_BYTES; more are
// lost. True when a silence follows them.
bool uart_received(uint16_t *count);

// The first `count` of them are done with; what follows is the front now. Bytes may come meanwhile.
void uart_drop(uint16_t count);

// Hear nothing until uart_enable_reception() or the end of what is sent: the buffer is the caller's.
void uart_disable_reception(void);

// The line is silent.
bool uart_silent(void);

// Listen into an empty buffer, after uart_disable_reception().
void uart_enable_reception(void);

// Bytes lost by the receiver since the last call.
uint8_t uart_take_overruns(void);

// After uart_disable_reception(): send the buffer's first bytes (1..256), then listen as uart_enable_reception() does.
// The buffer must stay until then.
void uart_send(uint16_t length);

// True until the last stop bit has left.
bool uart_sending(void);
