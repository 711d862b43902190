// SPDX-License-Identifier: MIT
// The EEPROM, measured by timer 1 and EE_READY from inside. With GPIOR2 not 0 (the test pokes it)
// the program asks for what is refused instead. Reckoning and expected values in test_eeprom.py.

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define NOPS(count) ".rept " #count "\n\tnop\n\t.endr\n\t"
#define EECR_IO     "%[eecr]"
#define REGISTERS                                                                        \
    [eecr] "I"(_SFR_IO_ADDR(EECR)), [mpe] "I"(EEMPE), [pe] "I"(EEPE), [re] "I"(EERE),    \
        [tcnt] "n"(_SFR_MEM_ADDR(TCNT1L))

uint8_t stored[4] EEMEM; // the first bytes, under a name

static volatile uint16_t ready_count;

ISR(EE_READY_vect)
{
    ready_count++;
}

static void wait(void)
{
    while ((EECR & (1U << EEPE)) != 0) {
    }
}

static void aim(uint16_t address, uint8_t value)
{
    wait();
    EEAR = address;
    EEDR = value;
}

static uint8_t read(uint16_t address)
{
    wait();
    EEAR = address;
    EECR |= (uint8_t)(1U << EERE);
    return EEDR;
}

static void set_mode_and_write(uint8_t mode, uint16_t address, uint8_t value)
{
    aim(address, value);
    EECR = (uint8_t)(mode << EEPM0);
    __asm__ volatile("sbi " EECR_IO ", %[mpe]\n\t"
                     "sbi " EECR_IO ", %[pe]\n\t" ::REGISTERS);
}

// 0: EECR with EEPE set in the fourth cycle after EEMPE. 1: in the fifth.
static void window(void)
{
    aim(0x10, 0x5A);
    __asm__ volatile("sbi " EECR_IO ", %[mpe]\n\t" NOPS(2) "sbi " EECR_IO
                                                           ", %[pe]\n\t" ::REGISTERS);
    RESULT[0] = EECR;
    aim(0x11, 0x5A);
    __asm__ volatile("sbi " EECR_IO ", %[mpe]\n\t" NOPS(3) "sbi " EECR_IO
                                                           ", %[pe]\n\t" ::REGISTERS);
    RESULT[1] = EECR;
}

// 2: cycles from before EEPE is set to after it. 3: the same of EERE.
static void halts(void)
{
    uint8_t before;
    uint8_t after;

    aim(0x12, 0xA5);
    __asm__ volatile("sbi " EECR_IO ", %[mpe]\n\t"
                     "lds %[before], %[tcnt]\n\t"
                     "sbi " EECR_IO ", %[pe]\n\t"
                     "lds %[after], %[tcnt]\n\t"
                     : [before] "=&r"(before), [after] "=&r"(after)
                     : REGISTERS);
    RESULT[2] = (uint8_t)(after - before);
    wait();
    __asm__ volatile("lds %[before], %[tcnt]\n\t"
                     "sbi " EECR_IO ", %[re]\n\t"
                     "lds %[after], %[tcnt]\n\t"
                     : [before] "=&r"(before), [after] "=&r"(after)
                     : REGISTERS);
    RESULT[3] = (uint8_t)(after - before);
}

static uint16_t write_time(uint8_t mode, uint8_t value)
{
    uint16_t before;

    set_mode_and_write(mode, 0x13, value);
    before = TCNT1;
    wait();
    return TCNT1 - before;
}

// 4 to 9: how long each mode takes and what it leaves.
static void modes(void)
{
    RESULT[4] = write_time(0, 0x3C);
    RESULT[5] = read(0x13);
    RESULT[6] = write_time(2, 0x0F);
    RESULT[7] = read(0x13);
    RESULT[8] = write_time(1, 0x00);
    RESULT[9] = read(0x13);
}

// 10: EEAR, written while busy. 11: EECR's mode, the same.
static void locked(void)
{
    set_mode_and_write(0, 0x14, 0x77);
    EEAR = 0x15;
    EECR = (uint8_t)(1U << EEPM0);
    RESULT[10] = EEAR;
    RESULT[11] = EECR & (uint8_t)((1U << EEPM0) | (1U << EEPM1));
    wait();
    EECR = 0;
}

// 12: EE_READY served in about 200 cycles with nothing to wait for. 13: while a byte is written.
// 14: in the 200 cycles after. 15: with EERIE = 0.
static void ready(void)
{
    wait();
    ready_count = 0;
    EECR = (uint8_t)(1U << EERIE);
    sei();
    __builtin_avr_delay_cycles(200);
    cli();
    RESULT[12] = ready_count;
    set_mode_and_write(0, 0x16, 0x88);
    EECR |= (uint8_t)(1U << EERIE);
    ready_count = 0;
    sei();
    __builtin_avr_delay_cycles(50000);
    cli();
    RESULT[13] = ready_count;
    wait();
    sei();
    __builtin_avr_delay_cycles(200);
    cli();
    RESULT[14] = ready_count;
    ready_count = 0;
    EECR = 0;
    sei();
    __builtin_avr_delay_cycles(200);
    cli();
    RESULT[15] = ready_count;
}

// 16: EEAR as it reads after all ones. 17: the last byte of the EEPROM, written and read.
static void last(void)
{
    EEAR = 0xFFFF;
    RESULT[16] = EEAR;
    set_mode_and_write(0, E2END, 0x99);
    RESULT[17] = read(E2END);
}

static void ask(uint8_t what)
{
    set_mode_and_write((what == 1) ? 3 : 0, 0x20, 1);
    switch (what) {
    case 2:
        EECR |= (uint8_t)(1U << EERE);
        break;
    case 3:
        EEDR = 2;
        break;
    case 4:
        __asm__ volatile("sbi " EECR_IO ", %[mpe]\n\t"
                         "sbi " EECR_IO ", %[pe]\n\t" ::REGISTERS);
        break;
    case 5:
        wait();
        EECR = (uint8_t)((1U << EERE) | (1U << EEPE));
        break;
    default:
        break;
    }
}

int main(void)
{
    TCCR1B = (uint8_t)(1U << CS10);
    if (GPIOR2 != 0) {
        ask(GPIOR2);
    } else {
        window();
        halts();
        modes();
        locked();
        ready();
        last();
        eeprom_update_byte(&stored[1],
                           0x42); // the library's own way, and its name for the test
        RESULT[18] = eeprom_read_byte(&stored[1]);
        RESULT[19] = 0x600D;
    }
    for (;;) {
    }
}
