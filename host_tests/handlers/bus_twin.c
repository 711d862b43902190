// SPDX-License-Identifier: MIT
//
// The three handlers of the bus: uart.c with its inline assembly, and uart_receive.S.
#include "handlers/handler_twins.h"

#define RECEIVER_ON    0x18U // values of UCSR0B: no interrupt
#define TRANSMITTER_ON 0x08U
#define SENDS          0x28U
#define ENDS           0x48U
#define ERRORS         0x1CU // of UCSR0A: FE0, DOR0, UPE0
#define OVERRAN        3U
#define SENT_ALL       0x42U // TXC0, and U2X0, which stays
#define SILENCE        1U    // OCF2A of TIFR2
#define SILENCE_BEGINS 0x03U // and TOV2

// struct uart_place
#define FIRST         0U
#define NEXT          2U
#define END           4U
#define FIRST_SILENCE 6U
#define OVERRUNS      8U
#define CONTROL_AFTER 9U

static uint16_t place;
static struct made_up sent;

static uint16_t somewhere(void)
{
    return (uint16_t)(0x0800U + (bench_noise() & 0x1FU));
}

static void put_word(uint16_t address, uint16_t value)
{
    bench_put(address, (uint8_t)value);
    bench_put((uint16_t)(address + 1U), (uint8_t)(value >> 8));
}

// All in one small buffer around an address whose low byte wraps.
static void prepare(void)
{
    uint16_t shift = (bench_noise() & 1U) != 0 ? 0xF0U : 0;

    for (uint16_t member = FIRST; member <= FIRST_SILENCE; member += 2U) {
        put_word((uint16_t)(place + member), (uint16_t)(somewhere() + shift));
    }
    if ((bench_noise() & 1U) != 0) { // no silence yet
        put_word(
            place + FIRST_SILENCE,
            (uint16_t)(bench_get(place + FIRST) | bench_get(place + FIRST + 1U) << 8));
    }
    if ((bench_noise() & 3U) == 0) { // full, but perhaps for 256 bytes
        put_word(place + END,
                 (uint16_t)(bench_get(place + NEXT) | bench_get(place + NEXT + 1U) << 8));
        bench_put(place + END + 1U, (uint8_t)(8U + (bench_noise() & 1U)));
    }
    bench_put(UCSR0A, bench_noise() & ((bench_noise() & 1U) != 0 ? 0xFFU : 0xE3U));
}

static void end_of_handler(void)
{
    twin_closes();
    twin_writes(UCSR0B, *twin_own(place + CONTROL_AFTER));
}

static void note_silence(void)
{
    twin_writes(TIFR2, SILENCE_BEGINS);
    if (twin_word(place + FIRST_SILENCE) == twin_word(place + FIRST)) {
        twin_put_word(place + FIRST_SILENCE, twin_word(place + NEXT));
    }
}

static void receive(void)
{
    twin_writes(UCSR0B, RECEIVER_ON);
    twin_opens();
    uint8_t status = twin_reads(UCSR0A);
    uint8_t byte = twin_reads(UDR0);
    twin_writes(TCNT2, 0);
    if (twin_has(TIFR2, SILENCE)) {
        note_silence();
    }
    uint16_t next = twin_word(place + NEXT);
    if ((status & ERRORS) != 0) {
        *twin_own(place + OVERRUNS) += status >> OVERRAN & 1U;
    } else if (next != twin_word(place + END)) {
        *twin_own(next) = byte;
        twin_put_word(place + NEXT, (uint16_t)(next + 1U));
    }
    end_of_handler();
}

static void send(void)
{
    uint16_t next = twin_word(place + NEXT);

    twin_writes(UCSR0B, TRANSMITTER_ON);
    twin_opens();
    twin_closes(); // the byte and the flag of what has left before it
    twin_writes(UDR0, *twin_own(next));
    twin_writes(UCSR0A, SENT_ALL);
    twin_opens();
    next++;
    twin_put_word(place + NEXT, next);
    *twin_own(place + CONTROL_AFTER) = next == twin_word(place + END) ? ENDS : SENDS;
    end_of_handler();
}

static void all_is_sent(void)
{
    twin_writes(UCSR0B, TRANSMITTER_ON);
    twin_opens();
    twin_calls(&sent);
    end_of_handler();
    twin_opens();
}

void run_bus_handlers(unsigned runs)
{
    static const struct shared_memory nothing[] = {{0, 0}};
    static struct made_up functions[2];
    struct handler handler = {
        .shared = nothing, .made_up = functions, .prepare = prepare};

    place = bench_variable("uart_place");
    sent = (struct made_up){.function = bench_function("__vector_sent"),
                            .interrupts_on = true,
                            .is_signal = true};
    functions[0] = sent;
    handler.name = "receive";
    handler.vector = VECTOR_RECEIVE;
    handler.twin = receive;
    bench_run(&handler, runs);
    handler.name = "send";
    handler.vector = VECTOR_EMPTY;
    handler.twin = send;
    bench_run(&handler, runs);
    handler.name = "sent";
    handler.vector = VECTOR_COMPLETE;
    handler.twin = all_is_sent;
    bench_run(&handler, runs);
}
