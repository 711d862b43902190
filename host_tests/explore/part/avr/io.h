// SPDX-License-Identifier: MIT
// <avr/io.h> of the explorer: the registers of an ATmega328P that the step engine uses, as memory.
// part.c gives them their side effects.
#pragma once

#include <stdint.h>

struct part_registers {
    volatile uint8_t tifr1;
    volatile uint8_t timsk1;
    volatile uint8_t tccr1a;
    volatile uint8_t tccr1b;
    volatile uint8_t temp; // the high byte of every 16-bit access
    volatile uint8_t ocr1al;
    volatile uint8_t ocr1bl;
    volatile uint16_t ocr1a;
    volatile uint16_t ocr1b;
    volatile uint16_t icr1;
    volatile uint16_t tcnt1;
    volatile uint8_t pinb;
    volatile uint8_t pinc;
    volatile uint8_t pind;
    volatile uint8_t portb;
    volatile uint8_t portc;
    volatile uint8_t portd;
    volatile uint8_t ddrb;
    volatile uint8_t ddrc;
    volatile uint8_t ddrd;
    volatile uint8_t eimsk;
    volatile uint8_t eifr;
    volatile uint8_t eicra;
    volatile uint8_t gpior0;
    volatile uint8_t gpior2;
};

extern struct part_registers part_registers;

// NOLINTBEGIN(*-naming,bugprone-reserved-identifier,cert-dcl*): names that are not ours
#define _BV(bit)          (1 << (bit))
#define _SFR_IO_ADDR(reg) 0

#define TIFR1  part_registers.tifr1
#define TIMSK1 part_registers.timsk1
#define TCCR1A part_registers.tccr1a
#define TCCR1B part_registers.tccr1b
#define OCR1A  part_registers.ocr1a
#define OCR1AH part_registers.temp
#define OCR1AL part_registers.ocr1al
#define OCR1B  part_registers.ocr1b
#define OCR1BH part_registers.temp
#define OCR1BL part_registers.ocr1bl
#define ICR1   part_registers.icr1
#define TCNT1  part_registers.tcnt1
#define PINB   part_registers.pinb
#define PINC   part_registers.pinc
#define PIND   part_registers.pind
#define PORTB  part_registers.portb
#define PORTC  part_registers.portc
#define PORTD  part_registers.portd
#define DDRB   part_registers.ddrb
#define DDRC   part_registers.ddrc
#define DDRD   part_registers.ddrd
#define EIMSK  part_registers.eimsk
#define EIFR   part_registers.eifr
#define EICRA  part_registers.eicra
#define GPIOR0 part_registers.gpior0
#define GPIOR2 part_registers.gpior2

#define TOV1  0
#define OCF1A 1
#define OCF1B 2
#define ICF1  5

#define TOIE1  0
#define OCIE1A 1
#define OCIE1B 2
#define ICIE1  5

#define WGM10  0
#define WGM11  1
#define COM1B0 4
#define COM1B1 5

#define CS10  0
#define WGM12 3
#define WGM13 4
#define ICES1 6

#define INT0  0
#define INTF0 0
#define ISC00 0

// The linker of the image gives the rings their section; here their alignment is what is left.
#define section(name) aligned(256)

// The layout that step_isr.S knows is the AVR's, not this machine's.
#define _Static_assert(condition, text) extern const uint8_t layout_of_the_avr
// NOLINTEND(*-naming,bugprone-reserved-identifier,cert-dcl*)
