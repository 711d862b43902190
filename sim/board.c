// SPDX-License-Identifier: MIT
//
// Putting a board together: the part, our models in it, the image; and how the models reach each
// other.

#include "board.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <sim_elf.h>

#include "access.h"
#include "cpu_clock.h"

#define GPIOR2       0x4BU // data address, the same on all parts
#define NOISE_EEPROM 0U
#define NOISE_RAM    1U
#define NOISE_PLACES 2U

__attribute__((format(printf, 2, 3))) static void set_error(struct board *b,
                                                            const char *format,
                                                            ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vsnprintf(b->error, sizeof b->error, format, arguments);
    va_end(arguments);
}

void board_refuse(struct board *b, const char *text)
{
    if (b->error[0] == '\0') {
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

// ---- what the parts report ----

static void on_refused(void *board, const char *text)
{
    board_refuse(board, text);
}

static void on_flag(void *board, uint8_t vector, uint64_t cycle)
{
    struct board *b = board;

    irq_stats_flag(&b->stats, vector, cycle);
}

static void on_byte(void *board, bool sent, uint8_t byte, uint64_t cycle)
{
    const struct board *b = board;

    if (b->serial_log != NULL) {
        serial_log_add(b->serial_log, sent, byte, cycle);
    }
}

static bool may_send(void *board)
{
    const struct board *b = board;

    return outputs_may_send(&b->outputs);
}

static void on_port_written(void *board, unsigned port, uint64_t cycle)
{
    struct board *b = board;

    outputs_follow_port(&b->outputs, port, cycle);
    inputs_follow_port(&b->inputs, port, cycle);
}

static void on_compare_output(void *board,
                              struct timer16 *timer,
                              int channel,
                              uint64_t cycle)
{
    struct board *b = board;

    outputs_follow_compare(&b->outputs, timer, channel, cycle);
}

static void on_timer0_output(void *board, uint64_t cycle)
{
    struct board *b = board;

    outputs_follow_timer0(&b->outputs, cycle);
}

static void drive_by_wire(const struct board *from,
                          struct board *to,
                          const struct board_pin *pin,
                          bool level,
                          uint64_t cycle)
{
    const struct scheduled_event event = {
        .cycle = own_time_to_bench(&from->time, cycle),
        .port = pin->port,
        .bit = pin->bit,
        .level = level,
    };

    if (!schedule_add(&to->schedule, &event)) {
        board_refuse(to, "clock wire too fast for the simulator");
    }
}

static void on_clock_out(void *board, bool level, uint64_t cycle)
{
    struct board *b = board;

    for (int i = 0; i < b->clock_wires; i++) {
        struct board *to = b->clock_wire[i];

        if (to == b) {
            pixel_input_drive(&b->pixel_input, level, cycle);
            continue;
        }
        drive_by_wire(b, to, to->pixel_input.pin, level, cycle);
        if (to->pixel_input.copy != NULL) {
            drive_by_wire(b, to, to->pixel_input.copy, level, cycle);
        }
    }
}

void board_wire_clock(struct board *from, struct board *to)
{
    from->clock_wire[from->clock_wires++] = to;
    to->clock_is_wired = true;
}

static void on_comparator_changed(void *board, uint64_t cycle)
{
    struct board *b = board;

    inputs_follow_comparator(&b->inputs, cycle);
}

static void on_watchdog_reset(void *board)
{
    struct board *b = board;

    supply_ask(&b->supply, SUPPLY_REQUEST_WATCHDOG);
}

static void on_interrupt_served(void *board)
{
    struct board *b = board;

    uart_follow_levels(&b->uart);
    eeprom_served(&b->eeprom);
}

// ---- what the board executes, resets and the supply ----

static void choose_run_state(struct board *b)
{
    enum run_state state = b->hang.main ? RUN_MAIN_HUNG : RUN_PROGRAM;

    if (b->hang.all) {
        state = RUN_ALL_HUNG;
    }
    if (!b->supply.powered) {
        state = RUN_UNPOWERED;
    }
    if (b->supply.request != SUPPLY_REQUEST_NONE) {
        state = RUN_REQUESTED;
    }
    b->run_loop.state = state;
}

static void on_power_failed(void *board)
{
    struct board *b = board;

    eeprom_power_cut(&b->eeprom, b->avr->cycle);
}

static void restart_part(void *board, bool cold)
{
    struct board *b = board;
    uint64_t cycle = b->avr->cycle;

    hang_end(&b->hang, b->avr, &b->program, cold);
    irq_stats_section(&b->stats, cycle);
    avr_reset(b->avr);
    b->avr->cycle = cycle; // simavr may set it back; the boards' common time goes on
    b->avr->state = cpu_Running;
    choose_run_state(b);
}

static void on_requested(void *board)
{
    struct board *b = board;

    run_loop_request(&b->run_loop);
}

static void fulfil_request(void *board)
{
    struct board *b = board;

    supply_fulfil(&b->supply);
    choose_run_state(b);
}

static struct board *board_of(avr_io_t *module)
{
    return (struct board *)((char *)module - offsetof(struct board, module));
}

// The models' part of a reset. Runs after simavr's own modules, at every reset of the part.
static void reset_models(avr_io_t *io)
{
    struct board *b = board_of(io);

    supply_reset(&b->supply);
    uart_reset(&b->uart); // before its driver is let go: a frame on its way is cut
    timers_reset(&b->timers);
    timer0_reset(&b->timer0);
    comparator_reset(&b->comparator);
    eeprom_reset(&b->eeprom);
    watchdog_reset(&b->watchdog);
    irq_stats_reset(&b->stats);
    ports_reset(&b->ports);
    extint_reset(&b->extint); // looks at the pins as they are now
    b->avr->data[GPIOR2] = b->strap;
    // The reset has emptied simavr's list of events.
    run_loop_schedule(&b->run_loop);
    pixel_input_schedule(&b->pixel_input);
    mechanics_schedule(&b->mechanics);
    schedule_restart(&b->schedule);
}

// The WDR instruction asks every module of simavr's part whether it is meant; -1: it is not.
static int on_ioctl(avr_io_t *io, uint32_t request, void *param)
{
    struct board *b = board_of(io);

    (void)param;
    if (request != AVR_IOCTL_WATCHDOG_RESET) {
        return -1;
    }
    watchdog_restart(&b->watchdog);
    return 0;
}

// simavr puts new modules at the head of its list, and resets from there: ours must come last.
static void append_module(struct board *b)
{
    avr_io_t **tail = &b->avr->io_port;

    while (*tail != NULL) {
        tail = &(*tail)->next;
    }
    b->module = (avr_io_t){
        .kind = "pixstep", .avr = b->avr, .reset = reset_models, .ioctl = on_ioctl};
    *tail = &b->module;
}

void board_seed(struct board *b, uint64_t seed)
{
    unsigned place = NOISE_PLACES * (unsigned)b->index;

    noise_seed(&b->eeprom.noise, seed, place + NOISE_EEPROM);
    noise_seed(&b->supply.noise, seed, place + NOISE_RAM);
}

// ---- putting it together ----

static void make_wiring(struct board *b)
{
    struct peripheral_host host = {.board = b, .flag = on_flag, .refuse = on_refused};

    b->wiring = (struct board_wiring){
        .host = host,
        .ports = {.board = b, .written = on_port_written},
        .timers = {.host = host, .output = on_compare_output},
        .timer0 = {.host = host, .output = on_timer0_output},
        .outputs = {.board = b, .clock_out = on_clock_out},
        .comparator = {.host = host, .changed = on_comparator_changed},
        .uart = {.host = host, .may_send = may_send, .byte = on_byte},
        .watchdog = {.host = host, .reset = on_watchdog_reset},
        .supply = {.board = b,
                   .power_failed = on_power_failed,
                   .restart = restart_part,
                   .requested = on_requested},
        .run_loop = {.board = b,
                     .served = on_interrupt_served,
                     .requested = fulfil_request},
    };
}

static void connect_pins(struct board *b, const struct board_logs *logs)
{
    switches_init(&b->switches, b->kind, b->index, &b->time);
    b->switches.log = logs->switches;
    b->inputs = (struct inputs){
        .ports = &b->ports,
        .timers = &b->timers,
        .comparator = &b->comparator,
        .extint = &b->extint,
        .switches = &b->switches,
        .wire_log = logs->wire,
    };
    b->outputs = (struct outputs){
        .hooks = &b->wiring.outputs,
        .board = b->index,
        .time = &b->time,
        .kind = b->kind,
        .ports = &b->ports,
        .timers = &b->timers,
        .timer0 = &b->timer0,
        .mechanics = &b->mechanics,
        .uart = &b->uart,
        .edges = logs->edges,
    };
}

static void attach_models(struct board *b)
{
    avr_t *avr = b->avr;
    const struct board_wiring *w = &b->wiring;

    irq_stats_attach(&b->stats, avr);
    timers_attach(&b->timers, avr, &w->timers);
    timer0_attach(&b->timer0, avr, &w->timer0);
    comparator_attach(&b->comparator, avr, &b->ports, &w->comparator);
    uart_attach(&b->uart, avr, b->bus, b->index, &b->time, &w->uart);
    eeprom_attach(&b->eeprom, avr, &w->host);
    watchdog_attach(&b->watchdog, avr, &w->watchdog);
    extint_attach(&b->extint, avr, &w->host, &b->ports);
    supply_attach(&b->supply, avr, &b->stack, &w->supply);
    ports_attach(&b->ports, avr, &w->ports);
}

static void attach_outside(struct board *b)
{
    pixel_input_attach(&b->pixel_input, b->avr, b->kind, &b->inputs);
    mechanics_attach(&b->mechanics, b->avr, &b->wiring.host, &b->inputs, &b->switches);
    schedule_attach(&b->schedule, b->avr, &b->time, &b->inputs, &b->supply);
    run_loop_attach(&b->run_loop,
                    b->avr,
                    &b->stats,
                    &(struct run_loop_image){&b->program, &b->skips},
                    &b->wiring.run_loop);
}

// Our models take over between the part's init and its first reset, in which simavr's timers would
// connect themselves to their pins.
static void init_with_models(avr_t *avr)
{
    struct board *b = avr->custom.data;

    b->init_part(avr);
    attach_models(b);
    attach_outside(b);
    append_module(b);
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

static bool know_instructions(struct board *b)
{
    return skips_find(&b->skips, b->avr) && plain_decode(&b->program, b->avr);
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
        loaded = know_instructions(b);
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
    b->init_part = b->avr->init;
    b->avr->init = init_with_models;
    b->avr->custom.data = b;
    if (avr_init(b->avr) != 0) {
        set_error(b, "libsimavr could not start the %s", b->kind->mcu);
        return false;
    }
    b->avr->frequency = b->kind->cpu_hz;
    b->avr->log = LOG_ERROR;
    return true;
}

bool board_open(struct board *b,
                int index,
                const char *kind_name,
                const char *image_path,
                double oscillator_ppm,
                struct bus *bus,
                const struct board_logs *logs)
{
    memset(b, 0, sizeof *b);
    b->index = index;
    b->bus = bus;
    b->serial_log = logs->serial;
    b->mechanics.log = logs->plant;
    b->strap = (uint8_t)((index == 0) ? 0 : index + 1);
    b->kind = board_kind_by_name(kind_name);
    if (b->kind == NULL) {
        set_error(b, "unknown board '%s': one of %s", kind_name, board_kind_names());
        return false;
    }
    b->time = own_time_of(b->kind->cpu_hz, cpu_clock_hz(), oscillator_ppm);
    make_wiring(b);
    connect_pins(b, logs);
    avr_global_logger_set(log_errors_only);
    if (!make_part(b) || !load_image(b, image_path)) {
        return false;
    }
    b->avr->frequency = b->kind->cpu_hz;
    stack_paint(&b->stack, b->avr);
    bus_connect(bus,
                &(struct bus_listener){.receiver = &b->uart, .receive = uart_receive});
    return true;
}

// ---- from outside ----

uint64_t board_bench_cycle(const struct board *b)
{
    return own_time_to_bench(&b->time, b->avr->cycle);
}

bool board_run(struct board *b, uint64_t cycle)
{
    bool going_on = run_loop_run(&b->run_loop, own_time_from_bench(&b->time, cycle));

    if (b->avr->state == cpu_Crashed && b->error[0] == '\0') {
        board_refuse(b, "the program crashed (invalid instruction or address)");
    }
    return going_on;
}

bool board_is_done(const struct board *b)
{
    return b->avr->state == cpu_Done;
}

void board_hang_main(struct board *b)
{
    b->hang.main = true;
    choose_run_state(b);
}

void board_hang_interrupts(struct board *b)
{
    b->hang.all = true;
    choose_run_state(b);
}

void board_stall(struct board *b, uint64_t cycles)
{
    run_loop_stall(&b->run_loop, cycles);
}

bool board_hang_axis(struct board *b, unsigned axis)
{
    const struct timer16 *timer = outputs_axis_timer(&b->outputs, axis);

    return hang_vector(&b->hang, b->avr, &b->program, timer->part->overflow.vector);
}

void board_end_hang(struct board *b)
{
    hang_end(&b->hang, b->avr, &b->program, true);
    choose_run_state(b);
}

void board_close(struct board *b)
{
    if (b->avr != NULL) {
        // simavr frees its modules through this list; ours is not from its heap and has no dealloc.
        avr_terminate(b->avr);
        b->avr = NULL;
        symbols_free(&b->symbols);
        skips_free(&b->skips);
        plain_free(&b->program);
    }
}
