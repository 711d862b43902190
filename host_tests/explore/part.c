// SPDX-License-Identifier: MIT
#include "explore/part.h"

#include <avr/io.h>
#include <string.h>

#include "explore/judge.h"
#include "explore/program.h"
#include "explore/step_isr.h"

#define DIR_BIT    4 // bits of port D, from hal/boards/uno.def
#define PERMIT_BIT 6
#define ESTOP_BIT  2

// A period of this length or more does not end while its own interrupt is served: at worst 450
// cycles of the emergency stop's handler and 165 cycles of a capture's handler come first.
#define LATE_TICKS 1024u

// Side effects of a write. They are due before the next access.
enum effect {
    EFFECT_NONE,
    EFFECT_FLAGS,
    EFFECT_TOP,
    EFFECT_TOP_LOW,
    EFFECT_EDGE,
    EFFECT_EDGE_LOW,
    EFFECT_PIN_FLAG,
};

struct part_registers part_registers;
struct part_state part;
bool *part_reception_off;

static bool has(uint8_t word, uint8_t bit)
{
    return (word & _BV(bit)) != 0;
}

bool part_permit_high(void)
{
    return has(PORTD, PERMIT_BIT);
}

bool part_estop_pressed(void)
{
    return !has(PIND, ESTOP_BIT);
}

static bool connected(void)
{
    return has(TCCR1A, COM1B1);
}

bool part_pulses_next(void)
{
    return connected() && part.buffer_edge <= part.buffer_top;
}

bool part_timer_served(void)
{
    return (TIMSK1 & (_BV(TOIE1) | _BV(OCIE1A))) != 0;
}

// The bytes of the state that are shared; these marks are not part of the state themselves.
static uint8_t *shared;

void part_open(void)
{
    size_t bytes = part_memory_bytes();

    part_reception_off = allocate(NULL, sizeof *part_reception_off);
    *part_reception_off = false;
    shared = allocate(NULL, bytes);
    memset(shared, 0, bytes);
}

void part_share(const volatile void *object, uint32_t bytes)
{
    memset(&shared[(uintptr_t)object - (uintptr_t)part_memory], 1, bytes);
}

void part_power_on(void)
{
    part_share(&part_registers, sizeof part_registers);
    PIND = (uint8_t)_BV(ESTOP_BIT);
    PINB = 0xFF;
    PINC = 0xFF;
}

// In mode 0 a write of a compare register takes effect at once; in mode 15 both are buffered.
static void take_effect_at_once(void)
{
    if ((TCCR1A & (_BV(WGM11) | _BV(WGM10))) == 0) {
        part.top = part.buffer_top;
        part.edge = part.buffer_edge;
    }
}

void part_settle(void)
{
    uint8_t effect = part.effect;

    part.effect = EFFECT_NONE;
    switch (effect) {
    case EFFECT_NONE:
        return;
    case EFFECT_FLAGS:
        TIFR1 = (uint8_t)(part.kept_flags & ~TIFR1);
        return;
    case EFFECT_TOP:
        part.buffer_top = OCR1A;
        part_registers.temp = (uint8_t)(OCR1A >> 8);
        break;
    case EFFECT_TOP_LOW:
        part.buffer_top = (uint16_t)(part_registers.temp << 8 | OCR1AL);
        break;
    case EFFECT_EDGE:
        part.buffer_edge = OCR1B;
        part_registers.temp = (uint8_t)(OCR1B >> 8);
        break;
    case EFFECT_EDGE_LOW:
        part.buffer_edge = (uint16_t)(part_registers.temp << 8 | OCR1BL);
        break;
    default:
        EIFR = 0;
        return;
    }
    take_effect_at_once();
}

// The side effect of an access to this register; EFFECT_NONE for any other object.
static uint8_t effect_of(const volatile void *address)
{
    static const struct {
        const volatile void *address;
        uint8_t effect;
    } effects[] = {
        {&TIFR1, EFFECT_FLAGS},
        {&OCR1A, EFFECT_TOP},
        {&OCR1AL, EFFECT_TOP_LOW},
        {&OCR1B, EFFECT_EDGE},
        {&OCR1BL, EFFECT_EDGE_LOW},
        {&EIFR, EFFECT_PIN_FLAG},
    };

    for (size_t i = 0; i < sizeof effects / sizeof effects[0]; i++) {
        if (effects[i].address == address) {
            return effects[i].effect;
        }
    }
    return EFFECT_NONE;
}

static void make_edge(void)
{
    part.edge_waits = false;
    if (connected()) {
        judge_edge(has(PORTD, DIR_BIT));
    }
}

// A period whose interrupt has not been served cannot end: config.h makes every interval longer
// than all that can keep the interrupt waiting.
static bool period_can_end(void)
{
    bool running = has(TCCR1B, CS10) && !has(TIFR1, TOV1) && !part.in_command;

    return running && (!part.in_fast || part.top < LATE_TICKS);
}

bool part_possible(enum part_event event)
{
    return event == PART_PERIOD_ENDS ? period_can_end() : true;
}

static void end_period(void)
{
    part.top = part.buffer_top;
    part.edge = part.buffer_edge;
    TIFR1 = (uint8_t)(TIFR1 | _BV(TOV1) | _BV(OCF1A));
    if (part.edge <= part.top) {
        TIFR1 = (uint8_t)(TIFR1 | _BV(OCF1B));
        part.edge_waits = true;
        // The edge comes 31 ticks from here, after the handler has looked at the flag.
        if (!part.in_fast) {
            make_edge();
        }
    }
}

void part_happen(enum part_event event)
{
    if (event == PART_PERIOD_ENDS) {
        end_period();
        return;
    }
    PIND = (uint8_t)(PIND ^ _BV(ESTOP_BIT));
    EIFR = (uint8_t)_BV(INTF0);
}

// The few instructions of the naked handler in estop.c.
static void estop_interrupt(void)
{
    EIFR = 0;
    EIMSK = (uint8_t)(EIMSK & ~_BV(INT0));
    part_sei();
    if (explored_estop_look()) {
        part_cli();
        EIMSK = (uint8_t)(EIMSK | _BV(INT0));
    }
}

static void overflow_interrupt(void)
{
    TIFR1 = (uint8_t)(TIFR1 & ~_BV(TOV1));
    part.in_fast = true;
    step_isr_overflow();
    part_settle();
    part.in_fast = false;
    if (part.edge_waits) {
        make_edge();
    }
}

static void compare_interrupt(void)
{
    TIFR1 = (uint8_t)(TIFR1 & ~_BV(OCF1A));
    step_isr_compare_a();
}

static void enter(void (*handler)(void))
{
    part.interrupts_on = false;
    part.depth++;
    handler();
    part_settle();
    part.depth--;
    part.interrupts_on = true;
    program_clear_stack();
}

// Serve one pending interrupt, in the order of the vectors. False when none is pending.
static bool serve_one(void)
{
    if (!part.interrupts_on) {
        return false;
    }
    if (has(EIMSK, INT0) && has(EIFR, INTF0)) {
        enter(estop_interrupt);
    } else if (has(TIMSK1, OCIE1A) && has(TIFR1, OCF1A)) {
        enter(compare_interrupt);
    } else if (has(TIMSK1, TOIE1) && has(TIFR1, TOV1)) {
        enter(overflow_interrupt);
    } else {
        return false;
    }
    return true;
}

void part_command_begins(void)
{
    part_settle();
    part.in_fast = false;
    part.in_command = true;
}

void part_command_ends(void)
{
    part_settle();
    part.in_command = false;
    part.in_fast = true;
}

static void look_around(const void *pc)
{
    part.points++;
    part.pc = pc;
    judge_look();
    program_point();
}

static void point_at(const void *pc)
{
    if (*part_reception_off) {
        return;
    }
    do {
        look_around(pc);
    } while (serve_one());
}

void part_point(void)
{
    part_settle();
    point_at(__builtin_return_address(0));
}

// Turning interrupts off is a point of its own, because an interrupt must wait behind it.
void part_cli(void)
{
    part_settle();
    if (part.interrupts_on) {
        point_at(__builtin_return_address(0));
    }
    part.interrupts_on = false;
}

void part_sei(void)
{
    part_settle();
    part.interrupts_on = true;
    while (!*part_reception_off && serve_one()) {
        look_around(__builtin_return_address(0));
    }
}

unsigned char part_interrupts_on(void)
{
    return part.interrupts_on;
}

// The 20 looks of the emergency stop's handler count as one point: an event between two of them has
// the same effect as one before the first look or behind the last.
static bool same_look(const volatile void *address)
{
    bool looks = address == &PIND;
    bool again = looks && part.looking;

    part.looking = looks;
    return again;
}

static void touched(void *address, uint32_t bytes, bool writes, const void *pc)
{
    size_t at = (size_t)((uintptr_t)address - (uintptr_t)part_memory);

    if (*part_reception_off) {
        return;
    }
    if (part.effect != EFFECT_NONE) {
        part_settle();
    }
    if (at >= part_memory_bytes()) {
        return;
    }
    if (!shared[at]) {
        if (part.depth != 0) {
            judge_unshared(address);
        }
        return;
    }
    judge_access(address, bytes);
    if (!same_look(address)) {
        point_at(pc);
    }
    if (writes) {
        part.kept_flags = TIFR1;
        part.effect = effect_of(address);
    }
}

// The functions that gcc calls before every access (-fsanitize=thread), in place of its library.
// NOLINTBEGIN(misc-use-internal-linkage): only the compiler knows them
#define ACCESS(name, bytes, writes)                                                      \
    void access_##name(void *address) __asm__("__tsan_" #name);                          \
    void access_##name(void *address)                                                    \
    {                                                                                    \
        touched(address, (bytes), (writes), __builtin_return_address(0));                \
    }
#define ACCESSES(bytes)                                                                  \
    ACCESS(read##bytes, bytes, false)                                                    \
    ACCESS(write##bytes, bytes, true)                                                    \
    ACCESS(unaligned_read##bytes, bytes, false)                                          \
    ACCESS(unaligned_write##bytes, bytes, true)
ACCESSES(1)
ACCESSES(2)
ACCESSES(4)
ACCESSES(8)
ACCESSES(16)

#define RANGE(name, writes)                                                              \
    void access_##name(void *address, uint32_t bytes) __asm__("__tsan_" #name);          \
    void access_##name(void *address, uint32_t bytes)                                    \
    {                                                                                    \
        touched(address, bytes, (writes), __builtin_return_address(0));                  \
    }
RANGE(read_range, false)
RANGE(write_range, true)

#define NOTHING(name)                                                                    \
    void ignored_##name(void) __asm__("__tsan_" #name);                                  \
    void ignored_##name(void)                                                            \
    {                                                                                    \
    }
NOTHING(init)
NOTHING(func_entry)
NOTHING(func_exit)
// NOLINTEND(misc-use-internal-linkage)
