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
; The handler may wait, for longer than a short interval, wherever it lets the step interrupts in.
; It therefore notes first where the engine is. m is the period whose interrupt was served last,
; m + 1 the one that it loaded:
;
;     served:      m         (m + 1 begins, overflow pending)
;     counter   ---|---------------|------
;
; The capture's vector comes before that of its timer's overflow, so that the overflow flag says
; most of the rest:
;
;     flag clear    the edge lies in m: behind it the overflow would have waited as well
;     flag set      in m + 1, or late in m
;
; With several axes it lies in m + 1 then if its count is not beyond the counter's, unless it has
; waited for longer than a period. The counter is therefore read before anything else: an edge that
; comes as a step interrupt begins has waited for 60 cycles by then, the shortest interval has 64.
; Where an edge has waited for longer, a step interrupt that made up for a late interval, before
; those of other axes, has seen it then and has set BEFORE (step_catch_up.inc), and it lies in m.
;
; With one axis there is no time for the counter: the overflow is served first of all, whose own
; interrupt may be close to its limit, and the edge lies in m + 1 if its count is below
; WAIT_MAX_TICKS, for which an overflow waits at most. At the shortest intervals that is wrong for
; an edge early in a period whose own interrupt is late; a locked line's edges are at the end of a
; period.
;
; A train that was cut off is noted if nothing has been taken from the ring since: not one that was
; cut behind the edge.
;
; A second edge that comes before ICRn is read has overwritten it. The edge is left out then, which
; a lock bridges; OVERRUN tells.
;
; With one axis this also takes the edges of a home switch, and a contact's first bounces come as
; close as that. The edge of a seek is therefore not left out: it gets the count of this very
; moment, some 200 cycles behind the contact's first edge, and the engine is noted once more for it.
;
; r3 belongs to the step interrupts (step_isr.S), which cannot come while this uses it. Reading ICRn
; and TCNTn disturbs TEMP, which belongs to a train there: it is put back.
;
; Where the axis is parked no interrupt of its own runs: the entry gets the coarse clock's units in
; the place of the idle count, and the other members are what they were when the axis was parked.
; The low byte of those units is noted first of all, too: the flag of such an axis is set from its
; first idle period on.
;
; Cycles with interrupts off: with one axis 26, or where the overflow flag is set 14 and then 17 or
; 19; with several 28, 45 where the overflow flag is set, 36 where the axis is parked. Later 16
; more. In all 165 at most, 200 for an edge of a seek that was overwritten; 215 where the axis is
; parked.
#define __SFR_OFFSET 0
#include <avr/io.h>

#include "config.h"                // CONFIG_*, BOARD_PIXEL_CLOCK_TIMER
#include "avr/hal/flag_bits.h"     // FLAG_*
#include "avr/hal/step_isr.h"      // STEP_*
#include "layout.h"                // CAPTURE_*, CAPTURED_EDGE_*, STEP_ISR_*
#include "ring/captured_edge.h"  // CAPTURED_EDGE_*

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
#define SWITCH_CAPTURES (CONFIG_AXES == 1 && FEATURE_HOMING)
#define PARKED_BIT      2 // which no other state of an engine has
#define WAIT_MAX_TICKS  22
#if STEP_STATE_PARKED != 1 << PARKED_BIT
#error "the handler tests one bit"
#endif

#define ENGINE (step_engines + CONFIG_PIXEL_CLOCK_AXIS * STEP_ISR_ENGINE_SIZE)
#define QUEUE  pixel_clock_edges

; Z is the address of the queue's free entry, its index times CAPTURED_EDGE_SIZE; to `full` if none
; is. Uses r24.
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
#if CONFIG_AXES == 1
    lsl r30
    add r30, r24
    lsl r30
#else
    swap r30
    lsr r30
    sub r30, r24
#endif
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

; Where the engine is; then interrupts on.
.macro note_engine
    lds r3, ENGINE + STEP_ISR_LEFT
    sts QUEUE + CAPTURE_FIRST_LEFT, r3
    lds r3, ENGINE + STEP_ISR_TAIL
    sts QUEUE + CAPTURE_FIRST_TAIL, r3
    lds r3, ENGINE + STEP_ISR_IDLE_COUNT
    sei
    sts QUEUE + CAPTURE_FIRST_IDLE_LOW, r3
.endm

; Near the vector table, as the section of step_isr.S is.
.section .lowtext, "ax", @progbits
    .global VECTOR
    .type VECTOR, @function
VECTOR:
    sbic GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    rjmp .Lcrowded
    sbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    sbis TIMER_FLAGS, OVERFLOW
    rjmp .Lnote
#if CONFIG_AXES == 1
    ; The interrupt of m + 1 comes behind NOP, and CLI before any other. Where it was a long one
    ; that of m + 2 comes too: a third one does not wait.
    sei
    nop
    cli
    sbis TIMER_FLAGS, OVERFLOW
    rjmp .Lwrapped_once
    sei
    nop
    cli
    sbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED_TWICE
.Lwrapped_once:
    sbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
#else
    lds r3, COUNT_LOW
    sts QUEUE + CAPTURE_FIRST_COUNTER, r3
    lds r3, COUNT_HIGH
    sts QUEUE + CAPTURE_FIRST_COUNTER + 1, r3
    lds r3, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r3
    sbic GPIOR0, FLAG_PIXEL_CLOCK_BEFORE
    rjmp .Lnote
    lds r3, ENGINE + STEP_ISR_STATE
    sbrc r3, PARKED_BIT
    rjmp .Lat_rest
    note_engine
    sbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED ; no sooner: the step interrupt waits
    push r24
    rjmp .Lsaved
.Lat_rest:
    in r3, TCNT0
    sei
    sts QUEUE + CAPTURE_FIRST_UNIT, r3
    sbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    push r24
    lds r24, ENGINE + STEP_ISR_LEFT
    sts QUEUE + CAPTURE_FIRST_LEFT, r24
    lds r24, ENGINE + STEP_ISR_TAIL
    sts QUEUE + CAPTURE_FIRST_TAIL, r24
    lds r24, ENGINE + STEP_ISR_IDLE_COUNT
    sts QUEUE + CAPTURE_FIRST_IDLE_LOW, r24
    rjmp .Lsaved
#endif
.Lnote:
    note_engine
    push r24
.Lsaved:
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
#if CONFIG_AXES > 1
    lds r18, ENGINE + STEP_ISR_IDLE_COUNT
    lds r24, ENGINE + STEP_ISR_IDLE_COUNT + 1
#endif
    in r19, TIMER_FLAGS
    sei
    sbrs r19, CAPTURED
    sbic GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    rjmp .Lsecond
.Lcounted_edge:
    std Z + CAPTURED_EDGE_TICKS, r20
    std Z + CAPTURED_EDGE_TICKS + 1, r21
#if CONFIG_AXES == 1
    ldi r19, 1
    sbis GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    rjmp .Lplaced
    sbic GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED_TWICE
    inc r19
    cpi r20, WAIT_MAX_TICKS
    sbci r21, 0
    brlo .Lplaced
    inc r19
#else
    sbis GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    rjmp .Lin_m
    lds r19, QUEUE + CAPTURE_FIRST_COUNTER
    cp r19, r20
    lds r19, QUEUE + CAPTURE_FIRST_COUNTER + 1
    cpc r19, r21
    ldi r19, 0
    brsh .Lplaced
.Lin_m:
    ldi r19, 1
#endif
.Lplaced:
    lds r20, QUEUE + CAPTURE_FIRST_IDLE_LOW
    std Z + CAPTURED_EDGE_IDLE_COUNT, r20
#if CONFIG_AXES > 1
    cp r18, r20                         ; the idle count of then: r24:r18 is that of now
    sbci r24, 0
    std Z + CAPTURED_EDGE_IDLE_COUNT + 1, r24
#endif
    lds r20, QUEUE + CAPTURE_FIRST_TAIL
    std Z + CAPTURED_EDGE_TAIL, r20
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
    ori r19, CAPTURED_EDGE_CUT
.Lwhole:
    std Z + CAPTURED_EDGE_LEFT_OR_CUT, r18
#if CONFIG_AXES > 1
    lds r24, ENGINE + STEP_ISR_STATE
    cpi r24, STEP_STATE_PARKED
    breq .Lparked
.Lcomplete:
#endif
    std Z + CAPTURED_EDGE_NOTES, r19
    publish
.Lleave:
    cbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
#if CONFIG_AXES == 1
    cbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED_TWICE
#endif
    .irp register, r31, r30, r21, r20, r19, r18, r24
    pop \register
    .endr
    out SREG, r24
    pop r24
    cli
#if CONFIG_AXES > 1
    cbi GPIOR0, FLAG_PIXEL_CLOCK_BEFORE
#endif
    cbi GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    cbi GPIOR0, FLAG_PIXEL_CLOCK_BUSY
    reti

#if CONFIG_AXES > 1
; The coarse clock's low 16 bits, as clock_look_units() makes them; the low byte is that of the
; beginning if it was noted.
.Lparked:
    cli
    in r18, TCNT0
    in r19, TIFR0
    in r20, GPIOR0
    lds r24, clock_overflows
    sei
    andi r19, 1 << TOV0
    andi r20, 1 << FLAG_CLOCK_COUNTING
    or r19, r20
    breq .Lcounted_units
    sbrs r18, 7
    inc r24
.Lcounted_units:
    sbis GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    rjmp .Lunits
    lds r19, QUEUE + CAPTURE_FIRST_UNIT
    cp r18, r19
    sbci r24, 0
    mov r18, r19
.Lunits:
    std Z + CAPTURED_EDGE_IDLE_COUNT, r18
    std Z + CAPTURED_EDGE_IDLE_COUNT + 1, r24
    ldi r19, CAPTURED_EDGE_WAS_PARKED
    rjmp .Lcomplete
#endif

.Lsecond:
#if SWITCH_CAPTURES
    in r24, ACSR
    sbrs r24, ACIC
    rjmp .Lleave
.Lcount_now:
    ; As above, so that no overflow waits behind the count: it lies in m.
    sei
    nop
    cli
    lds r20, COUNT_LOW
    lds r21, COUNT_HIGH
    sbic TIMER_FLAGS, OVERFLOW
    rjmp .Lcount_now
    lds r3, ENGINE + STEP_ISR_TRAIN_HIGH
    sts TOP_HIGH, r3
    note_engine
    cbi GPIOR0, FLAG_PIXEL_CLOCK_WRAPPED
    rjmp .Lcounted_edge
#else
    rjmp .Lleave
#endif

.Lfull:
    count_lost
    rjmp .Lleave
.Lcrowded:
    sbi GPIOR0, FLAG_PIXEL_CLOCK_OVERRUN
    sbi GPIOR0, FLAG_PIXEL_CLOCK_SECOND
    reti
