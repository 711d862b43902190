; SPDX-License-Identifier: MIT
; Arithmetic of steep curves: the assembly half of curve_steep.c. The C that this file stands for
; has the same names there; curve_steep.h explains the numbers:
;
;     uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks)
;     uint16_t curve_steep_root(uint32_t value)
;
; curve_steep_fit() evaluates a guess modulo 2^48 and divides what is left by the last difference:
; the quotient is by how many ticks the guess misses. It then evaluates the corrected guess, until
; the quotient is 0.
;
;     r0, r1       products, scratch              r24..r26  ticks
;     r8..r13      value                          r27       0
;     r14..r18     sum, then difference           r28, r29  Y: steep
;     r19..r23     bend; then the quotient,       r30, r31  h
;                  the bit, and the divisor's     T         the value is negative
;                  sixth byte
;
; Cycles of curve_steep_fit(), besides 92 (ATmega2560: 94) for the call and the
; registers:
;
;     an evaluation                    145; 3 more where h < 0, 17 more from 2^16 ticks on
;     its quotient, 0                  25: the guess is right
;     its quotient, positive           29, and 36 or 42 for each bit
;     its quotient, negative           33, and 36 or 42 for each bit
;
; A right guess: 262 (ATmega2560: 264). curve_steep_root(): 365 to 429 (ATmega2560: 367 to 431).
#include "avr/core/asm.inc" // macros
#include "layout.h" // offsets

#define V0       r8 /* value, modulo 2^48 */
#define V1       r9
#define V2       r10
#define V3       r11
#define V4       r12
#define V5       r13
#define D0       r14 /* sum, then difference and its multiples */
#define D1       r15
#define D2       r16
#define D3       r17
#define D4       r18
#define E0       r19 /* bend */
#define E1       r20
#define E2       r21
#define E3       r22
#define E4       r23
#define N0       r24 /* ticks */
#define N1       r25
#define N2       r26
#define ZERO     r27
#define Q0       r19 /* quotient, when bend is done with */
#define Q1       r20
#define Q2       r21
#define BITS     r22
#define D5       r23 /* upper byte of a multiple of the difference */
#define H0       r30 /* h */
#define H1       r31
#define VALUE    V0, V1, V2, V3, V4, V5
#define SUM      D0, D1, D2, D3, D4
#define MULTIPLE D0, D1, D2, D3, D4, D5
#define BEND     E0, E1, E2, E3, E4
#define TICKS    N0, N1, N2
#define QUOTIENT Q0, Q1, Q2

    .section .text.curve_steep_fit, "ax", @progbits
function curve_steep_fit
    save_registers 8                    ; 24
    movw r28, r24                       ; 1
    movw N0, r20                        ; 2
    mov N2, r22
    clr ZERO                            ; 1
fit_evaluate:
    load_plain CURVE_STEEP_HALF, H0, H1 ; 4

    ; bend = h * (ticks - 1) = h * ticks - h                      38 (41)
    mul H0, N0
    mov E0, r0
    mov E1, r1
    mul H0, N2
    mov E2, r0
    mov E3, r1
    clr E4
    add_product H0, N1, ZERO, E1, E2, E3
    add_product H1, N0, ZERO, E1, E2, E3, E4
    add_product H1, N1, ZERO, E2, E3, E4
    add_product H1, N2, ZERO, E3, E4
    clr r0
    sbrs H1, 7
    rjmp 1f
    com r0                              ;    the sign of h
    sub_number E2, E3, E4, TICKS        ;    h was taken as 2^16 too much
1:  sub_number BEND, H0, H1, r0, r0, r0

    ; sum = slope + bend                                          15
    load_wide CURVE_STEEP_SLOPE, SUM
    add_number SUM, BEND
    ; value = sum * ticks                                         49, 17 more for long intervals
    mul D0, N0
    movw V0, r0
    mul D2, N0
    movw V2, r0
    mul D4, N0
    movw V4, r0
    add_product D1, N0, ZERO, V1, V2, V3, V4, V5
    add_product D3, N0, ZERO, V3, V4, V5
    add_product D0, N1, ZERO, V1, V2, V3, V4, V5
    add_product D1, N1, ZERO, V2, V3, V4, V5
    add_product D2, N1, ZERO, V3, V4, V5
    add_product D3, N1, ZERO, V4, V5
    add_product D4, N1, ZERO, V5
    tst N2
    breq 1f
    add_product D0, N2, ZERO, V2, V3, V4, V5
    add_product D1, N2, ZERO, V3, V4, V5
    add_product D2, N2, ZERO, V4, V5
    add_product D3, N2, ZERO, V5
1:
    ; value += residual                                           16
    wide_op add, adc, r0, CURVE_STEEP_RESIDUAL, V0, V1, V2, V3, V4
    adc V5, ZERO
    ; value -= T * T                                              18
    plain_op sub, sbc, r0, CURVE_STEEP_STEP, VALUE
    ; difference = sum + bend                                     5
    add_number SUM, BEND

    ; quotient = value / difference, rounded down: by how many ticks the guess misses
    clt
    sbrs V5, 7
    rjmp 1f
    set                                 ;    -1 - value, and the quotient is one more
    .irp byte, VALUE
    com \byte
    .endr
1:  clr Q0
    clr Q1
    clr Q2
    clr BITS
    clr D5
fit_double:                             ; 16 a bit
    compare_number VALUE, MULTIPLE
    brlo fit_next_bit
    lsl D0
    rol D1
    rol D2
    rol D3
    rol D4
    rol D5
    inc BITS
    rjmp fit_double
fit_halve:                              ;    20 or 26 a bit
    lsr D5
    ror D4
    ror D3
    ror D2
    ror D1
    ror D0
    lsl Q0
    rol Q1
    rol Q2
    compare_number VALUE, MULTIPLE
    brlo fit_next_bit
    sub_number VALUE, MULTIPLE
    inc Q0
fit_next_bit:
    subi BITS, 1
    brcc fit_halve
    brts fit_increase
    mov r0, Q0
    or r0, Q1
    or r0, Q2
    breq fit_done
    sub_number TICKS, QUOTIENT
    rjmp fit_evaluate
fit_increase:
    sec
    number_op adc, adc, TICKS, QUOTIENT
    rjmp fit_evaluate

fit_done:
    lsl H0                              ; 8  slope = difference + 2h
    rol H1
    sbc r0, r0
    add_number SUM, H0, H1, r0, r0, r0
    store_wide CURVE_STEEP_SLOPE, SUM   ; 20
    store_wide CURVE_STEEP_RESIDUAL, V0, V1, V2, V3, V4
    movw r22, N0                        ; 3  the result: ticks
    mov r24, N2
    clr r25
    clr r1                              ; 1
    restore_registers 8                 ; 24
    ret                                 ; 4
end_function curve_steep_fit

; Digit by digit: two bits of the value at a time go into a remainder, and 4 * root + 1 is taken
; from it if it can be.
    .section .text.curve_steep_root, "ax", @progbits
function curve_steep_root
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
    subi r26, lo8(-3)
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
end_function curve_steep_root
