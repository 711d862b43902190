; SPDX-License-Identifier: MIT
; The account of periods and pixel edges: the assembly half of ledger_pixels.c, where the C is that
; this file stands for.
#include "avr/core/asm.inc" // macros
#include "build_features.h" // FEATURE_CLOCK_STATISTICS, SEVERAL_AXES
#include "avr/core/ledger_records.inc" // macros, layouts

#define STEPS    r20, r21, r22, r23
#define EXPECTED r18, r19

; Count r22 periods in the ledger at Y: at most three lengths are told by the ring, and the position
; moves if they pulse. STEPS becomes the position. r26 is lost, r24 keeps the periods.
.macro count_periods
    mov r24, r22
    count_fresh r24
    load_plain LEDGER_POSITION, STEPS
    ldd r26, Y + LEDGER_PULSE
    tst r26
    breq 5f
    ldd r26, Y + LEDGER_NEGATIVE
    tst r26
    brne 3f
    add r20, r24
    adc r21, r1
    adc r22, r1
    adc r23, r1
    rjmp 4f
3:  sub r20, r24
    sbc r21, r1
    sbc r22, r1
    sbc r23, r1
4:  store_plain LEDGER_POSITION, STEPS
5:
.endm

; The ledger at Y passed the edge of its next pixel at the position STEPS; EXPECTED are the low 16
; bits of the position expected. All that C calls may lose is lost.
.macro write_record
    plain_op sub, sbc, r26, LEDGER_ORIGIN, STEPS ; 12 steps of the line, beside those expected
    movw r30, r20                       ; 4
    sub r30, r18
    sbc r31, r19
    movw r18, r30
    ldd r24, Y + LEDGER_PIXEL           ; 12  the pixel's number
    ldd r25, Y + LEDGER_PIXEL + 1
    adiw r24, 1
    std Y + LEDGER_PIXEL, r24
    std Y + LEDGER_PIXEL + 1, r25
    brne 6f
    ldd r30, Y + LEDGER_PIXEL + 2
    ldd r31, Y + LEDGER_PIXEL + 3
    adiw r30, 1
    std Y + LEDGER_PIXEL + 2, r30
    std Y + LEDGER_PIXEL + 3, r31

6:  find_record                         ; 23
    fill_record 20, r18, r19            ; 16

    ldd r26, Y + LEDGER_RECORDS_TO_NEXT ; 19  to be kept?
    ldd r27, Y + LEDGER_RECORDS_TO_NEXT + 1
    sbiw r26, 1
    brne 9f
    lds r26, records_thinned
    lds r27, records_thinned + 1
    or r18, r26                         ;     not 0
    or r18, r27
9:  std Y + LEDGER_RECORDS_TO_NEXT, r26
    std Y + LEDGER_RECORDS_TO_NEXT + 1, r27
    or r18, r19
    brne 10f
    ldi r26, 1
    std Y + LEDGER_RECORDS_PASSING, r26
    rjmp 11f
10: std Y + LEDGER_RECORDS_PASSING, r1
    ldd r26, Y + LEDGER_RECORDS_MADE
    ldd r27, Y + LEDGER_RECORDS_MADE + 1
    adiw r26, 1
    std Y + LEDGER_RECORDS_MADE, r26
    std Y + LEDGER_RECORDS_MADE + 1, r27
11:
.endm

#if FEATURE_CLOCK_STATISTICS
; The error of an edge that came before its pixel, of number r24: given to the record at Z. Jumps to
; `shown` when it is 0, or that of the newest record that was kept, and else goes on with the error
; in r22, r23.
.macro take_early_error shown
    andi r24, LEDGER_RECORDS_EARLIER - 1 ; 16
    lsl r24
    movw r26, r28
    add r26, r24
    adc r27, r1
    adiw r26, LEDGER_RECORDS_EARLY
    ld r22, X+
    ld r23, X
    std Z + LEDGER_RECORD_ERROR, r22
    std Z + LEDGER_RECORD_ERROR + 1, r23
    mov r24, r22
    or r24, r23
    breq \shown
    st X, r1                            ; 10
    st -X, r1
    ldd r24, Y + LEDGER_RECORDS_SHOWN
    ldd r25, Y + LEDGER_RECORDS_SHOWN + 1
    cp r24, r22
    cpc r25, r23
    breq \shown
    movw r24, r28
    adiw r24, LEDGER_RECORDS
.endm
#endif

    .section .text.pass_periods, "ax", @progbits
pass_periods:
    count_periods
    ret

    .section .text.pass_edge, "ax", @progbits
pass_edge:
    write_record
#if FEATURE_CLOCK_STATISTICS
    take_early_error 12f
    jmp records_note_newest
12:
#endif
    ret

; void ledger_pass_periods(struct ledger *ledger, uint8_t count)
    .section .text.ledger_pass_periods, "ax", @progbits
function ledger_pass_periods
    push r28
    push r29
    movw r28, r24
    call pass_periods
    pop r29
    pop r28
    ret
end_function ledger_pass_periods

; void ledger_pass_edge(struct ledger *ledger, int32_t position_steps, uint16_t expected_steps)
    .section .text.ledger_pass_edge, "ax", @progbits
function ledger_pass_edge
    push r28
    push r29
    movw r28, r24
    call pass_edge
    pop r29
    pop r28
    ret
end_function ledger_pass_edge

; bool ledger_take_pixels(struct ledger *ledger, struct stream *stream, uint8_t tail)
;
;     r15  where the interrupt reads next   r16, r17  stream   Y  ledger   r22  periods of a pixel
;
; Cycles of a pixel: 235, all included but an error of an edge that is another than the one before;
; with a single axis 249.
#define TAIL    r15
#define PERIODS r22

    .section .text.ledger_take_pixels, "ax", @progbits
ways_out_of_take_pixels:
17: ldd r25, Z + EVEN_PIXEL_BEHIND_PERIODS ;  no: inside the pixel written last? Not known is one
    inc r25                             ;     below 0
    sub r20, TAIL
    neg r20
    cp r20, r25
    brlo 15f
14: clr r24
    rjmp 16f
15: ldi r24, 1
16: .irp register, 29, 28, 17, 16, 15
    pop r\register
    .endr
    ret

function ledger_take_pixels
    .irp register, 15, 16, 17, 28, 29
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov TAIL, r20
13: movw r30, r16                       ; 10  a mark that has its place?
    ldd r24, Z + EVEN_PIXEL_MARK_TAIL
    ldd r25, Z + EVEN_PIXEL_MARK_PLACED
    ldd r20, Z + EVEN_PIXEL_RETIRED
    cp r24, r25
    breq 17b
    movw r26, r30                       ; 9
    find_mark r25
    ldd r18, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_TICKS ; 9 of a pixel as a whole,
    ldd r19, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_TICKS + 1
    mov r0, r18
    or r0, r19
    breq 14b
    ldd PERIODS, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_PERIODS
    ldd r21, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_SLOT ; 6 that begins here,
    mov r0, r21
    sub r0, PERIODS
    cp r0, r20
    brne 14b
    mov r0, TAIL                        ; 4   and that is over?
    sub r0, r20
    cp r0, PERIODS
    brlo 15b

    adiw r26, EVEN_PIXEL_RETIRED        ; 9   the mark is passed
    st X, r21
    adiw r26, EVEN_PIXEL_MARK_TAIL - EVEN_PIXEL_RETIRED
    inc r24
    st X, r24
    pass_time r26, r18, r19, r1
    ldd r18, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_POSITION ; 14
    ldd r19, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_POSITION + 1
#if SEVERAL_AXES
    count_periods
    write_record
#if FEATURE_CLOCK_STATISTICS
    take_early_error .Lnext_pixel
    call records_note_newest
#endif
.Lnext_pixel:
#else
    call pass_periods
    call pass_edge
#endif
    rjmp 13b

end_function ledger_take_pixels
