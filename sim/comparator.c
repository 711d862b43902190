// SPDX-License-Identifier: MIT

#include "comparator.h"

#include <string.h>

#include "access.h"

// Data addresses, the same on all parts.
#define ACSR   0x50U
#define PRR    0x64U
#define ADCSRA 0x7AU
#define ADCSRB 0x7BU
#define ADMUX  0x7CU

#define ACD       0x80U // in ACSR
#define ACBG      0x40U
#define ACO       0x20U
#define ACI       0x10U
#define ACIE      0x08U
#define ACIC      0x04U
#define ACIS      0x03U
#define PRADC     0x01U // in PRR, PRR0
#define ADEN      0x80U // in ADCSRA
#define ACME      0x40U // in ADCSRB
#define MUX5      0x08U // in ADCSRB of the ATmega2560
#define MUX4_AND3 0x18U // in ADMUX: of the ADC only
#define MUX2_TO_0 0x07U

enum { ON_TOGGLE = 0, ON_RESERVED = 1, ON_FALL = 2, ON_RISE = 3 };

static const avr_io_addr_t shared[COMPARATOR_SHARED] = {PRR, ADCSRA, ADCSRB, ADMUX};

// By simavr's name of the part (without a P): ports of ADC7:0 and ADC15:8, and how many of the
// first have a digital pin.
static const struct analog_pins {
    const char *mcu;
    char port[2];
    uint8_t first_pins;
} parts[] = {
    {"atmega328", {'C', '\0'}, 6}, // ADC6 and ADC7 are analog only
    {"atmega2560", {'F', 'K'}, 8},
    {"atmega1284", {'A', '\0'}, 8},
};
static const struct analog_pins unknown = {"", {'\0', '\0'}, 0};

static const struct analog_pins *pins_of(const struct comparator *c)
{
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        if (strcmp(c->avr->mmcu, parts[i].mcu) == 0) {
            return &parts[i];
        }
    }
    return &unknown;
}

bool comparator_captures(const struct comparator *c)
{
    return (c->avr->data[ACSR] & ACIC) != 0;
}

// Sets port and bit to the negative input; returns why that is no pin with a digital input, or
// NULL.
static const char *find_pin(struct comparator *c)
{
    const struct analog_pins *pins = pins_of(c);
    unsigned upper = (c->avr->data[ADCSRB] & MUX5) != 0 ? 1 : 0;
    unsigned bit = c->avr->data[ADMUX] & MUX2_TO_0;

    if (pins->port[0] == '\0') {
        return "which pins this part's ADC has is not known";
    }
    if (upper != 0 && pins->port[1] == '\0') {
        return "MUX5 is not on this part";
    }
    if (upper == 0 && bit >= pins->first_pins) {
        return "ADC6 and ADC7 have no digital pin";
    }
    c->port = pins->port[upper];
    c->bit = (uint8_t)bit;
    return NULL;
}

// Sets port and bit from the registers. NULL, or what about the registers is not modelled.
static const char *find_inputs(struct comparator *c)
{
    const uint8_t *data = c->avr->data;

    c->port = '\0';
    if ((data[ACSR] & ACD) != 0) {
        return "it is switched off (ACD = 1)";
    }
    if ((data[ACSR] & ACBG) == 0) {
        return "AIN0 as positive input (ACBG = 0) is not modelled";
    }
    if ((data[ADCSRB] & ACME) == 0) {
        return "AIN1 as negative input (ACME = 0) is not modelled";
    }
    if ((data[ADCSRA] & ADEN) != 0) {
        return "AIN1 as negative input (ADEN = 1) is not modelled";
    }
    if ((data[PRR] & PRADC) != 0) {
        return "the multiplexer has no power (PRADC = 1)";
    }
    if ((data[ADMUX] & MUX4_AND3) != 0) {
        return "MUX4:3 other than 0 are not modelled";
    }
    return find_pin(c);
}

static bool output_seen(const struct comparator *c, uint64_t cycle)
{
    return (cycle >= c->output_cycle + COMPARATOR_ACO_CYCLES) ? c->output
                                                              : c->output_before;
}

// Sets ACI for the last change of the output, once ACO shows it.
static void set_due_flag(struct comparator *c, uint64_t cycle)
{
    if (c->flagged && cycle >= c->output_cycle + COMPARATOR_ACO_CYCLES) {
        c->flagged = false;
        c->avr->data[ACSR] |= ACI;
    }
}

static bool is_flagged_edge(const struct comparator *c, bool rises)
{
    switch (c->avr->data[ACSR] & ACIS) {
    case ON_TOGGLE:
        return true;
    case ON_FALL:
        return !rises;
    case ON_RISE:
        return rises;
    default:
        return false;
    }
}

static void set_output(struct comparator *c, bool output, uint64_t cycle)
{
    if (c->output != output) {
        set_due_flag(c, cycle);
        c->output_before = output_seen(c, cycle);
        c->output_cycle = cycle;
        c->output = output;
        c->flagged = is_flagged_edge(c, output);
    }
}

static void compare_pin(struct comparator *c, uint64_t cycle)
{
    bool low = c->port != '\0' && !ports_level(c->ports, c->port, c->bit);

    set_output(c, low, cycle);
    c->hooks->changed(c->hooks->host.board, cycle);
}

void comparator_follow(struct comparator *c, char port, uint64_t cycle)
{
    if (c->port == port) {
        compare_pin(c, cycle);
    }
}

static void follow_registers(struct comparator *c, uint64_t cycle)
{
    const char *wrong = find_inputs(c);

    if (wrong != NULL && comparator_captures(c)) {
        peripheral_refuse(&c->hooks->host, "analog comparator: with ACIC = 1, %s", wrong);
    }
    compare_pin(c, cycle);
}

static uint8_t read_acsr(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct comparator *c = param;
    uint64_t cycle = access_cycle(avr);

    set_due_flag(c, cycle);
    return (uint8_t)((avr->data[address] & ~ACO) | (output_seen(c, cycle) ? ACO : 0U));
}

static void write_acsr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct comparator *c = param;
    uint8_t flag;

    set_due_flag(c, access_cycle(avr));
    flag = (uint8_t)(avr->data[address] & ~value & ACI); // write one to clear
    avr->data[address] = (uint8_t)((value & ~(ACO | ACI)) | flag);
    if ((value & ACIE) != 0) {
        peripheral_refuse(&c->hooks->host,
                          "analog comparator: its interrupt (ACIE = 1) is not modelled");
    }
    if ((value & ACIC) != 0 && (value & ACIS) == ON_RESERVED) {
        peripheral_refuse(&c->hooks->host, "analog comparator: ACIS1:0 = 1 is reserved");
    }
    follow_registers(c, access_cycle(avr) + 1);
}

// A register that the ADC shares: simavr's own callback goes on working.
static void write_shared(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct comparator *c = param;
    int i = 0;

    while (shared[i] != address) {
        i++;
    }
    avr->data[address] = value;
    if (c->before[i].write != NULL) {
        c->before[i].write(avr, address, value, c->before[i].param);
    }
    follow_registers(c, access_cycle(avr) + 1);
}

void comparator_reset(struct comparator *c)
{
    c->avr->data[ACSR] = 0;
    c->output = c->output_before = c->flagged = false;
    c->output_cycle = 0;
    c->port = '\0';
}

void comparator_attach(struct comparator *c,
                       avr_t *avr,
                       const struct ports *ports,
                       const struct comparator_hooks *hooks)
{
    avr_io_t *own = peripheral_next(avr->io_port, "ac");

    memset(c, 0, sizeof *c);
    c->avr = avr;
    c->ports = ports;
    c->hooks = hooks;
    if (own != NULL) { // without its reset, simavr's comparator never starts
        own->reset = NULL;
    }
    for (int i = 0; i < COMPARATOR_SHARED; i++) {
        avr_io_addr_t io = (avr_io_addr_t)AVR_DATA_TO_IO(shared[i]);

        c->before[i].write = avr->io[io].w.c;
        c->before[i].param = avr->io[io].w.param;
        avr->io[io].w.c = write_shared;
        avr->io[io].w.param = c;
    }
    access_take(avr, ACSR, read_acsr, write_acsr, c);
}
