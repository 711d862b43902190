// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// Putting a board together: the part, our models in it, the image.

#include "board.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <sim_elf.h>

#include "access.h"
#include "board_run.h" // board_slice

#define GTCCR      0x43U // data addresses, the same on both parts
#define GTCCR_TSM  0x80U
#define GTCCR_SYNC 0x01U // PSRSYNC: the prescaler of timers 0, 1, 3, 4, 5
#define GPIOR1     0x4AU
#define GTCCR_MASK 0x83U

__attribute__((format(printf, 2, 3))) static void set_error(struct board *b,
                                                            const char *format,
                                                            ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vsnprintf(b->error, sizeof b->error, format, arguments);
    va_end(arguments);
}

void board_refuse(void *board, const char *text)
{
    struct board *b = board;

    if (b->error[0] == '\0') { // the first cause counts
        set_error(b,
                  "board %d (%s): %s, at cycle %llu, program address 0x%lx",
                  b->index,
                  b->kind->name,
                  text,
                  (unsigned long long)b->avr->cycle,
                  (unsigned long)b->avr->pc);
    }
    b->avr->state = cpu_Crashed;
}

static void on_flag(void *board, uint8_t vector, uint64_t cycle)
{
    struct board *b = board;

    irq_stats_flag(&b->stats, vector, cycle);
}

static void on_byte(void *board, bool sent, uint8_t byte, uint64_t cycle)
{
    struct board *b = board;

    if (b->serial_log != NULL) {
        serial_log_add(b->serial_log, sent, byte, cycle);
    }
}

// TSM keeps PSRSYNC as written and with it the timers halted; without TSM the bit clears itself.
static void write_gtccr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct board *b = param;
    bool tsm = (value & GTCCR_TSM) != 0;
    uint64_t cycle = access_cycle(avr) + 1;

    avr->data[address] = tsm ? (value & GTCCR_MASK) : 0;
    for (int i = 0; i < b->timers; i++) {
        timer16_hold(&b->timer[i], tsm && (value & GTCCR_SYNC) != 0, cycle);
    }
}

static void write_gpior1(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct board *b = param;

    avr->data[address] = value;
    irq_stats_section(&b->stats, value, access_cycle(avr) + 1);
    b->stats.section_entries[b->stats.section]++;
}

// The WDR instruction asks simavr's modules who feels meant.
static int on_watchdog_ioctl(avr_io_t *io, uint32_t request, void *param)
{
    struct board *b = io->avr->custom.data;

    (void)param;
    if (request != AVR_IOCTL_WATCHDOG_RESET) {
        return -1;
    }
    watchdog_restart(&b->watchdog);
    return 0;
}

static void attach_timers(struct board *b)
{
    b->timer_hooks = (struct timer16_hooks){.board = b,
                                            .output = board_compare_output,
                                            .flag = on_flag,
                                            .refuse = board_refuse};
    for (avr_io_t *io = b->avr->io_port; io != NULL; io = io->next) {
        avr_timer_t *part = (avr_timer_t *)(void *)io;

        if (strcmp(io->kind, "timer") == 0 && timer16_is_16_bit(part) &&
            b->timers < BOARD_TIMERS) {
            timer16_attach(&b->timer[b->timers], b->avr, part, &b->timer_hooks);
            board_find_icp(b, b->timers);
            b->timers++;
        }
    }
}

static void attach_safety(struct board *b)
{
    b->eeprom_hooks =
        (struct eeprom_hooks){.board = b, .flag = on_flag, .refuse = board_refuse};
    eeprom_attach(&b->eeprom, b->avr, &b->eeprom_hooks);
    b->watchdog_hooks = (struct watchdog_hooks){.board = b,
                                                .flag = on_flag,
                                                .reset = board_want_watchdog,
                                                .refuse = board_refuse};
    watchdog_attach(&b->watchdog, b->avr, &b->watchdog_hooks);
    b->watchdog.part->io.ioctl = on_watchdog_ioctl;
    b->extint_hooks = (struct extint_hooks){
        .board = b, .pin = board_pin_level, .flag = on_flag, .refuse = board_refuse};
    extint_attach(&b->extint, b->avr, &b->extint_hooks);
}

// The part's own init function, per kind of part; called first by ours.
static void (*part_init[LINE_BOARDS])(avr_t *avr);
static struct line *attach_line;

// Our models take over between the part's init and its first reset, in which simavr's timers would
// connect themselves to their pins.
static void init_with_models(avr_t *avr)
{
    struct board *b = avr->custom.data;

    part_init[b->index](avr);
    irq_stats_attach(&b->stats, avr);
    attach_timers(b);
    b->comparator_hooks = (struct comparator_hooks){.board = b,
                                                    .pin = board_pin_level,
                                                    .changed = board_follow_comparator,
                                                    .refuse = board_refuse};
    comparator_attach(&b->comparator, avr, &b->comparator_hooks);
    b->uart_hooks = (struct uart_hooks){.board = b,
                                        .refuse = board_refuse,
                                        .may_send = board_may_send,
                                        .flag = on_flag,
                                        .byte = on_byte};
    uart_attach(&b->uart, avr, attach_line, b->index, &b->uart_hooks);
    attach_safety(b);
    access_take(avr, GTCCR, NULL, write_gtccr, b);
    access_take(avr, GPIOR1, NULL, write_gpior1, b);
    board_watch_outputs(b);
    board_append_reset_hook(b);
}

__attribute__((format(printf, 3, 0))) static void log_errors_only(avr_t *avr,
                                                                  const int level,
                                                                  const char *format,
                                                                  va_list arguments)
{
    (void)avr;
    if (level == LOG_ERROR) {
        (void)fputs("simavr: ", stderr);
        (void)vfprintf(stderr, format, arguments);
    }
}

static bool load_image(struct board *b, const char *path)
{
    elf_firmware_t *image = calloc(1, sizeof *image);
    bool loaded = false;

    if (image == NULL) {
        set_error(b, "out of memory");
        return false;
    }
    if (access(path, R_OK) != 0) {
        set_error(b, "%s: no such image, or not readable", path);
    } else if (elf_read_firmware(path, image) != 0 || image->flashsize == 0) {
        set_error(b, "%s: not an AVR ELF image", path);
    } else if (image->flashbase + image->flashsize > b->avr->flashend + 1U) {
        set_error(b, "%s: too large for the %s", path, b->kind->mcu);
    } else {
        avr_load_firmware(b->avr, image);
        loaded = skips_find(&b->skips, b->avr);
        if (!loaded) {
            set_error(b, "out of memory");
        }
    }
    if (loaded && !(symbols_read(&b->symbols, path) &&
                    stack_find(&b->stack, &b->symbols, b->avr))) {
        set_error(b, "%s: no symbol _end: stripped, or not linked by avr-gcc", path);
        loaded = false;
    }
    free(image->flash);
    free(image);
    return loaded;
}

static bool make_part(struct board *b)
{
    b->avr = avr_make_mcu_by_name(b->kind->mcu);
    if (b->avr == NULL) {
        set_error(b, "this libsimavr does not know the %s", b->kind->mcu);
        return false;
    }
    part_init[b->index] = b->avr->init;
    b->avr->init = init_with_models;
    b->avr->custom.data = b;
    if (avr_init(b->avr) != 0) {
        set_error(b, "libsimavr could not start the %s", b->kind->mcu);
        return false;
    }
    b->avr->frequency = b->kind->cpu_hz;
    b->avr->log = LOG_ERROR;
    b->avr->run = board_slice;
    return true;
}

bool board_open(struct board *b,
                int index,
                const char *kind_name,
                const char *image_path,
                struct line *line,
                struct edges *edges)
{
    memset(b, 0, sizeof *b);
    b->index = index;
    b->edges = edges;
    b->strap = (uint8_t)((index == 0) ? 0 : index + 1);
    b->kind = board_kind_by_name(kind_name);
    if (b->kind == NULL) {
        set_error(b, "unknown board '%s': one of %s", kind_name, board_kind_names());
        return false;
    }
    board_find_switches(b);
    avr_global_logger_set(log_errors_only);
    attach_line = line;
    if (!make_part(b) || !load_image(b, image_path)) {
        return false;
    }
    b->avr->frequency = b->kind->cpu_hz;
    stack_paint(&b->stack, b->avr);
    line->uart[line->boards++] = &b->uart;
    return true;
}

void board_close(struct board *b)
{
    if (b->avr != NULL) {
        // simavr frees its modules through this list; ours is not from its heap and has no dealloc.
        avr_terminate(b->avr);
        b->avr = NULL;
        symbols_free(&b->symbols);
        skips_free(&b->skips);
    }
}
