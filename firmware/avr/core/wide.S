; SPDX-License-Identifier: MIT
; The assembly half of wide.h, where the C stands. No other register is changed:
;
;     wide_times_in_registers, called by wide_times()
;
;     r20..r23, r24       a: bits 8 to 39, then bits 0 to 7
;     r18, r19            factor
;     r18..r21, r22       the product, like a
;     r26, r27, r30, r31  bits 8 to 39 of the product
;     r25                 0
;
; 51 cycles with `call` and `ret` (ATmega2560: 53).
#include "avr/core/asm.inc" // macros

#define A0   r24
#define A1   r20
#define A2   r21
#define A3   r22
#define A4   r23
#define B0   r18
#define B1   r19
#define P1   r26 /* pairs P2:P1 and P4:P3 */
#define P2   r27
#define P3   r30
#define P4   r31
#define ZERO r25

    .section .text.wide_times_in_registers, "ax", @progbits
function wide_times_in_registers
    clr ZERO                            ; 1
    mul A1, B0                          ; 6
    movw P1, r0
    mul A3, B0
    movw P3, r0
    add_product A4, B0, ZERO, P4        ; 3
    add_product A2, B0, ZERO, P2, P3, P4 ; 5
    add_product A1, B1, ZERO, P2, P3, P4 ; 5
    add_product A2, B1, ZERO, P3, P4    ; 4
    add_product A3, B1, ZERO, P4        ; 3
    add_product A0, B1, ZERO, P1, P2, P3, P4 ; 6
    mul A0, B0                          ; 7
    mov r22, r0
    add P1, r1
    adc P2, ZERO
    adc P3, ZERO
    adc P4, ZERO
    movw r18, P1                        ; 2
    movw r20, P3
    clr r1                              ; 1
    ret                                 ; 8  and the call
end_function wide_times_in_registers
