; SPDX-License-Identifier: MIT
; Arithmetic of steep curves: the assembly half of curve_steep.c, where its C stands.
;
;     uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks)
;     uint16_t curve_steep_root(uint32_t value)
;
; r2..r6 are left alone: they are the step interrupt's. An interrupt may come between any two
; instructions.
#include "motion/curve_steep_layout.h"

#define LOW CURVE_STEEP_WIDE_LOW

#define V0    r8                 /* value, modulo 2^48 */
#define V1    r9
#define V2    r10
#define V3    r11
#define V4    r12
#define V5    r13
#define D0    r14                /* sum, then difference and its multiples */
#define D1    r15
#define D2    r16
#define D3    r17
#define D4    r18
#define E0    r19                /* bend */
#define E1    r20
#define E2    r21
#define E3    r22
#define E4    r23
#define N0    r24                /* ticks */
#define N1    r25
#define N2    r26
#define ZERO  r27
#define Q0    r19                /* quotient, when bend is done with */
#define Q1    r20
#define Q2    r21
#define BITS  r22
#define D5    r23                /* upper byte of a multiple of the difference */
#define A0    r30                /* h */
#define A1    r31

; V[at..] += r1:r0, with the carry up to V5
.macro add_product a, b, others:vararg
    add \a, r0
    adc \b, r1
    .irp reg, \others
    adc \reg, ZERO
    .endr
.endm

    .section .text.curve_steep_fit, "ax", @progbits
    .global curve_steep_fit
    .type curve_steep_fit, @function
curve_steep_fit:
    .irp reg, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
    push r\reg                          ; 24
    .endr
    movw r28, r24                       ; 1
    movw N0, r20                        ; 2
    mov N2, r22
    clr ZERO                            ; 1
fit_evaluate:
    ldd A0, Y + CURVE_STEEP_HALF        ; 4
    ldd A1, Y + CURVE_STEEP_HALF + 1

    ; bend = h * (ticks - 1) = h * ticks - h                      50
    mul A0, N0
    mov E0, r0
    mov E1, r1
    mul A0, N2
    mov E2, r0
    mov E3, r1
    clr E4
    mul A0, N1
    add E1, r0
    adc E2, r1
    adc E3, ZERO
    mul A1, N0
    add_product E1, E2, E3, E4
    mul A1, N1
    add_product E2, E3, E4
    mul A1, N2
    add E3, r0
    adc E4, r1
    clr r0
    sbrs A1, 7
    rjmp 1f
    com r0                              ;    the sign of h
    sub E2, N0                          ;    h was taken as 2^16 too much
    sbc E3, N1
    sbc E4, N2
1:  sub E0, A0
    sbc E1, A1
    sbc E2, r0
    sbc E3, r0
    sbc E4, r0

    ; sum = slope + bend                                          16
    ldd D0, Y + CURVE_STEEP_SLOPE + LOW
    ldd D1, Y + CURVE_STEEP_SLOPE
    ldd D2, Y + CURVE_STEEP_SLOPE + 1
    ldd D3, Y + CURVE_STEEP_SLOPE + 2
    ldd D4, Y + CURVE_STEEP_SLOPE + 3
    add D0, E0
    adc D1, E1
    adc D2, E2
    adc D3, E3
    adc D4, E4
    ; value = sum * ticks                                         50, 24 more for long intervals
    mul D0, N0
    movw V0, r0
    mul D2, N0
    movw V2, r0
    mul D4, N0
    movw V4, r0
    mul D1, N0
    add_product V1, V2, V3, V4, V5
    mul D3, N0
    add_product V3, V4, V5
    mul D0, N1
    add_product V1, V2, V3, V4, V5
    mul D1, N1
    add_product V2, V3, V4, V5
    mul D2, N1
    add_product V3, V4, V5
    mul D3, N1
    add V4, r0
    adc V5, r1
    mul D4, N1
    add V5, r0
    tst N2
    breq 1f
    mul D0, N2
    add_product V2, V3, V4, V5
    mul D1, N2
    add_product V3, V4, V5
    mul D2, N2
    add V4, r0
    adc V5, r1
    mul D3, N2
    add V5, r0
1:
    ; value += residual                                           16
    ldd r0, Y + CURVE_STEEP_RESIDUAL + LOW
    add V0, r0
    ldd r0, Y + CURVE_STEEP_RESIDUAL
    adc V1, r0
    ldd r0, Y + CURVE_STEEP_RESIDUAL + 1
    adc V2, r0
    ldd r0, Y + CURVE_STEEP_RESIDUAL + 2
    adc V3, r0
    ldd r0, Y + CURVE_STEEP_RESIDUAL + 3
    adc V4, r0
    adc V5, ZERO
    ; value -= T * T                                              18
    ldd r0, Y + CURVE_STEEP_STEP
    sub V0, r0
    ldd r0, Y + CURVE_STEEP_STEP + 1
    sbc V1, r0
    ldd r0, Y + CURVE_STEEP_STEP + 2
    sbc V2, r0
    ldd r0, Y + CURVE_STEEP_STEP + 3
    sbc V3, r0
    ldd r0, Y + CURVE_STEEP_STEP + 4
    sbc V4, r0
    ldd r0, Y + CURVE_STEEP_STEP + 5
    sbc V5, r0
    ; difference = sum + bend                                     6
    add D0, E0
    adc D1, E1
    adc D2, E2
    adc D3, E3
    adc D4, E4

    ; quotient = value / difference, rounded down: by how many ticks the guess misses
    clt
    sbrs V5, 7
    rjmp 1f
    set                                 ;    -1 - value, and the quotient is one more
    .irp reg, 8, 9, 10, 11, 12, 13
    com r\reg
    .endr
1:  clr Q0
    clr Q1
    clr Q2
    clr BITS
    clr D5
fit_multiple:                           ;    19 a bit
    cp V0, D0
    cpc V1, D1
    cpc V2, D2
    cpc V3, D3
    cpc V4, D4
    cpc V5, D5
    brlo fit_below
    lsl D0
    rol D1
    rol D2
    rol D3
    rol D4
    rol D5
    inc BITS
    rjmp fit_multiple
fit_bit:                                ;    20 or 27 a bit
    lsr D5
    ror D4
    ror D3
    ror D2
    ror D1
    ror D0
    lsl Q0
    rol Q1
    rol Q2
    cp V0, D0
    cpc V1, D1
    cpc V2, D2
    cpc V3, D3
    cpc V4, D4
    cpc V5, D5
    brlo fit_below
    sub V0, D0
    sbc V1, D1
    sbc V2, D2
    sbc V3, D3
    sbc V4, D4
    sbc V5, D5
    inc Q0
fit_below:
    subi BITS, 1
    brcc fit_bit
    brts fit_longer
    mov r0, Q0
    or r0, Q1
    or r0, Q2
    breq fit_done
    sub N0, Q0
    sbc N1, Q1
    sbc N2, Q2
    rjmp fit_evaluate
fit_longer:
    sec
    adc N0, Q0
    adc N1, Q1
    adc N2, Q2
    rjmp fit_evaluate

fit_done:
    lsl A0                              ; 10 slope = difference + 2h
    rol A1
    sbc r0, r0
    add D0, A0
    adc D1, A1
    adc D2, r0
    adc D3, r0
    adc D4, r0
    std Y + CURVE_STEEP_SLOPE + LOW, D0 ; 20
    std Y + CURVE_STEEP_SLOPE, D1
    std Y + CURVE_STEEP_SLOPE + 1, D2
    std Y + CURVE_STEEP_SLOPE + 2, D3
    std Y + CURVE_STEEP_SLOPE + 3, D4
    std Y + CURVE_STEEP_RESIDUAL + LOW, V0
    std Y + CURVE_STEEP_RESIDUAL, V1
    std Y + CURVE_STEEP_RESIDUAL + 1, V2
    std Y + CURVE_STEEP_RESIDUAL + 2, V3
    std Y + CURVE_STEEP_RESIDUAL + 3, V4
    movw r22, N0                        ; 3  ticks
    mov r24, N2
    clr r25
    clr r1                              ; 1
    .irp reg, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8
    pop r\reg                           ; 24
    .endr
    ret                                 ; 5

    .size curve_steep_fit, . - curve_steep_fit

; Digit by digit: two bits of the value at a time go into a remainder, and 4 * root + 1 is taken
; from it if it can be.
    .section .text.curve_steep_root, "ax", @progbits
    .global curve_steep_root
    .type curve_steep_root, @function
curve_steep_root:
    clr r18                             ;    remainder, 3 bytes
    clr r19
    clr r20
    ldi r26, 1                          ;    4 * root + 1, 3 bytes
    clr r27
    clr r21
    ldi r31, 4                          ;    bytes
root_byte:
    ldi r30, 4                          ;    pairs of bits in each
root_pair:
    lsl r25                             ; 8  remainder = 4 * remainder + the next two bits
    rol r18
    rol r19
    rol r20
    lsl r25
    rol r18
    rol r19
    rol r20
    cp r18, r26                         ; 4
    cpc r19, r27
    cpc r20, r21
    brlo 1f
    sub r18, r26                        ; 3
    sbc r19, r27
    sbc r20, r21
    lsl r26                             ; 6  root = 2 * root + 1
    rol r27
    rol r21
    subi r26, 0xFD
    rjmp 2f
1:  lsl r26                             ; 4  root = 2 * root
    rol r27
    rol r21
    dec r26
2:  dec r30                             ; 3
    brne root_pair
    mov r25, r24                        ;    the next byte
    mov r24, r23
    mov r23, r22
    dec r31
    brne root_byte
    lsr r21                             ;    root
    ror r27
    ror r26
    lsr r21
    ror r27
    ror r26
    movw r24, r26
    ret
    .size curve_steep_root, . - curve_steep_root
