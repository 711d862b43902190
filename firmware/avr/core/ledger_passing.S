; SPDX-License-Identifier: MIT
; The account of pixels whose records are not kept, several of them in a row: ledger_pixels.S takes
; them by this where records are thinned, on boards of several axes; ledger_pixels.c has the C. What
; follows from one pixel to the next stays in registers, and only the last one's record is written:
; the others would have been overwritten. Stops in front of a pixel whose record is to be kept.
;
;     pixel        5     6     7     8     9     10     one in ten is kept: to_next is 6
;     record       -     -     -     -     x     stop   that of 9 stands for the newest pixel
;
;     r7        pixels that may be taken     r18, r19  scratch
;     r8..r10   their time                   r20, r21  steps of the line, low 16 bits
;     r11, r12  error of the last one's edge r22, r23  steps of a pixel; r23 also: the sign of all
;     r13       number of the last one       r24, r25  mark_tail, mark_placed
;     r14       retired                      X         error of an edge
;     r15       tail                         Y         ledger
;     r16, r17  stream                       Z         mark
;
; Cycles: 69 for each pixel, 26 more where its edge had an error, and 270 once.
#include "avr/core/asm.inc" // macros
#include "build_features.h" // FEATURE_CLOCK_STATISTICS, SEVERAL_AXES
#include "avr/core/ledger_records.inc" // macros, layouts

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#define LEFT    r7
#define PIXEL   r13
#define RETIRED r14
#define TAIL    r15
#define SIGN    r23
#define MOST    (EVEN_PIXEL_MARK_COUNT - 1)

    .section .text.ledger_take_passing, "ax", @progbits

; The error r12:r11 of an edge, which came before the account: is it another than that of the record
; kept last by more than the limit?
early:
    mov r0, r11
    mov r19, r12
    ldd r18, Y + LEDGER_RECORDS_SHOWN
    sub r0, r18
    ldd r18, Y + LEDGER_RECORDS_SHOWN + 1
    sbc r19, r18
    brge 1f
    com r19
    neg r0
    sbci r19, 0xFF
1:  lds r18, records_thinned + LEDGER_THINNING_ERROR
    cp r18, r0
    lds r18, records_thinned + LEDGER_THINNING_ERROR + 1
    cpc r18, r19
    brlo is_kept
    st X, r1
    st -X, r1
    ldd r18, Z + EVEN_PIXEL_MARK_SLOT
    rjmp passed
is_kept:
    rjmp done

; Y is the ledger, r17:r16 the stream, r15 where the interrupt reads next. All that C calls may lose
; is lost.
function ledger_take_passing
    ldd r18, Y + LEDGER_RECORDS_TO_NEXT ; 16  the one that is kept in any case is not for here
    ldd r19, Y + LEDGER_RECORDS_TO_NEXT + 1
    cpi r18, MOST + 1
    cpc r19, r1
    brlo 1f
    ldi r18, MOST + 1
1:  dec r18
    breq nothing
    ldd r19, Y + LEDGER_PULSE
    tst r19
    brne begin
nothing:
    ret
begin:
    .irp register, 7, 8, 9, 10, 11, 12, 13, 14 ; 16
    push r\register
    .endr
    mov LEFT, r18                       ; 30
    clr r8
    clr r9
    clr r10
    ldd PIXEL, Y + LEDGER_PIXEL
    ldd SIGN, Y + LEDGER_NEGATIVE
    neg SIGN
    ldd r20, Y + LEDGER_POSITION
    ldd r21, Y + LEDGER_POSITION + 1
    ldd r18, Y + LEDGER_ORIGIN
    sub r20, r18
    ldd r18, Y + LEDGER_ORIGIN + 1
    sbc r21, r18
    movw r30, r16
    ldd RETIRED, Z + EVEN_PIXEL_RETIRED
    ldd r24, Z + EVEN_PIXEL_MARK_TAIL
    ldd r25, Z + EVEN_PIXEL_MARK_PLACED
    find_mark r19                       ; 10
    adiw r30, EVEN_PIXEL_MARKS

next:
    tst LEFT                            ; 4   a mark that has its place?
    breq done
    cp r24, r25
    breq done
    ldd r0, Z + EVEN_PIXEL_MARK_TICKS   ; 14  of a pixel as a whole, that begins here,
    ldd r19, Z + EVEN_PIXEL_MARK_TICKS + 1
    or r19, r0
    breq done
    ldd r22, Z + EVEN_PIXEL_MARK_PERIODS
    ldd r18, Z + EVEN_PIXEL_MARK_SLOT
    mov r19, r18
    sub r19, r22
    cp r19, RETIRED
    brne done
    mov r19, TAIL                       ; 4   and that is over?
    sub r19, RETIRED
    cp r19, r22
    brlo done
    eor r22, SIGN                       ; 12  where it was to end?
    sub r22, SIGN
    movw r26, r20
    add r26, r22
    adc r27, SIGN
    ldd r0, Z + EVEN_PIXEL_MARK_POSITION
    ldd r19, Z + EVEN_PIXEL_MARK_POSITION + 1
    cp r26, r0
    cpc r27, r19
    brne done
    movw r20, r26
    mov r26, PIXEL                      ; 16
    inc r26
    andi r26, LEDGER_RECORDS_EARLIER - 1
    lsl r26
    clr r27
    add r26, r28
    adc r27, r29
    adiw r26, LEDGER_RECORDS_EARLY
    ld r11, X+
    ld r12, X
    mov r0, r11
    or r0, r12
    breq passed
    rjmp early
passed:
    mov RETIRED, r18                    ; 15
    inc r24
    inc PIXEL
    dec LEFT
    ldd r0, Z + EVEN_PIXEL_MARK_TICKS
    add r8, r0
    ldd r0, Z + EVEN_PIXEL_MARK_TICKS + 1
    adc r9, r0
    adc r10, r1
    adiw r30, EVEN_PIXEL_MARK_BYTES     ; 6
    mov r18, r24
    andi r18, EVEN_PIXEL_MARK_COUNT - 1
    brne next
    subi r30, lo8(EVEN_PIXEL_MARK_COUNT * EVEN_PIXEL_MARK_BYTES)
    sbci r31, hi8(EVEN_PIXEL_MARK_COUNT * EVEN_PIXEL_MARK_BYTES)
    rjmp next

done:
    movw r30, r16                       ; 5   any at all?
    ldd r26, Z + EVEN_PIXEL_RETIRED
    mov r27, RETIRED
    sub r27, r26
    brne 1f
    rjmp leave
1:  std Z + EVEN_PIXEL_RETIRED, RETIRED ; 4
    std Z + EVEN_PIXEL_MARK_TAIL, r24
    pass_time r0, r8, r9, r10           ; 20
    count_fresh r27                     ; 9
    eor r27, SIGN                       ; 22  all their steps
    sub r27, SIGN
    load_plain LEDGER_POSITION, r18, r19, r20, r21
    add r18, r27
    adc r19, SIGN
    adc r20, SIGN
    adc r21, SIGN
    store_plain LEDGER_POSITION, r18, r19, r20, r21
    plain_op sub, sbc, r26, LEDGER_ORIGIN, r18, r19, r20, r21 ; 12
    ldd r22, Y + LEDGER_PIXEL           ; 18  pixels that were taken; their sum's carry
    mov r23, PIXEL
    sub r23, r22
    mov r24, PIXEL
    std Y + LEDGER_PIXEL, r24
    cp r24, r22
    ldd r25, Y + LEDGER_PIXEL + 1
    adc r25, r1
    std Y + LEDGER_PIXEL + 1, r25
    .irp byte, 2, 3
    ldd r0, Y + LEDGER_PIXEL + \byte
    adc r0, r1
    std Y + LEDGER_PIXEL + \byte, r0
    .endr
    ldd r26, Y + LEDGER_RECORDS_TO_NEXT ; 10
    ldd r27, Y + LEDGER_RECORDS_TO_NEXT + 1
    sub r26, r23
    sbc r27, r1
    std Y + LEDGER_RECORDS_TO_NEXT, r26
    std Y + LEDGER_RECORDS_TO_NEXT + 1, r27
    find_record                         ; 23
    fill_record 18, r1, r1              ; 20
    std Z + LEDGER_RECORD_ERROR, r11
    std Z + LEDGER_RECORD_ERROR + 1, r12
    ldi r26, 1
    std Y + LEDGER_RECORDS_PASSING, r26
leave:
    .irp register, 14, 13, 12, 11, 10, 9, 8, 7
    pop r\register
    .endr
    ret
end_function ledger_take_passing

#endif
