// SPDX-License-Identifier: MIT

#include "bus.h"

#include <string.h>

#define RECENT 1024 // frames looked back at for a collision: more than a master may queue

void bus_init(struct bus *bus)
{
    memset(bus, 0, sizeof *bus);
    bus_set_master(bus, BUS_BAUD, BUS_PARITY_EVEN);
    bus->master_strict = false;
}

void bus_connect(struct bus *bus, const struct bus_listener *listener)
{
    bus->listener[bus->boards++] = *listener;
}

void bus_set_master(struct bus *bus, uint32_t baud, enum bus_parity parity)
{
    static const uint8_t formats[] = {
        [BUS_PARITY_NONE] = 0x06, [BUS_PARITY_ODD] = 0x36, [BUS_PARITY_EVEN] = 0x26};

    bus->master_baud = baud;
    bus->master_format = formats[parity];
    bus->master_rest = 0;
    bus->master_strict = true;
}

static uint32_t bit_cycles_x1000(const struct bus *bus)
{
    return (uint32_t)((uint64_t)cpu_clock_hz() * 1000 / bus->master_baud);
}

// The stop bit is the idle level: a start bit over it still comes through.
static uint64_t busy_until(const struct bus_frame *frame)
{
    return frame->end - frame->bit_cycles_x1000 / 1000;
}

static void collide(struct bus *bus, struct bus_frame *frame)
{
    if (frame->start >= bus->all_quiet) {
        return;
    }
    for (unsigned back = 1; back <= RECENT && back <= bus->next_frame; back++) {
        struct bus_frame *other = &bus->frame[(bus->next_frame - back) % BUS_FRAMES];

        if (other->sender != frame->sender && busy_until(other) > frame->start &&
            busy_until(frame) > other->start) {
            other->corrupted = frame->corrupted = true;
            bus->corrupted_frames++;
        }
    }
}

struct bus_frame *bus_start(struct bus *bus, const struct bus_frame *frame)
{
    struct bus_frame *kept = &bus->frame[bus->next_frame % BUS_FRAMES];

    *kept = *frame;
    collide(bus, kept);
    if (busy_until(kept) > bus->all_quiet) {
        bus->all_quiet = busy_until(kept);
    }
    bus->next_frame++;
    if (bus->log != NULL && frame->sender != 0) {
        wire_log_frame(bus->log, kept);
    }
    for (int i = 0; i < bus->boards; i++) {
        if (i != frame->sender) {
            bus->listener[i].receive(bus->listener[i].receiver, kept);
        }
    }
    return kept;
}

uint64_t bus_master_send(struct bus *bus,
                         const uint8_t *bytes,
                         size_t count,
                         uint64_t cycle)
{
    if (bus->master_ready < cycle) {
        bus->master_ready = cycle;
        bus->master_rest = 0;
    }
    for (size_t i = 0; i < count; i++) {
        // Exact bit times on average: the remainder of the division goes into the next frame.
        uint64_t length = (uint64_t)cpu_clock_hz() * BUS_BITS + bus->master_rest;
        struct bus_frame frame = {
            .start = bus->master_ready,
            .end = bus->master_ready + length / bus->master_baud,
            .bit_cycles_x1000 = bit_cycles_x1000(bus),
            .sender = BUS_MASTER,
            .data = bytes[i],
            .format = bus->master_format,
        };

        (void)bus_start(bus, &frame);
        bus->master_ready = frame.end;
        bus->master_rest = (uint32_t)(length % bus->master_baud);
    }
    return bus->master_ready;
}

void bus_master_pause(struct bus *bus, uint64_t cycles)
{
    bus->master_ready += cycles;
}

static bool is_master_format(const struct bus *bus, const struct bus_frame *frame)
{
    uint32_t mine = bit_cycles_x1000(bus);

    return frame->format == bus->master_format &&
           bus_speeds_fit(mine, frame->bit_cycles_x1000, mine);
}

static bool is_received_well(const struct bus *bus, const struct bus_frame *frame)
{
    return !frame->corrupted && (!bus->master_strict || is_master_format(bus, frame));
}

int bus_master_receive(struct bus *bus, uint64_t cycle, uint64_t *end)
{
    while (bus->next_unread != bus->next_frame) {
        const struct bus_frame *frame = &bus->frame[bus->next_unread % BUS_FRAMES];

        if (frame->sender == BUS_MASTER) {
            bus->next_unread++;
        } else if (frame->end > cycle) {
            return -1;
        } else {
            bus->next_unread++;
            *end = frame->end;
            return is_received_well(bus, frame) ? frame->data : (uint8_t)~frame->data;
        }
    }
    return -1;
}

bool bus_busy(const struct bus *bus, uint64_t cycle)
{
    for (unsigned i = bus->next_unread; i != bus->next_frame; i++) {
        const struct bus_frame *frame = &bus->frame[i % BUS_FRAMES];

        if (frame->sender != BUS_MASTER && frame->end > cycle) {
            return true;
        }
    }
    return false;
}
