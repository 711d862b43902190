; SPDX-License-Identifier: MIT
; The place of a captured edge among single periods, nearly always where the pixel clock is fast:
; the quick way of ledger_advance_to_capture() in ledger.c, on boards of several axes. All other
; places are found by ledger_capture_anywhere() there. In C it takes some 100 cycles more, and two
; axes of a 1284P lose 12 % of their smooth rate at 10 steps a pixel.
;
;     uint32_t ledger_advance_to_capture(struct ledger *ledger, struct stream *stream,
;                                        const struct engine_sample *sample, uint8_t back,
;                                        uint16_t captured_ticks)
;
;     r10, r11  sample                     r14, r15  stream            Y  ledger
;     r12       where the interrupt reads  r16, r17  captured ticks
;     r13       back
;
; Cycles: 132, 16 for each period between the two slots, and ledger_pass_waypoints().
#include "avr/core/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "layout.h" // offsets
#include "ring/step_codes.h" // STEP_HIGH_TRAIN

#if SEVERAL_AXES

; Y is the ledger, Z the stream in both macros.

; Goes to `anywhere` unless the ring goes on from the account by single periods: an idle period has
; come (their number is at Z + idle), or r19 is not 0, or the account stands in a train. 14 cycles.
.macro look_for_periods anywhere, idle
    .irp byte, 0, 1
    ldd r18, Z + \idle + \byte
    ldd r0, Y + LEDGER_IDLE_SEEN + \byte
    eor r18, r0
    or r19, r18
    .endr
    ldd r18, Y + LEDGER_TRAIN           ;     LEDGER_NO_TRAIN becomes 0
    com r18
    or r19, r18
    brne \anywhere
.endm

; The time r25..r22 of the count r23:r22 in the period `back`, r25, from the one that the interrupt
; loaded last, where it reads slot `tail`, r24, next. Goes to `anywhere` unless that period stands
; in the ring and is as long. r0, r18..r21, r26, r27, r30, r31 are lost.
;
;     r18       slot of the period, r19 that of the account, r20 how far the account is behind
;     T         the account is in front of the period
;     r21:r26   ticks between the two slots
;
; Cycles: 54, and 16 for each period between the two slots.
.macro place_in_ring anywhere
    ldd r19, Z + EVEN_PIXEL_RETIRED     ; 9   the period stands in the ring?
    mov r20, r24
    sub r20, r19
    ldd r21, Y + LEDGER_FRESH
    add r21, r20
    cp r25, r21
    brsh 1f
    mov r18, r24                        ; 13  and is as long as the captured count?
    sub r18, r25
    dec r18
    ldd r31, Z + EVEN_PIXEL_RING + 1
    mov r30, r18
    ld r26, Z
    inc r31
    ld r27, Z
    cp r26, r22
    cpc r27, r23
    brlo 1f
    clr r26                             ; 11  from the earlier slot to the later one
    clr r27
    clr r21
    mov r24, r18
    sub r24, r19                        ;     periods between them, if the account is behind
    clt
    cp r25, r20
    mov r25, r18
    brlo 2f
    set
    neg r24
    mov r25, r19
    rjmp 3f
1:  rjmp \anywhere
2:  mov r30, r19
3:  add r26, r24                        ; 3   a period is a tick longer than its entry says
    rjmp 5f
4:  ld r0, Z                            ; 16
    ldi r24, STEP_HIGH_TRAIN
    cp r0, r24
    brsh 1b
    dec r31
    ld r24, Z
    inc r31
    inc r30
    add r26, r24
    adc r27, r0
    adc r21, r1
5:  cpse r30, r25                       ; 2
    rjmp 4b
    clr r24                             ; 7   the account is behind the period, or in front of it
    clr r25
    brts 6f
    add_number r22, r23, r24, r26, r27, r21
    rjmp 7f
6:  sub_number r22, r23, r24, r26, r27, r21
    sbc r25, r1
7:  plain_op add, adc, r18, LEDGER_LOADED, r22, r23, r24, r25 ; 12
.endm

    .section .text.ledger_advance_to_capture, "ax", @progbits

anywhere:                               ;     the arguments as they came
    movw r24, r28
    movw r22, r14
    movw r20, r10
    mov r18, r13
    .irp register, 29, 28, 15, 14, 13, 12, 11, 10
    pop r\register
    .endr
    jmp ledger_capture_anywhere

function ledger_advance_to_capture
    .irp register, 10, 11, 12, 13, 14, 15, 28, 29 ; 16
    push r\register
    .endr
    movw r28, r24                       ; 5
    movw r14, r22
    movw r10, r20
    movw r30, r20
    mov r13, r18
    ldd r12, Z + LEDGER_SAMPLE_TAIL     ; 18
    ldd r19, Z + LEDGER_SAMPLE_CUT
    look_for_periods anywhere, LEDGER_SAMPLE_IDLE
    mov r20, r12                        ; 1
    call ledger_pass_waypoints          ; 5
    tst r24                             ; 2   not among single periods
    breq anywhere
    movw r30, r14                       ; 4
    mov r24, r12
    mov r25, r13
    movw r22, r16
    place_in_ring anywhere              ; 54
    .irp register, 29, 28, 15, 14, 13, 12, 11, 10 ; 21
    pop r\register
    .endr
    ret
end_function ledger_advance_to_capture

#endif
