; SPDX-License-Identifier: MIT
; Writes pixels of few even steps on boards of several axes: the assembly half of even_pixel.c. The
; C that this file stands for is even_pixels_write() there; even_pixels_write.S is the same for a
; single axis, in less flash and more cycles.
;
;     uint8_t even_pixels_write(struct line *line, struct stream *stream, bool negative,
;                               uint8_t budget)
;
;     r8, r9    line, while Y is the stream      r14        WAYS
;     r10       what the pixels have cost        r16, r17   stream
;     r11       budget                           r22, r23   length of the pixel, ticks
;     r12       third byte of the pixel's length Y          line
;     r13       steps of a pixel
;
; WAYS tells how steps, segments and lengths are found, the same for all pixels of a call:
;
;     NEGATIVE  steps go in negative direction
;     PLAIN     a plain line: a segment of one byte is unpacked here, 80 cycles, or two, 108. Other
;               segments come from line_even_steps(), 230 cycles.
;     EXACT     this pixel and the next ones are pixels of the exact grid, as a whole. Then
;               line.to_edge_ticks stays 0 and edge_open set, as they are between two such pixels;
;               only where a pixel is not written here do they tell its length.
;
; Cycles of a pixel on a grid of whole ticks: 281 inside a run, 361 with a segment of one byte of
; its own; for each step 6, 10 for a longer one, or 4 where all are equally long. Where the grid
; has fractions of a tick 51 more; of another number of steps than the pixel before, 25 more.
#include "build_features.h" // SEVERAL_AXES
#include "motion/even_pixels.inc" // macros, registers
#include "motion/pixel_period_layout.h"

#if SEVERAL_AXES

#define WAYS      r14
#define EXACT_BIT 1
#define PLAIN_BIT 2

; X is where the byte of the queue at place r25:r24 is. Z is the queue. 12 cycles.
.macro find_queued_byte
    ldd r18, Z + EVEN_PIXEL_QUEUE_MASK
    ldd r19, Z + EVEN_PIXEL_QUEUE_MASK + 1
    and r18, r24
    and r19, r25
    ldd r26, Z + EVEN_PIXEL_QUEUE_BYTES
    ldd r27, Z + EVEN_PIXEL_QUEUE_BYTES + 1
    add r26, r18
    adc r27, r19
.endm

; Periods number `numbers` of a group: 6 cycles, or 10 where the sum r25 goes over 255 and the
; period is a longer one. `longer_periods` of the same group stands where a branch reaches it.
.macro periods group, numbers:vararg
    .irp number, \numbers
    add r25, r24
    brcs .Llonger_\group\()_\number
    st X+, r20
    st Z+, r21
.Lbehind_\group\()_\number:
    .endr
.endm

.macro longer_periods group, numbers:vararg
    .irp number, \numbers
.Llonger_\group\()_\number:
    sub r25, STEPS
    st X+, r22
    st Z+, r23
    rjmp .Lbehind_\group\()_\number
    .endr
.endm

; The same where all are equally long, 4 cycles each.
.macro equal_periods group, numbers:vararg
    .irp number, \numbers
    st X+, r20
    st Z+, r21
    .endr
.endm

; r18 periods by the macro `write`: groups of one, two and four as the bits of r18 tell, 13 cycles,
; and then of eight, 3 cycles each.
.macro write_in_groups write
    sbrs r18, 0
    rjmp 7f
    \write one, 0
7:  sbrs r18, 1
    rjmp 7f
    \write two, 0, 1
7:  sbrs r18, 2
    rjmp 7f
    \write four, 0, 1, 2, 3
7:  andi r18, 0xF8
    breq 9f
7:  \write eight, 0, 1, 2, 3, 4, 5, 6, 7
    subi r18, 8
    brne 7b
9:
.endm

    .section .text.even_pixels_write, "ax", @progbits

; The length of a pixel of the exact grid, as line_pixel_ticks() would leave it.
remember:
    note_length
    ret

no_room:
    std Y + EVEN_PIXEL_ROOM, STEPS
wait:
    cpse SPENT, r1
    rjmp leave
    com SPENT                           ;     EVEN_PIXEL_WAITS
leave:
    mov r24, SPENT
    .irp register, 29, 28, 17, 16, 14, 13, 12, 11, 10, 9, 8
    pop r\register
    .endr
    ret
not_here:
    sbrc WAYS, EXACT_BIT
    rcall remember
    rjmp leave

; Any segment, also one that is in work.
ask_segment:
    movw r24, r28
    mov r22, WAYS
    andi r22, 1 << NEGATIVE_BIT
    call line_even_steps
    mov STEPS, r24
    subi r24, 1                         ;     0 is no such pixel either
    cpi r24, EVEN_PIXEL_MOST_STEPS
    brsh leave
    rjmp next_pixel

function even_pixels_write
    .irp register, 8, 9, 10, 11, 12, 13, 14, 16, 17, 28, 29
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov BUDGET, r18
    clr SPENT
    ldd r18, Y + EVEN_PIXEL_FLAGS
    sbrs r18, EVEN_PIXEL_SMOOTH_BIT
    ori r20, 1 << PLAIN_BIT
    mov WAYS, r20
    look_for_pixel_of_segment
    breq next_segment
    sbrs WAYS, PLAIN_BIT
    rjmp ask_segment
    ldd r24, Y + EVEN_PIXEL_COUNT
    ldd r25, Y + EVEN_PIXEL_COUNT + 1
    rjmp segment_in_work
dry:
    rjmp leave
far_ask_segment:
    rjmp ask_segment

; A segment of two bytes: a short run.
short_run:
    cpi r20, EVEN_PIXEL_RUN
    brsh far_ask_segment
    subi r20, EVEN_PIXEL_SHORT_RUN
    adiw r24, 1
    find_queued_byte
    mov r18, r20
    ld r20, X
    mov r26, r18
    rjmp segment_read

next_segment:
    sbrs WAYS, PLAIN_BIT                ; 2
    rjmp ask_segment
    ld r30, Y                           ; 15  is one queued?
    ldd r31, Y + 1
    ldd r24, Z + EVEN_PIXEL_QUEUE_AT
    ldd r25, Z + EVEN_PIXEL_QUEUE_AT + 1
    ldd r18, Z + EVEN_PIXEL_QUEUE_HEAD
    ldd r19, Z + EVEN_PIXEL_QUEUE_HEAD + 1
    cp r18, r24
    cpc r19, r25
    breq dry
    find_queued_byte                    ; 17  of one byte?
    ld r20, X
    ldi r26, 1
    cpi r20, EVEN_PIXEL_NEAR_LAST + 1
    brsh short_run
    subi r20, EVEN_PIXEL_NEAR_ZERO
segment_read:
    adiw r24, 1                         ; 20  it is passed, and in work
    std Z + EVEN_PIXEL_QUEUE_AT, r24
    std Z + EVEN_PIXEL_QUEUE_AT + 1, r25
    ldd r24, Z + EVEN_PIXEL_QUEUE_LAST
    ldd r25, Z + EVEN_PIXEL_QUEUE_LAST + 1
    mov r21, r20
    lsl r21
    sbc r21, r21
    add r24, r20
    adc r25, r21
    std Z + EVEN_PIXEL_QUEUE_LAST, r24
    std Z + EVEN_PIXEL_QUEUE_LAST + 1, r25
    std Y + EVEN_PIXEL_COUNT, r24       ; 9
    std Y + EVEN_PIXEL_COUNT + 1, r25
    std Y + EVEN_PIXEL_REPEAT, r26
    std Y + EVEN_PIXEL_REPEAT + 1, r1
segment_in_work:
    sbrs WAYS, NEGATIVE_BIT             ; 9   in the direction of the steps before it, and few?
    rjmp 1f
    com r25
    neg r24
    sbci r25, 0xFF
1:  cpse r25, r1
    rjmp leave
    mov STEPS, r24
    subi r24, 1
    cpi r24, EVEN_PIXEL_MOST_STEPS
    brsh no_even_steps
    std Y + EVEN_PIXEL_CURVE_HALF, r1   ; 8
    std Y + EVEN_PIXEL_CURVE_HALF + 1, r1
    std Y + EVEN_PIXEL_SPEED, STEPS
    std Y + EVEN_PIXEL_SPEED + 1, r1

next_pixel:
    look_for_room far_wait, far_no_room ; 16
    sbrc WAYS, EXACT_BIT                ; 4
    rjmp exact
    look_for_exact_pixel ask
    ldi r18, 1 << EXACT_BIT
    or WAYS, r18
exact:
    ldd r30, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD ; 17 a whole number of ticks?
    ldd r31, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD + 1
    ldd r18, Z + PIXEL_PERIOD_REMAINDER
    .irp byte, 1, 2, 3
    ldd r19, Z + PIXEL_PERIOD_REMAINDER + \byte
    or r18, r19
    .endr
    brne fraction
    .irp byte, 0, 1, 2, 3               ; 8
    ldd 22 + \byte, Z + PIXEL_PERIOD_WHOLE + \byte
    .endr
    rjmp length_known
far_wait:
    rjmp wait
far_no_room:
    rjmp no_room
no_even_steps:
    rjmp leave
far_not_here:
    rjmp not_here
fraction:
    movw r24, r28
    adiw r24, EVEN_PIXEL_GRID
    call pixel_grid_advance
    rjmp length_known
ask:
    movw r24, r28                       ;     how long is the pixel? 0: not known yet
    call line_pixel_ticks
    mov r18, r22
    or r18, r23
    or r18, r24
    breq far_not_here
length_known:
    mov TICKS2, r24                     ; 5
    cpi r24, EVEN_PIXEL_TICKS_TOO_BIG
    cpc r25, r1
    brsh far_not_here

    keep_interval divide                ; 28
    ldd r20, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE ; 6
    ldd r21, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE + 1
    mov r24, r26
    rjmp divided

; No interval of the next pixel follows from this one.
no_single_periods:
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_STEPS, r1
    clr r24
    clr r25
    rjmp not_here

; divide_short() in even_pixel.c.
divide:
    cpse TICKS2, r1                     ; 3
    rjmp divide_long
    ldi r30, lo8(even_pixel_reciprocals) ; 12
    ldi r31, hi8(even_pixel_reciprocals)
    add r30, STEPS
    adc r31, r1
    add r30, STEPS
    adc r31, r1
    lpm r26, Z+
    lpm r27, Z
    mul r22, r26                        ; 18  r21:r20 = ticks * reciprocal / 65536
    mov r18, r1
    mul r23, r27
    movw r20, r0
    clr r19
    mul r22, r27
    add r18, r0
    adc r20, r1
    adc r21, r19
    mul r23, r26
    add r18, r0
    adc r20, r1
    adc r21, r19
    mul r20, STEPS                      ; 8   the rest
    mov r24, r22
    sub r24, r0
    clr r1
    cp r24, STEPS
    brlo 1f
    sub r24, STEPS
    subi r20, 0xFF
    sbci r21, 0xFF
1:  cpi r21, EVEN_PIXEL_BASE_MAX_HIGH   ; 6   neither too long nor too short?
    brsh no_single_periods
    cpi r20, EVEN_PIXEL_BASE_MIN
    cpc r21, r1
    brlo no_single_periods
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_STEPS, STEPS ; 12
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS, r22
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS + 1, r23
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE, r20
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE + 1, r21
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_REMAINDER, r24

divided:
    sbrs WAYS, EXACT_BIT                ; 2
    rcall forget
    take_pixel_of_segment r26, r27      ; 10
    move_position WAYS, r18, r19        ; 14

; Append the pixel to the stream: its length r23:r22 (and TICKS2), the shorter interval r21:r20, the
; number of longer ones r24, the position r19:r18.
    movw r8, r28                        ; 2
    movw r28, r16
    ldd r26, Y + EVEN_PIXEL_MARK_HEAD   ; 18  its end's mark waits; the one before gets a place
    mov r27, r26
    inc r27
    std Y + EVEN_PIXEL_MARK_HEAD, r27
    std Y + EVEN_PIXEL_MARK_PLACED, r26
    dec r26
    andi r26, EVEN_PIXEL_MARK_COUNT - 1
    ldi r27, EVEN_PIXEL_MARK_BYTES
    mul r26, r27
    movw r30, r0
    clr r1
    add r30, r28
    adc r31, r29
    adiw r30, EVEN_PIXEL_MARKS
    bst r26, 0                          ; 3   T: it is the last one in memory
    cpi r26, EVEN_PIXEL_MARK_COUNT - 1
    breq 1f
    clt
1:  ldd r25, Y + EVEN_PIXEL_HEAD        ; 5   behind the first period
    inc r25
    std Z + EVEN_PIXEL_MARK_SLOT, r25
    movw r26, r20                       ; 4   which is a longer one if any is
    cpse r24, r1
    adiw r26, 1
    ldd r25, Y + EVEN_PIXEL_BEHIND_TICKS ; 16 time from the mark before that one
    add r25, r26
    std Z + EVEN_PIXEL_MARK_TICKS, r25
    ldd r25, Y + EVEN_PIXEL_BEHIND_TICKS + 1
    adc r25, r27
    std Z + EVEN_PIXEL_MARK_TICKS + 1, r25
    brcs 2f
    ldd r25, Y + EVEN_PIXEL_BEHIND_PERIODS ;  not known is one below 0
    inc r25
    std Z + EVEN_PIXEL_MARK_PERIODS, r25
2:  brtc 3f                             ; 10
    subi r30, lo8(EVEN_PIXEL_MARK_COUNT * EVEN_PIXEL_MARK_BYTES)
    sbci r31, hi8(EVEN_PIXEL_MARK_COUNT * EVEN_PIXEL_MARK_BYTES)
3:  std Z + EVEN_PIXEL_MARK_BYTES + EVEN_PIXEL_MARK_FLAGS, r1
    std Z + EVEN_PIXEL_MARK_BYTES + EVEN_PIXEL_MARK_PERIODS, r1
    std Z + EVEN_PIXEL_MARK_BYTES + EVEN_PIXEL_MARK_POSITION, r18
    std Z + EVEN_PIXEL_MARK_BYTES + EVEN_PIXEL_MARK_POSITION + 1, r19
    mov r25, STEPS                      ; 7
    dec r25
    cpse TICKS2, r1                     ;     of the time above 16 bits the marks know nothing
    ldi r25, 0xFF
    std Y + EVEN_PIXEL_BEHIND_PERIODS, r25
    movw r30, r22                       ; 7
    sub r30, r26
    sbc r31, r27
    std Y + EVEN_PIXEL_BEHIND_TICKS, r30
    std Y + EVEN_PIXEL_BEHIND_TICKS + 1, r31
    ldd r25, Y + EVEN_PIXEL_END_TICKS   ; 20
    add r25, r22
    std Y + EVEN_PIXEL_END_TICKS, r25
    ldd r25, Y + EVEN_PIXEL_END_TICKS + 1
    adc r25, r23
    std Y + EVEN_PIXEL_END_TICKS + 1, r25
    ldd r25, Y + EVEN_PIXEL_END_TICKS + 2
    adc r25, TICKS2
    std Y + EVEN_PIXEL_END_TICKS + 2, r25
    ldd r25, Y + EVEN_PIXEL_END_TICKS + 3
    adc r25, r1
    std Y + EVEN_PIXEL_END_TICKS + 3, r25

; Its periods. The slot behind the last one reads empty, and the interrupt must not see the first
; one yet: its high byte is written last.
;
;     r0        that byte                       r21:r20  shorter interval - 1
;     r18       periods still to write          r23:r22  longer interval - 1
;     r19       page of the high bytes          r24      so many are longer
;     r28       first slot                      r25      the fraction that is carried
;     r29       periods behind the ring's end   X, Z     the next entry's low and high byte
    ldd r27, Y + EVEN_PIXEL_RING + 1    ; 16
    ldd r26, Y + EVEN_PIXEL_HEAD
    mov r31, r27
    inc r31
    mov r19, r31
    mov r30, r26
    add r30, STEPS
    std Y + EVEN_PIXEL_HEAD, r30
    ldi r25, 0xFF
    st Z, r25
    mov r30, r26
    mov r28, r26
    subi r20, 1                         ; 5
    sbci r21, 0
    movw r22, r20
    subi r22, 0xFF
    sbci r23, 0xFF
    mov r18, STEPS                      ; 12  the first one; behind it the ring may end
    dec r18
    mov r25, STEPS
    cpse r24, r1
    rjmp 4f
    st X, r20
    mov r0, r21
    rjmp 5f
    longer_periods one, 0
    longer_periods two, 0, 1
    longer_periods four, 0, 1, 2, 3
4:  st X, r22
    mov r0, r23
    mov r25, r24
5:  dec r25
    tst r18
    brne 1f
    rjmp written
1:  clr r29
    inc r26                             ; 6
    inc r30
    breq 6f
    mov r29, r30                        ;     periods - (256 - slot), if that is 0 or more
    add r29, r18
    brcc 1f
    rjmp 8f
1:  clr r29
6:  cpse r24, r1
    rjmp 1f
    rjmp equal
1:  sub r25, STEPS                      ; 1   the sum goes over 255 where it went over STEPS

mixed:
    write_in_groups periods
    cpse r29, r1
    rjmp 1f
    rjmp written
1:  rcall begin_of_ring
    rjmp mixed
8:  sub r18, r29
    rjmp 6b
    longer_periods eight, 0, 1, 2, 3, 4, 5, 6, 7

equal:
    write_in_groups equal_periods
    tst r29
    breq written
    rcall begin_of_ring
    rjmp equal

written:
    mov r30, r28                        ; 5
    mov r31, r19
    st Z, r0
    movw r28, r8
    count_cost                          ; 7
    brsh far_leave
    look_for_pixel_of_segment           ; 9
    breq 1f
    rjmp next_pixel
1:  rjmp next_segment
far_leave:
    rjmp leave

; The rest of the periods is written from slot 0 on. X and Z have come to the pages behind theirs.
begin_of_ring:
    mov r18, r29
    clr r29
    dec r27
    dec r31
    ret

forget:
    forget_length r25
    ret

divide_long:
    sbrc WAYS, EXACT_BIT
    rcall remember
    call_divide
    cpse r24, r1
    rjmp 1f
    rjmp leave
1:  sbrc WAYS, EXACT_BIT
    rcall forget
    ldd r22, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS
    ldd r23, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS + 1
    ldd r20, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE
    ldd r21, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE + 1
    ldd r24, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_REMAINDER
    rjmp divided
end_function even_pixels_write

#endif
