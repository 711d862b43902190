// SPDX-License-Identifier: MIT
#include "explore/part.h"

#include <avr/io.h>
#include <string.h>

#include "avr/hal/board.h" // BOARD_KEEP
#include "explore/judge.h"
#include "explore/program.h"
#include "explore/step_isr.h"
#include "hal/clock.h" // CLOCK_UNIT_TICKS
#if CONFIG_AXES > 1
#include "avr/hal/clock_units.h" // clock_overflows
#include "avr/hal/step_isr.h"    // step_engines
#endif

// A period of this length or more does not end while its own interrupt is served: at worst 450
// cycles of the emergency stop's handler and 165 cycles of a capture's handler come first.
#define LATE_TICKS 1024u

// The most that passes with interrupts off, and in a handler that lets others in, ticks.
#define NEAR_TICKS    8u
#define HANDLER_TICKS 1000u
// The most that passes in a piece of program between two timed events.
#define PIECE_TICKS 8192u
// A piece of program that passes so many points never ends.
#define POINTS_MAX 20000u
// Where nothing is timed, so much passes between two rounds.
#define NOTHING_TICKS 4096u
// Timers are started by stores that follow each other so closely.
#define START_TICKS 2u

// Side effects of an access. They are due before the next one.
enum effect {
    EFFECT_NONE,
    EFFECT_FLAGS,
    EFFECT_TOP,
    EFFECT_TOP_LOW,
    EFFECT_EDGE,
    EFFECT_EDGE_LOW,
    EFFECT_PIN_FLAG,
    EFFECT_COUNT_READ,
    EFFECT_CAPTURE_READ,
    EFFECT_CONTROL,
    EFFECT_MASK,
};

struct part_registers part_registers;
struct part_state part;
bool *part_reception_off;

static bool has(uint8_t word, uint8_t bit)
{
    return (word & _BV(bit)) != 0;
}

// The pins of the board file.
#define LEVEL_OF(number, port, bit)                                                      \
    if (axis == (number)) {                                                              \
        return has(PORT##port, bit);                                                     \
    }
static bool goes_negative(uint8_t axis)
{
#define WANT_DIR BOARD_WANTED
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(LEVEL_OF(number, port, bit))
#include BOARD_FILE
#undef WANT_DIR
    return false;
}

bool part_permit_high(void)
{
#define PERMIT_LEVEL(port, bit) return has(PORT##port, bit);
#define WANT_PERMIT             BOARD_WANTED
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(PERMIT_LEVEL(port, bit))
#include BOARD_FILE
#undef WANT_PERMIT
}

#define WANT_ESTOP               BOARD_WANTED
#define ESTOP_PRESSED(port, bit) return !has(PIN##port, bit);
bool part_estop_pressed(void){
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(ESTOP_PRESSED(port, bit))
#include BOARD_FILE
}

// The pin at which estop.c looks.
#define ESTOP_REGISTER(port, bit) return &PIN##port;
static volatile uint8_t *estop_register(void){
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(ESTOP_REGISTER(port, bit))
#include BOARD_FILE
}

#define ESTOP_MASK(port, bit) return (uint8_t)_BV(bit);
static uint8_t estop_mask(void)
{
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(ESTOP_MASK(port, bit))
#include BOARD_FILE
}
#undef WANT_ESTOP

static struct part_timer_registers *registers_of(uint8_t axis)
{
    return &part_registers.timers[axis];
}

static bool connected(uint8_t axis)
{
    return has(registers_of(axis)->tccra, COM1B1);
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
    PINA = 0xFF;
    PINB = 0xFF;
    PINC = 0xFF;
    PIND = 0xFF;
}

#if CONFIG_AXES > 1
// Timer 0 has wrapped: its interrupt counts at once, or as soon as interrupts are on.
static void count_overflow(void)
{
    uint32_t overflows = part.now_ticks / (256u * CLOCK_UNIT_TICKS);

    if (clock_overflows != overflows) {
        TIFR0 = part.interrupts_on ? 0 : (uint8_t)_BV(TOV0);
    }
    if (part.interrupts_on) {
        clock_overflows = overflows;
    }
}

// The registers that count.
static void show_time(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (part.timers[i].running) {
            registers_of(i)->tcnt =
                (uint16_t)(part.now_ticks - part.timers[i].began_ticks);
        }
    }
    TCNT0 = (uint8_t)(part.now_ticks / CLOCK_UNIT_TICKS);
    count_overflow();
}

static bool is_served(uint8_t axis)
{
    return (registers_of(axis)->timsk & (_BV(TOIE1) | _BV(OCIE1A))) != 0;
}

static void note_cleared(uint8_t axis)
{
    if (has(registers_of(axis)->tifr, TOV1) && !is_served(axis)) {
        part.timers[axis].looked_at = true;
    }
}

static void note_served(uint8_t axis)
{
    if (is_served(axis)) {
        part.timers[axis].looked_at = false;
    }
}

// Somebody will ask whether a period has begun, an interrupt or the main loop: no second one begins
// before that. Nobody asks of a parked axis.
static bool is_awaited(uint8_t axis)
{
    return is_served(axis) || part.timers[axis].looked_at ||
           step_engines[axis].state != STEP_ENGINE_PARKED;
}

static void start_or_stop(uint8_t axis)
{
    part.timers[axis].running = has(registers_of(axis)->tccrb, CS10);
    part.timers[axis].began_ticks = part.now_ticks - registers_of(axis)->tcnt;
    if (part.timers[axis].running) {
        part.now_ticks += START_TICKS;
        show_time();
    }
}
#else
static void count_overflow(void)
{
}

static void note_cleared(uint8_t axis)
{
    (void)axis;
}

static void note_served(uint8_t axis)
{
    (void)axis;
}

static bool is_awaited(uint8_t axis)
{
    (void)axis;
    return true;
}

static void start_or_stop(uint8_t axis)
{
    (void)axis;
}
#endif

// In mode 0 a write of a compare register takes effect at once; in mode 15 both are buffered.
static void take_effect_at_once(uint8_t axis)
{
    struct part_timer *timer = &part.timers[axis];

    if ((registers_of(axis)->tccra & (_BV(WGM11) | _BV(WGM10))) == 0) {
        timer->top = timer->buffer_top;
        timer->edge = timer->buffer_edge;
    }
}

void part_settle(void)
{
    uint8_t effect = part.effect;
    uint8_t axis = part.effect_axis;
    struct part_timer *timer = &part.timers[axis];
    struct part_timer_registers *registers = registers_of(axis);

    part.effect = EFFECT_NONE;
    part.effect_axis = 0;
    switch (effect) {
    case EFFECT_NONE:
        return;
    case EFFECT_FLAGS:
        note_cleared(axis);
        registers->tifr = (uint8_t)(part.kept_flags & ~registers->tifr);
        part.kept_flags = 0;
        return;
    case EFFECT_MASK:
        note_served(axis);
        return;
    case EFFECT_TOP:
        timer->buffer_top = registers->ocra;
        registers->temp = (uint8_t)(registers->ocra >> 8);
        break;
    case EFFECT_TOP_LOW:
        timer->buffer_top = (uint16_t)(registers->temp << 8 | registers->ocral);
        break;
    case EFFECT_EDGE:
        timer->buffer_edge = registers->ocrb;
        registers->temp = (uint8_t)(registers->ocrb >> 8);
        break;
    case EFFECT_EDGE_LOW:
        timer->buffer_edge = (uint16_t)(registers->temp << 8 | registers->ocrbl);
        break;
    case EFFECT_COUNT_READ:
        registers->temp = (uint8_t)(registers->tcnt >> 8);
        return;
    case EFFECT_CAPTURE_READ:
        registers->temp = (uint8_t)(registers->icr >> 8);
        return;
    case EFFECT_CONTROL:
        start_or_stop(axis);
        return;
    default:
        EIFR = 0;
        return;
    }
    take_effect_at_once(axis);
}

// Side effects by the place of a register among those of its timer.
#define PLACE(member) offsetof(struct part_timer_registers, member)
static uint8_t effect_of_write(size_t place)
{
    static const uint8_t effects[sizeof(struct part_timer_registers)] = {
        [PLACE(tifr)] = EFFECT_FLAGS,
        [PLACE(ocra)] = EFFECT_TOP,
        [PLACE(ocral)] = EFFECT_TOP_LOW,
        [PLACE(ocrb)] = EFFECT_EDGE,
        [PLACE(ocrbl)] = EFFECT_EDGE_LOW,
        [PLACE(tccrb)] = EFFECT_CONTROL,
#if CONFIG_AXES > 1
        [PLACE(timsk)] = EFFECT_MASK,
#endif
    };

    return effects[place];
}

static uint8_t effect_of_read(size_t place)
{
    switch (place) {
    case PLACE(tcnt):
        return EFFECT_COUNT_READ;
    case PLACE(icr):
        return EFFECT_CAPTURE_READ;
    default:
        return EFFECT_NONE;
    }
}

// Note the side effect of an access to this object, if it is a register that has one.
static void note_effect(const volatile void *address, bool writes)
{
    size_t at = (size_t)((uintptr_t)address - (uintptr_t)&part_registers.timers);

    if (at >= sizeof part_registers.timers) {
        part.effect = writes && address == &EIFR ? EFFECT_PIN_FLAG : EFFECT_NONE;
        return;
    }
    size_t place = at % sizeof(struct part_timer_registers);

    part.effect = writes ? effect_of_write(place) : effect_of_read(place);
    if (part.effect != EFFECT_NONE) {
        part.effect_axis = (uint8_t)(at / sizeof(struct part_timer_registers));
    }
    if (part.effect == EFFECT_FLAGS) {
        part.kept_flags = registers_of(part.effect_axis)->tifr;
    }
}

// The tick of the edge that the running period has.
static uint32_t edge_ticks(uint8_t axis)
{
#if CONFIG_AXES > 1
    return part.timers[axis].began_ticks + part.timers[axis].edge + 1u;
#else
    (void)axis;
    return 0;
#endif
}

static void make_edge(uint8_t axis)
{
    part.timers[axis].edge_waits = false;
    if (connected(axis)) {
        judge_edge(axis, edge_ticks(axis), goes_negative(axis));
    }
}

// A period whose interrupt has not been served cannot end: config.h makes every interval longer
// than all that can keep the interrupt waiting.
static bool period_can_end(uint8_t axis)
{
    const struct part_timer *timer = &part.timers[axis];
    const struct part_timer_registers *registers = registers_of(axis);
    bool waits = is_awaited(axis) && has(registers->tifr, TOV1);

    return has(registers->tccrb, CS10) && !waits && !timer->in_command &&
           (!timer->in_fast || timer->top < LATE_TICKS);
}

static void end_period(uint8_t axis)
{
    struct part_timer *timer = &part.timers[axis];
    struct part_timer_registers *registers = registers_of(axis);

    timer->top = timer->buffer_top;
    timer->edge = timer->buffer_edge;
    registers->tifr = (uint8_t)(registers->tifr | _BV(TOV1) | _BV(OCF1A));
    if (timer->edge <= timer->top) {
        registers->tifr = (uint8_t)(registers->tifr | _BV(OCF1B));
        timer->edge_waits = true;
        // The edge comes 31 ticks from here, after the handler has looked at the flag.
        if (!timer->in_fast) {
            make_edge(axis);
        }
    }
}

#if CONFIG_AXES > 1
static uint32_t end_ticks(uint8_t axis)
{
    return part.timers[axis].began_ticks + part.timers[axis].top + 1u;
}

// The ends of an axis's periods change nothing: nobody serves it, the flags are set, no edge comes.
static bool ends_unseen(uint8_t axis)
{
    const struct part_timer_registers *registers = registers_of(axis);
    uint8_t flags = (uint8_t)(_BV(TOV1) | _BV(OCF1A));

    return !is_awaited(axis) && (registers->tifr & flags) == flags &&
           part.timers[axis].buffer_edge > part.timers[axis].buffer_top;
}

// Ticks until this; 0 if it is due.
static uint32_t until(uint32_t ticks)
{
    return (int32_t)(ticks - part.now_ticks) > 0 ? ticks - part.now_ticks : 0;
}

// Ticks until something timed happens that can be seen.
static uint32_t until_next(void)
{
    uint32_t least = part.clock_every != 0 ? until(part.clock_ticks) : UINT32_MAX;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (part.timers[i].running && !ends_unseen(i) && until(end_ticks(i)) < least) {
            least = until(end_ticks(i));
        }
    }
    return least;
}

static bool time_can_pass(void)
{
    uint32_t ticks = until_next();

    uint32_t most = part.depth != 0 ? HANDLER_TICKS : PIECE_TICKS;

    if (ticks > (part.interrupts_on ? most : NEAR_TICKS)) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (part.timers[i].running && !ends_unseen(i) && until(end_ticks(i)) <= ticks &&
            !period_can_end(i)) {
            return false;
        }
    }
    return true;
}

// What has ended until now.
static void end_periods(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        while (part.timers[i].running && until(end_ticks(i)) == 0) {
            part.timers[i].began_ticks = end_ticks(i);
            end_period(i);
        }
    }
}

static void pass(uint32_t ticks)
{
    part.now_ticks += ticks;
    end_periods();
    show_time();
}

static void capture_edge(void)
{
    struct part_timer_registers *registers = registers_of(CONFIG_PIXEL_CLOCK_AXIS);

    part.clock_ticks += part.clock_every;
    registers->icr = registers->tcnt;
    registers->tifr = (uint8_t)(registers->tifr | _BV(ICF1));
}

static void next_timed(void)
{
    uint32_t ticks = until_next();

    pass(ticks != UINT32_MAX ? ticks : NOTHING_TICKS);
    if (part.clock_every != 0 && until(part.clock_ticks) == 0) {
        capture_edge();
    }
}

void part_pass_time(void)
{
    if (until_next() <= PIECE_TICKS) {
        part_pass_long_time(PART_BEFORE_TICKS);
    }
}

void part_pass_long_time(uint32_t before_ticks)
{
    uint32_t ticks = until_next();

    if (ticks > before_ticks && ticks != UINT32_MAX) {
        pass(ticks - before_ticks);
    }
}

void part_start_clock(uint32_t every_ticks)
{
    part.clock_every = every_ticks;
    part.clock_ticks = part.now_ticks + every_ticks;
}

void part_set_flag(uint8_t bit)
{
    part_point();
    GPIOR0 = (uint8_t)(GPIOR0 | _BV(bit));
}

void part_clear_flag(uint8_t bit)
{
    part_point();
    GPIOR0 = (uint8_t)(GPIOR0 & ~_BV(bit));
}
#else
static bool time_can_pass(void)
{
    return period_can_end(0);
}

static void next_timed(void)
{
    end_period(0);
}
#endif

bool part_possible(enum part_event event)
{
    return event == PART_PERIOD_ENDS ? time_can_pass() : true;
}

void part_happen(enum part_event event)
{
    if (event == PART_PERIOD_ENDS) {
        next_timed();
        return;
    }
    *estop_register() = (uint8_t)(*estop_register() ^ estop_mask());
    EIFR = (uint8_t)_BV(BOARD_ESTOP_INT);
}

// The few instructions of the naked handler in estop.c.
static void estop_interrupt(void)
{
    EIFR = 0;
    EIMSK = (uint8_t)(EIMSK & ~_BV(BOARD_ESTOP_INT));
    part_sei();
    if (explored_estop_look()) {
        part_cli();
        EIMSK = (uint8_t)(EIMSK | _BV(BOARD_ESTOP_INT));
    }
}

static void overflow_interrupt(uint8_t axis)
{
    struct part_timer *timer = &part.timers[axis];

    registers_of(axis)->tifr = (uint8_t)(registers_of(axis)->tifr & ~_BV(TOV1));
    timer->in_fast = true;
    step_isr_overflow(axis);
    part_settle();
    timer->in_fast = false;
    if (timer->edge_waits) {
        make_edge(axis);
    }
}

static void compare_interrupt(uint8_t axis)
{
    registers_of(axis)->tifr = (uint8_t)(registers_of(axis)->tifr & ~_BV(OCF1A));
    step_isr_compare_a(axis);
}

static void enter(void (*handler)(uint8_t axis), uint8_t axis)
{
    part.interrupts_on = false;
    part.depth++;
    handler(axis);
    part_settle();
    part.depth--;
    part.interrupts_on = true;
    count_overflow();
    program_clear_stack();
}

#if CONFIG_AXES > 1
static void capture_interrupt(uint8_t axis)
{
    registers_of(axis)->tifr = (uint8_t)(registers_of(axis)->tifr & ~_BV(ICF1));
    capture_isr();
}
#endif

// Serve one pending interrupt of a timer, in the order of the vectors. False when none is pending.
static bool serve_timer(uint8_t axis)
{
    const struct part_timer_registers *registers = registers_of(axis);
    uint8_t pending = (uint8_t)(registers->timsk & registers->tifr);

#if CONFIG_AXES > 1
    if (has(pending, ICF1)) {
        enter(capture_interrupt, axis);
        return true;
    }
#endif
    if (has(pending, OCF1A)) {
        enter(compare_interrupt, axis);
    } else if (has(pending, TOV1)) {
        enter(overflow_interrupt, axis);
    } else {
        return false;
    }
    return true;
}

static void enter_estop(uint8_t axis)
{
    (void)axis;
    estop_interrupt();
}

static bool serve_one(void)
{
    if (!part.interrupts_on) {
        return false;
    }
    if (has(EIMSK, BOARD_ESTOP_INT) && has(EIFR, BOARD_ESTOP_INT)) {
        enter(enter_estop, 0);
        return true;
    }
    bool served = false;

    for (uint8_t i = 0; !served && i < CONFIG_AXES; i++) {
        served = serve_timer(i);
    }
    return served;
}

void part_command_begins(uint8_t axis)
{
    part_settle();
    part.timers[axis].in_fast = false;
    part.timers[axis].in_command = true;
}

void part_command_ends(uint8_t axis)
{
    part_settle();
    part.timers[axis].in_command = false;
    part.timers[axis].in_fast = true;
}

static void look_around(const void *pc)
{
    part.points++;
    if (part.points == POINTS_MAX) {
        judge_broken(JUDGE_ENDLESS);
    }
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
    count_overflow();
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
    bool looks = address == estop_register();
    bool again = looks && part.looking;

    part.looking = looks;
    return again;
}

// SBI and CBI read and write GPIOR0 in one instruction: only the read is a point.
static bool same_bit(const volatile void *address, bool writes)
{
    return writes && address == &GPIOR0;
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
    judge_access(&(struct part_access){address, pc, bytes, writes});
    if (!same_look(address) && !same_bit(address, writes)) {
        point_at(pc);
    }
    note_effect(address, writes);
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
