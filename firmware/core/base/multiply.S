; SPDX-License-Identifier: MIT
; The assembly half of multiply.h:
;
;     uint32_t multiply_u32_u16(uint32_t a, uint16_t b)
;
; r2..r6 are left alone: they are the step interrupt's.

; a is in r25:r22, b in r21:r20. Out of line: there are many products and little flash memory.
    .section .text.multiply_u32_u16, "ax", @progbits
    .global multiply_u32_u16
    .type multiply_u32_u16, @function
multiply_u32_u16:
    clr r18                             ; 1
    mul r22, r20                        ; 6
    movw r26, r0
    mul r24, r20
    movw r30, r0
    mul r23, r21                        ; 4
    add r30, r0
    adc r31, r1
    mul r23, r20                        ; 5
    add r27, r0
    adc r30, r1
    adc r31, r18
    mul r22, r21                        ; 5
    add r27, r0
    adc r30, r1
    adc r31, r18
    mul r25, r20                        ; 6
    add r31, r0
    mul r24, r21
    add r31, r0
    movw r22, r26                       ; 3
    movw r24, r30
    clr r1
    ret                                 ; 8 and the call
    .size multiply_u32_u16, . - multiply_u32_u16
