// SPDX-License-Identifier: MIT

#include "control_board.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- memories ----

static const struct symbol *find_symbol(const struct board *b, const char *name)
{
    bool several;
    const struct symbol *symbol = symbols_find(&b->symbols, name, &several);

    if (symbol == NULL) {
        control_answer(several ? "error '%s' names several places of the image"
                               : "error the image has no symbol '%s'",
                       name);
    }
    return symbol;
}

// SYMBOL or SYMBOL+OFFSET of this space. *left: bytes of the symbol from there on, 0 if unknown.
static bool find_symbol_place(const struct board *b,
                              char *text,
                              enum symbol_space space,
                              uint64_t *address,
                              uint64_t *left)
{
    char *plus = strchr(text, '+');
    const struct symbol *symbol;
    uint64_t offset = 0;

    if (plus != NULL) {
        *plus = '\0';
        if (!control_number(plus + 1, UINT32_MAX, &offset)) {
            return false;
        }
    }
    symbol = find_symbol(b, text);
    if (symbol == NULL) {
        return false;
    }
    if (symbol->space != space) {
        control_answer("error '%s' is in %s, not in %s",
                       text,
                       symbol_space_name(symbol->space),
                       symbol_space_name(space));
        return false;
    }
    *address = symbol->address + offset;
    *left = (symbol->size > offset) ? symbol->size - offset : 0;
    return true;
}

// A number or a symbol's place, at most `last`.
static bool read_place(const struct board *b,
                       char *text,
                       enum symbol_space space,
                       uint64_t last,
                       uint64_t *address,
                       uint64_t *left)
{
    *left = 0;
    if (text[0] >= '0' && text[0] <= '9') {
        return control_number(text, last, address);
    }
    if (!find_symbol_place(b, text, space, address, left)) {
        return false;
    }
    if (*address > last) {
        control_answer("error address %" PRIu64 " is beyond %" PRIu64, *address, last);
        return false;
    }
    return true;
}

// The number of bytes that the word gives, or the number that the symbol has left.
static bool read_length(
    const struct control *c, int word, uint64_t left, uint64_t most, uint64_t *count)
{
    if (c->words > word) {
        return control_number(c->word[word], most, count);
    }
    if (left == 0) {
        control_answer("error %s: how many bytes?", c->word[0]);
        return false;
    }
    *count = left;
    return true;
}

static bool check_fits(uint64_t address, size_t count, uint64_t bytes, const char *memory)
{
    if (address + count > bytes) {
        control_answer("error %zu bytes at %" PRIu64 " go beyond the %s's end",
                       count,
                       address,
                       memory);
        return false;
    }
    return true;
}

// TCNT0 of every part. simavr computes the count only when an instruction reads it.
#define COUNT_ADDRESS 0x46U

static void refresh_count(avr_t *avr)
{
    const avr_io_addr_t io = AVR_DATA_TO_IO(COUNT_ADDRESS);

    if (avr->io[io].r.c != NULL) {
        avr->data[COUNT_ADDRESS] =
            avr->io[io].r.c(avr, COUNT_ADDRESS, avr->io[io].r.param);
    }
}

static void do_peek(struct control *c)
{
    struct board *b = control_board(c);
    uint64_t address;
    uint64_t left;
    uint64_t count;

    if (b != NULL &&
        read_place(b, c->word[2], SYMBOL_RAM, b->avr->ramend, &address, &left) &&
        read_length(c, 3, left, b->avr->ramend + 1U - address, &count)) {
        refresh_count(b->avr);
        control_answer_hex("mem", &b->avr->data[address], (size_t)count);
        control_answer("%s", "");
    }
}

static void do_poke(struct control *c)
{
    struct board *b = control_board(c);
    uint64_t address;
    uint64_t left;
    size_t count;

    if (b != NULL &&
        read_place(b, c->word[2], SYMBOL_RAM, b->avr->ramend, &address, &left) &&
        control_bytes(c, c->word[3], &count) &&
        check_fits(address, count, b->avr->ramend + 1U, "RAM")) {
        memcpy(&b->avr->data[address], c->bytes, count);
        control_answer("ok");
    }
}

static void do_symbol(struct control *c)
{
    const struct board *b = control_board(c);
    const struct symbol *symbol = (b != NULL) ? find_symbol(b, c->word[2]) : NULL;

    if (symbol != NULL) {
        control_answer("symbol %s 0x%" PRIx32 " %" PRIu32,
                       symbol_space_name(symbol->space),
                       symbol->address,
                       symbol->size);
    }
}

static void read_eeprom(struct control *c, struct board *b)
{
    uint64_t address;
    uint64_t left;
    uint64_t count;

    if (read_place(b, c->word[3], SYMBOL_EEPROM, b->eeprom.size - 1U, &address, &left) &&
        read_length(c, 4, left, b->eeprom.size - address, &count)) {
        control_answer_hex("mem", &b->eeprom.bytes[address], (size_t)count);
        control_answer("%s", "");
    }
}

static void write_eeprom(struct control *c, struct board *b)
{
    uint64_t address;
    uint64_t left;
    size_t count;

    if (c->words < 5) {
        control_answer("error eeprom write: expected ADDRESS HEX");
    } else if (read_place(
                   b, c->word[3], SYMBOL_EEPROM, b->eeprom.size - 1U, &address, &left) &&
               control_bytes(c, c->word[4], &count) &&
               check_fits(address, count, b->eeprom.size, "EEPROM")) {
        memcpy(&b->eeprom.bytes[address], c->bytes, count);
        control_answer("ok");
    }
}

static void answer_eeprom(const struct board *b)
{
    const struct eeprom *e = &b->eeprom;
    uint64_t cycle = b->avr->cycle;

    (void)printf("eeprom %" PRIu64, e->writes);
    if (e->busy && e->due > cycle) {
        control_answer(" %u %" PRIu64,
                       (unsigned)e->address,
                       own_time_to_bench(&b->time, e->due - cycle));
    } else {
        control_answer(" - 0");
    }
}

static void do_eeprom(struct control *c)
{
    struct board *b = control_board(c);

    if (b == NULL) {
        return;
    }
    if (strcmp(c->word[2], "state") == 0) {
        answer_eeprom(b);
    } else if (strcmp(c->word[2], "read") == 0 && c->words > 3) {
        read_eeprom(c, b);
    } else if (strcmp(c->word[2], "write") == 0 && c->words > 3) {
        write_eeprom(c, b);
    } else {
        control_answer(
            "error eeprom '%s': read ADDRESS LENGTH, write ADDRESS HEX or state",
            c->word[2]);
    }
}

// ---- pins ----

static void schedule_event(struct board *b, const struct scheduled_event *event)
{
    if (schedule_add(&b->schedule, event)) {
        control_answer("ok");
    } else {
        control_answer("error more than %d events are scheduled", SCHEDULE_EVENTS);
    }
}

static void do_pin(struct control *c)
{
    struct board *b = control_board(c);
    struct scheduled_event event = {.request = SUPPLY_REQUEST_NONE};
    uint64_t bit;
    uint64_t level;
    bool later;

    if (b == NULL || !control_number(c->word[3], 7, &bit) ||
        !control_number(c->word[4], 1, &level) ||
        !control_at(c, 5, &later, &event.cycle)) {
        return;
    }
    if (strlen(c->word[2]) != 1 || c->word[2][0] < 'A' || c->word[2][0] > 'L') {
        control_answer("error '%s' is not a port from A to L", c->word[2]);
        return;
    }
    event.port = c->word[2][0];
    event.bit = (uint8_t)bit;
    event.level = level != 0;
    if (later) {
        schedule_event(b, &event);
    } else {
        inputs_drive(&b->inputs,
                     event.port,
                     event.bit,
                     event.level,
                     own_time_from_bench(&b->time, event.cycle));
        control_answer("ok");
    }
}

static void do_permit(struct control *c)
{
    const struct board *b = control_board(c);

    if (b != NULL) {
        const struct outputs_permit *permit = &b->outputs.permit;

        control_answer("permit %d %" PRIu64 " %" PRIu64 " %" PRIu64,
                       permit->level ? 1 : 0,
                       permit->changes,
                       permit->cycle,
                       permit->rise);
    }
}

// ---- supply and resets ----

// Performs the request now, or at the cycle that the words from `first` on name.
static void request_supply(struct control *c,
                           struct board *b,
                           enum supply_request request,
                           int first)
{
    struct scheduled_event event = {.request = request};
    bool later;

    if (!control_at(c, first, &later, &event.cycle)) {
        return;
    }
    if (later) {
        schedule_event(b, &event);
    } else if (!supply_has_effect(&b->supply, request)) {
        control_answer("error %s: the board %s power",
                       c->word[0],
                       b->supply.powered ? "already has" : "has no");
    } else {
        supply_do(&b->supply, request);
        control_answer("ok %" PRIu64, board_bench_cycle(b));
    }
}

static void do_power(struct control *c)
{
    struct board *b = control_board(c);
    bool on = strcmp(c->word[2], "on") == 0;

    if (b == NULL) {
        return;
    }
    if (!on && strcmp(c->word[2], "off") != 0) {
        control_answer("error power '%s': on or off", c->word[2]);
        return;
    }
    request_supply(c, b, on ? SUPPLY_REQUEST_ON : SUPPLY_REQUEST_OFF, 3);
}

static void do_cycle(struct control *c)
{
    struct board *b = control_board(c);

    if (b != NULL) {
        request_supply(c, b, SUPPLY_REQUEST_CYCLE, 2);
    }
}

static void do_reset(struct control *c)
{
    struct board *b = control_board(c);
    bool brown_out = strcmp(c->word[2], "brownout") == 0;

    if (b == NULL) {
        return;
    }
    if (!brown_out && strcmp(c->word[2], "external") != 0) {
        control_answer("error reset '%s': external or brownout", c->word[2]);
        return;
    }
    request_supply(
        c, b, brown_out ? SUPPLY_REQUEST_BROWN_OUT : SUPPLY_REQUEST_EXTERNAL, 3);
}

// ---- faults ----

#define MOST_STALL_CYCLES 100000U

static bool make_axis_hang(struct board *b, const char *word)
{
    uint64_t axis;

    if (!control_number(word, (uint64_t)b->kind->axes - 1, &axis)) {
        return false;
    }
    if (!board_hang_axis(b, (unsigned)axis)) {
        control_answer("error hang: at most %d patches", HANG_PATCHES);
        return false;
    }
    return true;
}

static bool make_hang_at(struct board *b, char *word)
{
    uint64_t address;
    uint64_t left;

    if (!read_place(b, word, SYMBOL_FLASH, b->avr->flashend, &address, &left)) {
        return false;
    }
    if (!hang_at(&b->hang, b->avr, &b->program, (uint32_t)address)) {
        control_answer("error hang: no instruction can be patched at 0x%" PRIx64,
                       address);
        return false;
    }
    return true;
}

static bool make_stall(struct board *b, const char *word)
{
    uint64_t cycles;

    if (!control_number(word, MOST_STALL_CYCLES, &cycles)) {
        return false;
    }
    board_stall(b, cycles);
    return true;
}

// The fault that the third and fourth word name. False after an error's answer.
static bool make_fault(struct control *c, struct board *b)
{
    const char *what = c->word[2];

    if (strcmp(what, "main") == 0) {
        board_hang_main(b);
    } else if (strcmp(what, "interrupts") == 0) {
        board_hang_interrupts(b);
    } else if (strcmp(what, "off") == 0) {
        board_end_hang(b);
    } else if (strcmp(what, "axis") == 0 && c->words > 3) {
        return make_axis_hang(b, c->word[3]);
    } else if (strcmp(what, "at") == 0 && c->words > 3) {
        return make_hang_at(b, c->word[3]);
    } else if (strcmp(what, "for") == 0 && c->words > 3) {
        return make_stall(b, c->word[3]);
    } else {
        control_answer("error hang '%s': main, interrupts, for CYCLES, axis N, at "
                       "ADDRESS|SYMBOL or off",
                       what);
        return false;
    }
    return true;
}

static void do_hang(struct control *c)
{
    struct board *b = control_board(c);
    bool kept = c->words > 3 && strcmp(c->word[c->words - 1], "kept") == 0;

    if (b == NULL) {
        return;
    }
    if (!b->supply.powered) {
        control_answer("error hang: the board has no power");
        return;
    }
    c->words -= kept ? 1 : 0;
    if (make_fault(c, b)) {
        b->hang.kept = b->hang.kept || kept;
        control_answer("ok %" PRIu64, board_bench_cycle(b));
    }
}

const struct command control_board_commands[] = {
    {"peek", 3, 4, do_peek},
    {"poke", 4, 4, do_poke},
    {"symbol", 3, 3, do_symbol},
    {"eeprom", 3, 5, do_eeprom},
    {"pin", 5, 7, do_pin},
    {"permit", 2, 2, do_permit},
    {"power", 3, 5, do_power},
    {"cycle", 2, 4, do_cycle},
    {"reset", 3, 5, do_reset},
    {"hang", 3, 5, do_hang},
    {NULL, 0, 0, NULL},
};
