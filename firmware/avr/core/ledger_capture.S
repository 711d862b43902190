; SPDX-License-Identifier: MIT
; The place of a captured edge inside a whole pixel or beside one, nearly always where the pixel
; clock is fast: the quick way of ledger_advance_to_capture() in ledger.c, on boards of several
; axes. All other places are found by ledger_capture_anywhere() there.
;
;     uint32_t ledger_advance_to_capture(struct ledger *ledger, struct stream *stream,
;                                        const struct engine_sample *sample, uint8_t back,
;                                        uint16_t captured_ticks)
;
;     r10, r11  sample                     r14, r15  stream            Y  ledger
;     r12       where the interrupt reads  r16, r17  captured ticks
;     r13       back
;
; Cycles: 144, 16 for each period between the two slots, and ledger_take_pixels().
#include "avr/core/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "avr/core/ledger_place.inc" // macros, layouts

#if SEVERAL_AXES

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
    ldd r12, Z + LEDGER_SAMPLE_TAIL     ; 30
    ldd r19, Z + LEDGER_SAMPLE_CUT
    look_for_pixels anywhere, LEDGER_SAMPLE_IDLE, r14
    mov r20, r12                        ; 1
    call ledger_take_pixels             ; 5
    tst r24                             ; 2   not inside a whole pixel
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
