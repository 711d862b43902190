; SPDX-License-Identifier: MIT
; Accounts for pixels that were written as a whole: the assembly half of ledger_pixels.c, where the
; C is that this file stands for.
;
;     bool ledger_take_pixels(struct ledger *ledger, struct stream *stream, uint8_t tail)
;
;     r15      where the interrupt reads next      r18..r21  position, then steps of the line
;     r16, r17 stream                              r22       periods of the pixel
;     Y        ledger                              r24, r25  position expected, then the pixel's number
;
; Cycles of a pixel: 196, with an error of its edge 26 and records_note_newest() besides.
#include "base/asm.inc" // macros
#include "build_features.h"
#include "motion/even_pixel_layout.h"
#include "motion/ledger_layout.h"

#if STREAM_WHOLE_PIXELS

#define TAIL    r15
#define PERIODS r22
#define STEPS   r18, r19, r20, r21

    .section .text.ledger_take_pixels, "ax", @progbits
function ledger_take_pixels
    .irp register, 15, 16, 17, 28, 29
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov TAIL, r20
    rjmp next

none:
    clr r24
    rjmp leave
inside:
    ldi r24, 1
leave:
    .irp register, 29, 28, 17, 16, 15
    pop r\register
    .endr
    ret

next:
    movw r30, r16                       ; 8   a mark that has its place?
    ldd r24, Z + EVEN_PIXEL_MARK_TAIL
    ldd r25, Z + EVEN_PIXEL_MARK_PLACED
    cp r24, r25
    breq none
    ldd r20, Z + EVEN_PIXEL_RETIRED     ; 9
    andi r24, EVEN_PIXEL_MARK_COUNT - 1
    ldi r25, EVEN_PIXEL_MARK_BYTES
    mul r24, r25
    add r30, r0
    adc r31, r1
    clr r1
    ldd PERIODS, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_PERIODS ; 4 of a pixel as a whole,
    tst PERIODS
    breq none
    ldd r21, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_SLOT ; 6 that begins here,
    mov r24, r21
    sub r24, PERIODS
    cp r24, r20
    brne none
    mov r24, TAIL                       ; 4   and that is over?
    sub r24, r20
    cp r24, PERIODS
    brlo inside

    ldd r24, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_TICKS ; 24 its time
    ldd r25, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_TICKS + 1
    .irp byte, 0, 1, 2, 3
    ldd r26, Y + LEDGER_LOADED + \byte
    .if \byte == 0
    add r26, r24
    .elseif \byte == 1
    adc r26, r25
    .else
    adc r26, r1
    .endif
    std Y + LEDGER_LOADED + \byte, r26
    .endr
    ldd r24, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_POSITION ; 12 the mark is passed
    ldd r25, Z + EVEN_PIXEL_MARKS + EVEN_PIXEL_MARK_POSITION + 1
    movw r30, r16
    std Z + EVEN_PIXEL_RETIRED, r21
    ldd r26, Z + EVEN_PIXEL_MARK_TAIL
    inc r26
    std Z + EVEN_PIXEL_MARK_TAIL, r26
    ldd r26, Y + LEDGER_FRESH           ; 8   three lengths at most are told by the ring
    add r26, PERIODS
    brcs 1f
    cpi r26, 4
    brlo 2f
1:  ldi r26, 3
2:  std Y + LEDGER_FRESH, r26

    load_plain LEDGER_POSITION, STEPS   ; 28  position
    ldd r26, Y + LEDGER_PULSE
    tst r26
    breq 5f
    ldd r26, Y + LEDGER_NEGATIVE
    tst r26
    brne 3f
    add r18, PERIODS
    adc r19, r1
    adc r20, r1
    adc r21, r1
    rjmp 4f
3:  sub r18, PERIODS
    sbc r19, r1
    sbc r20, r1
    sbc r21, r1
4:  store_plain LEDGER_POSITION, STEPS

5:  plain_op sub, sbc, r26, LEDGER_ORIGIN, STEPS ; 15 steps of the line, beside those expected
    movw r22, r18
    sub r22, r24
    sbc r23, r25
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

6:  ldd r30, Y + LEDGER_RECORDS_NEWEST  ; 14  the next record's place, unless the newest passes
    ldd r26, Y + LEDGER_RECORDS_PASSING
    tst r26
    brne 8f
    inc r30
    cpi r30, LEDGER_RECORDS_MOST
    brlo 7f
    clr r30
7:  std Y + LEDGER_RECORDS_NEWEST, r30
    ldd r26, Y + LEDGER_RECORDS_COUNT
    cpi r26, LEDGER_RECORDS_MOST
    brsh 8f
    inc r26
    std Y + LEDGER_RECORDS_COUNT, r26
8:  ldi r26, LEDGER_RECORD_BYTES        ; 9
    mul r30, r26
    movw r30, r0
    clr r1
    add r30, r28
    adc r31, r29
    adiw r30, LEDGER_RECORDS_KEPT
    .irp byte, 0, 1, 2, 3               ; 16
    std Z + \byte, 18 + \byte
    .endr
    std Z + LEDGER_RECORD_BEYOND, r22
    std Z + LEDGER_RECORD_BEYOND + 1, r23
    std Z + LEDGER_RECORD_PIXEL, r24
    std Z + LEDGER_RECORD_PIXEL + 1, r25

    ldd r26, Y + LEDGER_RECORDS_TO_NEXT ; 25  to be kept?
    ldd r27, Y + LEDGER_RECORDS_TO_NEXT + 1
    sbiw r26, 1
    brne 9f
    lds r26, records_thinned
    lds r27, records_thinned + 1
    std Y + LEDGER_RECORDS_TO_NEXT, r26
    std Y + LEDGER_RECORDS_TO_NEXT + 1, r27
    rjmp keep
9:  std Y + LEDGER_RECORDS_TO_NEXT, r26
    std Y + LEDGER_RECORDS_TO_NEXT + 1, r27
    or r22, r23
    brne keep
    ldi r26, 1
    std Y + LEDGER_RECORDS_PASSING, r26
    rjmp recorded
keep:
    std Y + LEDGER_RECORDS_PASSING, r1
    ldd r26, Y + LEDGER_RECORDS_MADE
    ldd r27, Y + LEDGER_RECORDS_MADE + 1
    adiw r26, 1
    std Y + LEDGER_RECORDS_MADE, r26
    std Y + LEDGER_RECORDS_MADE + 1, r27
recorded:
#if FEATURE_CLOCK_STATISTICS
    andi r24, LEDGER_RECORDS_EARLIER - 1 ; 16 the error of an edge that came before its pixel
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
    breq 10f
    st X, r1
    st -X, r1
    movw r24, r28
    adiw r24, LEDGER_RECORDS
    call records_note_newest
10:
#endif
    rjmp next
end_function ledger_take_pixels

#endif
