// SPDX-License-Identifier: MIT
//
// What a board's handlers are and which memory they have, and their twins.
#pragma once

#include "handlers/handler_bench.h"

#include BOARD_FILE

// Vectors by the data sheets.
#if BOARD_ID == 1
#define VECTOR_RECEIVE  18
#define VECTOR_EMPTY    19
#define VECTOR_COMPLETE 20
#define VECTOR_CAPTURE  10
#define VECTOR_OVERFLOW 13
#define VECTORS_HALTED  11
#elif BOARD_ID == 2
#define VECTOR_RECEIVE  25
#define VECTOR_EMPTY    26
#define VECTOR_COMPLETE 27
#define VECTOR_CAPTURE  46
#define VECTORS_HALTED  17, 32, 42, 47
#else
#define VECTOR_RECEIVE  20
#define VECTOR_EMPTY    21
#define VECTOR_COMPLETE 22
#define VECTOR_CAPTURE  31
#define VECTORS_HALTED  13, 32
#endif

// Data addresses, the same on all parts.
#define GPIOR0 0x3EU
#define TIFR0  0x35U
#define TIFR1  0x36U
#define TIFR2  0x37U
#define TCNT0  0x46U
#define ACSR   0x50U
#define TCNT2  0xB2U
#define UCSR0A 0xC0U
#define UCSR0B 0xC1U
#define UDR0   0xC6U

// Of a 16-bit timer, from its first register on.
#define TIMER_TCCRA 0x0U
#define TIMER_TCNT  0x4U
#define TIMER_ICR   0x6U
#define TIMER_OCRA  0x8U
#define TIMER_OCRB  0xAU
#define OVERFLOW    0U // bits of TIFRn and TIMSKn
#define COMPARE_A   1U
#define CAPTURED    5U

// struct step_engine and struct pulse_train in the part's memory, as the assembly has them.
#define ENGINE_BYTES 28U
#define TAIL         0U
#define STATE        1U
#define IDLE_COUNT   2U
#define LEFT         4U
#define TRAIN_HIGH   5U
#define TRAINS       6U
#define STOP         24U
#define PULSE        25U
#define CUT          26U
#define TRAIN_BYTES  9U
#define AFTER_SHORT  2U
#define AFTER_LONG   4U
#define SHORT_LOW    6U
#define LONG_LOW     7U
#define TOP_HIGH     8U

struct board_timer {
    uint16_t base, flags, mask; // data addresses
    uint16_t engine, ring;
};

struct board_timer board_timer(unsigned axis);

// Each runs its handlers.
void run_bus_handlers(unsigned runs);
void run_clock_handler(unsigned runs);
void run_halted_handlers(unsigned runs);
void run_single_step_handler(unsigned runs);
