; SPDX-License-Identifier: MIT
; The step interrupt: timer overflow of each axis, at the start of every period. It loads the next
; period into the double-buffered OCRnA and has this whole period to do so. The STEP edges
; themselves are made by OCRnB; nothing here moves them.
;
; The C it stands for is step_engine_next(); this does its frequent cases and leaves commands to C:
;
;     if (left > 0) {                              a run, carried on here
;         OCRnA = run.sum >= 0 ? long : short;
;         if (TIFRn & TOVn) late();                the next period began meanwhile
;         run.sum += run.sum >= 0 ? run.after_long : run.after_short;
;         if (--left == 0) take the ring's next entry if it is a run;
;     } else if (left < 0) {                       the other run, counted upwards
;         ...
;     } else if (ring->high[tail] < STEP_HIGH_RUN) {  a single period
;         OCRnA = ring->high[tail] << 8 | ring->low[tail];
;         if (TIFRn & TOVn) late();
;         tail++;
;     } else ...
;
; r2..r6 belong to these handlers: no other code uses them (cmake/avr.cmake), so nothing is pushed.
; Nothing lives in them from one interrupt to the next.
;
;     r2 SREG of the interrupted program, r3 left / r24 of the interrupted program,
;     r4:r5 sum / Z of the interrupted program, r6 scratch
;
; Cycles, ATmega328P (ATmega2560):
;
;                                     run 0     run 1     single period
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
; TEMP, the high byte that a write of OCRnAL takes along, holds run_high while a run is carried: a
; run's two intervals differ in their low byte only, and whoever else reads or writes a 16-bit
; register of this timer stores run_high there again (OCRnAH).
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
; interrupts are not.
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

; After a halt the overflow interrupt gives way to the compare A interrupt of the same instant,
; whose handler does not look at the ring (step_timer.c): the writer may still be adding to it.
.macro give_way mask
    lds r24, \mask
    andi r24, ~(1 << TOIE1)
    ori r24, 1 << OCIE1A
    sts \mask, r24
.endm

; Halted while a command was taken, whether by an empty ring or from outside: the rest of a run
; that was taken since is cut off (step_engine_halt() in step_engine.h). Interrupts are off, and
; stay so until the handler is left.
.macro halt_if_told engine, mask
    lds r24, \engine + STEP_ISR_STOP
    and r24, r24
    breq .Lgoes\@
    lds r24, \engine + STEP_ISR_LEFT
    sts \engine + STEP_ISR_CUT, r24
    ldi r24, 0
    sts \engine + STEP_ISR_LEFT, r24
    ldi r24, 3
    sts \engine + STEP_ISR_STATE, r24
    give_way \mask
.Lgoes\@:
.endm

; One interval of a run, then the sum behind it. r5: high byte of the run's sum.
.macro run_interval axis, run, low, after, top_low, flags, flag
    lds r6, \run + \low
    sts \top_low, r6
    sbic \flags, \flag
    rjmp .Llate\axis
    lds r4, \run + STEP_ISR_SUM
    lds r6, \run + \after
    add r4, r6
    sts \run + STEP_ISR_SUM, r4
    lds r6, \run + \after + 1
    adc r5, r6
    sts \run + STEP_ISR_SUM + 1, r5
.endm

; Count the period off and leave; look for what comes next after the last one. count: dec or inc.
.macro run_leave axis, engine, count
    \count r3
    sts \engine + STEP_ISR_LEFT, r3
    breq .Llast\@
    out SREG, r2
    reti
.Llast\@:
    rjmp .Lrefill\axis
.endm

.macro run_period axis, engine, run, count, top_low, flags, flag
    lds r5, \run + STEP_ISR_SUM + 1
    and r5, r5
    brmi .Lshort\@
    run_interval \axis, \run, STEP_ISR_LONG_LOW, STEP_ISR_AFTER_LONG, \top_low, \flags, \flag
    run_leave \axis, \engine, \count
.Lshort\@:
    run_interval \axis, \run, STEP_ISR_SHORT_LOW, STEP_ISR_AFTER_SHORT, \top_low, \flags, \flag
    run_leave \axis, \engine, \count
.endm

; r24 and Z make room for the ring's next entry: Z there, r24 its high byte, flags as against a run.
.macro find_entry axis, engine
    mov r3, r24
    movw r4, r30
    lds r30, \engine + STEP_ISR_TAIL
    ldi r31, hi8(step_rings + \axis * STEP_ISR_RING_SIZE + STEP_ISR_HIGH_OFFSET)
    ld r24, Z
    cpi r24, 0xFD
.endm

.macro restore_r24_z
    movw r30, r4
    mov r24, r3
.endm

; The entry at Z is a run's: what follows is carried here.
.macro take_run engine, top_high
    dec r31
    ld r24, Z
    sts \engine + STEP_ISR_LEFT, r24
    inc r30
    sts \engine + STEP_ISR_TAIL, r30
    and r24, r24
    lds r24, \engine + STEP_ISR_RUNS + STEP_ISR_TOP_HIGH
    brpl .Lfirst\@
    lds r24, \engine + STEP_ISR_RUNS + STEP_ISR_RUN_SIZE + STEP_ISR_TOP_HIGH
.Lfirst\@:
    sts \engine + STEP_ISR_RUN_HIGH, r24
    sts \top_high, r24
.endm

; An idle period into the registers. First of all no edge in it: the running period may be the
; shortest one.
.macro load_idle top_low, top_high, edge_low, edge_high
    ldi r24, 0xFF
    sts \edge_high, r24
    sts \edge_low, r24
    ldi r24, hi8(4096 - 1)
    sts \top_high, r24
    ldi r24, lo8(4096 - 1)
    sts \top_low, r24
.endm

.macro count_idle engine
    lds r30, \engine + STEP_ISR_IDLE_COUNT
    lds r31, \engine + STEP_ISR_IDLE_COUNT + 1
    adiw r30, 1
    sts \engine + STEP_ISR_IDLE_COUNT, r30
    sts \engine + STEP_ISR_IDLE_COUNT + 1, r31
.endm

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
    rjmp .Llate_entry\axis
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
    run_period \axis, \engine, \engine + STEP_ISR_RUNS, dec, \top_low, \flags, \flag
.Lsecond\axis:
    run_period \axis, \engine, \engine + STEP_ISR_RUNS + STEP_ISR_RUN_SIZE, inc, \
        \top_low, \flags, \flag

    ; Looked for one period ahead, so that one run follows another without a longer way.
.Lrefill\axis:
    find_entry \axis, \engine
    brne .Lout\axis
    take_run \engine, \top_high
.Lout\axis:
    restore_r24_z
    out SREG, r2
    reti

.Lrare\axis:
    brne .Lcommand\axis
    take_run \engine, \top_high
    restore_r24_z
    rjmp .Lagain\axis

.Lcommand\axis:
    cpi r24, 0xFE
    breq step_isr_obey_\axis
    ; Empty. In a line that is a fault; else one more idle period, already in the registers.
    lds r24, \engine + STEP_ISR_STATE
    cpi r24, 1
    breq .Lhalt\axis
    count_idle \engine
.Lloaded\axis:
    sbis \flags, \flag
    rjmp .Lout\axis
    rjmp .Llate_entry\axis

    ; No edge in the next period: first of all, the interval may be the shortest one.
.Lhalt\axis:
    load_idle \top_low, \top_high, \edge_low, \edge_high
    sbic \flags, \flag
    rjmp .Llate_entry\axis
    ldi r24, 2
    sts \engine + STEP_ISR_STATE, r24
    ldi r24, 0
    sts \engine + STEP_ISR_PULSE, r24
    count_idle \engine
    ; A stale flag would count this period twice.
    ldi r24, 1 << OCF1A
    out \flags, r24
    give_way \mask
    rjmp .Lout\axis

    .type step_isr_obey_\axis, @function
step_isr_obey_\axis:
    call_c_nested step_isr_command_\axis, \mask
    halt_if_told \engine, \mask
    rjmp .Lloaded\axis

.Llate_entry\axis:
    restore_r24_z
    ; The period that should be another one has begun: no edge in it.
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

; Compare A, at the end of every period of a halted axis: the next one is an idle one. First of all
; no edge in it, 13 cycles behind the flag's service, because the period that runs may be the
; shortest. 42 cycles (44) in all. LOAD_IDLE in step_timer.c is the same in C.
.macro halted_handler engine, vector, top_low, top_high, edge_low, edge_high, flags, flag
    .global \vector
    .type \vector, @function
\vector:
    in r2, SREG
    mov r3, r24
    load_idle \top_low, \top_high, \edge_low, \edge_high
    ldi r24, 1 << \flag
    out \flags, r24
    ldi r24, 2
    sts \engine + STEP_ISR_STATE, r24
    movw r4, r30
    count_idle \engine
    restore_r24_z
    out SREG, r2
    reti
.endm

; Near the vector table: the linker makes its jumps short ones (-mrelax), a cycle less.
.section .lowtext, "ax", @progbits
#define HANDLER(axis, timer)                                                             \
    step_handler axis, step_engines + axis * STEP_ISR_ENGINE_SIZE, TIMER##timer##_OVF_vect, \
        OCR##timer##AL, OCR##timer##AH, OCR##timer##BL, OCR##timer##BH, TCCR##timer##A,   \
        TIFR##timer, TOV##timer, TIMSK##timer
#define BOARD_PIN(signal, axis, port, bit, header_pin)
#define BOARD_AXIS(axis, timer) HANDLER(axis, timer)
#include BOARD_FILE
#undef BOARD_AXIS

#define HALTED_HANDLER(axis, timer)                                                       \
    halted_handler step_engines + axis * STEP_ISR_ENGINE_SIZE, TIMER##timer##_COMPA_vect, \
        OCR##timer##AL, OCR##timer##AH, OCR##timer##BL, OCR##timer##BH, TIFR##timer, TOV##timer
#define BOARD_AXIS(axis, timer) HALTED_HANDLER(axis, timer)
#include BOARD_FILE
