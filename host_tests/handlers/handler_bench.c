// SPDX-License-Identifier: MIT
#include "handlers/handler_bench.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_avr.h>
#include <sim_core.h>
#include <sim_elf.h>

#include "skips.h"
#include "symbols.h"

#define VECTOR_BYTES 4U // a jmp each
#define RETURN_AT    0U // the interrupted program: where it is does not matter
#define ACCESSES     4000U
#define STACK_BYTES  64U // below the stack pointer, that a handler may use
#define ABOVE_STACK  24U
#define REGISTERS    32U
#define STEP_FIRST   2U // r2 to r6 belong to the step interrupts
#define STEP_LAST    6U
#define CHANGES_MOST 64U

enum kind { READS, WRITES, SETS, CLEARS, OPENS, CLOSES, CALLS };

struct access {
    enum kind kind;
    uint16_t address;
    uint8_t value; // or the bit
    uint32_t pc;
};

struct change {
    uint16_t address;
    uint8_t value;
};

static struct bench {
    avr_t *avr;
    struct skips skips;
    struct symbols symbols;
    const struct handler *handler;
    unsigned run;
    struct access accesses[ACCESSES];
    unsigned made, compared;
    uint8_t *before, *own;
    struct change changes[CHANGES_MOST]; // of a made-up function
    unsigned changed;
    bool is_making_up;
    uint64_t noise;
} bench = {.noise = 0x9E3779B97F4A7C15U};

__attribute__((format(printf, 1, 2), noreturn)) static void fail(const char *format, ...)
{
    va_list arguments;

    (void)printf(
        "%s, run %u: ", bench.handler != NULL ? bench.handler->name : "image", bench.run);
    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    (void)printf("\n");
    exit(1);
}

// ---- the image ----

static const struct symbol *symbol_of(const char *name)
{
    bool several = false;
    const struct symbol *found = symbols_find(&bench.symbols, name, &several);

    if (found == NULL) {
        fail("no symbol %s", name);
    }
    return found;
}

uint16_t bench_variable(const char *name)
{
    return (uint16_t)symbol_of(name)->address;
}

uint32_t bench_function(const char *name)
{
    return symbol_of(name)->address;
}

void bench_open(const char *image_path, const char *part_name)
{
    static elf_firmware_t image;
    avr_t *avr = avr_make_mcu_by_name(part_name);

    if (avr == NULL || avr_init(avr) != 0) {
        fail("no %s", part_name);
    }
    if (elf_read_firmware(image_path, &image) != 0 || image.flashsize == 0) {
        fail("%s: not an AVR image", image_path);
    }
    avr_load_firmware(avr, &image);
    // The hardware's registers are plain memory.
    memset(avr->io, 0, sizeof avr->io);
    bench.avr = avr;
    if (!skips_find(&bench.skips, avr) || !symbols_read(&bench.symbols, image_path)) {
        fail("%s: no symbols", image_path);
    }
    bench.before = malloc(avr->ramend + 1U);
    bench.own = malloc(avr->ramend + 1U);
}

// ---- chance ----

static uint64_t random_word(void)
{
    bench.noise ^= bench.noise << 13;
    bench.noise ^= bench.noise >> 7;
    bench.noise ^= bench.noise << 17;
    return bench.noise;
}

uint8_t bench_noise(void)
{
    return (uint8_t)(random_word() >> 40);
}

uint8_t bench_margin(void)
{
    static const uint8_t margins[] = {0, 0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF};
    uint8_t found = bench_noise();

    return found < 160U ? margins[found % sizeof margins] : bench_noise();
}

static void fill_with_noise(uint8_t *to, size_t bytes)
{
    while (bytes >= sizeof(uint64_t)) {
        uint64_t word = random_word();
        memcpy(to, &word, sizeof word);
        to += sizeof word;
        bytes -= sizeof word;
    }
    for (; bytes > 0; bytes--) {
        *to++ = bench_noise();
    }
}

void bench_put(uint16_t address, uint8_t value)
{
    bench.avr->data[address] = value;
    if (bench.is_making_up) {
        if (bench.changed == CHANGES_MOST) {
            fail("too many changes");
        }
        bench.changes[bench.changed++] = (struct change){address, value};
    }
}

uint8_t bench_get(uint16_t address)
{
    return bench.avr->data[address];
}

// ---- the handler's side ----

static uint16_t stack_pointer(void)
{
    return (uint16_t)(bench.avr->data[R_SPL] | bench.avr->data[R_SPH] << 8);
}

static void set_stack_pointer(uint16_t value)
{
    bench.avr->data[R_SPL] = (uint8_t)value;
    bench.avr->data[R_SPH] = (uint8_t)(value >> 8);
}

static bool is_shared(uint16_t address)
{
    if (address <= bench.avr->ioend) {
        return address >= REGISTERS && address != R_SREG && address != R_SPL &&
               address != R_SPH;
    }
    for (const struct shared_memory *one = bench.handler->shared; one->bytes != 0;
         one++) {
        if (address >= one->first && address - one->first < one->bytes) {
            return true;
        }
    }
    return false;
}

static void note(enum kind kind, uint16_t address, uint8_t value)
{
    if (bench.made == ACCESSES) {
        fail("no end");
    }
    bench.accesses[bench.made++] = (struct access){kind, address, value, bench.avr->pc};
}

static uint16_t word_at(uint32_t pc)
{
    return (uint16_t)(bench.avr->flash[pc] | bench.avr->flash[pc + 1U] << 8);
}

// What the instruction at the program counter does with shared memory that it names.
static bool access_of(uint16_t opcode, struct access *found)
{
    uint8_t of = (opcode >> 4) & 0x1FU;
    bool is_write = false;

    if ((opcode & 0xFE0FU) == 0x9000U || (opcode & 0xFE0FU) == 0x9200U) { // lds, sts
        found->address = word_at(bench.avr->pc + 2U);
        is_write = (opcode & 0x0200U) != 0;
    } else if ((opcode & 0xF000U) == 0xB000U) { // in, out
        found->address = (uint16_t)(0x20U + ((opcode & 0xFU) | ((opcode >> 5) & 0x30U)));
        is_write = (opcode & 0x0800U) != 0;
    } else if ((opcode & 0xFC00U) == 0x9800U) { // cbi, sbic, sbi, sbis
        found->address = (uint16_t)(0x20U + ((opcode >> 3) & 0x1FU));
        found->kind = (opcode & 0x0200U) != 0 ? SETS : CLEARS;
        found->value = opcode & 7U;
        if ((opcode & 0x0100U) != 0) {
            found->kind = READS;
            found->value = bench.avr->data[found->address];
        }
        return true;
    } else {
        return false;
    }
    found->kind = is_write ? WRITES : READS;
    found->value = bench.avr->data[is_write ? of : found->address];
    return true;
}

// Other interrupts, where they may come.
static void interrupt(void)
{
    for (unsigned i = STEP_FIRST; i <= STEP_LAST; i++) {
        bench.avr->data[i] = bench_noise();
    }
    if (bench.handler->interrupt != NULL) {
        bench.handler->interrupt();
    }
}

static const struct made_up *made_up_here(void)
{
    for (const struct made_up *one = bench.handler->made_up; one->function != 0; one++) {
        if (one->function == bench.avr->pc) {
            return one;
        }
    }
    return NULL;
}

// Back from a function that is not run.
static void make_up(const struct made_up *function)
{
    avr_t *avr = bench.avr;
    uint16_t sp = (uint16_t)(stack_pointer() + avr->address_size);
    uint32_t pc = 0;

    note(CALLS, 0, avr->sreg[S_I]);
    if (avr->sreg[S_I] != function->interrupts_on ||
        (!function->is_signal && avr->data[1])) {
        fail("a function is called with I %u, r1 %u", avr->sreg[S_I], avr->data[1]);
    }
    bench.is_making_up = true;
    if (function->leave != NULL) {
        function->leave();
    }
    bench.is_making_up = false;
    for (unsigned i = 0; i < REGISTERS && !function->is_signal; i++) {
        if (i == 0 || (i >= 18U && i <= 27U) || i >= 30U) {
            avr->data[i] = bench_noise();
        }
    }
    if (function->interrupts_on) {
        interrupt();
    }
    for (uint8_t i = 0; i < avr->address_size; i++) {
        pc = pc << 8 | avr->data[sp - avr->address_size + 1U + i];
    }
    set_stack_pointer(sp);
    if (function->is_signal) {
        avr->sreg[S_I] = 1;
    }
    avr->pc = pc << 1;
}

static void step(void)
{
    avr_t *avr = bench.avr;
    const struct made_up *function = made_up_here();
    struct access found = {.address = 0};
    bool was_on = avr->sreg[S_I] != 0;
    uint16_t opcode = word_at(avr->pc);

    if (function != NULL) {
        make_up(function);
        return;
    }
    if (access_of(opcode, &found) && is_shared(found.address)) {
        note(found.kind, found.address, found.value);
    }
    uint32_t next = skips_mend(&bench.skips, avr, avr_run_one(avr));
    bool is_on = avr->sreg[S_I] != 0;
    if (is_on != was_on && next != RETURN_AT) {
        note(is_on ? OPENS : CLOSES, 0, 0);
    }
    avr->pc = next;
    if (was_on && is_on && next != RETURN_AT && bench_noise() < 80U) {
        interrupt();
    }
}

// ---- the twin's side ----

static const char *const kinds[] = {"read of",
                                    "write to",
                                    "set bit of",
                                    "clear bit of",
                                    "interrupts on",
                                    "interrupts off",
                                    "call"};

static const struct access *expect(enum kind kind, uint16_t address)
{
    const struct access *one = &bench.accesses[bench.compared];

    if (bench.compared == bench.made) {
        fail("the handler ends, its twin goes on: %s %03X", kinds[kind], address);
    }
    if (one->kind != kind || one->address != address) {
        fail("access %u, at %05X: %s %03X, of the twin %s %03X",
             bench.compared,
             one->pc,
             kinds[one->kind],
             one->address,
             kinds[kind],
             address);
    }
    bench.compared++;
    return one;
}

static void expect_value(const struct access *one, uint8_t value)
{
    if (one->value != value) {
        fail("access %u, at %05X: %s %03X is %02X, of the twin %02X",
             bench.compared - 1U,
             one->pc,
             kinds[one->kind],
             one->address,
             one->value,
             value);
    }
}

uint8_t twin_reads(uint16_t address)
{
    return expect(READS, address)->value;
}

void twin_writes(uint16_t address, uint8_t value)
{
    expect_value(expect(WRITES, address), value);
}

void twin_sets(uint16_t address, uint8_t bit)
{
    expect_value(expect(SETS, address), bit);
}

void twin_clears(uint16_t address, uint8_t bit)
{
    expect_value(expect(CLEARS, address), bit);
}

bool twin_has(uint16_t address, uint8_t bit)
{
    return (twin_reads(address) >> bit & 1U) != 0;
}

void twin_opens(void)
{
    (void)expect(OPENS, 0);
}

void twin_closes(void)
{
    (void)expect(CLOSES, 0);
}

uint8_t *twin_own(uint16_t address)
{
    return &bench.own[address];
}

uint16_t twin_word(uint16_t address)
{
    return (uint16_t)(bench.own[address] | bench.own[address + 1U] << 8);
}

void twin_put_word(uint16_t address, uint16_t value)
{
    bench.own[address] = (uint8_t)value;
    bench.own[address + 1U] = (uint8_t)(value >> 8);
}

void twin_calls(const struct made_up *function)
{
    expect_value(expect(CALLS, 0), function->interrupts_on);
    for (unsigned i = 0; i < bench.changed; i++) {
        bench.own[bench.changes[i].address] = bench.changes[i].value;
    }
    bench.changed = 0; // of one function that leaves something
}

// ---- a run ----

static void compare_memory(uint16_t sp)
{
    avr_t *avr = bench.avr;

    for (uint32_t address = avr->ioend + 1U; address <= avr->ramend; address++) {
        bool is_stack = address <= sp && address + STACK_BYTES > sp;
        if (avr->data[address] != bench.own[address] && !is_stack &&
            !is_shared((uint16_t)address)) {
            fail("memory at %04X is %02X, of the twin %02X, was %02X",
                 address,
                 avr->data[address],
                 bench.own[address],
                 bench.before[address]);
        }
    }
}

static void compare_registers(uint16_t sp, const uint8_t *sreg)
{
    avr_t *avr = bench.avr;

    for (unsigned i = 0; i < REGISTERS; i++) {
        if ((i < STEP_FIRST || i > STEP_LAST) && avr->data[i] != bench.before[i]) {
            fail("r%u is %02X, was %02X", i, avr->data[i], bench.before[i]);
        }
    }
    for (unsigned i = 0; i < S_I; i++) {
        if (avr->sreg[i] != sreg[i]) {
            fail("SREG bit %u was changed", i);
        }
    }
    if (stack_pointer() != sp || !avr->sreg[S_I]) {
        fail("the stack pointer is %04X, was %04X; I %u",
             stack_pointer(),
             sp,
             avr->sreg[S_I]);
    }
}

static void begin(uint16_t sp)
{
    avr_t *avr = bench.avr;

    avr->state = cpu_Running;
    fill_with_noise(avr->data, avr->ramend + 1U);
    for (unsigned i = 0; i < S_I; i++) {
        avr->sreg[i] = bench_noise() & 1U;
    }
    avr->sreg[S_I] = 0;
    bench.handler->prepare();
    for (uint8_t i = 0; i < avr->address_size; i++) {
        avr->data[sp - i] = 0;
    }
    set_stack_pointer((uint16_t)(sp - avr->address_size));
    memcpy(bench.before, avr->data, avr->ramend + 1U);
    memcpy(bench.own, avr->data, avr->ramend + 1U);
    bench.made = bench.compared = bench.changed = 0;
    avr->pc = bench.handler->vector * VECTOR_BYTES;
}

static void run_once(void)
{
    avr_t *avr = bench.avr;
    uint16_t sp = (uint16_t)(avr->ramend - ABOVE_STACK);
    uint8_t sreg[8];

    begin(sp);
    memcpy(sreg, avr->sreg, sizeof sreg);
    for (unsigned i = 0; avr->pc != RETURN_AT; i++) {
        if (i == ACCESSES || stack_pointer() + STACK_BYTES <= sp) {
            fail("no end, or too much stack");
        }
        step();
    }
    bench.handler->twin();
    if (bench.compared != bench.made) {
        fail("access %u is not the twin's: %s %03X",
             bench.compared,
             kinds[bench.accesses[bench.compared].kind],
             bench.accesses[bench.compared].address);
    }
    compare_memory(sp);
    compare_registers(sp, sreg);
}

void bench_run(const struct handler *handler, unsigned runs)
{
    bench.handler = handler;
    for (bench.run = 0; bench.run < runs; bench.run++) {
        run_once();
    }
    bench.handler = NULL;
}
