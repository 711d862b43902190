// SPDX-License-Identifier: MIT
#include "explore/program.h"

#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>

#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"

#define STACK_BYTES 65536u
// Below the block that alloca() returns, the stack holds only the call that is being made.
#define STACK_MARGIN  64u
#define STACK_CLEARED 2048u

// The search's own data. They are allocated and set before the first state is saved, so that they
// are not part of a state.
struct host {
    jmp_buf out; // way out of the program, back to the search
    struct program_task task;
    const char *broken;
    uint16_t most_points;
    bool on_stack; // the program runs on its own stack
    uint8_t stack[STACK_BYTES];
};

// The place where the program goes on; it is part of the state.
struct place {
    jmp_buf at;
    uint8_t *low; // low end of the stack in use
};

static struct host *host;
static struct place place;

void *allocate(void *old, size_t bytes)
{
    void *room = realloc(old, bytes);

    if (room == NULL) {
        (void)fputs("pixstep-explore: out of memory\n", stderr);
        exit(2);
    }
    return room;
}

// Uses the forms of setjmp() that do not save the signal mask, because nothing here needs signals.
static __attribute__((noinline)) void leave(enum program_verdict verdict)
{
    place.low = (uint8_t *)__builtin_alloca(16) - STACK_MARGIN;
    if (_setjmp(place.at) == 0) {
        _longjmp(host->out, (int)verdict);
    }
}

// Clear the part's accounts, so that a state between two pieces does not contain them.
static void begin_piece(void)
{
    part.points = 0;
    part.pc = NULL;
    part.looking = false;
    leave(PROGRAM_OVER);
}

static void segment_pieces(void)
{
    for (;;) {
        begin_piece();
        part_pass_time();
        if (host->task.piece == PROGRAM_ROUND) {
            board_round();
        } else {
            board_act(host->task.piece);
        }
        part_point();
        judge_between();
        if (part.points > host->most_points) {
            host->most_points = part.points;
        }
    }
}

// The AVR goes on with a wrong quotient; here the run is over.
static void divided_by_zero(int number)
{
    (void)number;
    judge_broken(JUDGE_DIVIDES);
}

// What breaks a rule before anything is explored ends the program.
static void power_on(void)
{
    if (_setjmp(host->out) == 0) {
        board_power_on();
        return;
    }
    (void)printf("broken: %s\nwhile the board starts\n", host->broken);
    exit(1);
}

void program_open(void)
{
    struct sigaction action = {.sa_handler = divided_by_zero, .sa_flags = SA_NODEFER};

    (void)sigaction(SIGFPE, &action, NULL);
    ucontext_t program;
    ucontext_t here;

    host = allocate(NULL, sizeof *host);
    memset(host, 0, sizeof *host);
    board_open();
    part_open();
    power_on();
    (void)getcontext(&program);
    program.uc_stack.ss_sp = host->stack;
    program.uc_stack.ss_size = STACK_BYTES;
    program.uc_link = NULL;
    makecontext(&program, segment_pieces, 0);
    if (_setjmp(host->out) == 0) {
        (void)swapcontext(&here, &program);
    }
}

// These two functions are not inlined, because they return twice.
__attribute__((noinline)) enum program_verdict program_go(const struct program_task *task)
{
    int verdict = _setjmp(host->out);

    if (verdict == 0) {
        host->task = *task;
        host->on_stack = true;
        _longjmp(place.at, 1);
    }
    host->on_stack = false;
    return (enum program_verdict)verdict;
}

__attribute__((noinline)) enum program_verdict program_call(void (*function)(void))
{
    int verdict = _setjmp(host->out);

    if (verdict == 0) {
        function();
        part.points = 0;
        part.pc = NULL;
        part.looking = false;
    }
    return (enum program_verdict)verdict;
}

const char *program_broken(void)
{
    return host->broken;
}

uint16_t program_most_points(void)
{
    uint16_t most = host->most_points;

    host->most_points = 0;
    return most;
}

const struct program_task *program_task(void)
{
    return &host->task;
}

void program_point(void)
{
    if (!host->on_stack || host->task.to_the_end) {
        return;
    }
    leave(PROGRAM_AT_POINT);
    for (unsigned event = 0; event < PART_EVENT_KINDS; event++) {
        if ((host->task.events & 1u << event) != 0) {
            part_happen((enum part_event)event);
        }
    }
}

__attribute__((noinline)) void program_clear_stack(void)
{
    if (host->on_stack) {
        uint8_t *end = (uint8_t *)__builtin_alloca(16) - (size_t)2 * STACK_MARGIN;
        memset(end - STACK_CLEARED, 0, STACK_CLEARED);
    }
}

_Noreturn void judge_broken(const char *rule)
{
    host->broken = rule;
    _longjmp(host->out, PROGRAM_BROKEN);
}

void judge_unshared(const volatile void *address)
{
    part_share(address, 1);
    _longjmp(host->out, PROGRAM_SHARES);
}

// What is saved.

static size_t stack_bytes(void)
{
    return (size_t)(host->stack + STACK_BYTES - place.low);
}

size_t program_size(void)
{
    return part_memory_bytes() + stack_bytes();
}

void program_save(uint8_t *memory)
{
    memcpy(memory, part_memory, part_memory_bytes());
    memcpy(&memory[part_memory_bytes()], place.low, stack_bytes());
}

void program_restore(const uint8_t *memory, size_t size)
{
    size_t on_stack = size - part_memory_bytes();

    memcpy(part_memory, memory, part_memory_bytes());
    memcpy(host->stack + STACK_BYTES - on_stack, &memory[part_memory_bytes()], on_stack);
}

static uint64_t mix(uint64_t hash, uint64_t word)
{
    __uint128_t product = (__uint128_t)(hash ^ word) * 0x9E3779B97F4A7C15u;

    return (uint64_t)product ^ (uint64_t)(product >> 64);
}

static void hash_bytes(const uint8_t *bytes, size_t count, uint64_t hash[2])
{
    for (size_t at = 0; at < count; at += sizeof(uint64_t)) {
        uint64_t word = 0;
        memcpy(&word, &bytes[at], count - at < sizeof word ? count - at : sizeof word);
        hash[0] = mix(hash[0], word);
        hash[1] = mix(hash[1] + 0xA4093822299F31D0u, ~word);
    }
}

void program_hash(uint64_t hash[2])
{
    hash[0] = 0x243F6A8885A308D3u;
    hash[1] = 0x13198A2E03707344u;
    hash_bytes(part_memory, part_memory_bytes(), hash);
    hash_bytes(place.low, stack_bytes(), hash);
}
