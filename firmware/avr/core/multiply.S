; SPDX-License-Identifier: MIT
; The assembly half of multiply.h, where the C stands. No other register is changed:
;
;     multiply_in_registers, called by multiply_u32_u16()
;
;     r22..r25            a, then the product
;     r20, r21            b
;     r26, r27, r30, r31  the product
;     r18                 0
;
; The partial products by their bytes in the result. What reaches beyond 32 bits is left out:
;
;     byte       3        2        1        0
;              [   a2 * b0   ]  [   a0 * b0   ]
;              [   a1 * b1   ]
;                       [   a1 * b0   ]
;                       [   a0 * b1   ]
;       a3 * b0 ]
;       a2 * b1 ]
;
; Out of line, because there are many products and little flash memory. 38 cycles with `call` and
; `ret` (ATmega2560: 40).
#include "avr/core/asm.inc" // macros

#define A0   r22
#define A1   r23
#define A2   r24
#define A3   r25
#define B0   r20
#define B1   r21
#define P0   r26 /* pairs P1:P0 and P3:P2 */
#define P1   r27
#define P2   r30
#define P3   r31
#define ZERO r18

    .section .text.multiply_in_registers, "ax", @progbits
function multiply_in_registers
    clr ZERO                            ; 1
    mul A0, B0                          ; 6
    movw P0, r0
    mul A2, B0
    movw P2, r0
    add_product A1, B1, ZERO, P2, P3    ; 4
    add_product A1, B0, ZERO, P1, P2, P3 ; 5
    add_product A0, B1, ZERO, P1, P2, P3 ; 5
    add_product A3, B0, ZERO, P3        ; 3
    add_product A2, B1, ZERO, P3        ; 3
    movw A0, P0                         ; 3
    movw A2, P2
    clr r1
    ret                                 ; 8  and the call
end_function multiply_in_registers
