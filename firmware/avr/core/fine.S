; SPDX-License-Identifier: MIT
; The assembly half of fine.h, where the C stands:
;
;     void fine_add(struct fine_ticks *to, const struct fine_ticks *by)
;     void fine_track(struct fine_ticks *pair, int32_t error_ticks, uint8_t shift)
#include "avr/core/asm.inc" // macros
#include "base/fine.h"  // FINE_TICK_CENTRE

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

; r20 to r23, r24, r25   the error: ticks, fraction
; r18                   shift
; r19                   halvings still to come
; Z                     the number that is corrected next
    .section .text.fine_track, "ax", @progbits
function fine_track
    movw r30, r24
    ld r26, Z
    ldd r27, Z + 1
    clr r24
    ldi r25, hi8(FINE_TICK_CENTRE)
    sub r24, r26
    sbc r25, r27
    sbc r20, r1
    sbc r21, r1
    sbc r22, r1
    sbc r23, r1
    mov r19, r18
    rcall halve_and_add
    mov r19, r18
    cpse r18, r1
    inc r19
    ; goes on below
end_function fine_track

function halve_and_add
    clc
    rjmp another
halving:
    asr r23                             ; 9 a halving
    ror r22
    ror r21
    ror r20
    ror r25
    ror r24
another:
    dec r19                             ; leaves the carry alone: the last bit that fell out
    brpl halving
    ld r26, Z
    adc r26, r24
    st Z+, r26
    ld r26, Z
    adc r26, r25
    st Z+, r26
    .irp register, r20, r21, r22, r23
    ld r26, Z
    adc r26, \register
    st Z+, r26
    .endr
    ret
end_function halve_and_add
