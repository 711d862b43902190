; SPDX-License-Identifier: MIT
; The place of a captured edge inside a whole pixel or beside one, nearly always where the pixel
; clock is fast: the quick way of ledger_advance_to_capture() in ledger.c, on boards of several
; axes. All other places are found by ledger_capture_anywhere() there.
;
;     uint32_t ledger_advance_to_capture(struct ledger *ledger, struct stream *stream,
;                                        const struct engine_sample *sample, uint8_t back,
;                                        uint16_t captured_ticks)
;
;     r10, r11  sample                     r18  slot of the period     r22..r25  the edge's time
;     r12       where the interrupt reads  r19  the account's slot     X, r21    ticks between the
;     r13       back                       r20  how far it is behind             two slots
;     r14, r15  stream                     r16, r17  captured ticks    Y  ledger
;
; Cycles: 155, 16 for each period between the two slots, and ledger_take_pixels().
#include "base/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "motion/even_pixel_layout.h"
#include "motion/ledger_layout.h"
#include "motion/step_codes.h" // STEP_HIGH_TRAIN

#if SEVERAL_AXES

#define SUM r26, r27, r21
#define TIME r22, r23, r24, r25

    .section .text.ledger_advance_to_capture, "ax", @progbits

function ledger_advance_to_capture
    .irp register, 10, 11, 12, 13, 14, 15, 28, 29 ; 16
    push r\register
    .endr
    movw r28, r24                       ; 5
    movw r14, r22
    movw r10, r20
    movw r30, r20
    mov r13, r18
    ldd r12, Z + LEDGER_SAMPLE_TAIL     ; 16  an idle period or a cut has come,
    ldd r19, Z + LEDGER_SAMPLE_CUT
    .irp byte, 0, 1
    ldd r18, Z + LEDGER_SAMPLE_IDLE + \byte
    ldd r0, Y + LEDGER_IDLE_SEEN + \byte
    eor r18, r0
    or r19, r18
    .endr
    ldd r18, Y + LEDGER_TRAIN           ; 4   or a train: LEDGER_NO_TRAIN becomes 0,
    com r18
    or r19, r18
    movw r30, r22                       ; 10  or a batch?
    subi r30, lo8(-EVEN_PIXEL_BATCH_HEAD)
    sbci r31, hi8(-EVEN_PIXEL_BATCH_HEAD)
    ld r18, Z
    ldd r0, Z + 1
    eor r18, r0
    or r19, r18
    brne anywhere
    mov r20, r12                        ; 1
    call ledger_take_pixels             ; 5
    tst r24                             ; 2   not inside a whole pixel
    breq anywhere
    movw r30, r14                       ; 11  the period stands in the ring?
    ldd r19, Z + EVEN_PIXEL_RETIRED
    mov r20, r12
    sub r20, r19
    ldd r21, Y + LEDGER_FRESH
    add r21, r20
    cp r13, r21
    brsh anywhere
    mov r18, r12                        ; 12  and is as long as the captured count?
    sub r18, r13
    dec r18
    ldd r31, Z + EVEN_PIXEL_RING + 1
    mov r30, r18
    ld r22, Z
    inc r31
    ld r23, Z
    cp r22, r16
    cpc r23, r17
    brsh 1f

anywhere:                               ;     the arguments as they came
    movw r24, r28
    movw r22, r14
    movw r20, r10
    mov r18, r13
    .irp register, 29, 28, 15, 14, 13, 12, 11, 10
    pop r\register
    .endr
    jmp ledger_capture_anywhere

1:  clr r26                             ; 6   from the earlier slot to the later one
    clr r27
    clr r21
    mov r24, r18
    sub r24, r19                        ;     periods between them, if the account is behind
    cp r13, r20
    brlo 2f
    neg r24
    mov r25, r19
    rjmp 3f
2:  mov r30, r19
    mov r25, r18
3:  add r26, r24                        ; 1   a period is a tick longer than its entry says
    rjmp 5f
4:  ld r0, Z                            ; 16
    ldi r24, STEP_HIGH_TRAIN
    cp r0, r24
    brsh anywhere
    dec r31
    ld r24, Z
    inc r31
    inc r30
    add r26, r24
    adc r27, r0
    adc r21, r1
5:  cpse r30, r25
    rjmp 4b

    load_plain LEDGER_LOADED, TIME      ; 8
    cp r13, r20                         ; 10  the account is behind the period, or in front of it
    brlo 6f
    sub_number r22, r23, r24, r26, r27, r21
    sbc r25, r1
    rjmp 7f
6:  add_number r22, r23, r24, r26, r27, r21
    adc r25, r1
7:  add r22, r16                        ; 4
    adc r23, r17
    adc r24, r1
    adc r25, r1
    .irp register, 29, 28, 15, 14, 13, 12, 11, 10 ; 21
    pop r\register
    .endr
    ret
end_function ledger_advance_to_capture

#endif
