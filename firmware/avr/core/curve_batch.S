; SPDX-License-Identifier: MIT
; curve_batch.h for a narrow curve, on the AVR with several axes: fill in the high bytes, let
; curve_flat_steps.S make the steps, show them to the interrupt, note them for the account.
;
;     void curve_batch_narrow(struct walk *walk, struct stream *stream, uint8_t count);
;
;     r10, r11  top before the steps      r14  slot of the first step    Y    walk, and its curve
;     r12, r13  ring                      r15  number of steps           r16  stream
;
; Cycles: some 275 for a batch of 56 steps, 4 a step of them for the high bytes, and
; curve_flat_narrow(). Where the high byte changes among the steps curve_flat_finish() makes the
; rest.
#include "avr/core/asm.inc"         // macros
#include "build_features.h"     // SEVERAL_AXES
#include "layout.h" // offsets

#if SEVERAL_AXES

#define TOP    r10
#define HIGH   r11
#define RING   r12
#define LOWS   r13
#define SLOT   r14
#define COUNT  r15
#define TICKS  r24, r25, r26, r27

; The number at pointer + offset += ticks. By way of r20 to r23.
.macro memory_add pointer, offset
    .irp byte, 0, 1, 2, 3
    ldd 20 + \byte, \pointer + \offset + \byte
    .endr
    add_number r20, r21, r22, r23, TICKS
    .irp byte, 0, 1, 2, 3
    std \pointer + \offset + \byte, 20 + \byte
    .endr
.endm

    .section .text.curve_batch_narrow, "ax", @progbits
function curve_batch_narrow
    .irp register, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
    push \register
    .endr
    movw r28, r24
    movw r16, r22
    mov COUNT, r20
    movw r30, r16
    ld RING, Z                          ;     CURVE_BATCH_RING
    ldd LOWS, Z + CURVE_BATCH_RING + 1
    ldd SLOT, Z + CURVE_BATCH_HEAD
    ldd TOP, Y + CURVE_FLAT_TOP
    ldd HIGH, Y + CURVE_FLAT_TOP + 1

    mov r30, SLOT                       ;     the high bytes of all steps but the first: the ring's
    inc r30                             ;     arrays lie on 256-byte boundaries
    mov r31, LOWS
    inc r31
    mov r18, COUNT
    dec r18
    mov r19, r18
    lsr r19
    lsr r19
    andi r18, 3
    breq 2f
1:  st Z, HIGH
    inc r30
    dec r18
    brne 1b
2:  tst r19
    breq 4f
3:  .rept 4
    st Z, HIGH
    inc r30
    .endr
    dec r19
    brne 3b

4:  movw r24, r28                       ;     the low bytes
    mov r22, SLOT
    mov r23, LOWS
    mov r20, COUNT
    call curve_flat_narrow
    mov r0, r24                         ;     steps that are left, carries into the high byte
    or r0, r25
    breq whole
    rjmp finish

whole:
    movw r18, r22                       ;     ticks: (top + 1) * count + extra
    movw r20, TOP
    subi r20, -1
    sbci r21, -1
    mul r20, COUNT
    movw r24, r0
    mul r21, COUNT
    movw r26, r0
    clr r1
    add r25, r26
    mov r26, r27
    adc r26, r1
    clr r27
    clr r20
    sbrc r19, 7
    com r20
    add r24, r18
    adc r25, r19
    adc r26, r20
    adc r27, r20

publish:                                ;     HIGH is that of the first step
    mov r30, SLOT
    add r30, COUNT
    mov r18, r30                        ;     the new head
    mov r31, LOWS
    inc r31
    ldi r19, CURVE_BATCH_EMPTY
    st Z, r19
    mov r30, SLOT
    st Z, HIGH

    movw r30, r16
    subi r30, lo8(-CURVE_BATCH_NEXT)
    sbci r31, hi8(-CURVE_BATCH_NEXT)
    ld r20, Z
    ldd r21, Z + 1
    mov r22, r20
    sub r22, r21
    cpi r22, CURVE_BATCH_COUNT
    brsh 5f                             ;     no room: the reader adds the periods up
    mov r22, r20
    inc r22
    st Z, r22
    andi r20, CURVE_BATCH_COUNT - 1
    ldi r22, CURVE_BATCH_NOTE
    mul r20, r22
    add r30, r0
    adc r31, r1
    clr r1
    std Z + CURVE_BATCH_NOTES, SLOT
    std Z + CURVE_BATCH_NOTES + 1, COUNT
    std Z + CURVE_BATCH_NOTES + 2, r24
    std Z + CURVE_BATCH_NOTES + 3, r25
    std Z + CURVE_BATCH_NOTES + 4, r26
    std Z + CURVE_BATCH_NOTES + 5, r27
5:  movw r30, r16
    std Z + CURVE_BATCH_HEAD, r18
    memory_add Z, CURVE_BATCH_END_TICKS
    memory_add Y, CURVE_BATCH_EXACT_TICKS
    ldd r18, Y + CURVE_BATCH_UNTIL
    ldd r19, Y + CURVE_BATCH_UNTIL + 1
    sub r18, COUNT
    sbc r19, r1
    std Y + CURVE_BATCH_UNTIL, r18
    std Y + CURVE_BATCH_UNTIL + 1, r19
    .irp register, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10
    pop \register
    .endr
    ret

; struct curve_made curve_flat_finish(progress, flat, ring, top, slot, count)
finish:
    push r16
    push r17
    push r12
    movw r20, r28
    movw r18, RING
    movw r16, TOP
    mov r12, COUNT
    call curve_flat_finish
    pop r12
    pop r17
    pop r16
    mov HIGH, r23                       ;     first_high; r22 is COUNT
    movw r26, r20
    movw r24, r18
    rjmp publish
end_function curve_batch_narrow

#endif
