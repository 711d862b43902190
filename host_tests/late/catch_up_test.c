// SPDX-License-Identifier: MIT
//
// The step interrupt of a board with several axes, where it comes late: the linked image's own
// handlers, instruction by instruction on the model of the timer, beside their twin in C
// (step_twin.h), and beside the edges that the ring asks for.
//
// A run is a scene (an axis, two trains or a train and what follows, a clock edge that waits) in
// which one interrupt comes so many cycles late, the others at once. Each interrupt
//
//  * reads and writes the timer as the twin does, access by access, and ends as the twin does;
//  * leaves the engine, what it notes of intervals, and all other RAM as the twin has them;
//  * keeps the registers and the stack of the interrupted program.
//
// Of each run every STEP edge lies where the ring has it, to the cycle, up to the end or up to the
// interrupt that stops the axis; a run without a late interrupt is not stopped. Every lateness is
// tried, from none up to the end of the running period.
//
// Usage: catch_up_test IMAGE [long]

#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_avr.h>
#include <sim_core.h>
#include <sim_elf.h>

#include "late/step_twin.h"
#include "skips.h"
#include "symbols.h"
#include "timers.h"

#define BOARD_TEXT_OF(word) #word
#define BOARD_TEXT(word)    BOARD_TEXT_OF(word)
#include BOARD_FILE

// Layout of the engine, a train and a ring in the part's memory, as the assembly has it.
#define STEP_ISR_ENGINE_SIZE 28
#define STEP_ISR_TAIL        0
#define STEP_ISR_STATE       1
#define STEP_ISR_IDLE_COUNT  2
#define STEP_ISR_LEFT        4
#define STEP_ISR_TRAIN_HIGH  5
#define STEP_ISR_TRAINS      6
#define STEP_ISR_STOP        24
#define STEP_ISR_PULSE       25
#define STEP_ISR_CUT         26
#define STEP_ISR_TRAIN_SIZE  9
#define STEP_ISR_SUM         0
#define STEP_ISR_AFTER_SHORT 2
#define STEP_ISR_AFTER_LONG  4
#define STEP_ISR_SHORT_LOW   6
#define STEP_ISR_LONG_LOW    7
#define STEP_ISR_TOP_HIGH    8
#define STEP_ISR_RING_SIZE   512
#define STEP_ISR_HIGH_OFFSET 256
#define PIXEL_CLOCK_BEFORE   6 // bit of GPIOR0: a clock edge lies in the running period

#define GPIOR0       0x3EU // data address, the same on all parts
#define VECTOR_BYTES 4U    // a jmp each
#define RETURN_AT    0U    // the interrupted program: where it is does not matter

#define PULSE_LOW   (BOARD_CPU_HZ / 500000 - 1)
#define FIRST_TOP   900U // of the single period before the trains
#define SOON_CYCLES 2U   // an instruction of the main program ends first
#define ACCESSES    2000U
#define PERIODS     64U
#define STACK_BYTES 48U // below the stack pointer, that a handler may use

#define CAPTURE_FLAG  0x20U
#define OVERFLOW_FLAG 0x01U
#define STEP_CONTROL  0x33U // TCCRnA: mode 15, OCnB set at its match
#define STEP_CHANNEL  1
#define CLOCKED       0x19U // TCCRnB: mode 15, prescaler 1
#define EASY_TICKS    160U  // from here on no interrupt is late by itself
// Shorter periods may end twice while an interrupt makes up for one and takes the next entry, too.
#define LOST_BELOW_TICKS 100U
#define STRAY_MOST       2U // edges before the axis is stopped that may be wrong
#define IN_TIME          UINT_MAX
#define LATE_MOST                                                                        \
    130U // cycles before a period's end: the longest way to its successor's load
#define NEVER TIMER16_NEVER

struct access {
    uint8_t which, value;
    bool is_write;
};

static struct part {
    avr_t *avr;
    struct timers timers;
    struct timer16_hooks hooks;
    struct skips skips;
    struct symbols symbols;

    struct timer16 *timer;                                // of the axis
    uint16_t engine, ring, last, before_low, before_high; // data addresses
    uint32_t vector, late, command;                       // program addresses
    uint16_t registers[TWIN_REGISTERS];                   // data addresses

    struct access accesses[ACCESSES];
    unsigned made, compared;
    uint64_t flag_cycle; // since when the overflow's flag is set
    uint64_t edges[PERIODS + 2U];
    unsigned edge_count;
    bool lost_inside; // a period ended unseen while an interrupt was served
    uint8_t *before;  // RAM as it was
} part;

// What follows the first entry.
enum tail {
    SAME_TRAIN,
    OTHER_TRAIN,
    SINGLE, // two single periods
    NOTHING,
    ORDER,
    TAILS,
};

struct scene {
    unsigned axis;
    uint16_t base, steps, remainder; // of the train: intervals of base or base + 1 ticks
    int16_t sum;
    uint8_t count; // of the first entry
    bool second;   // it is train 1's
    enum tail tail;
    int other;           // the other train's or the single's base less this one's, ticks
    uint8_t tail_count;  // of the second entry
    uint64_t clock_at;   // cycles behind the late interrupt's overflow; NEVER
    unsigned late;       // which interrupt is late
    bool halts;          // a halt is asked for while the command is executed
    unsigned late_again; // that and the next one by so many cycles
};

static struct totals {
    uint64_t runs, interrupts, stopped, whole, lost, lost_inside, off, stray, commands,
        cut;
    uint64_t visits[TWIN_PATHS];
} totals;

static const struct scene *running_scene;
static unsigned running_cycles;

__attribute__((format(printf, 1, 2), noreturn)) static void fail(const char *format, ...)
{
    const struct scene *s = running_scene;
    va_list arguments;

    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    if (s != NULL) {
        (void)printf(
            "\n  axis %u, base %u + %u/%u, sum %d, %u of train %d, then %d (%+d, %u); "
            "clock at %lld, interrupt %u begins %d cycles before its end, the next one "
            "%u late\n",
            s->axis,
            s->base,
            s->remainder,
            s->steps,
            s->sum,
            s->count,
            s->second,
            (int)s->tail,
            s->other,
            s->tail_count,
            (long long)s->clock_at,
            s->late,
            (int)running_cycles,
            s->late_again);
    }
    exit(1);
}

// ---- the part ----

static void on_flag(void *board, uint8_t vector, uint64_t cycle)
{
    (void)board;
    if (part.timer != NULL && vector == part.timer->part->overflow.vector) {
        part.flag_cycle = cycle;
    }
}

static void on_refused(void *board, const char *text)
{
    (void)board;
    fail("refused: %s", text);
}

static void on_output(void *board, struct timer16 *timer, int channel, uint64_t cycle)
{
    (void)board;
    if (timer == part.timer && channel == STEP_CHANNEL && timer->oc_level[channel] &&
        timer16_com(timer, channel) != 0 && part.edge_count < PERIODS + 2U) {
        part.edges[part.edge_count++] = cycle;
    }
}

static uint32_t address_of(const char *name)
{
    bool several = false;
    const struct symbol *found = symbols_find(&part.symbols, name, &several);

    if (found == NULL) {
        fail("no symbol %s", name);
    }
    return found->address;
}

static void open_part(const char *image_path)
{
    static elf_firmware_t image;
    avr_t *avr = avr_make_mcu_by_name(BOARD_TEXT(BOARD_MCU));

    if (avr == NULL || avr_init(avr) != 0) {
        fail("no %s", BOARD_TEXT(BOARD_MCU));
    }
    part.avr = avr;
    part.hooks = (struct timer16_hooks){.host = {.flag = on_flag, .refuse = on_refused},
                                        .output = on_output};
    timers_attach(&part.timers, avr, &part.hooks);
    if (elf_read_firmware(image_path, &image) != 0 || image.flashsize == 0) {
        fail("%s: not an AVR image", image_path);
    }
    avr_load_firmware(avr, &image);
    if (!skips_find(&part.skips, avr) || !symbols_read(&part.symbols, image_path)) {
        fail("%s: no symbols", image_path);
    }
    part.before = malloc(avr->ramend + 1U);
    avr->sreg[S_I] = 0;
}

static uint16_t axis_byte(const char *name, unsigned axis)
{
    return (uint16_t)(address_of(name) + axis);
}

static void choose_axis(unsigned axis)
{
    static const char names[] = {
#define BOARD_AXIS(axis, timer) [axis] = '0' + (timer),
#include BOARD_FILE
    };
    char name[] = "step_isr_command_N";
    struct timer16 *t = timers_by_name(&part.timers, names[axis]);

    part.timer = t;
    part.engine = (uint16_t)(address_of("step_engines") + axis * STEP_ISR_ENGINE_SIZE);
    part.ring = (uint16_t)(address_of("step_rings") + axis * STEP_ISR_RING_SIZE);
    part.last = axis_byte("step_isr_last", axis);
    part.before_low = axis_byte("step_isr_before_low", axis);
    part.before_high = axis_byte("step_isr_before_high", axis);
    part.vector = t->part->overflow.vector * VECTOR_BYTES;
    name[sizeof name - 2U] = (char)('0' + axis);
    part.command = address_of(name);
    memcpy(name, "step_isr_late_N", sizeof "step_isr_late_N");
    name[sizeof "step_isr_late_N" - 2U] = (char)('0' + axis);
    part.late = address_of(name);

    const avr_timer_t *p = t->part;
    part.registers[TWIN_TOP_LOW] = p->comp[0].r_ocr;
    part.registers[TWIN_TOP_HIGH] = p->comp[0].r_ocrh;
    part.registers[TWIN_EDGE_LOW] = p->comp[1].r_ocr;
    part.registers[TWIN_EDGE_HIGH] = p->comp[1].r_ocrh;
    part.registers[TWIN_COUNT_LOW] = p->r_tcnt;
    part.registers[TWIN_COUNT_HIGH] = p->r_tcnth;
    part.registers[TWIN_CONTROL] = p->wgm[0].reg;
    part.registers[TWIN_FLAGS] = p->overflow.raised.reg;
    part.registers[TWIN_MASK] = p->overflow.enable.reg;
    part.registers[TWIN_BEFORE] = GPIOR0;
}

static uint16_t word_at(uint32_t pc)
{
    return (uint16_t)(part.avr->flash[pc] | part.avr->flash[pc + 1U] << 8);
}

// The data address that the instruction at the program counter reads or writes by name; 0: none.
static uint16_t address_accessed(uint16_t opcode, uint32_t pc, bool *is_write, int *of)
{
    *of = (opcode >> 4) & 0x1F;
    if ((opcode & 0xFE0FU) == 0x9000U || (opcode & 0xFE0FU) == 0x9200U) { // lds, sts
        *is_write = (opcode & 0x0200U) != 0;
        return word_at(pc + 2U);
    }
    if ((opcode & 0xF000U) == 0xB000U) { // in, out
        *is_write = (opcode & 0x0800U) != 0;
        return (uint16_t)(0x20U + ((opcode & 0xFU) | ((opcode >> 5) & 0x30U)));
    }
    if ((opcode & 0xFC00U) == 0x9800U) { // cbi, sbic, sbi, sbis
        *of = -1;
        *is_write = (opcode & 0x0100U) == 0;
        return (uint16_t)(0x20U + ((opcode >> 3) & 0x1FU));
    }
    return 0;
}

static int register_at(uint16_t address)
{
    for (int i = 0; i < TWIN_REGISTERS; i++) {
        if (address != 0 && part.registers[i] == address) {
            return i;
        }
    }
    return -1;
}

// The running period is not the one whose end the flag stands for: one more has ended since.
static bool period_is_lost(void)
{
    return part.timer->bottom != part.flag_cycle;
}

static void step(void)
{
    avr_t *avr = part.avr;
    bool is_write = false;
    int of = 0;
    uint16_t opcode = word_at(avr->pc);
    uint16_t address = address_accessed(opcode, avr->pc, &is_write, &of);
    int which = register_at(address);
    bool was_lost = period_is_lost();

    avr->pc = skips_mend(&part.skips, avr, avr_run_one(avr));
    if (which < 0) {
        return;
    }
    if (which == TWIN_COUNT_LOW && is_write && !was_lost) {
        part.flag_cycle = part.timer->bottom; // the same period, moved
    }
    part.lost_inside |= which == TWIN_FLAGS && period_is_lost();
    if (part.made == ACCESSES) {
        fail("an interrupt without an end");
    }
    uint8_t value = of >= 0 ? avr->data[of] : avr->data[address];
    if (is_write && of < 0) {
        value = (opcode & 7U) == PIXEL_CLOCK_BEFORE && (opcode & 0x0200U) != 0;
    }
    part.accesses[part.made++] = (struct access){(uint8_t)which, value, is_write};
}

static uint16_t stack_pointer(void)
{
    return (uint16_t)(part.avr->data[R_SPL] | part.avr->data[R_SPH] << 8);
}

static void set_stack_pointer(uint16_t value)
{
    part.avr->data[R_SPL] = (uint8_t)value;
    part.avr->data[R_SPH] = (uint8_t)(value >> 8);
}

// ---- an interrupt, and its twin ----

static uint8_t twin_reads(void *owner, enum twin_register which)
{
    struct access *one = &part.accesses[part.compared];

    (void)owner;
    if (part.compared == part.made || one->is_write || one->which != which) {
        fail("access %u: the twin reads %d, the assembly does not",
             part.compared,
             (int)which);
    }
    part.compared++;
    return one->value;
}

static void twin_writes(void *owner, enum twin_register which, uint8_t value)
{
    struct access *one = &part.accesses[part.compared];

    (void)owner;
    if (part.compared == part.made || !one->is_write || one->which != which ||
        one->value != value) {
        fail("access %u: the twin writes %u to %d, the assembly %s %u, register %u",
             part.compared,
             value,
             (int)which,
             one->is_write ? "writes" : "reads",
             one->value,
             one->which);
    }
    part.compared++;
}

static const struct twin_timer twin_timer = {.read = twin_reads, .write = twin_writes};

static struct step_ring ring;

static uint8_t *data(uint16_t address)
{
    return &part.avr->data[address];
}

static int16_t int16_at(uint16_t address)
{
    return (int16_t)(uint16_t)(*data(address) | *data((uint16_t)(address + 1U)) << 8);
}

static void put_int16(uint16_t address, int16_t value)
{
    *data(address) = (uint8_t)value;
    *data((uint16_t)(address + 1U)) = (uint8_t)((uint16_t)value >> 8);
}

static uint16_t train_at(unsigned which)
{
    return (uint16_t)(part.engine + STEP_ISR_TRAINS + which * STEP_ISR_TRAIN_SIZE);
}

static void read_engine(struct step_engine *engine)
{
    *engine = (struct step_engine){
        .tail = *data(part.engine + STEP_ISR_TAIL),
        .state = *data(part.engine + STEP_ISR_STATE),
        .idle_count = (uint16_t)int16_at(part.engine + STEP_ISR_IDLE_COUNT),
        .left = (int8_t)*data(part.engine + STEP_ISR_LEFT),
        .train_high = *data(part.engine + STEP_ISR_TRAIN_HIGH),
        .stop = *data(part.engine + STEP_ISR_STOP) != 0,
        .pulse = *data(part.engine + STEP_ISR_PULSE) != 0,
        .cut = (int8_t)*data(part.engine + STEP_ISR_CUT),
    };
    for (unsigned i = 0; i < STEP_TRAINS; i++) {
        uint16_t at = train_at(i);
        engine->trains[i] = (struct pulse_train){
            .sum = int16_at(at + STEP_ISR_SUM),
            .after_short = int16_at(at + STEP_ISR_AFTER_SHORT),
            .after_long = int16_at(at + STEP_ISR_AFTER_LONG),
            .short_low = *data(at + STEP_ISR_SHORT_LOW),
            .long_low = *data(at + STEP_ISR_LONG_LOW),
            .top_high = *data(at + STEP_ISR_TOP_HIGH),
        };
    }
}

// Into the part's memory; what the interrupt has no business with stays.
static void write_engine(const struct step_engine *engine)
{
    *data(part.engine + STEP_ISR_TAIL) = engine->tail;
    *data(part.engine + STEP_ISR_STATE) = engine->state;
    put_int16(part.engine + STEP_ISR_IDLE_COUNT, (int16_t)engine->idle_count);
    *data(part.engine + STEP_ISR_LEFT) = (uint8_t)engine->left;
    *data(part.engine + STEP_ISR_TRAIN_HIGH) = engine->train_high;
    *data(part.engine + STEP_ISR_STOP) = engine->stop;
    *data(part.engine + STEP_ISR_PULSE) = engine->pulse;
    *data(part.engine + STEP_ISR_CUT) = (uint8_t)engine->cut;
    for (unsigned i = 0; i < STEP_TRAINS; i++) {
        uint16_t at = train_at(i);
        put_int16(at + STEP_ISR_SUM, engine->trains[i].sum);
        put_int16(at + STEP_ISR_AFTER_SHORT, engine->trains[i].after_short);
        put_int16(at + STEP_ISR_AFTER_LONG, engine->trains[i].after_long);
        *data(at + STEP_ISR_SHORT_LOW) = engine->trains[i].short_low;
        *data(at + STEP_ISR_LONG_LOW) = engine->trains[i].long_low;
        *data(at + STEP_ISR_TOP_HIGH) = engine->trains[i].top_high;
    }
}

// All RAM is as the twin has it, but for the stack below the stack pointer.
static void compare_memory(const struct twin *twin, uint16_t sp)
{
    avr_t *avr = part.avr;
    uint32_t first = avr->ioend + 1U;
    uint8_t *found = &avr->data[first];
    uint32_t size = (uint32_t)(sp + 1U - STACK_BYTES - first);
    struct step_engine assembly;

    if (*data(part.last) != twin->last || *data(part.before_low) != twin->before_low ||
        *data(part.before_high) != twin->before_high) {
        fail("noted %02X %02X %02X, the twin %02X %02X %02X",
             *data(part.last),
             *data(part.before_low),
             *data(part.before_high),
             twin->last,
             twin->before_low,
             twin->before_high);
    }
    read_engine(&assembly);
    // The twin's memory: what was there, with what the twin changed.
    uint8_t engine_bytes[STEP_ISR_ENGINE_SIZE];
    memcpy(engine_bytes, data(part.engine), sizeof engine_bytes);
    write_engine(&twin->engine);
    if (memcmp(engine_bytes, data(part.engine), sizeof engine_bytes) != 0) {
        fail("engine: tail %u left %d sum %d %d, the twin: tail %u left %d sum %d %d",
             assembly.tail,
             assembly.left,
             assembly.trains[0].sum,
             assembly.trains[1].sum,
             twin->engine.tail,
             twin->engine.left,
             twin->engine.trains[0].sum,
             twin->engine.trains[1].sum);
    }
    // Now take the interrupt's own memory out of the comparison.
    memcpy(&part.before[part.engine], data(part.engine), STEP_ISR_ENGINE_SIZE);
    part.before[part.last] = *data(part.last);
    part.before[part.before_low] = *data(part.before_low);
    part.before[part.before_high] = *data(part.before_high);
    if (memcmp(found, &part.before[first], size) != 0 ||
        memcmp(&avr->data[sp + 1U], &part.before[sp + 1U], avr->ramend - sp) != 0) {
        fail("other memory was changed");
    }
}

static void remember_memory(void)
{
    memcpy(part.before, part.avr->data, part.avr->ramend + 1U);
}

// r7 and up, SREG and the stack pointer are the interrupted program's.
static void compare_registers(uint16_t sp, const uint8_t *sreg)
{
    avr_t *avr = part.avr;

    for (unsigned i = 0; i < 32U; i++) {
        if ((i < 2U || i > 6U) && avr->data[i] != part.before[i]) {
            fail("r%u is %02X, was %02X", i, avr->data[i], part.before[i]);
        }
    }
    for (unsigned i = 0; i < S_I; i++) {
        if (avr->sreg[i] != sreg[i]) {
            fail("SREG bit %u was changed", i);
        }
    }
    if (stack_pointer() != sp) {
        fail("the stack pointer has moved");
    }
}

static bool is_flagged(uint8_t flag)
{
    timer16_sync(part.timer, part.avr->cycle);
    return (part.avr->data[part.registers[TWIN_FLAGS]] & flag) != 0;
}

static void step_unseen(void)
{
    avr_t *avr = part.avr;

    avr->pc = skips_mend(&part.skips, avr, avr_run_one(avr));
}

static enum twin_end end_of_interrupt(const avr_t *avr)
{
    if (avr->pc == part.late) {
        return TWIN_LATE;
    }
    return avr->pc == part.command ? TWIN_COMMAND : TWIN_RETURNS;
}

// The C half of an interrupt, and the way back. A halt may be asked for while a command is executed
// (step_engine_halt_soon()): what C has taken of a train is then cut off.
static void go_on_in_c(struct twin *twin, enum twin_end end)
{
    struct step_engine found;
    avr_t *avr = part.avr;
    bool halts = running_scene->halts;

    if (end == TWIN_RETURNS) {
        return;
    }
    if (end == TWIN_COMMAND && halts) {
        *data(part.engine + STEP_ISR_STOP) = true;
    }
    while (avr->pc != RETURN_AT) {
        step_unseen();
    }
    read_engine(&found);
    if (end == TWIN_LATE) {
        step_engine_halt(&twin->engine);
    } else {
        struct step_load load = step_engine_next(&twin->engine, twin->ring);
        (void)load;
        if (halts) {
            twin->engine.stop = true;
            twin->engine.cut = twin->engine.left;
            twin->engine.left = 0;
            twin->engine.state = STEP_ENGINE_HALTING;
        }
    }
    if (is_flagged(OVERFLOW_FLAG) && end == TWIN_COMMAND) {
        return; // the command took longer than the period
    }
    if (found.tail != twin->engine.tail || found.left != twin->engine.left ||
        found.cut != twin->engine.cut || found.state != twin->engine.state ||
        found.stop != twin->engine.stop || found.idle_count != twin->engine.idle_count ||
        found.trains[0].sum != twin->engine.trains[0].sum ||
        found.trains[1].sum != twin->engine.trains[1].sum) {
        fail("behind C: tail %u left %d cut %d state %u stop %d, the twin %u %d %d %u %d",
             found.tail,
             found.left,
             found.cut,
             found.state,
             found.stop,
             twin->engine.tail,
             twin->engine.left,
             twin->engine.cut,
             twin->engine.state,
             twin->engine.stop);
    }
    totals.commands += end == TWIN_COMMAND;
    totals.cut += twin->engine.cut != 0;
}

// Serve the interrupt now: the response, then the handler up to its end.
static enum twin_end serve(struct twin *twin)
{
    avr_t *avr = part.avr;
    uint16_t sp = stack_pointer();
    uint8_t sreg[8];
    bool has_three = avr->address_size == 3;

    memcpy(sreg, avr->sreg, sizeof sreg);
    remember_memory();
    part.made = part.compared = 0;
    avr->data[part.registers[TWIN_FLAGS]] &= (uint8_t)~OVERFLOW_FLAG;
    avr->cycle += has_three ? 5U : 4U;
    for (uint8_t i = 0; i < avr->address_size; i++) {
        avr->data[sp - i] = 0;
    }
    part.before[sp] = part.before[sp - 1U] = part.before[sp - 2U] = 0;
    set_stack_pointer((uint16_t)(sp - avr->address_size));
    avr->sreg[S_I] = 0;
    avr->pc = part.vector;
    do {
        step();
    } while (avr->pc != RETURN_AT && avr->pc != part.late && avr->pc != part.command);
    enum twin_end end = end_of_interrupt(avr);
    enum twin_end expected = twin_interrupt(twin);
    if (end != expected || part.compared != part.made) {
        fail("the interrupt ends with %d after %u accesses, the twin with %d after %u",
             (int)end,
             part.made,
             (int)expected,
             part.compared);
    }
    compare_memory(twin, sp);
    go_on_in_c(twin, end);
    avr->sreg[S_I] = 0;
    compare_registers(sp, sreg);
    for (unsigned i = 0; i < TWIN_PATHS; i++) {
        totals.visits[i] += twin->visited >> i & 1U;
    }
    totals.interrupts++;
    set_stack_pointer(sp);
    return end;
}

// ---- a run ----

static uint64_t ideal[PERIODS]; // first cycle of each period of the ring
static unsigned periods;

static void add_period(uint32_t ticks)
{
    ideal[periods + 1U] = ideal[periods] + ticks;
    periods++;
}

static void add_train(struct step_engine *engine, bool second, uint8_t count)
{
    struct pulse_train *train = &engine->trains[second];

    for (uint8_t i = 0; i < count; i++) {
        bool is_long = train->sum >= 0;
        uint8_t low = is_long ? train->long_low : train->short_low;
        add_period((uint32_t)(train->top_high << 8 | low) + 1U);
        train->sum =
            (int16_t)(train->sum + (is_long ? train->after_long : train->after_short));
    }
}

static struct pulse_train train_of(const struct scene *s, uint16_t base)
{
    uint16_t top = (uint16_t)(base - 1U);

    return (struct pulse_train){
        .sum = s->sum,
        .after_short = (int16_t)s->remainder,
        .after_long = (int16_t)(s->remainder - s->steps),
        .short_low = (uint8_t)top,
        .long_low = (uint8_t)(top + 1U),
        .top_high = (uint8_t)(top >> 8),
    };
}

static uint8_t slot;

static void add_entry(uint8_t high, uint8_t low)
{
    ring.high[slot] = high;
    ring.low[slot] = low;
    slot++;
}

static void add_train_entry(bool second, uint8_t count)
{
    add_entry(STEP_HIGH_TRAIN, (uint8_t)(second ? -count : count));
}

static void add_tail(const struct scene *s, struct step_engine *counting)
{
    uint16_t base = (uint16_t)(s->base + s->other);

    if (s->tail == SAME_TRAIN || s->tail == OTHER_TRAIN) {
        bool second = s->second != (s->tail == OTHER_TRAIN);
        add_train_entry(second, s->tail_count);
        add_train(counting, second, s->tail_count);
    } else if (s->tail != NOTHING && s->tail != ORDER) {
        add_entry((uint8_t)((base - 1U) >> 8), (uint8_t)(base - 1U));
        add_period(base);
        add_entry((uint8_t)((base + 99U) >> 8), (uint8_t)(base + 99U));
        add_period(base + 100U);
    }
    if (s->tail == ORDER) { // and a train that C takes behind it
        add_entry(STEP_HIGH_COMMAND, STEP_COMMAND_PULSE);
        add_train_entry(s->second, s->tail_count);
    }
    add_entry(STEP_HIGH_EMPTY, 0);
}

static void fill_ring(const struct scene *s, struct twin *twin)
{
    struct step_engine counting;

    memset(&ring, 0, sizeof ring);
    twin->engine.trains[s->second] = train_of(s, s->base);
    twin->engine.trains[!s->second] = train_of(s, (uint16_t)(s->base + s->other));
    counting = twin->engine;
    slot = 250; // around the ring's end
    twin->engine.tail = slot;
    periods = 0;
    add_train_entry(s->second, s->count);
    add_train(&counting, s->second, s->count);
    add_tail(s, &counting);
    for (uint16_t i = 0; i < STEP_RING_SLOTS; i++) {
        *data((uint16_t)(part.ring + i)) = ring.low[i];
        *data((uint16_t)(part.ring + STEP_ISR_HIGH_OFFSET + i)) = ring.high[i];
    }
}

// The single period before the first train is about to begin.
static void start_timer(void)
{
    struct timer16 *t = part.timer;
    uint64_t cycle = part.avr->cycle;

    t->tccra = STEP_CONTROL;
    t->tccrb = CLOCKED;
    t->temp = 0;
    t->ocr[0] = t->ocr_buffer[0] = FIRST_TOP;
    t->ocr[1] = t->ocr_buffer[1] = PULSE_LOW;
    t->ocr[2] = t->ocr_buffer[2] = 0xFFFFU;
    t->counting = true;
    t->blocked = false;
    t->oc_level[STEP_CHANNEL] = false;
    t->capture_due = NEVER;
    t->match_due[0] = t->match_due[1] = t->match_due[2] = NEVER;
    timer16_set_count(t, FIRST_TOP - 20U, cycle);
    part.avr->data[part.registers[TWIN_FLAGS]] = 0;
    part.avr->data[part.registers[TWIN_MASK]] =
        0; // the run below serves the interrupts itself
    part.avr->data[part.registers[TWIN_CONTROL]] = STEP_CONTROL;
    part.edge_count = 0;
    part.lost_inside = false;
}

static uint64_t random_state = 0x9E3779B97F4A7C15u;

static uint8_t noise(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint8_t)(random_state >> 56);
}

static void begin_run(const struct scene *s, struct twin *twin)
{
    avr_t *avr = part.avr;

    avr->cycle = 100000;
    avr->state = cpu_Running;
    avr_interrupt_reset(avr);
    set_stack_pointer((uint16_t)(avr->ramend - 8U));
    for (unsigned i = 0; i < 32U; i++) {
        avr->data[i] = noise();
    }
    for (unsigned i = 0; i < S_I; i++) {
        avr->sreg[i] = noise() & 1U;
    }
    *data(GPIOR0) = 0;
    *twin = (struct twin){.ring = &ring,
                          .has_clock = s->axis == BOARD_PIXEL_CLOCK_AXIS,
                          .low_ticks = PULSE_LOW,
                          .timer = &twin_timer};
    twin->engine.state = STEP_ENGINE_IN_LINE;
    twin->engine.pulse = true;
    twin->last = *data(part.last) = noise();
    twin->before_low = *data(part.before_low) = noise();
    twin->before_high = *data(part.before_high) = noise();
    fill_ring(s, twin);
    write_engine(&twin->engine);
    start_timer();
}

// Where the ring has an edge, counted from the single period's; NEVER behind its last one.
static uint64_t wanted_edge(unsigned index)
{
    return index > periods ? NEVER : part.edges[0] + FIRST_TOP + 1U + ideal[index - 1U];
}

// An interrupt that stops the axis may have seen that it is late only behind the edge of the period
// that repeats, which then is one too many or too early (docs/FAULTS.md, underrun). Where a train
// is over and nothing follows, its next interval may have been loaded as well.
static void check_edges(enum twin_end end)
{
    unsigned exact = 1;

    while (exact < part.edge_count && part.edges[exact] == wanted_edge(exact)) {
        exact++;
    }
    unsigned off = part.edge_count - exact;
    if (end == TWIN_COMMAND && exact == periods + 1U) {
        off = 0; // what follows is C's business
    } else if (end == TWIN_LATE) {
        totals.off += off != 0;
        totals.stray += off;
        off = off > STRAY_MOST ? off : 0;
    } else if (end == TWIN_RETURNS && part.edge_count != periods + 1U) {
        fail("%u edges, the ring has %u periods", part.edge_count, periods + 1U);
    }
    if (off != 0) {
        fail("edge %u is at %lld, not %lld",
             exact,
             (long long)(part.edges[exact] - part.edges[0]),
             (long long)(wanted_edge(exact) - part.edges[0]));
    }
}

// Wait for the next overflow.
static void wait_for_overflow(void)
{
    if (!is_flagged(OVERFLOW_FLAG)) {
        part.avr->cycle = part.timer->bottom_due;
        (void)is_flagged(OVERFLOW_FLAG);
    }
    part.avr->cycle += SOON_CYCLES;
}

// Hold the interrupt up. The late one begins `left_cycles` before the running period ends, but not
// before it would. Returns false where that is no later than at once.
static bool hold_up(const struct scene *s, unsigned left_cycles, unsigned interrupt)
{
    avr_t *avr = part.avr;
    bool held_up = true;

    if (interrupt == s->late && left_cycles != IN_TIME) {
        uint64_t begin = part.timer->bottom_due - left_cycles;
        held_up = begin >= avr->cycle;
        avr->cycle = held_up ? begin : avr->cycle;
    } else if (interrupt == s->late + 1U) {
        avr->cycle += s->late_again;
    }
    timer16_sync(part.timer, avr->cycle);
    return held_up;
}

static void place_clock_edge(const struct scene *s, unsigned interrupt)
{
    if (interrupt == s->late && s->clock_at != NEVER) {
        part.timer->capture_due = part.timer->bottom + s->clock_at;
    }
}

static void end_run(const struct scene *s, unsigned left_cycles, enum twin_end end)
{
    if (end == TWIN_LATE && left_cycles == IN_TIME && s->late_again == 0 &&
        s->base >= EASY_TICKS) {
        fail("stopped, and nothing was late");
    }
    totals.stopped += end == TWIN_LATE;
    totals.whole += end != TWIN_LATE;
    for (unsigned i = 0; i < 3U && end != TWIN_COMMAND; i++) { // the last periods' edges
        timer16_sync(part.timer, part.timer->bottom_due);
    }
    if (part.lost_inside && (end != TWIN_LATE || s->base < LOST_BELOW_TICKS)) {
        totals.lost_inside++;
        if (s->base >= LOST_BELOW_TICKS) {
            fail("a period ended unseen");
        }
        return;
    }
    check_edges(end);
}

// A run ends early where an interrupt begins when one more period is over: the flag that would tell
// is set already, so the account of time finds that (time_check.c). Returns false when the
// interrupt cannot begin as early as that.
static bool run(const struct scene *s, unsigned left_cycles)
{
    struct twin twin;
    enum twin_end end = TWIN_RETURNS;

    running_scene = s;
    running_cycles = left_cycles;
    begin_run(s, &twin);
    totals.runs++;
    for (unsigned i = 0; end == TWIN_RETURNS && twin.engine.state == STEP_ENGINE_IN_LINE;
         i++) {
        wait_for_overflow();
        place_clock_edge(s, i);
        if (!hold_up(s, left_cycles, i)) {
            return false;
        }
        if (period_is_lost()) {
            totals.lost++;
            return true;
        }
        end = serve(&twin);
    }
    end_run(s, left_cycles, end);
    return true;
}

static void run_all_late(const struct scene *s, unsigned step_cycles)
{
    (void)run(s, IN_TIME);
    for (unsigned left = 1; left < LATE_MOST && run(s, left); left += step_cycles) {
    }
}

// ---- the scenes ----

static const uint16_t bases[] = {64,  65,  66,  72,  80,  96,  120, 126, 127, 128,
                                 129, 130, 140, 170, 200, 240, 253, 254, 257, 258,
                                 300, 420, 511, 514, 515, 600, 769, 1100};
static const struct {
    uint16_t steps, remainder;
    int16_t sum;
} patterns[] = {
    {4, 0, -1}, // equal
    {2, 1, 0},  // long, short in turn
    {2, 1, -1},
    {5, 1, 0}, // one long one
    {5, 1, -2},
    {5, 4, 0}, // one short one
    {5, 4, 3},
};
static const int others[] = {
    0, 1, -1, 5, -5, 17, -20, 63, 64, 65, -64, 100, 190, 256, 700};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static bool is_possible(const struct scene *s)
{
    int other = (int)s->base + s->other;
    bool crosses = s->remainder != 0 &&
                   ((s->base - 1) >> 8 != s->base >> 8 || (other - 1) >> 8 != other >> 8);

    return other >= 64 && !crosses;
}

struct thoroughness {
    unsigned base_step, other_step, late_step;
    bool all_axes, again;
};

static void run_scene(struct scene *s, const struct thoroughness *how)
{
    if (!is_possible(s)) {
        return;
    }
    for (s->late = 0; s->late < s->count + 2U; s->late++) {
        s->clock_at = NEVER;
        s->late_again = 0;
        s->halts = s->tail == ORDER && (s->late & 1U) != 0;
        run_all_late(s, how->late_step);
        if (s->axis == BOARD_PIXEL_CLOCK_AXIS) {
            for (s->clock_at = 0; s->clock_at < s->base + 40U;
                 s->clock_at += s->base / 5U) {
                run_all_late(s, 2U * how->late_step);
            }
        }
        s->clock_at = NEVER;
        if (how->again) {
            for (s->late_again = 3; s->late_again < s->base;
                 s->late_again += s->base / 5U) {
                run_all_late(s, 10U * how->late_step);
            }
        }
    }
}

static void run_tails(struct scene *s, const struct thoroughness *how)
{
    for (s->tail = 0; s->tail < TAILS; s->tail++) {
        bool has_other = s->tail == OTHER_TRAIN || s->tail == SINGLE;
        s->tail_count = s->tail == SAME_TRAIN ? 2 : 3;
        for (unsigned i = 0; i < (has_other ? COUNT(others) : 1U); i += how->other_step) {
            s->other = has_other ? others[i] : 0;
            run_scene(s, how);
        }
    }
}

static void run_patterns(struct scene *s, const struct thoroughness *how)
{
    static const uint8_t counts[] = {1, 2, 4};

    for (unsigned i = 0; i < COUNT(patterns); i++) {
        s->steps = patterns[i].steps;
        s->remainder = patterns[i].remainder;
        s->sum = patterns[i].sum;
        for (unsigned k = 0; k < COUNT(counts); k++) {
            s->count = counts[k];
            run_tails(s, how);
        }
    }
}

static void run_axes(const struct thoroughness *how)
{
    for (unsigned axis = 0; axis < BOARD_AXES; axis++) {
        if (!how->all_axes && axis != 0 && axis != BOARD_PIXEL_CLOCK_AXIS) {
            continue;
        }
        choose_axis(axis);
        for (unsigned b = 0; b < COUNT(bases); b += how->base_step) {
            for (int second = 0; second < 2; second++) {
                struct scene s = {.axis = axis, .base = bases[b], .second = second != 0};
                run_patterns(&s, how);
            }
        }
    }
}

static void report(void)
{
    static const char *const names[TWIN_PATHS] = {
        "equal",
        "counter set",
        "counter set, short",
        "counter set, long",
        "entry ahead",
        "counter set, any",
        "stretched",
        "stretched, single",
        "as long",
        "moved, long",
        "before its edge",
        "between trains",
    };

    (void)printf(
        "%llu runs, %llu interrupts; %llu runs whole, %llu stopped (%llu of them "
        "behind %llu wrong edges), %llu lost a period, "
        "%llu inside an interrupt; %llu commands, %llu trains cut off\n",
        (unsigned long long)totals.runs,
        (unsigned long long)totals.interrupts,
        (unsigned long long)totals.whole,
        (unsigned long long)totals.stopped,
        (unsigned long long)totals.off,
        (unsigned long long)totals.stray,
        (unsigned long long)totals.lost,
        (unsigned long long)totals.lost_inside,
        (unsigned long long)totals.commands,
        (unsigned long long)totals.cut);
    if (totals.commands == 0 || totals.cut == 0) {
        fail("no command, or none with a halt");
    }
    for (unsigned i = 0; i < TWIN_PATHS; i++) {
        (void)printf("  %-20s %llu\n", names[i], (unsigned long long)totals.visits[i]);
        if (totals.visits[i] == 0) {
            fail("never went that way");
        }
    }
}

int main(int argc, char **argv)
{
    bool is_long = argc > 2 && strcmp(argv[2], "long") == 0;
    struct thoroughness quick = {.base_step = 7, .other_step = 4, .late_step = 5};
    struct thoroughness all = {
        .base_step = 2, .other_step = 2, .late_step = 2, .all_axes = true, .again = true};

    if (argc < 2) {
        (void)fprintf(stderr, "usage: catch_up_test IMAGE [long]\n");
        return 2;
    }
    open_part(argv[1]);
    run_axes(is_long ? &all : &quick);
    running_scene = NULL;
    report();
    return 0;
}
