; SPDX-License-Identifier: MIT
; The step interrupt: the timer overflow of each axis, at the start of every period. The interrupt
; loads the next period into the double-buffered OCRnA and has the whole current period to do so.
; OCRnB makes the STEP edges themselves; nothing here moves an edge.
;
; The C that this file stands for is step_engine_next(). This file does its frequent cases and
; leaves commands to C:
;
;     if (left > 0) {                              a period of pulse train 0
;         OCRnA = train.sum >= 0 ? long : short;
;         if (TIFRn & TOVn) late();                the next period has begun meanwhile
;         train.sum += train.sum >= 0 ? train.after_long : train.after_short;
;         if (--left == 0) take the ring's next entry if it is a pulse train;
;     } else if (left < 0) {                       a period of pulse train 1, counted upwards
;         ...
;     } else if (ring->high[tail] < STEP_HIGH_TRAIN) {  a single period
;         OCRnA = ring->high[tail] << 8 | ring->low[tail];
;         if (TIFRn & TOVn) late();
;         tail++;
;     } else ...
;
; Registers. r2..r6 belong to these handlers: no other code uses them (cmake/avr.cmake) where these
; can come, so nothing is pushed. They hold nothing from one interrupt to the next.
;
;                pulse train               single period, and what is rare
;     r2         SREG of the interrupted program
;     r3         left                      r24 of the interrupted program
;     r4, r5     sum                       Z of the interrupted program
;     r6         scratch                   -
;     r24        -                         the entry's high byte, then scratch
;     Z          -                         the ring's slot at `tail`
;
; The paths:
;
;     overflow
;       |
;       +-- left > 0 -----> train_period 0 --+-- not the last one --------------------> reti
;       +-- left < 0 -----> train_period 1 --+-- the last one --> refill: take the next
;       |                                                         train, if there is one --> reti
;       +-- left == 0 ----> entry: the ring's slot at `tail`
;                             |
;                             +-- single period: load it ----------------------------> reti
;                             +-- pulse train: take it --> its first period, as above
;                             +-- command: execute it in C, the other interrupts on --> reti
;                             +-- empty: in a line halt, else count an idle period ---> reti
;
;     Each path looks at TOVn after it has written OCRnA. Set: the next period has begun already
;     and would repeat the current one, so too_late takes the pin from the timer before the edge.
;
; Cycles, ATmega328P (ATmega2560):
;
;                                     train 0   train 1   single period
;     interrupt response              4 (5)     4 (5)     4 (5)
;     rjmp in the vector table        2         2         2
;     save SREG, read left            3         3         3
;     which case?                     3         3         4
;     save r24, Z; find the entry     -         -         7
;     long or short? / its kind       4 or 5    4 or 5    2
;     load OCRnA                      4         4         7
;     has the next period begun?      2         2         2
;     advance sum / tail              12        12        3
;     count down                      4         4         -
;     restore, reti                   5 (6)     5 (6)     7 (8)
;                                     --        --        --
;                                     43-44     43-44     41
;                                    (45-46)   (45-46)   (43)
;
; The last period of an entry takes 38 cycles more on the ATmega328P, on the ATmega2560 30 if the
; train goes on and 33 if another one follows.
;
; TEMP, the high byte that a write of OCRnAL takes along, holds train_high during a pulse train: a
; train's two intervals differ in their low byte only. Whoever else reads or writes a 16-bit
; register of this timer then stores train_high in TEMP again, by way of OCRnAH.
;
; Bits are named after timer 1. They have the same places in every 16-bit timer.
#define __SFR_OFFSET 0
#include <avr/io.h>

#include "avr/hal/board.h"     // BOARD_FILE
#include "avr/hal/flag_bits.h" // FLAG_*
#include "avr/hal/step_isr.h"  // STEP_*, QUIET_TICKS
#include "layout.h"            // STEP_ISR_*

; Save what a C function may change beyond what the handler has saved, call the function, restore.
.macro call_c function
    .irp register, r0, r1, r18, r19, r20, r21, r22, r23, r25, r26, r27
    push \register
    .endr
    clr r1
    call \function
    .irp register, r27, r26, r25, r23, r22, r21, r20, r19, r18, r1, r0
    pop \register
    .endr
.endm

; The same for what takes some hundred cycles. Meanwhile the interrupts of the other axes are
; served, those of this timer are not. `mask` is TIMSKn.
.macro call_c_nested function, mask
    push r2
    push r3
    push r4
    push r5
    lds r24, \mask
    push r24
    clr r24
    sts \mask, r24
    sei
    call_c \function
    cli
    pop r24
    sts \mask, r24
    pop r5
    pop r4
    pop r3
    pop r2
.endm

; After a halt the overflow interrupt gives way to the compare A interrupt of the same instant. Its
; handler does not look at the ring (step_timer.c), to which the writer may still be adding.
.macro give_way mask
    lds r24, \mask
    andi r24, ~(1 << TOIE1)
    ori r24, 1 << OCIE1A
    sts \mask, r24
.endm

; A halt was requested while C took a command, whether by an empty ring or from outside: cut off
; the rest of a pulse train that C has taken since (step_engine_halt() in step_engine.h). Interrupts
; are off, and stay off until the handler returns.
.macro halt_if_requested engine, mask
    lds r24, \engine + STEP_ISR_STOP
    and r24, r24
    breq .Lgoes_on\@
    lds r24, \engine + STEP_ISR_LEFT
    sts \engine + STEP_ISR_CUT, r24
    ldi r24, 0
    sts \engine + STEP_ISR_LEFT, r24
    ldi r24, STEP_STATE_HALTING
    sts \engine + STEP_ISR_STATE, r24
    give_way \mask
.Lgoes_on\@:
.endm

; One interval of a pulse train, then the sum behind it. r5: high byte of the sum.
.macro train_interval axis, engine, train, name, kind, low, after, count, top_low, flags, flag
    lds r6, \train + \low
    sts \top_low, r6
    sbic \flags, \flag
#if CONFIG_AXES == 1
    rjmp .Llate\axis
#else
    rjmp .Llate_\kind\()_\name\axis
.Lmade_up_\kind\()_\name\axis:
    sts step_isr_last + \axis, r6
#endif
    train_advance \train, \after
    train_leave \axis, \engine, \name, \count
.endm

; The sum behind an interval: whether the next one is long.
.macro train_advance train, after
    lds r4, \train + STEP_ISR_SUM
    lds r6, \train + \after
    add r4, r6
    sts \train + STEP_ISR_SUM, r4
    lds r6, \train + \after + 1
    adc r5, r6
    sts \train + STEP_ISR_SUM + 1, r5
.endm

; Count the period and return; behind the last one look for the next train. count: dec or inc.
.macro train_leave axis, engine, name, count
    \count r3
    breq .Llast\@
    sts \engine + STEP_ISR_LEFT, r3
    out SREG, r2
    reti
.Llast\@:
    rjmp .Lrefill_\name\axis
.endm

; A period of the pulse train `train` (struct pulse_train).
.macro train_period axis, engine, train, name, count, top_low, flags, flag
    lds r5, \train + STEP_ISR_SUM + 1
.Lperiod_\name\axis:
    and r5, r5
    brmi .Lshort\@
    train_interval \axis, \engine, \train, \name, long, STEP_ISR_LONG_LOW, \
        STEP_ISR_AFTER_LONG, \count, \top_low, \flags, \flag
.Lshort\@:
    train_interval \axis, \engine, \train, \name, short, STEP_ISR_SHORT_LOW, \
        STEP_ISR_AFTER_SHORT, \count, \top_low, \flags, \flag
.endm

; Save r24 and Z, then find the ring's next entry: Z is its slot, r24 its high byte. The flags
; compare this byte with STEP_HIGH_TRAIN.
.macro find_entry axis, engine
    mov r3, r24
    movw r4, r30
    lds r30, \engine + STEP_ISR_TAIL
    ldi r31, hi8(step_rings + \axis * STEP_ISR_RING_SIZE + STEP_ISR_HIGH_OFFSET)
    ld r24, Z
    cpi r24, STEP_HIGH_TRAIN
.endm

.macro restore_r24_z
    movw r30, r4
    mov r24, r3
.endm

; The entry at Z is a pulse train's: take its count. Flags: of the count, negative for train 1.
.macro take_count engine
    dec r31
    ld r24, Z
    sts \engine + STEP_ISR_LEFT, r24
    inc r30
    sts \engine + STEP_ISR_TAIL, r30
    and r24, r24
.endm

.macro load_train_high engine, top_high
    sts \engine + STEP_ISR_TRAIN_HIGH, r24
    sts \top_high, r24
.endm

; The entry at Z is a pulse train's: begin the train and load the high byte of its intervals.
.macro take_train engine, top_high
    take_count \engine
    lds r24, \engine + STEP_ISR_TRAINS + STEP_ISR_TOP_HIGH
    brpl .Lfirst\@
    lds r24, \engine + STEP_ISR_TRAINS + STEP_ISR_TRAIN_SIZE + STEP_ISR_TOP_HIGH
.Lfirst\@:
    load_train_high \engine, \top_high
.endm

; Behind the last period of an entry take the next one, if it is a train's: a period ahead, so that
; one train follows another without a longer path. A train that goes on keeps its high byte; one
; that follows another is the other one. other: brmi behind train 0, brpl behind train 1.
#if CONFIG_AXES > 1
.macro refill_leave axis, late
    restore_r24_z
    .if \late
    jmp .Lagain\axis
    .else
    out SREG, r2
    reti
    .endif
.endm

.macro refill axis, engine, other, other_train, top_high, out, spent, late=0
    find_entry \axis, \engine
    brne \spent\axis
    take_count \engine
    \other .Lother\@
\out:
    refill_leave \axis, \late
.Lother\@:
    lds r24, \other_train + STEP_ISR_TOP_HIGH
    lds r30, \engine + STEP_ISR_TRAIN_HIGH
    cpse r24, r30
    rjmp .Lanother_high\@
    refill_leave \axis, \late
.Lanother_high\@:
    load_train_high \engine, \top_high
    call .Lanother_high\axis
    rjmp \out
.endm
#endif

; Load an idle period. First of all disable its edge: the current period may be the shortest one.
.macro load_idle top_low, top_high, edge_low, edge_high
    ldi r24, hi8(QUIET_TICKS)           ; its low byte is the same
    sts \edge_high, r24
    sts \edge_low, r24
    ldi r24, hi8(STEP_IDLE_TICKS - 1)
    sts \top_high, r24
    ldi r24, lo8(STEP_IDLE_TICKS - 1)
    sts \top_low, r24
.endm

.macro count_idle engine
    lds r30, \engine + STEP_ISR_IDLE_COUNT
    lds r31, \engine + STEP_ISR_IDLE_COUNT + 1
    adiw r30, 1
    sts \engine + STEP_ISR_IDLE_COUNT, r30
    sts \engine + STEP_ISR_IDLE_COUNT + 1, r31
.endm

#if CONFIG_AXES > 1
#include "avr/hal/step_catch_up.inc" // the ways of a late interval
#endif

.macro step_handler axis, engine, vector, top_low, top_high, edge_low, edge_high, \
    control, flags, flag, mask
    .type step_isr_entry_\axis, @function
step_isr_entry_\axis:
    find_entry \axis, \engine
    brsh .Lnear\axis
    sts \top_high, r24
    dec r31
    ld r24, Z
    sts \top_low, r24
    sbic \flags, \flag
#if CONFIG_AXES == 1
    rjmp .Llate_entry\axis
#else
    rjmp .Llate_single\axis
.Lentry_loaded\axis:
#endif
    inc r30
    sts \engine + STEP_ISR_TAIL, r30
    restore_r24_z
    out SREG, r2
    reti
.Lnear\axis:
    rjmp .Lrare\axis

    .global \vector
    .type \vector, @function
\vector:
    in r2, SREG
.Lagain\axis:
    lds r3, \engine + STEP_ISR_LEFT
    and r3, r3
    brmi .Lsecond\axis
    breq step_isr_entry_\axis
    train_period \axis, \engine, \engine + STEP_ISR_TRAINS, 0_, dec, \top_low, \flags, \flag
.Lsecond\axis:
    train_period \axis, \engine, \engine + STEP_ISR_TRAINS + STEP_ISR_TRAIN_SIZE, 1_, inc, \
        \top_low, \flags, \flag

#if CONFIG_AXES == 1
.Lrefill_0_\axis:
.Lrefill_1_\axis:
    find_entry \axis, \engine
    brne .Lspent\axis
    take_train \engine, \top_high
.Lout\axis:
    restore_r24_z
    out SREG, r2
    reti
.Lspent\axis:
    ldi r24, 0
    sts \engine + STEP_ISR_LEFT, r24
    rjmp .Lout\axis
#else
.Lrefill_0_\axis:
    refill \axis, \engine, brmi, \engine + STEP_ISR_TRAINS + STEP_ISR_TRAIN_SIZE, \top_high, \
        .Lout\axis, .Lspent
.Lspent\axis:
    ldi r24, 0
    sts \engine + STEP_ISR_LEFT, r24
    rjmp .Lout\axis
.Lrefill_1_\axis:
    refill \axis, \engine, brpl, \engine + STEP_ISR_TRAINS, \top_high, .Lout_1_\axis, .Lspent
#endif

.Lrare\axis:
    brne .Lcommand\axis
    take_train \engine, \top_high
#if CONFIG_AXES > 1
    ldi r24, 0
    sts step_isr_last + \axis, r24
    ldi r24, STEP_ISR_UNKNOWN
    sts step_isr_before_high + \axis, r24
#endif
    restore_r24_z
    rjmp .Lagain\axis

.Lcommand\axis:
    cpi r24, STEP_HIGH_COMMAND
    breq step_isr_execute_\axis
    ; Empty. In a line that is a fault; else one more idle period, which the registers hold already.
    lds r24, \engine + STEP_ISR_STATE
    cpi r24, STEP_STATE_IN_LINE
    breq .Lhalt\axis
    count_idle \engine
.Lloaded\axis:
    sbis \flags, \flag
    rjmp .Lout\axis
    rjmp .Llate_entry\axis

.Lhalt\axis:
    load_idle \top_low, \top_high, \edge_low, \edge_high
    sbic \flags, \flag
    rjmp .Llate_entry\axis
    ldi r24, STEP_STATE_HALTED
    sts \engine + STEP_ISR_STATE, r24
    ldi r24, 0
    sts \engine + STEP_ISR_PULSE, r24
    count_idle \engine
    ; A stale flag would count this period twice.
    ldi r24, 1 << OCF1A
    out \flags, r24
    give_way \mask
    rjmp .Lout\axis

    .type step_isr_execute_\axis, @function
step_isr_execute_\axis:
    call_c_nested step_isr_command_\axis, \mask
    halt_if_requested \engine, \mask
    rjmp .Lloaded\axis

.Llate_entry\axis:
    restore_r24_z
    ; The current period has begun again, in place of the next one: take the pin from the timer, so
    ; that it makes no edge.
.Llate\axis:
    .type step_isr_too_late_\axis, @function
step_isr_too_late_\axis:
    mov r3, r24
    ldi r24, 1 << WGM11 | 1 << WGM10
    sts \control, r24
    push r3
    push r30
    push r31
    call_c step_isr_late_\axis
    pop r31
    pop r30
    pop r24
    out SREG, r2
    reti
.endm

; Compare A, at the end of every period of a halted axis: the next period is an idle one, and its
; edge is disabled 13 cycles behind the flag's service. 42 cycles (44) in all. LOAD_IDLE in
; step_timer.c is the same in C.
.macro halted_handler engine, vector, top_low, top_high, edge_low, edge_high, flags, flag
    .global \vector
    .type \vector, @function
\vector:
    in r2, SREG
    mov r3, r24
    load_idle \top_low, \top_high, \edge_low, \edge_high
    ldi r24, 1 << \flag
    out \flags, r24
    ldi r24, STEP_STATE_HALTED
    sts \engine + STEP_ISR_STATE, r24
    movw r4, r30
    count_idle \engine
    restore_r24_z
    out SREG, r2
    reti
.endm

; This section lies near the vector table, so that the linker can shorten the table's jumps
; (-mrelax) by a cycle each.
.section .lowtext, "ax", @progbits
#define ENGINE(axis) step_engines + axis * STEP_ISR_ENGINE_SIZE
#define HANDLER(axis, timer)                                                             \
    step_handler axis, ENGINE(axis), TIMER##timer##_OVF_vect, OCR##timer##AL,             \
        OCR##timer##AH, OCR##timer##BL, OCR##timer##BH, TCCR##timer##A, TIFR##timer,      \
        TOV##timer, TIMSK##timer
#define BOARD_PIN(signal, axis, port, bit, header_pin)
#define BOARD_AXIS(axis, timer) HANDLER(axis, timer)
#include BOARD_FILE
#undef BOARD_AXIS

#if CONFIG_AXES > 1
; In the reach of the handlers' rjmp, each of them.
#define CATCH_UP(axis, timer)                                                            \
    make_up_ways axis, ENGINE(axis), TCNT##timer##L, TIFR##timer
#define BOARD_AXIS(axis, timer) CATCH_UP(axis, timer)
#include BOARD_FILE
#undef BOARD_AXIS
#define CATCH_UP_RARELY(axis, timer)                                                     \
    catch_up axis, ENGINE(axis), TCNT##timer##L                                         $ \
    set_counter_high axis, ENGINE(axis), TCNT##timer##L, OCR##timer##AH                 $ \
    stretch axis, ENGINE(axis), TCNT##timer##L, OCR##timer##AL, OCR##timer##AH,           \
        OCR##timer##BL, OCR##timer##BH, TIFR##timer, TOV##timer                         $ \
    catch_up_entry axis, ENGINE(axis)                                                   $ \
    make_up_fast_ways axis, ENGINE(axis), TCNT##timer##L, OCR##timer##AL,                   \
        OCR##timer##AH, TIFR##timer, TOV##timer
#define BOARD_AXIS(axis, timer) CATCH_UP_RARELY(axis, timer)
#include BOARD_FILE
#undef BOARD_AXIS
#endif

#define HALTED_HANDLER(axis, timer)                                                       \
    halted_handler ENGINE(axis), TIMER##timer##_COMPA_vect, OCR##timer##AL,               \
        OCR##timer##AH, OCR##timer##BL, OCR##timer##BH, TIFR##timer, TOV##timer
#define BOARD_AXIS(axis, timer) HALTED_HANDLER(axis, timer)
#include BOARD_FILE
