; SPDX-License-Identifier: MIT
; The assembly half of divide.h, where the C stands:
;
;     uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
;     struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor)
;
;     r22, r23  lower half of the value, then the quotient
;     r24, r25  upper half of the value, then the rest
;     r20, r21  divisor
;     r18       bits still to come
;
; The arguments and results of both functions are in the same registers.
;
; Bit by bit. The value moves left; the divisor is taken from its upper half whenever this half is
; not below the divisor. At the start it is, so the quotient has 16 bits. 12 to 14 cycles a bit.
#include "base/asm.inc" // macros

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
