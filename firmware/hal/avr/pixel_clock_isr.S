; SPDX-License-Identifier: MIT
; The pixel clock's capture interrupt: places an edge by the step engine of the clock's axis and
; queues it, so that edges never wait for the main loop.
;
;     edge        hardware copies the counter to ICRn and requests the interrupt
;     handler     notes in which period, and of which entry of the ring, the edge lies
;     main loop   pixel_clock_take()
;
; BUSY is set while the handler runs: an edge that comes meanwhile only sets OVERRUN, so that a
; noisy input cannot nest the handler. BUSY is cleared with interrupts off, by the last instruction
; but one.
;
; The period of an edge is counted back from the one that the engine loaded last, m + 1, where m is
; the period whose interrupt was served last:
;
;     served:      m         (m + 1 begins, overflow pending)
;     counter   ---|---------------|------
;
; Reading ICRn and TCNTn disturbs TEMP, which belongs to a run (step_isr.S): it is put back.
#define __SFR_OFFSET 0
#include <avr/io.h>

#include "config.h"                // CONFIG_*, BOARD_PIXEL_CLOCK_TIMER
#include "hal/avr/capture_queue.h" // CAPTURE_*
#include "hal/avr/flag_bits.h"     // FLAG_*
#include "hal/avr/step_isr.h"      // STEP_ISR_*

#define PASTE(a, b, c)  a##b##c
#define EXPAND(a, b, c) PASTE(a, b, c)
#define VECTOR          EXPAND(TIMER, BOARD_PIXEL_CLOCK_TIMER, _CAPT_vect)
#define EDGE_LOW        EXPAND(ICR, BOARD_PIXEL_CLOCK_TIMER, L)
#define EDGE_HIGH       EXPAND(ICR, BOARD_PIXEL_CLOCK_TIMER, H)
#define COUNT_LOW       EXPAND(TCNT, BOARD_PIXEL_CLOCK_TIMER, L)
#define COUNT_HIGH      EXPAND(TCNT, BOARD_PIXEL_CLOCK_TIMER, H)
#define TOP_HIGH        EXPAND(OCR, BOARD_PIXEL_CLOCK_TIMER, AH)
#define TIMER_FLAGS     EXPAND(TIFR, BOARD_PIXEL_CLOCK_TIMER, )
#define OVERFLOW        0 // bits of TIMER_FLAGS, the same in every timer
#define CAPTURED        5
#define PARKED_BIT      2 // which no other state of an engine has
#if STEP_STATE_PARKED != 1 << PARKED_BIT
#error "the handler tests one bit"
#endif

#define ENGINE (step_engines + CONFIG_PIXEL_CLOCK_AXIS * STEP_ISR_ENGINE_SIZE)
#define QUEUE  pixel_clock_edges

; Z is the address of the queue's free entry, its index times 7; to `full` if none is. Uses r24.
.macro find_place full
    lds r24, QUEUE + CAPTURE_QUEUE_HEAD
    lds r30, QUEUE + CAPTURE_QUEUE_TAIL
    sub r30, r24
    cpi r30, lo8(-CONFIG_CLOCK_EDGES)
    brne .Lroom
    rjmp \full
.Lroom:
    andi r24, CONFIG_CLOCK_EDGES - 1
    mov r30, r24
    swap r30
    lsr r30
    sub r30, r24
    ldi r31, 0
    subi r30, lo8(-(QUEUE + CAPTURE_QUEUE_ENTRIES))
    sbci r31, hi8(-(QUEUE + CAPTURE_QUEUE_ENTRIES))
.endm

; The entry is complete. Uses r24.
.macro publish
    lds r24, QUEUE + CAPTURE_QUEUE_HEAD
    inc r24
    sts QUEUE + CAPTURE_QUEUE_HEAD, r24
.endm

; Uses r24.
.macro count_lost
    lds r24, QUEUE + CAPTURE_QUEUE_LOST
    inc r24
    breq .Lcounted
    sts QUEUE + CAPTURE_QUEUE_LOST, r24
.Lcounted:
.endm

; Near the vector table, as the section of step_isr.S is.
.section .lowtext, "ax", @progbits
    .global VECTOR
    .type VECTOR, @function
#if CONFIG_AXES == 1

; With a single axis no other step interrupt holds the handler up, and each cycle with interrupts
; off is one of the shortest interval: off for 13 cycles, then for 9, and for 21 where the sample,
; the flags and the counter belong together. At most one period began since the edge.
;
;     0 or 1: the counter is in m + 1 (the flag was set before the counter was read, or it appeared
;     beside a count that has just wrapped) or in m; and 1 more when the captured value is beyond
;     the counter: the edge lies in the period before the counter's.
;
; 165 cycles at most.
VECTOR:
    sbic GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    rjmp .Lcrowded
    sbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    sei
    push r24
    in r24, SREG
    push r24
    push r30
    push r31
    find_place .Lfull
    .irp register, r18, r19, r20, r21, r22, r23, r25, r26, r27
    push \register
    .endr
    cli
    lds r20, EDGE_LOW
    lds r21, EDGE_HIGH
    lds r24, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r24
    sei
    std Z + CAPTURE_ENTRY_CAPTURED, r20
    std Z + CAPTURE_ENTRY_CAPTURED + 1, r21
    cli
    lds r22, ENGINE + STEP_ISR_TAIL
    lds r23, ENGINE + STEP_ISR_LEFT
    lds r25, ENGINE + STEP_ISR_CUT
    lds r26, ENGINE + STEP_ISR_IDLE_COUNT
    lds r27, ENGINE + STEP_ISR_IDLE_COUNT + 1
    in r18, TIMER_FLAGS
    lds r20, COUNT_LOW
    lds r21, COUNT_HIGH
    in r24, TIMER_FLAGS
    lds r19, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r19
    sei
    std Z + CAPTURE_ENTRY_TAIL, r22
    or r23, r25
    std Z + CAPTURE_ENTRY_LEFT_OR_CUT, r23
    std Z + CAPTURE_ENTRY_IDLE_COUNT, r26
    std Z + CAPTURE_ENTRY_IDLE_COUNT + 1, r27
    sbrc r18, OVERFLOW
    rjmp .Lwrapped
    sbrs r24, OVERFLOW
    rjmp .Lnot_wrapped
    ldi r19, 0
    cpi r20, CAPTURE_JUST_WRAPPED_TICKS
    cpc r21, r19
    brsh .Lnot_wrapped
.Lwrapped:
    ldi r24, 0
    rjmp .Lcompare
.Lnot_wrapped:
    ldi r24, 1
.Lcompare:
    ldd r18, Z + CAPTURE_ENTRY_CAPTURED
    ldd r19, Z + CAPTURE_ENTRY_CAPTURED + 1
    cp r20, r18
    cpc r21, r19
    brsh .Lplaced
    inc r24
.Lplaced:
    and r25, r25
    breq .Lwhole
    ori r24, CAPTURE_CUT
.Lwhole:
    std Z + CAPTURE_ENTRY_NOTES, r24
    publish
    .irp register, r27, r26, r25, r23, r22, r21, r20, r19, r18
    pop \register
    .endr
.Lleave:
    pop r31
    pop r30
    pop r24
    out SREG, r24
    pop r24
    cli
    cbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    reti
.Lfull:
    count_lost
    rjmp .Lleave
.Lcrowded:
    sbi GPIOR0, FLAG_PIXEL_CLOCK_OVERRUN
    reti

#else

; With several axes the handler may wait, for longer than a short interval, wherever it lets the
; step interrupts in. It therefore notes first where the engine is. The capture's vector comes
; before that of its timer's overflow, so that the overflow flag says most of the rest:
;
;     flag clear    the edge lies in m: behind it the overflow would have waited as well
;     flag set      in m + 1 if its count is not beyond the counter, else in m
;
; Where the axis is parked no interrupt of its own runs: the entry gets the coarse clock's units in
; the place of the idle count, and the other members are what they were when the axis was parked.
; Those units are noted first of all, too: the flag of such an axis is set from its first idle
; period on. A train that was cut off is noted if nothing has been taken from the ring since: not
; one that was cut behind the edge.
;
; A second edge that comes before ICRn is read has overwritten it. The edge is left out then, which
; a lock bridges; OVERRUN tells.
;
; Interrupts are off for 29 cycles, 50 where the overflow flag is set, 51 where the axis is parked,
; then for 15. 165 cycles at most; 215 where the axis is parked.
VECTOR:
    sbic GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    rjmp .Lcrowded
    sbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    push r24
    lds r24, ENGINE + STEP_ISR_LEFT
    sts QUEUE + CAPTURE_FIRST_LEFT, r24
    lds r24, ENGINE + STEP_ISR_TAIL
    sts QUEUE + CAPTURE_FIRST_TAIL, r24
    lds r24, ENGINE + STEP_ISR_IDLE_COUNT
    sts QUEUE + CAPTURE_FIRST_IDLE_LOW, r24
    sbic TIMER_FLAGS, OVERFLOW
    rjmp .Lwrapped
.Lnoted:
    sei
    in r24, SREG
    push r24
    .irp register, r18, r19, r20, r21, r30, r31
    push \register
    .endr
    find_place .Lfull
    cli
    lds r20, EDGE_LOW
    lds r21, EDGE_HIGH
    lds r24, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r24
    lds r18, ENGINE + STEP_ISR_IDLE_COUNT
    lds r24, ENGINE + STEP_ISR_IDLE_COUNT + 1
    in r19, TIMER_FLAGS
    sei
    sbrs r19, CAPTURED
    sbic GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    rjmp .Lunsure
    std Z + CAPTURE_ENTRY_CAPTURED, r20
    std Z + CAPTURE_ENTRY_CAPTURED + 1, r21
    sbis GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    rjmp .Lin_m
    cbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    lds r19, QUEUE + CAPTURE_FIRST_COUNTER
    cp r19, r20
    lds r19, QUEUE + CAPTURE_FIRST_COUNTER + 1
    cpc r19, r21
    ldi r19, 0
    brsh .Lplaced
.Lin_m:
    ldi r19, 1
.Lplaced:
    lds r20, QUEUE + CAPTURE_FIRST_IDLE_LOW ; the idle count of then: r24:r18 is that of now
    cp r18, r20
    sbci r24, 0
    std Z + CAPTURE_ENTRY_IDLE_COUNT, r20
    std Z + CAPTURE_ENTRY_IDLE_COUNT + 1, r24
    lds r20, QUEUE + CAPTURE_FIRST_TAIL
    std Z + CAPTURE_ENTRY_TAIL, r20
    lds r18, QUEUE + CAPTURE_FIRST_LEFT
    and r18, r18
    brne .Lwhole
    lds r24, ENGINE + STEP_ISR_TAIL
    cp r24, r20
    brne .Lwhole
    lds r24, ENGINE + STEP_ISR_CUT
    and r24, r24
    breq .Lwhole
    mov r18, r24
    ori r19, CAPTURE_CUT
.Lwhole:
    std Z + CAPTURE_ENTRY_LEFT_OR_CUT, r18
    lds r24, ENGINE + STEP_ISR_STATE
    cpi r24, STEP_STATE_PARKED
    breq .Lparked
.Lcomplete:
    std Z + CAPTURE_ENTRY_NOTES, r19
    publish
.Lleave:
    .irp register, r31, r30, r21, r20, r19, r18, r24
    pop \register
    .endr
    out SREG, r24
    pop r24
    cli
    cbi GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    cbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    reti

; The coarse clock's low 16 bits, as clock_look_units() makes them.
.Lparked:
    lds r20, QUEUE + CAPTURE_FIRST_FLAGS
    and r20, r20
    breq .Lunits_now
    ldi r19, 0
    sts QUEUE + CAPTURE_FIRST_FLAGS, r19
    lds r18, QUEUE + CAPTURE_FIRST_COUNTER
    lds r24, QUEUE + CAPTURE_FIRST_COUNTER + 1
    lds r19, QUEUE + CAPTURE_FIRST_TIMER_0
    rjmp .Lunits
.Lunits_now:
    cli
    in r18, TCNT0
    in r19, TIFR0
    in r20, GPIOR0
    lds r24, clock_overflows
    sei
.Lunits:
    andi r19, 1 << TOV0
    andi r20, 1 << FLAG_CLOCK_COUNTING
    or r19, r20
    breq .Lcounted_units
    sbrs r18, 7
    inc r24
.Lcounted_units:
    std Z + CAPTURE_ENTRY_IDLE_COUNT, r18
    std Z + CAPTURE_ENTRY_IDLE_COUNT + 1, r24
    ldi r19, CAPTURE_WAS_PARKED
    rjmp .Lcomplete

.Lwrapped:
    sbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    lds r24, ENGINE + STEP_ISR_STATE
    sbrc r24, PARKED_BIT
    rjmp .Lwrapped_parked
    lds r24, COUNT_LOW
    sts QUEUE + CAPTURE_FIRST_COUNTER, r24
    lds r24, COUNT_HIGH
    sts QUEUE + CAPTURE_FIRST_COUNTER + 1, r24
    lds r24, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r24
    rjmp .Lnoted
.Lwrapped_parked:
    in r24, TCNT0
    sts QUEUE + CAPTURE_FIRST_COUNTER, r24
    in r24, TIFR0
    sts QUEUE + CAPTURE_FIRST_TIMER_0, r24
    in r24, GPIOR0
    sts QUEUE + CAPTURE_FIRST_FLAGS, r24
    lds r24, clock_overflows
    sts QUEUE + CAPTURE_FIRST_COUNTER + 1, r24
    rjmp .Lnoted
.Lfull:
    count_lost
.Lunsure:
    cbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    ldi r24, 0
    sts QUEUE + CAPTURE_FIRST_FLAGS, r24
    rjmp .Lleave
.Lcrowded:
    sbi GPIOR0, FLAG_PIXEL_CLOCK_OVERRUN
    sbi GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    reti

#endif
