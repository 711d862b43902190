// SPDX-License-Identifier: MIT
// <avr/io.h> of the explorer: the registers that the step engine uses, of an ATmega328P or of an
// ATmega1284P, as memory. part.c gives them their side effects.
#pragma once

#include <stdint.h>

#include "config.h" // CONFIG_AXES

// Of a 16-bit timer. Axis 0 has timer 1, axis 1 timer 3.
struct part_timer_registers {
    volatile uint8_t tifr;
    volatile uint8_t timsk;
    volatile uint8_t tccra;
    volatile uint8_t tccrb;
    volatile uint8_t temp; // the high byte of every 16-bit access
    volatile uint8_t ocral;
    volatile uint8_t ocrbl;
    volatile uint16_t ocra;
    volatile uint16_t ocrb;
    volatile uint16_t icr;
    volatile uint16_t tcnt;
};

struct part_registers {
    struct part_timer_registers timers[CONFIG_AXES];
    volatile uint8_t pina;
    volatile uint8_t pinb;
    volatile uint8_t pinc;
    volatile uint8_t pind;
    volatile uint8_t porta;
    volatile uint8_t portb;
    volatile uint8_t portc;
    volatile uint8_t portd;
    volatile uint8_t ddra;
    volatile uint8_t ddrb;
    volatile uint8_t ddrc;
    volatile uint8_t ddrd;
    volatile uint8_t eimsk;
    volatile uint8_t eifr;
    volatile uint8_t eicra;
    volatile uint8_t gpior0;
    volatile uint8_t gpior2;
#if CONFIG_AXES > 1
    volatile uint8_t tcnt0;
    volatile uint8_t tifr0;
#endif
};

extern struct part_registers part_registers;

// NOLINTBEGIN(*-naming,bugprone-reserved-identifier,cert-dcl*): names that are not ours
#define _BV(bit)          (1 << (bit))
#define _SFR_IO_ADDR(reg) 0

#define TIFR1  part_registers.timers[0].tifr
#define TIMSK1 part_registers.timers[0].timsk
#define TCCR1A part_registers.timers[0].tccra
#define TCCR1B part_registers.timers[0].tccrb
#define OCR1A  part_registers.timers[0].ocra
#define OCR1AH part_registers.timers[0].temp
#define OCR1AL part_registers.timers[0].ocral
#define OCR1B  part_registers.timers[0].ocrb
#define OCR1BH part_registers.timers[0].temp
#define OCR1BL part_registers.timers[0].ocrbl
#define ICR1   part_registers.timers[0].icr
#define TCNT1  part_registers.timers[0].tcnt
#if CONFIG_AXES > 1
#define TIFR3  part_registers.timers[1].tifr
#define TIMSK3 part_registers.timers[1].timsk
#define TCCR3A part_registers.timers[1].tccra
#define TCCR3B part_registers.timers[1].tccrb
#define OCR3A  part_registers.timers[1].ocra
#define OCR3AH part_registers.timers[1].temp
#define OCR3B  part_registers.timers[1].ocrb
#define ICR3   part_registers.timers[1].icr
#define TCNT3  part_registers.timers[1].tcnt
#define TCNT0  part_registers.tcnt0
#define TIFR0  part_registers.tifr0
#endif
#define PINA   part_registers.pina
#define PINB   part_registers.pinb
#define PINC   part_registers.pinc
#define PIND   part_registers.pind
#define PORTA  part_registers.porta
#define PORTB  part_registers.portb
#define PORTC  part_registers.portc
#define PORTD  part_registers.portd
#define DDRA   part_registers.ddra
#define DDRB   part_registers.ddrb
#define DDRC   part_registers.ddrc
#define DDRD   part_registers.ddrd
#define EIMSK  part_registers.eimsk
#define EIFR   part_registers.eifr
#define EICRA  part_registers.eicra
#define GPIOR0 part_registers.gpior0
#define GPIOR2 part_registers.gpior2

#define TOV0   0
#define TOV1   0
#define OCF1A  1
#define OCF1B  2
#define ICF1   5
#define TOIE1  0
#define OCIE1A 1
#define OCIE1B 2
#define ICIE1  5
#define WGM10  0
#define WGM11  1
#define COM1B0 4
#define COM1B1 5
#if CONFIG_AXES > 1
#define TOV3   TOV1
#define OCF3A  OCF1A
#define OCF3B  OCF1B
#define ICF3   ICF1
#define TOIE3  TOIE1
#define OCIE3A OCIE1A
#define OCIE3B OCIE1B
#define ICIE3  ICIE1
#define WGM30  WGM10
#define WGM31  WGM11
#define COM3B0 COM1B0
#define COM3B1 COM1B1
#endif

#define CS10  0
#define WGM12 3
#define WGM13 4
#define ICES1 6

#define INT0  0
#define INT2  2
#define ISC00 0

// The linker of the image gives the rings their section; here their alignment is what is left.
#define section(name) aligned(256)

// The layout that step_isr.S knows is the AVR's, not this machine's.
#define _Static_assert(condition, text) extern const uint8_t layout_of_the_avr
// NOLINTEND(*-naming,bugprone-reserved-identifier,cert-dcl*)
