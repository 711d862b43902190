; SPDX-License-Identifier: MIT
; The step interrupt: timer overflow of each axis, at the start of every period. It loads the next
; period into the double-buffered OCRnA and has this whole period to do so. The STEP edges
; themselves are made by OCRnB; nothing here moves them.
;
; The C it stands for is step_engine_next(); this does its frequent case (a plain period) and the
; idle case, and leaves commands to C:
;
;     uint8_t high = ring->high[tail];
;     if (high >= STEP_HIGH_COMMAND)
;         ...
;     OCRnA = high << 8 | ring->low[tail];
;     tail++;
;     if (TIFRn & TOVn) late();        the next period began meanwhile
;
; Cycles of the frequent case, ATmega328P (ATmega2560):
;
;     interrupt response                       4 (5)
;     jmp in the vector table                  3
;     save r24, SREG, r30, r31                 9
;     find and read the high byte              5
;     is it a command?                         2
;     load OCRnA, read the low byte            7
;     advance the tail                         3
;     has the next period begun?               2
;     restore, reti                           13 (14)
;                                             --
;                                             48 (50)
#define __SFR_OFFSET 0
#include <avr/io.h>

#include "hal/avr/board.h"    // BOARD_FILE
#include "hal/avr/step_isr.h" // layout

; Save what a C function may change beyond what the handler has saved, call it, restore.
.macro call_c function
    push r0
    push r1
    push r18
    push r19
    push r20
    push r21
    push r22
    push r23
    push r25
    push r26
    push r27
    clr r1
    call \function
    pop r27
    pop r26
    pop r25
    pop r23
    pop r22
    pop r21
    pop r20
    pop r19
    pop r18
    pop r1
    pop r0
.endm

; The rare cases take some hundred cycles: the other axes are served meanwhile, this timer's own
; interrupts are not. The C function comes back with interrupts off.
.macro call_c_nested function, mask
    lds r24, \mask
    push r24
    clr r24
    sts \mask, r24
    sei
    call_c \function
    pop r24
    sts \mask, r24
.endm

; After a halt the overflow interrupt gives way to the compare A interrupt of the same instant,
; whose handler does not look at the ring (step_timer.c): the writer may still be adding to it.
.macro give_way_if_halted axis, mask
    lds r24, step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_STATE
    cpi r24, 2
    brne 5f
    lds r24, \mask
    andi r24, ~(1 << TOIE1)
    ori r24, 1 << OCIE1A
    sts \mask, r24
5:
.endm

.macro step_handler axis, vector, top_low, top_high, flags, flag, mask
    .global \vector
    .type \vector, @function
\vector:
    push r24
    in r24, SREG
    push r24
    push r30
    push r31
    lds r30, step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_TAIL
    ldi r31, hi8(step_rings + \axis * STEP_ISR_RING_SIZE + STEP_ISR_HIGH_OFFSET)
    ld r24, Z
    cpi r24, 0xFE
    brsh 2f
    sts \top_high, r24
    dec r31
    ld r24, Z
    sts \top_low, r24
    inc r30
    sts step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_TAIL, r30
1:  sbic \flags, \flag
    rjmp 4f
    pop r31
    pop r30
    pop r24
    out SREG, r24
    pop r24
    reti

2:  breq 3f
    ; Empty. In a line that is a fault; else one more idle period, already in the registers.
    lds r24, step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_STATE
    cpi r24, 1
    breq 3f
    lds r30, step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_IDLE_COUNT
    lds r31, step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_IDLE_COUNT + 1
    adiw r30, 1
    sts step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_IDLE_COUNT, r30
    sts step_engines + \axis * STEP_ISR_ENGINE_SIZE + STEP_ISR_IDLE_COUNT + 1, r31
    rjmp 1b

3:  call_c_nested step_isr_command_\axis, \mask
    give_way_if_halted \axis, \mask
    rjmp 1b

4:  call_c step_isr_late_\axis
    pop r31
    pop r30
    pop r24
    out SREG, r24
    pop r24
    reti
.endm

.text
#define HANDLER(axis, timer)                                                             \
    step_handler axis, TIMER##timer##_OVF_vect, OCR##timer##AL, OCR##timer##AH,          \
        TIFR##timer, TOV##timer, TIMSK##timer
#define BOARD_AXIS(axis, timer) HANDLER(axis, timer)
#define BOARD_PIN(signal, axis, port, bit, header_pin)
#include BOARD_FILE
