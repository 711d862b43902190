; SPDX-License-Identifier: MIT
; The account from waypoint to waypoint: the assembly of ledger_waypoints.c, which is the C that
; this file stands for.
#include "avr/core/asm.inc" // macros
#include "build_features.h" // FEATURE_CLOCK_STATISTICS, SEVERAL_AXES
#include "layout.h" // offsets

; Y is the ledger in all macros.

; Z, the stream, becomes the place of waypoint r24 from there on (less EVEN_PIXEL_WAYPOINTS). r18
; and `scratch` are lost. 8 cycles.
.macro find_waypoint scratch
    mov r18, r24
    andi r18, EVEN_PIXEL_WAYPOINT_COUNT - 1
    ldi \scratch, EVEN_PIXEL_WAYPOINT_BYTES
    mul r18, \scratch
    add r30, r0
    adc r31, r1
    clr r1
.endm

; So many periods more: at most three lengths are told by the ring. r26 is lost. 9 cycles.
.macro count_fresh periods
    ldd r26, Y + LEDGER_FRESH
    add r26, \periods
    brcs 1f
    cpi r26, 4
    brlo 2f
1:  ldi r26, 3
2:  std Y + LEDGER_FRESH, r26
.endm

; Z becomes the place of the next record, which is that of the newest one if it is passed over. r26
; is lost. 23 cycles.
.macro find_record
    ldd r30, Y + LEDGER_RECORDS_NEWEST
    ldd r26, Y + LEDGER_RECORDS_PASSING
    tst r26
    brne 8f
    inc r30
    cpi r30, RECORDS_KEPT
    brlo 7f
    clr r30
7:  std Y + LEDGER_RECORDS_NEWEST, r30
    ldd r26, Y + LEDGER_RECORDS_COUNT
    cpi r26, RECORDS_KEPT
    brsh 8f
    inc r26
    std Y + LEDGER_RECORDS_COUNT, r26
8:  ldi r26, LEDGER_RECORD_BYTES
    mul r30, r26
    movw r30, r0
    clr r1
    add r30, r28
    adc r31, r29
    adiw r30, LEDGER_RECORDS_KEPT
.endm

; The record at Z: the steps in four registers from number `steps` on, so many beyond those
; expected, and the pixel r25:r24. 16 cycles.
.macro fill_record steps, beyond_low, beyond_high
    .irp byte, 0, 1, 2, 3
    std Z + \byte, \steps + \byte
    .endr
    std Z + LEDGER_RECORD_BEYOND, \beyond_low
    std Z + LEDGER_RECORD_BEYOND + 1, \beyond_high
    std Z + LEDGER_RECORD_PIXEL, r24
    std Z + LEDGER_RECORD_PIXEL + 1, r25
.endm

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

; bool ledger_pass_waypoints(struct ledger *ledger, struct stream *stream, uint8_t tail)
;
;     r15  where the interrupt reads next   r16, r17  stream   Y  ledger   r22  periods passed
;
; Cycles of a pixel edge: 241, all included but an error of an edge that is another than the one
; before; with a single axis 255.
#define TAIL    r15
#define PERIODS r22

    .section .text.ledger_pass_waypoints, "ax", @progbits
ways_out_of_pass_waypoints:
17: ldd r24, Z + EVEN_PIXEL_PLAIN       ;     no waypoint yet: on the way to one?
    tst r24
    breq 14f
    mov r0, TAIL
    sub r0, r20
15: ldi r24, 1                          ;     unless it lags too far, by r0 periods
    ldi r20, EVEN_PIXEL_LAG_MOST
    cp r0, r20
    brlo 16f
14: clr r24
16: .irp register, 29, 28, 17, 16, 15
    pop r\register
    .endr
    ret

function ledger_pass_waypoints
    .irp register, 15, 16, 17, 28, 29
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov TAIL, r20
13: movw r30, r16                       ; 10  a waypoint that has its slot?
    ldd r24, Z + EVEN_PIXEL_WAYPOINT_TAIL
    ldd r25, Z + EVEN_PIXEL_WAYPOINT_PLACED
    ldd r20, Z + EVEN_PIXEL_RETIRED
    cp r24, r25
    breq 17b
    movw r26, r30                       ; 9
    find_waypoint r25
    ldd r19, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_WAY ; 6 by single periods alone,
    mov r25, r19
    andi r25, EVEN_PIXEL_WAY_PLAIN
    cpi r25, EVEN_PIXEL_WAY_PLAIN
    brne 14b
    ldd r21, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_SLOT ; 8 and passed?
    mov PERIODS, r21
    sub PERIODS, r20
    mov r0, TAIL
    sub r0, r20
    cp r0, PERIODS
    brlo 15b

    adiw r26, EVEN_PIXEL_RETIRED        ; 9
    st X, r21
    adiw r26, EVEN_PIXEL_WAYPOINT_TAIL - EVEN_PIXEL_RETIRED
    inc r24
    st X, r24
    movw r26, r16                       ; 28  time, of which the waypoint knows 24 bits
    adiw r26, EVEN_PIXEL_DELAY_TICKS
    ldd r0, Y + LEDGER_LOADED + 2
    .irp byte, 0, 1, 2
    ld r25, X+
    ldd r18, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_TICKS + \byte
    .if \byte == 0
    add r18, r25
    .else
    adc r18, r25
    .endif
    std Y + LEDGER_LOADED + \byte, r18
    .endr
    cp r18, r0
    brsh 19f
    ldd r18, Y + LEDGER_LOADED + 3
    inc r18
    std Y + LEDGER_LOADED + 3, r18
19:
#if SEVERAL_AXES
    sbrc r19, 7                         ; 2   a place, no edge
    rjmp 18f
#endif
    ldd r18, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_POSITION ; 14
    ldd r19, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_POSITION + 1
#if SEVERAL_AXES
    count_periods
    write_record
#if FEATURE_CLOCK_STATISTICS
    take_early_error .Lnext_waypoint
    call records_note_newest
#endif
.Lnext_waypoint:
#else
    call pass_periods
    call pass_edge
#endif
    rjmp 13b
#if SEVERAL_AXES
18: call pass_periods
    rjmp 13b
#endif

end_function ledger_pass_waypoints
