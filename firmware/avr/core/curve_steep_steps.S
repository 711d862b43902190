; SPDX-License-Identifier: MIT
; Batches of steep steps: the assembly half of curve_steep.c. The C that this file stands for is
; steps() and one_step() there; curve_steep.h explains the numbers:
;
;     uint8_t curve_steep_steps(struct curve_steep *steep, volatile uint8_t *low, uint8_t count)
;
;     r0, r1       products, scratch              r20..r23, r15  difference (r15 its lowest byte)
;     r7           steps still to make            r24..r27       bend, then 2h and scratch
;     r8..r12      residual                       Y              steep
;     r13, r14     0, sign of h                   Z              next entry's low byte
;     r16, r17     h                              T              set: this is the first entry
;     r18, r19     ticks, or one less
;
; The sum of the ticks is in *steep, like everything that does not change. The caller stores the
; high byte of the first entry, which makes the batch visible to the step interrupt.
;
; Cycles of a step:
;
;     guess: as far from the last interval as that from the one before   10
;     bend = h * ticks                                                   17
;     residual += bend + (difference + bend) * ticks - T * T             68
;     difference += 2 * bend                                              5
;     0 <= residual < difference? (the upper 16 bits nearly always do)    3
;     into the ring                                                      11
;     sum of the ticks                                                   11
;     another one?                                                        4
;                                                                       ---
;     a step whose guess is right                                       129
;     a guess one tick too short, besides                                43
;     a guess one tick too long, besides                                 57
;     each further tick more 15, each further tick less                  20
;
; The paths through a step:
;
;     step --> guess right? -- yes ----------> put --> first entry? -- no --> store the high byte
;       ^        | no                           ^        | yes                  |
;       |      wrong: a tick more (longer) or   |      keep it for the caller   |
;       |        less (shorter) until it fits   |        |                      |
;       |        |                              |        +-------> sum <--------+
;       |      corrected: missed by too much? --+                   |
;       |        then this step is the last one                   another one?
;       +-------------------------------------------------- yes ----+---- no --> over
#include "avr/core/asm.inc" // macros
#include "layout.h" // offsets

#define LEFT  r7 /* steps still to make */
#define V0    r8 /* residual */
#define V1    r9
#define V2    r10
#define V3    r11
#define V4    r12
#define ZERO  r13
#define SIGN  r14 /* of h */
#define D0    r15 /* difference */
#define H0    r16 /* h */
#define H1    r17
#define N0    r18 /* ticks, or one less */
#define N1    r19
#define D1    r20
#define D2    r21
#define D3    r22
#define D4    r23
#define P0    r24 /* bend, then 2h and scratch */
#define P1    r25
#define P2    r26
#define P3    r27
#define VALUE V0, V1, V2, V3, V4
#define DIFF  D0, D1, D2, D3, D4
#define BEND  P0, P1, P2, P3, SIGN
#define TWICE_HALF P0, P1, SIGN, SIGN, SIGN

    .section .text.curve_steep_steps, "ax", @progbits
function curve_steep_steps
    save_registers 7                    ; 26
    movw r28, r24                       ; 3
    movw r30, r22
    mov LEFT, r20
    clr ZERO                            ; 3
    clr SIGN
    set                                 ;    the first one
    std Y + CURVE_STEEP_SUM, ZERO       ; 6
    std Y + CURVE_STEEP_SUM + 1, ZERO
    std Y + CURVE_STEEP_SUM + 2, ZERO
    load_wide CURVE_STEEP_RESIDUAL, VALUE ; 30
    load_wide CURVE_STEEP_SLOPE, DIFF
    load_plain CURVE_STEEP_HALF, H0, H1
    load_plain CURVE_STEEP_LAST, N0, N1
    sbrc H1, 7                          ; 2
    com SIGN
    movw P0, H0                         ; 8  difference = slope - 2h
    lsl P0
    rol P1
    sub_number DIFF, TWICE_HALF
    subi N0, 1                          ; 2  top
    sbci N1, 0

steep_step:
    cpi D4, CURVE_STEEP_LIMIT           ; 3  40 bits are enough?
    brlo 1f
    rjmp steep_leave
1:  load_plain CURVE_STEEP_CHANGE, r0, r1 ; 7  ticks = top + 1 + change
    sec
    adc N0, r0
    adc N1, r1
    mul H0, N0                          ; 3  bend = h * ticks
    movw P0, r0
    mulsu H1, N1                        ; 3
    movw P2, r0
    mulsu H1, N0                        ; 6
    sbc P3, ZERO
    add P1, r0
    adc P2, r1
    adc P3, ZERO
    add_product H0, N1, ZERO, P1, P2, P3 ; 5
    add_number VALUE, BEND              ; 5  residual += bend
    add_number DIFF, BEND               ; 5  difference += bend
    plain_op sub, sbc, r0, CURVE_STEEP_STEP, VALUE ; 15 residual -= T * T
    add_product D0, N0, ZERO, V0, V1, V2, V3, V4 ; 7 residual += difference * ticks
    add_product D1, N0, ZERO, V1, V2, V3, V4 ; 6
    add_product D2, N0, ZERO, V2, V3, V4 ; 5
    add_product D3, N0, ZERO, V3, V4    ; 4
    add_product D4, N0, ZERO, V4        ; 3
    add_product D0, N1, ZERO, V1, V2, V3, V4 ; 6
    add_product D1, N1, ZERO, V2, V3, V4 ; 5
    add_product D2, N1, ZERO, V3, V4    ; 4
    add_product D3, N1, ZERO, V4        ; 3
    add_number DIFF, BEND               ; 5  difference += bend
    cp V3, D3                           ; 3  a negative value is larger, too
    cpc V4, D4
    brsh steep_wrong
steep_put:
    subi N0, 1                          ; 2  top
    sbci N1, 0
    brmi steep_too_long                 ; 1
steep_store:
    st Z, N0                            ; 2
    brts steep_first                    ; 1
    inc r31                             ; 4
    st Z, N1
    dec r31
steep_sum:
    ldd r0, Y + CURVE_STEEP_SUM         ; 11
    add r0, N0
    std Y + CURVE_STEEP_SUM, r0
    ldd r0, Y + CURVE_STEEP_SUM + 1
    adc r0, N1
    std Y + CURVE_STEEP_SUM + 1, r0
    brcs steep_carry
steep_next:
    inc r30                             ; 1
    dec LEFT                            ; 4
    breq steep_end
    rjmp steep_step

steep_end:
    rjmp steep_leave

steep_carry:
    ldd r0, Y + CURVE_STEEP_SUM + 2
    inc r0
    std Y + CURVE_STEEP_SUM + 2, r0
    rjmp steep_next

steep_first:                            ;    the caller stores the high byte
    clt
    std Y + CURVE_STEEP_FIRST_HIGH, N1
    rjmp steep_sum

steep_too_long:                         ; too long to extrapolate from
    rcall steep_make_last
    rjmp steep_store

steep_make_last:                        ;    this step is the last one
    std Y + CURVE_STEEP_GOOD, ZERO
    mov LEFT, ZERO
    inc LEFT
    ret

; A wrong guess: r0 counts the corrections.
steep_wrong:
    clr r0                              ; 1
    movw P0, H0                         ; 3  2h
    lsl P0
    rol P1
    tst V4                              ; 2
    brpl steep_compare
steep_longer:                           ;    a tick more
    inc r0                              ; 1
    subi N0, lo8(-1)                    ; 2  ticks++
    sbci N1, hi8(-1)
    add_number DIFF, TWICE_HALF         ; 5  difference += 2h
    add_number VALUE, DIFF              ; 5  residual += difference
    brmi steep_longer                   ; 2
    rjmp steep_corrected                ; 2

steep_shorter:                          ;    a tick less
    dec r0                              ; 1
    subi N0, 1                          ; 2  ticks--
    sbci N1, 0
    sub_number VALUE, DIFF              ; 5  residual -= difference
    sub_number DIFF, TWICE_HALF         ; 5  difference -= 2h
steep_compare:
    compare_number VALUE, DIFF          ; 5
    brsh steep_shorter                  ; 2
    tst r0                              ; 2  the upper bits alone were equal
    brne steep_corrected
    rjmp steep_put
steep_corrected:
    clr r1                              ; 3
    sbrc r0, 7
    com r1
    mov P0, r0                          ; 1
    load_plain CURVE_STEEP_CHANGE, P2, P3 ; 10 change += corrections
    add P2, r0
    adc P3, r1
    store_plain CURVE_STEEP_CHANGE, P2, P3
    subi P0, -CURVE_STEEP_MISS_MAX      ; 4  too many?
    cpi P0, 2 * CURVE_STEEP_MISS_MAX + 1
    brlo 1f
    rcall steep_make_last
1:  rjmp steep_put

steep_leave:
    movw P0, H0                         ; 8  slope = difference + 2h
    lsl P0
    rol P1
    add_number DIFF, TWICE_HALF
    store_wide CURVE_STEEP_RESIDUAL, VALUE ; 20
    store_wide CURVE_STEEP_SLOPE, DIFF
    subi N0, lo8(-1)                    ; 6  ticks
    sbci N1, hi8(-1)
    store_plain CURVE_STEEP_LAST, N0, N1
    mov r24, r30                        ; 2
    clr r1
    restore_registers 7                 ; 26
    ret                                 ; 4
end_function curve_steep_steps
