// SPDX-License-Identifier: MIT
//
// Resets and the power supply: what each leaves as it was and what it makes anew.
//
// Rules, from the ATmega328P and ATmega2560 data sheets (System Control and Reset):
//  * MCUSR collects the causes: a power-on leaves PORF alone, every other reset adds its own flag;
//    a program can clear flags, never set them.
//  * registers of the I/O space get their initial values and all pins become inputs. RAM and the
//    general purpose registers keep their content, except through a power cut: then they are noise.
// Not modelled: the start-up time (the program begins at once), the supply's slope.

#include "board.h"

#include <stddef.h>
#include <string.h>

#include "access.h"
#include "board_run.h"

#define MCUSR        0x54U // data address, the same on both parts
#define GPIOR2       0x4BU
#define REGISTERS    32U // r0 to r31, the first data addresses
#define NOISE_EEPROM 0U
#define NOISE_RAM    1U
#define NOISE_PLACES 2U

static const char *const cause_names[BOARD_CAUSES] = {
    "power-on", "external", "brownout", "watchdog"};

int board_cause_by_name(const char *name)
{
    for (int i = 0; i < BOARD_CAUSES; i++) {
        if (strcmp(cause_names[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

void board_seed(struct board *b, uint64_t seed)
{
    noise_seed(&b->eeprom.noise, seed, NOISE_PLACES * (unsigned)b->index + NOISE_EEPROM);
    noise_seed(&b->ram_noise, seed, NOISE_PLACES * (unsigned)b->index + NOISE_RAM);
}

// Write zero to clear.
static void write_mcusr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)param;
    avr->data[address] &= value;
}

// Every model's part of a reset. Runs after simavr's own modules, at every reset of the part.
static void on_reset(avr_io_t *io)
{
    struct board *b = (struct board *)((char *)io - offsetof(struct board, reset_hook));

    b->avr->data[MCUSR] = b->mcusr;
    uart_reset(&b->uart); // before its driver is let go: a frame on its way is cut
    for (int i = 0; i < b->timers; i++) {
        timer16_reset(&b->timer[i]);
    }
    comparator_reset(&b->comparator);
    eeprom_reset(&b->eeprom);
    watchdog_reset(&b->watchdog);
    irq_stats_reset(&b->stats);
    board_release_outputs(b);
    extint_reset(&b->extint); // knows the pins as they are now
    b->avr->data[GPIOR2] = b->strap;
    // The reset has emptied simavr's list of events.
    board_schedule_end(b);
    board_schedule_pulse(b);
    board_schedule_switches(b);
    board_schedule_plan(b);
}

// simavr puts new modules at the head of its list, and resets from there: ours must come last.
void board_append_reset_hook(struct board *b)
{
    avr_io_t **tail = &b->avr->io_port;

    while (*tail != NULL) {
        tail = &(*tail)->next;
    }
    b->reset_hook.kind = "pixstep";
    b->reset_hook.avr = b->avr;
    b->reset_hook.reset = on_reset;
    b->reset_hook.next = NULL;
    *tail = &b->reset_hook;
    b->powered = true;
    b->mcusr = 1U << BOARD_POWER_ON;
    access_take(b->avr, MCUSR, NULL, write_mcusr, b);
}

static void reset_part(struct board *b)
{
    uint64_t cycle = b->avr->cycle;

    b->want = BOARD_WANT_NONE;
    irq_stats_section(&b->stats, b->stats.section, cycle);
    avr_reset(b->avr);
    b->avr->cycle =
        cycle; // the boards' common time goes on, whatever simavr does with it
    b->avr->state = cpu_Running;
    b->avr->run = board_next_run(b);
}

static void fill_with_noise(struct board *b)
{
    avr_t *avr = b->avr;
    unsigned first = avr->ioend + 1U;

    stack_before_noise(&b->stack, avr);
    noise_fill(&b->ram_noise, avr->data, REGISTERS);
    noise_fill(&b->ram_noise, &avr->data[first], avr->ramend + 1U - first);
    stack_after_noise(&b->stack, avr);
}

void board_reset(struct board *b, enum board_cause cause)
{
    if (cause == BOARD_POWER_ON) {
        b->mcusr = 0;
        fill_with_noise(b);
    } else {
        b->mcusr = b->avr->data[MCUSR];
    }
    b->mcusr |= (uint8_t)(1U << cause);
    board_end_hang(b, cause == BOARD_POWER_ON);
    reset_part(b);
}

void board_power_off(struct board *b)
{
    eeprom_power_cut(&b->eeprom, b->avr->cycle);
    b->mcusr = 0;
    b->powered = false;
    board_end_hang(b, true);
    reset_part(b);
}

void board_power_on(struct board *b)
{
    b->powered = true;
    board_reset(b, BOARD_POWER_ON);
}

// ---- from within an instruction or event: as soon as that has ended ----

void board_do_wanted(avr_t *avr)
{
    struct board *b = avr->custom.data;
    enum board_want want = b->want;

    b->want = BOARD_WANT_NONE;
    switch (want) {
    case BOARD_WANT_OFF:
        board_power_off(b);
        break;
    case BOARD_WANT_ON:
        board_power_on(b);
        break;
    case BOARD_WANT_CYCLE:
        board_power_off(b);
        board_power_on(b);
        break;
    case BOARD_WANT_WATCHDOG:
    case BOARD_WANT_EXTERNAL:
    case BOARD_WANT_BROWN_OUT:
        board_reset(b, (enum board_cause)(want - BOARD_WANT_EXTERNAL + BOARD_EXTERNAL));
        break;
    case BOARD_WANT_NONE:
    default:
        avr->run = board_next_run(b);
        break;
    }
}

void board_want(struct board *b, enum board_want want)
{
    if (want > b->want) { // the supply rules
        b->want = want;
    }
    b->avr->run = board_do_wanted;
    if (b->avr->state == cpu_Sleeping) {
        b->avr->state = cpu_Running;
    }
    b->avr->interrupt_state = 0; // nothing is served any more
}

void board_want_watchdog(void *board)
{
    board_want(board, BOARD_WANT_WATCHDOG);
}
