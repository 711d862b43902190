; SPDX-License-Identifier: MIT
; The assembly half of fine.h, where the C stands:
;
;     void fine_add(struct fine_ticks *to, const struct fine_ticks *by)
;     void fine_halve(struct fine_ticks *length, uint8_t times)
#include "base/asm.inc" // macros

    .section .text.fine_add, "ax", @progbits
function fine_add
    movw r26, r24
    movw r30, r22
    ldi r18, 6
    clc
next_byte:
    ld r24, X                           ; 10 a byte, 9 the last one
    ld r25, Z+
    adc r24, r25
    st X+, r24
    dec r18                             ; leaves the carry alone
    brne next_byte
    ret
end_function fine_add

    .section .text.fine_halve, "ax", @progbits
function fine_halve
    movw r30, r24
    ld r18, Z
    ldd r19, Z + 1
    ldd r20, Z + 2
    ldd r21, Z + 3
    ldd r24, Z + 4
    ldd r25, Z + 5
    rjmp another
halving:
    asr r25
    ror r24
    ror r21
    ror r20
    ror r19
    ror r18
another:
    subi r22, 1
    brcc halving
    st Z, r18
    std Z + 1, r19
    std Z + 2, r20
    std Z + 3, r21
    std Z + 4, r24
    std Z + 5, r25
    ret
end_function fine_halve
