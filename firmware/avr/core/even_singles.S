; SPDX-License-Identifier: MIT
; Evenly spaced steps as single periods, on boards of several axes: what no pulse train can make is
; written so. Elsewhere train_pixel_singles() in train_pixel.c does it in C.
;
;     struct even_singles even_singles_write(struct even *even, struct step_ring *ring,
;                                            uint8_t slot, uint8_t count)
;
;     r18       periods to write           r21:r20  shorter one - 1 r29:r28  n
;     r19       longer periods             r23:r22  sum, less n     X, Z     low and high byte
;     r17:r16   remainder                  r25:r24  longer one - 1
;
; Cycles: 9 for a period and 15 for a longer one, 3 for each four of them and for each one beyond,
; and some 90 with the call.
#include "avr/core/asm.inc"         // macros
#include "build_features.h"     // SEVERAL_AXES
#include "layout.h" // offsets

#if SEVERAL_AXES

; Periods of these names; `longer` of the same names stands where a branch reaches it. The ring's
; arrays lie on 256-byte boundaries, so that a slot is the low byte of both pointers.
.macro periods names:vararg
    .irp name, \names
    add_number r22, r23, r16, r17
    brpl .Llonger_\name
    st X, r20
    st Z, r21
.Lbehind_\name:
    inc r26
    inc r30
    .endr
.endm

.macro longer names:vararg
    .irp name, \names
.Llonger_\name:
    sub_number r22, r23, r28, r29
    inc r19
    st X, r24
    st Z, r25
    rjmp .Lbehind_\name
    .endr
.endm

    .section .text.even_singles_write, "ax", @progbits
    longer first, single
function even_singles_write
    save_registers 16
    push r24
    push r25
    mov r26, r20
    mov r27, r23
    mov r30, r20                        ;     the first one's high byte, by which the interrupt sees
    add r30, r18                        ;     them all, is put behind the last one for now
    mov r31, r23
    inc r31
    movw r28, r24
    load_plain EVEN_BASE, r24, r25
    movw r20, r24
    subi r20, 1
    sbci r21, 0
    load_plain EVEN_SUM, r22, r23
    load_plain EVEN_REMAINDER, r16, r17
    ldd r19, Y + EVEN_STEPS
    ldd r29, Y + EVEN_STEPS + 1
    mov r28, r19
    sub_number r22, r23, r28, r29
    ldi r19, 0

    periods first
    mov r30, r26
    dec r18
    mov r0, r18                         ;     one by one up to a multiple of four
    lsr r0
    lsr r0
    andi r18, 3
    breq 2f
1:  periods single
    dec r18
    brne 1b
2:  mov r18, r0
    tst r18
    breq 4f
3:  periods one, two, three, four
    dec r18
    brne 3b
4:
    add_number r22, r23, r28, r29
    pop r29
    pop r28
    std Y + EVEN_SUM, r22
    std Y + EVEN_SUM + 1, r23
    mov r24, r19
    ld r25, Z
    restore_registers 16
    ret
    longer one, two, three, four
end_function even_singles_write

#endif
