; SPDX-License-Identifier: MIT
; The assembly half of divide.h, where the C stands:
;
;     uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
;     struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor)
;     uint32_t divide_product(uint32_t a, uint32_t b, uint32_t divisor, uint32_t *rest)
;
; The first two:
;
;     r22, r23  lower half of the value, then the quotient
;     r24, r25  upper half of the value, then the rest
;     r20, r21  divisor
;     r18       bits still to come
;
; Their arguments and results are in the same registers.
;
; Bit by bit. The value moves left; the divisor is taken from its upper half whenever this half is
; not below the divisor. At the start it is, so the quotient has 16 bits. 12 to 14 cycles a bit.
#include "avr/core/asm.inc" // macros

#define LOW0     r22
#define LOW1     r23
#define HIGH0    r24
#define HIGH1    r25
#define DIVISOR0 r20
#define DIVISOR1 r21
#define BITS     r18

    .section .text.divide_u32_u16, "ax", @progbits
function divide_u32_u16
    rcall divide_with_rest              ; 3
    movw r24, LOW0                      ; 1
    ret                                 ; 8  and the call
end_function divide_u32_u16

function divide_with_rest
    ldi BITS, 16                        ; 1
quotient_bit:
    lsl LOW0                            ; 4  the quotient grows where the value leaves
    rol LOW1
    rol HIGH0
    rol HIGH1
    brcs 1f                             ; 1  (2 when taken) a 17th bit: not below the divisor
    cp HIGH0, DIVISOR0                  ; 3  (4 when taken)
    cpc HIGH1, DIVISOR1
    brlo 2f
1:  sub HIGH0, DIVISOR0                 ; 3
    sbc HIGH1, DIVISOR1
    inc LOW0
2:  dec BITS                            ; 3
    brne quotient_bit
    ret                                 ; 8  and the call
end_function divide_with_rest

; Bit by bit as well, twice. The product has 64 bits: a is its lower half at first and moves out of
; it to the right, a bit at a time, and each bit that was set adds b to the upper half. The product
; then moves left as a value does above.
#define PRODUCT_LOW  r22, r23, r24, r25 /* a, then the lower half, then the quotient */
#define PRODUCT_HIGH r26, r27, r30, r31 /* the upper half, then the rest */
#define FACTOR       r18, r19, r20, r21 /* b; r18 counts bits when b is not needed any more */
#define DIVISOR      r14, r15, r16, r17
#define COUNT        r0

    .section .text.divide_product, "ax", @progbits
function divide_product
    ldi r26, 33
    mov COUNT, r26
    sub_number PRODUCT_HIGH, PRODUCT_HIGH ; 0, no carry
factor_bit:
    ror r31                             ; 8
    ror r30
    ror r27
    ror r26
    ror r25
    ror r24
    ror r23
    ror r22
    dec COUNT                           ; 2, leaves the carry alone
    breq product_made
    brcc factor_bit                     ; 2 or 7
    add_number PRODUCT_HIGH, FACTOR
    rjmp factor_bit
product_made:
    compare_number PRODUCT_HIGH, DIVISOR
    brsh too_large
    ldi r18, 32
product_bit:
    lsl r22                             ; 8
    rol r23
    rol r24
    rol r25
    rol r26
    rol r27
    rol r30
    rol r31
    brcs 1f                             ; 1  (2 when taken) a 33rd bit: not below the divisor
    compare_number PRODUCT_HIGH, DIVISOR ; 5  (6 when taken)
    brlo 2f
1:  sub_number PRODUCT_HIGH, DIVISOR    ; 5
    inc r22
2:  dec r18                             ; 3
    brne product_bit
    movw r18, r26
    movw r26, r12
    st X+, r18
    st X+, r19
    st X+, r30
    st X+, r31
    ret
too_large:
    ldi r24, 0xFF
    ldi r25, 0xFF
    movw r22, r24
    ret
end_function divide_product
