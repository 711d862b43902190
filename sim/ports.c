// SPDX-License-Identifier: MIT

#include "ports.h"

#include <stddef.h>

#include <avr_ioport.h>

#include "access.h"
#include "peripheral.h"

// From a level at the pin to PINx: 0.5 to 1.5 cycles on the part. An instruction that begins in the
// very cycle of the change still reads the level before.
#define SYNCHRONIZER_CYCLES 1

static unsigned index_of(char port)
{
    return (unsigned)(port - 'A');
}

static avr_irq_t *pin_irq(const struct ports *p, char port, unsigned bit)
{
    return avr_io_getirq(p->avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port), (int)bit);
}

bool ports_has(const struct ports *p, char port, unsigned bit)
{
    return index_of(port) < PORTS_COUNT && pin_irq(p, port, bit) != NULL;
}

bool ports_is_output(const struct ports *p, char port, unsigned bit)
{
    return ((unsigned)p->pins[index_of(port)].ddr >> bit & 1U) != 0;
}

bool ports_is_high_output(const struct ports *p, char port, unsigned bit)
{
    unsigned index = index_of(port);

    return ((p->pins[index].port & p->pins[index].ddr) >> bit & 1U) != 0;
}

bool ports_level(const struct ports *p, char port, unsigned bit)
{
    unsigned index = index_of(port);
    uint8_t mask = (uint8_t)(1U << bit);

    if ((p->pins[index].ddr & mask) == 0 && (p->pins[index].driven_mask & mask) != 0) {
        return (p->pins[index].driven_level & mask) != 0;
    }
    return (p->pins[index].port & mask) != 0;
}

bool ports_is_driven(const struct ports *p, char port, unsigned bit, bool level)
{
    unsigned index = index_of(port);
    bool driven = (p->pins[index].driven_mask >> bit & 1U) != 0;
    bool before = (p->pins[index].driven_level >> bit & 1U) != 0;

    return driven && before == level;
}

// PINx takes the levels over.
static void take_levels(struct ports *p)
{
    for (unsigned index = 0; index < PORTS_COUNT; index++) {
        char port = (char)('A' + index);
        unsigned arriving = p->pins[index].arriving;
        unsigned level = p->pins[index].driven_level;

        for (unsigned bit = 0; arriving >> bit != 0; bit++) {
            if ((arriving >> bit & 1U) != 0) {
                avr_raise_irq(pin_irq(p, port, bit), level >> bit & 1U);
            }
        }
        p->pins[index].arriving = 0;
    }
}

static avr_cycle_count_t on_synchronized(struct avr_t *avr,
                                         avr_cycle_count_t when,
                                         void *param)
{
    (void)avr;
    (void)when;
    take_levels(param);
    return 0;
}

void ports_drive(struct ports *p, char port, unsigned bit, bool level, uint64_t cycle)
{
    unsigned index = index_of(port);
    uint8_t mask = (uint8_t)(1U << bit);
    avr_ioport_external_t external = {.name = (unsigned char)port & 0x7FU};

    p->pins[index].driven_mask |= mask;
    p->pins[index].driven_level =
        (uint8_t)((p->pins[index].driven_level & ~mask) | (level ? mask : 0));
    // Without this, simavr forgets the level at the program's next write to the port.
    external.mask = p->pins[index].driven_mask;
    external.value = p->pins[index].driven_level;
    (void)avr_ioctl(p->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL((uint32_t)port), &external);
    p->pins[index].arriving |= mask;
    if (p->avr->cycle > cycle) {
        take_levels(p);
    } else {
        avr_cycle_timer_register(p->avr, SYNCHRONIZER_CYCLES, on_synchronized, p);
    }
}

static void on_port_written(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct ports *p = param;

    p->pins[irq->irq].port = (uint8_t)value;
    p->hooks->written(p->hooks->board, irq->irq, access_cycle(p->avr) + 1);
}

static void on_ddr_written(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct ports *p = param;

    p->pins[irq->irq].ddr = (uint8_t)value;
    p->hooks->written(p->hooks->board, irq->irq, access_cycle(p->avr) + 1);
}

static avr_ioport_t *find_port(const struct ports *p, char name)
{
    avr_io_t *io = peripheral_next(p->avr->io_port, "port");

    while (io != NULL && ((avr_ioport_t *)(void *)io)->name != name) {
        io = peripheral_next(io->next, "port");
    }
    return (avr_ioport_t *)(void *)io;
}

// Resets what libsimavr remembers of a port, so that it reports the next change.
static void forget_outputs(const struct ports *p, avr_ioport_t *port)
{
    port->io.irq[IOPORT_IRQ_DIRECTION_ALL].value = 0;
    port->io.irq[IOPORT_IRQ_REG_PORT].value = 0;
    p->avr->data[port->r_pin] = 0;
    for (unsigned bit = 0; bit < 8; bit++) {
        bool level = ports_level(p, port->name, bit);

        port->io.irq[bit].value = level ? 1 : 0;
        p->avr->data[port->r_pin] |= (uint8_t)((level ? 1U : 0U) << bit);
    }
}

void ports_reset(struct ports *p)
{
    for (unsigned index = 0; index < PORTS_COUNT; index++) {
        avr_ioport_t *port = find_port(p, (char)('A' + index));

        p->pins[index].port = p->pins[index].ddr = 0;
        if (port != NULL) {
            forget_outputs(p, port);
            p->hooks->written(p->hooks->board, index, p->avr->cycle);
        }
    }
}

void ports_attach(struct ports *p, avr_t *avr, const struct ports_hooks *hooks)
{
    p->avr = avr;
    p->hooks = hooks;
    for (unsigned index = 0; index < PORTS_COUNT; index++) {
        uint32_t port = AVR_IOCTL_IOPORT_GETIRQ((uint32_t)'A' + index);
        avr_irq_t *port_irq = avr_io_getirq(avr, port, IOPORT_IRQ_REG_PORT);
        avr_irq_t *ddr_irq = avr_io_getirq(avr, port, IOPORT_IRQ_DIRECTION_ALL);

        if (port_irq != NULL && ddr_irq != NULL) {
            port_irq->irq = ddr_irq->irq = index; // how the callback knows its port
            avr_irq_register_notify(port_irq, on_port_written, p);
            avr_irq_register_notify(ddr_irq, on_ddr_written, p);
        }
    }
}
