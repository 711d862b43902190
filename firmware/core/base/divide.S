; SPDX-License-Identifier: MIT
; The assembly half of divide.h:
;
;     uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
;     struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor)
;
; The same registers hold the arguments of both, and the results. r2..r6 are left alone: they are
; the step interrupt's.

; Bit by bit; the divisor goes into the upper half of the value at first less than once.
    .section .text.divide_u32_u16, "ax", @progbits
    .global divide_u32_u16
    .type divide_u32_u16, @function
divide_u32_u16:
    rcall divide_with_rest
    movw r24, r22
    ret
    .size divide_u32_u16, . - divide_u32_u16

    .global divide_with_rest
    .type divide_with_rest, @function
divide_with_rest:
    ldi r18, 16
quotient_bit:
    lsl r22                             ; 4  the quotient grows where the value leaves
    rol r23
    rol r24
    rol r25
    brcs 1f                             ; 1
    cp r24, r20                         ; 3
    cpc r25, r21
    brlo 2f
1:  sub r24, r20                        ; 3
    sbc r25, r21
    inc r22
2:  dec r18                             ; 3
    brne quotient_bit
    ret
    .size divide_with_rest, . - divide_with_rest
