// SPDX-License-Identifier: MIT

#include "eeprom.h"

#include <string.h>

#include "access.h"

// Bits of EECR.
#define EEPM  0x30U
#define EERIE EEPROM_EERIE
#define EEMPE 0x04U
#define EEPE  0x02U
#define EERE  0x01U

#define HALT_AFTER_EEPE 2U
#define HALT_AFTER_EERE 4U

enum { MODE_BOTH = 0, MODE_ERASE = 1, MODE_WRITE = 2, MODE_RESERVED = 3 };

static void refuse_busy(const struct eeprom *e, const char *what)
{
    peripheral_refuse(e->host,
                      "EEPROM: %s while byte 0x%03x is being written",
                      what,
                      (unsigned)e->address);
}

void eeprom_follow_level(struct eeprom *e, uint64_t cycle)
{
    bool wanted = (e->avr->data[e->part->r_eecr] & EERIE) != 0 && !e->busy;

    if (!wanted) {
        e->part->ready.pending = 0;
    } else if (!e->part->ready.pending) {
        peripheral_raise(e->host, e->avr, &e->part->ready, cycle);
    }
}

// ---- programming ----

static uint64_t write_cycles(const struct eeprom *e)
{
    return peripheral_cycles_of_us(
        e->avr, (e->mode == MODE_BOTH) ? EEPROM_BOTH_US : EEPROM_HALF_US);
}

static uint8_t written_value(const struct eeprom *e)
{
    switch (e->mode) {
    case MODE_ERASE:
        return EEPROM_ERASED;
    case MODE_WRITE:
        return e->bytes[e->address] & e->value;
    default:
        return e->value;
    }
}

static void finish_write(struct eeprom *e, uint64_t cycle)
{
    if (e->busy && e->due <= cycle) {
        e->busy = false;
        e->bytes[e->address] = written_value(e);
        eeprom_follow_level(e, e->due);
    }
}

static avr_cycle_count_t on_write_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)when;
    finish_write(param, avr->cycle);
    return 0;
}

static void schedule_end(struct eeprom *e)
{
    peripheral_schedule(e->avr, e->due, on_write_due, e);
}

static uint16_t address_of(const struct eeprom *e)
{
    return (uint16_t)(e->avr->data[e->part->r_eearl] | e->avr->data[e->part->r_eearh]
                                                           << 8);
}

// The byte that an interrupted write leaves. The cells change in this order: an erase raises bits,
// a write then lowers them.
static uint8_t partly_written(struct eeprom *e, uint64_t cycle)
{
    uint8_t random = noise_byte(&e->noise);
    uint8_t before = e->bytes[e->address];
    bool erasing = e->mode == MODE_ERASE ||
                   (e->mode == MODE_BOTH && cycle - e->started < write_cycles(e) / 2);

    if (erasing) {
        return before | random;
    }
    return (uint8_t)((e->mode == MODE_WRITE ? before : EEPROM_ERASED) &
                     (e->value | random));
}

void eeprom_power_cut(struct eeprom *e, uint64_t cycle)
{
    finish_write(e, cycle);
    if (e->busy) {
        bool anything = (noise_byte(&e->noise) & 1U) != 0;

        e->bytes[e->address] =
            anything ? noise_byte(&e->noise) : partly_written(e, cycle);
        e->busy = false;
        avr_cycle_timer_cancel(e->avr, on_write_due, e);
    }
}

// ---- the program's view ----

static void start_write(struct eeprom *e, uint64_t cycle)
{
    uint8_t mode = (uint8_t)((e->avr->data[e->part->r_eecr] & EEPM) >> 4);

    if (e->busy) {
        refuse_busy(e, "EEPE set");
        return;
    }
    if (mode == MODE_RESERVED) {
        peripheral_refuse(e->host, "EEPROM: EEPM1:0 = 3 is reserved");
        return;
    }
    e->busy = true;
    e->mode = mode;
    e->address = address_of(e);
    e->value = e->avr->data[e->part->r_eedr];
    e->started = cycle + 1;
    e->due = e->started + write_cycles(e);
    e->writes++;
    schedule_end(e);
    e->avr->cycle += HALT_AFTER_EEPE;
}

static void start_read(struct eeprom *e)
{
    if (e->busy) {
        refuse_busy(e, "EERE set");
        return;
    }
    e->avr->data[e->part->r_eedr] = e->bytes[address_of(e)];
    e->avr->cycle += HALT_AFTER_EERE;
}

static void start_access(struct eeprom *e, uint8_t bits, bool enabled, uint64_t cycle)
{
    if ((bits & EEPE) != 0 && (bits & EERE) != 0) {
        peripheral_refuse(e->host, "EEPROM: EEPE and EERE set at once");
    } else if ((bits & EEPE) != 0 && enabled) {
        start_write(e, cycle);
    } else if ((bits & EERE) != 0) {
        start_read(e);
    }
}

static void write_eecr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct eeprom *e = param;
    uint64_t cycle = access_cycle(avr);
    uint8_t touched = access_bits_written(avr);
    bool enabled = cycle <= e->enabled_until;

    finish_write(e, cycle);
    if ((touched & EEMPE) != 0) {
        e->enabled_until = ((value & EEMPE) != 0) ? cycle + EEPROM_ENABLE_TICKS : 0;
    }
    if (e->busy) {
        touched &= (uint8_t)~EEPM;
    }
    avr->data[address] =
        (uint8_t)((avr->data[address] & ~touched) | (value & touched)) & (EEPM | EERIE);
    start_access(e, value & access_bits_written(avr), enabled, cycle);
    eeprom_follow_level(e, cycle + 1);
}

// simavr stores the value returned in the register.
static uint8_t read_eecr(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct eeprom *e = param;
    uint64_t cycle = access_cycle(avr);

    finish_write(e, cycle);
    return (uint8_t)((avr->data[address] & (EEPM | EERIE)) |
                     (cycle <= e->enabled_until ? EEMPE : 0U) | (e->busy ? EEPE : 0U));
}

static void write_eear(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct eeprom *e = param;
    unsigned last = e->size - 1U;

    finish_write(e, access_cycle(avr));
    if (!e->busy) {
        avr->data[address] =
            (uint8_t)(value & ((address == e->part->r_eearh) ? last >> 8 : last));
    }
}

static void write_eedr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct eeprom *e = param;

    finish_write(e, access_cycle(avr));
    if (e->busy) {
        refuse_busy(e, "EEDR written");
    }
    avr->data[address] = value;
}

// ---- attaching and reset ----

void eeprom_reset(struct eeprom *e)
{
    e->enabled_until = 0;
    e->avr->data[e->part->r_eecr] = 0;
    if (e->busy) { // "unless the EEPROM is busy programming"
        e->avr->data[e->part->r_eecr] = (uint8_t)(e->mode << 4);
        schedule_end(e);
    }
}

void eeprom_attach(struct eeprom *e, avr_t *avr, const struct peripheral_host *host)
{
    avr_eeprom_t *part = peripheral_find(avr, "eeprom", "EEPROM");

    memset(e, 0, sizeof *e);
    e->avr = avr;
    e->part = part;
    e->host = host;
    e->size = (part->size < EEPROM_BYTES_MOST) ? part->size : EEPROM_BYTES_MOST;
    memset(e->bytes, (int)EEPROM_ERASED, sizeof e->bytes);
    access_take(avr, part->r_eecr, read_eecr, write_eecr, e);
    access_take(avr, part->r_eearl, NULL, write_eear, e);
    access_take(avr, part->r_eearh, NULL, write_eear, e);
    access_take(avr, part->r_eedr, NULL, write_eedr, e);
}
