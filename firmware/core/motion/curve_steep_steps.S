; SPDX-License-Identifier: MIT
; Batches of steep steps: the assembly half of curve_steep.c, where its C stands.
;
;     uint8_t curve_steep_steps(struct curve_steep *steep, volatile uint8_t *low, uint8_t count)
;
; Everything that changes is in registers, but for the sum of ticks. r2..r6 are left alone: they
; are the step interrupt's. An interrupt may come between any two instructions.
;
; Cycles of a step:
;
;     guess: as far from the last interval as that from the one before   10
;     bend = h * ticks                                                   17
;     residual += bend + (difference + bend) * ticks - T * T             68
;     difference += 2 * bend                                              5
;     0 <= residual < difference? (upper 16 bits will nearly always do)   3
;     into the ring                                                      11
;     sum of ticks                                                       11
;     another one?                                                        4
;                                                                       ---
;     a step whose guess is right                                       129
;     a wrong guess, besides                                             27
;     a tick more 15, a tick less                                        20
#include "motion/curve_steep_layout.h"

#define LOW CURVE_STEEP_WIDE_LOW

#define LEFT  r7                 /* steps still to make */
#define V0    r8                 /* residual */
#define V1    r9
#define V2    r10
#define V3    r11
#define V4    r12
#define ZERO  r13
#define SIGN  r14                /* of h */
#define D0    r15                /* difference */
#define H0    r16                /* h */
#define H1    r17
#define N0    r18                /* ticks, or one less */
#define N1    r19
#define D1    r20
#define D2    r21
#define D3    r22
#define D4    r23
#define P0    r24                /* bend, then 2h and something for a moment */
#define P1    r25
#define P2    r26
#define P3    r27
#define VALUE V0, V1, V2, V3, V4
#define DIFF  D0, D1, D2, D3, D4
#define BEND  P0, P1, P2, P3, SIGN
#define TWICE_HALF P0, P1, SIGN, SIGN, SIGN

.macro add5 a0, a1, a2, a3, a4, b0, b1, b2, b3, b4
    add \a0, \b0
    adc \a1, \b1
    adc \a2, \b2
    adc \a3, \b3
    adc \a4, \b4
.endm

.macro sub5 a0, a1, a2, a3, a4, b0, b1, b2, b3, b4
    sub \a0, \b0
    sbc \a1, \b1
    sbc \a2, \b2
    sbc \a3, \b3
    sbc \a4, \b4
.endm

; a... += b * c
.macro add_product b, c, a0, a1, others:vararg
    mul \b, \c
    add \a0, r0
    adc \a1, r1
    .irp reg, \others
    adc \reg, ZERO
    .endr
.endm

; V += or -= one byte of the struct
.macro with_byte op, reg, at
    ldd r0, Y + \at
    \op \reg, r0
.endm

    .section .text.curve_steep_steps, "ax", @progbits
    .global curve_steep_steps
    .type curve_steep_steps, @function
curve_steep_steps:
    .irp reg, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
    push r\reg                          ; 26
    .endr
    movw r28, r24                       ; 3
    movw r30, r22
    mov LEFT, r20
    clr ZERO                            ; 3
    clr SIGN
    set                                 ;    the first one
    std Y + CURVE_STEEP_SUM, ZERO       ; 6
    std Y + CURVE_STEEP_SUM + 1, ZERO
    std Y + CURVE_STEEP_SUM + 2, ZERO
    ldd V0, Y + CURVE_STEEP_RESIDUAL + LOW ; 30
    ldd V1, Y + CURVE_STEEP_RESIDUAL
    ldd V2, Y + CURVE_STEEP_RESIDUAL + 1
    ldd V3, Y + CURVE_STEEP_RESIDUAL + 2
    ldd V4, Y + CURVE_STEEP_RESIDUAL + 3
    ldd D0, Y + CURVE_STEEP_SLOPE + LOW
    ldd D1, Y + CURVE_STEEP_SLOPE
    ldd D2, Y + CURVE_STEEP_SLOPE + 1
    ldd D3, Y + CURVE_STEEP_SLOPE + 2
    ldd D4, Y + CURVE_STEEP_SLOPE + 3
    ldd H0, Y + CURVE_STEEP_HALF
    ldd H1, Y + CURVE_STEEP_HALF + 1
    ldd N0, Y + CURVE_STEEP_LAST
    ldd N1, Y + CURVE_STEEP_LAST + 1
    sbrc H1, 7                          ; 2
    com SIGN
    movw P0, H0                         ; 8  difference = slope - 2h
    lsl P0
    rol P1
    sub5 DIFF, TWICE_HALF
    subi N0, 1                          ; 2  top
    sbci N1, 0

steep_step:
    cpi D4, CURVE_STEEP_LIMIT           ; 3  40 bits are enough?
    brlo 1f
    rjmp steep_over
1:  ldd r0, Y + CURVE_STEEP_CHANGE      ; 7  ticks = top + 1 + change
    ldd r1, Y + CURVE_STEEP_CHANGE + 1
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
    mul H0, N1                          ; 5
    add P1, r0
    adc P2, r1
    adc P3, ZERO
    add5 VALUE, BEND                    ; 5  residual += bend
    add5 DIFF, BEND                     ; 5  difference += bend
    with_byte sub, V0, CURVE_STEEP_STEP ; 15 residual -= T * T
    with_byte sbc, V1, CURVE_STEEP_STEP + 1
    with_byte sbc, V2, CURVE_STEEP_STEP + 2
    with_byte sbc, V3, CURVE_STEEP_STEP + 3
    with_byte sbc, V4, CURVE_STEEP_STEP + 4
    add_product D0, N0, V0, V1, V2, V3, V4 ; 7 residual += difference * ticks
    add_product D1, N0, V1, V2, V3, V4  ; 6
    add_product D2, N0, V2, V3, V4      ; 5
    mul D3, N0                          ; 4
    add V3, r0
    adc V4, r1
    mul D4, N0                          ; 3
    add V4, r0
    add_product D0, N1, V1, V2, V3, V4  ; 6
    add_product D1, N1, V2, V3, V4      ; 5
    mul D2, N1                          ; 4
    add V3, r0
    adc V4, r1
    mul D3, N1                          ; 3
    add V4, r0
    add5 DIFF, BEND                     ; 5  difference += bend
    cp V3, D3                           ; 3  negative is larger too
    cpc V4, D4
    brsh steep_wrong
steep_put:
    subi N0, 1                          ; 2  top
    sbci N1, 0
    brmi steep_long                     ; 1
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
    rjmp steep_over

steep_carry:
    ldd r0, Y + CURVE_STEEP_SUM + 2
    inc r0
    std Y + CURVE_STEEP_SUM + 2, r0
    rjmp steep_next

steep_first:                            ;    the caller stores its high byte
    clt
    std Y + CURVE_STEEP_FIRST_HIGH, N1
    rjmp steep_sum

steep_long:                             ;    no guess can follow
    rcall steep_bad
    rjmp steep_store

steep_bad:                              ;    this step is the last one
    std Y + CURVE_STEEP_GOOD, ZERO
    mov LEFT, ZERO
    inc LEFT
    ret

; A wrong guess. Corrections are counted in r0.
steep_wrong:
    clr r0                              ; 1
    movw P0, H0                         ; 3  2h
    lsl P0
    rol P1
    tst V4                              ; 2
    brpl steep_is_over
steep_up:                               ;    a tick more
    inc r0                              ; 1
    subi N0, 0xFF                       ; 2  ticks++
    sbci N1, 0xFF
    add5 DIFF, TWICE_HALF               ; 5  difference += 2h
    add5 VALUE, DIFF                    ; 5  residual += difference
    brmi steep_up                       ; 2
    rjmp steep_right                    ; 2
steep_down:                             ;    a tick less
    dec r0                              ; 1
    subi N0, 1                          ; 2  ticks--
    sbci N1, 0
    sub5 VALUE, DIFF                    ; 5  residual -= difference
    sub5 DIFF, TWICE_HALF               ; 5  difference -= 2h
steep_is_over:
    cp V0, D0                           ; 5
    cpc V1, D1
    cpc V2, D2
    cpc V3, D3
    cpc V4, D4
    brsh steep_down                     ; 2
    tst r0                              ; 2  the upper bits alone were equal
    brne steep_right
    rjmp steep_put
steep_right:
    clr r1                              ; 3
    sbrc r0, 7
    com r1
    mov P0, r0                          ; 1
    ldd P2, Y + CURVE_STEEP_CHANGE      ; 10 change += corrections
    ldd P3, Y + CURVE_STEEP_CHANGE + 1
    add P2, r0
    adc P3, r1
    std Y + CURVE_STEEP_CHANGE, P2
    std Y + CURVE_STEEP_CHANGE + 1, P3
    subi P0, -CURVE_STEEP_MISS_MAX      ; 5  too many?
    cpi P0, 2 * CURVE_STEEP_MISS_MAX + 1
    brlo 1f
    rcall steep_bad
1:  rjmp steep_put


steep_over:
    movw P0, H0                         ; 8  slope = difference + 2h
    lsl P0
    rol P1
    add5 DIFF, TWICE_HALF
    std Y + CURVE_STEEP_RESIDUAL + LOW, V0 ; 24
    std Y + CURVE_STEEP_RESIDUAL, V1
    std Y + CURVE_STEEP_RESIDUAL + 1, V2
    std Y + CURVE_STEEP_RESIDUAL + 2, V3
    std Y + CURVE_STEEP_RESIDUAL + 3, V4
    std Y + CURVE_STEEP_SLOPE + LOW, D0
    std Y + CURVE_STEEP_SLOPE, D1
    std Y + CURVE_STEEP_SLOPE + 1, D2
    std Y + CURVE_STEEP_SLOPE + 2, D3
    std Y + CURVE_STEEP_SLOPE + 3, D4
    subi N0, 0xFF                       ; 6  ticks
    sbci N1, 0xFF
    std Y + CURVE_STEEP_LAST, N0
    std Y + CURVE_STEEP_LAST + 1, N1
    mov r24, r30                        ; 2
    clr r1
    .irp reg, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7
    pop r\reg                           ; 26
    .endr
    ret                                 ; 5
    .size curve_steep_steps, . - curve_steep_steps
