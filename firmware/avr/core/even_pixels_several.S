; SPDX-License-Identifier: MIT
; Writes pixels of few even steps on boards of several axes: the assembly half of even_pixel.c. The
; C that this file stands for is even_pixels_write() there; even_pixels_write.S is the same for a
; single axis, in less flash and more cycles.
;
;     uint8_t even_pixels_write(struct line *line, struct stream *stream, bool negative,
;                               uint8_t budget)
;
;     r8, r9    line, while Y is the stream      r14        WAYS
;     r10       pixels that are still to be      r16, r17   stream
;               written of those that were       r22, r23   length of the pixel, ticks
;               taken from the segment
;     r11       what is left of the budget
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
;     WHOLE     the exact grid's period is a whole number of ticks
;     SHORT     the fractions of the exact grid fit 16 bits
;     MORE      the segment in work has pixels beside those of r10
;
; A pixel below 2^16 ticks takes the last quotient of as many steps, on whatever axis, if one
; product shows that it holds. Only another one is divided, by way of the reciprocals.
;
; Cycles of a pixel on a grid of whole ticks: 242 inside a run, 320 with a segment of one byte of
; its own; for each step 6, 10 for a longer one, or 4 where all are equally long. Where the grid has
; fractions of a tick some 30 more, or 90 if 16 bits do not hold them; where no quotient holds 46
; more.
#include "build_features.h" // SEVERAL_AXES
#include "avr/core/even_pixels.inc" // macros, registers
#include "avr/core/even_periods.inc" // write_in_groups; it takes STEPS from the file above
#include "layout.h" // offsets

#if SEVERAL_AXES

#define PIXELS    r10
#define LEFT      r11
#define WAYS      r14
#define EXACT_BIT 1
#define PLAIN_BIT 2
#define WHOLE_BIT 3
#define SHORT_BIT 4
#define MORE_BIT  5

#define QUOTIENTS 16 /* a power of two */

; The last quotients of pixels, by the low bits of their steps.
    .lcomm even_pixel_quotients, 2 * QUOTIENTS

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

; Z is where the last quotient of a pixel of as many steps is kept, or of 16 more or less. 6 cycles.
.macro find_quotient
    mov r30, STEPS
    andi r30, QUOTIENTS - 1
    lsl r30
    ldi r31, 0
    subi r30, lo8(-(even_pixel_quotients))
    sbci r31, hi8(-(even_pixel_quotients))
.endm

    .section .text.even_pixels_write, "ax", @progbits

; The length of a pixel of the exact grid, as line_pixel_ticks() would leave it.
remember:
    note_length
    ret

no_room:
    std Y + EVEN_PIXEL_ROOM, STEPS
wait:
    pop r24
    sub r24, LEFT
    brne give_cost
    com r24                             ;     EVEN_PIXEL_WAITS
    rjmp give_cost
leave:
    pop r24                             ; 5   what the pixels have cost
    sub r24, LEFT
give_cost:
    ldd r18, Y + EVEN_PIXEL_REPEAT      ; 10
    ldd r19, Y + EVEN_PIXEL_REPEAT + 1
    add r18, PIXELS
    adc r19, r1
    std Y + EVEN_PIXEL_REPEAT, r18
    std Y + EVEN_PIXEL_REPEAT + 1, r19
    .irp register, 29, 28, 17, 16, 14, 13, 12, 11, 10, 9, 8 ; 27
    pop r\register
    .endr
    ret

; The segment in work has a pixel: takes as many as PIXELS can count.
load_pixels:
    ldd r24, Y + EVEN_PIXEL_REPEAT
    ldd r25, Y + EVEN_PIXEL_REPEAT + 1
    ldi r18, 0xFF - (1 << MORE_BIT)
    and WAYS, r18
    mov PIXELS, r24
    tst r25
    breq 1f
    com r18                             ;     255 of more
    or WAYS, r18
    ldi r18, 0xFF
    mov PIXELS, r18
1:  sub r24, PIXELS
    sbc r25, r1
    std Y + EVEN_PIXEL_REPEAT, r24
    std Y + EVEN_PIXEL_REPEAT + 1, r25
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
    rcall load_pixels
    rjmp next_pixel

function even_pixels_write
    .irp register, 8, 9, 10, 11, 12, 13, 14, 16, 17, 28, 29, 18
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov LEFT, r18
    clr PIXELS
    ldd r18, Y + EVEN_PIXEL_FLAGS
    sbrs r18, EVEN_PIXEL_SMOOTH_BIT
    ori r20, 1 << PLAIN_BIT
    mov WAYS, r20
    ldd r24, Y + EVEN_PIXEL_REPEAT
    ldd r25, Y + EVEN_PIXEL_REPEAT + 1
    or r24, r25
    breq next_segment
    sbrs WAYS, PLAIN_BIT
    rjmp ask_segment
    rcall load_pixels
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
    std Y + EVEN_PIXEL_COUNT, r24       ; 5
    std Y + EVEN_PIXEL_COUNT + 1, r25
    mov PIXELS, r26
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
    sbrs WAYS, EXACT_BIT                ; 2
    rjmp look_at_grid
exact:
    ldd r30, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD ; 4
    ldd r31, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD + 1
    .irp byte, 0, 1, 2, 3               ; 8
    ldd 22 + \byte, Z + PIXEL_PERIOD_WHOLE + \byte
    .endr
    sbrs WAYS, WHOLE_BIT                ; 2
    rjmp fraction
length_known:
    mov TICKS2, r24                     ; 3
    or r24, r25
    brne far_long_pixel
    find_quotient                       ; 10  the last quotient of as many steps
    ld r20, Z
    ldd r21, Z + 1
    mul r20, STEPS                      ; 18  holds if one product leaves less than the steps
    mov r24, r22
    sub r24, r0
    mov r25, r23
    sbc r25, r1
    brlo divide
    mul r21, STEPS
    sub r25, r0
    brlo divide
    or r25, r1
    brne divide
    clr r1
    cp r24, STEPS
    brsh divide
    rjmp divided
far_wait:
    rjmp wait
far_no_room:
    rjmp no_room
no_even_steps:
    rjmp leave
far_not_here:
    rjmp not_here
far_long_pixel:
    rjmp long_pixel

no_single_periods:
    clr r24
    clr r25
    rjmp not_here

; divide_short() in even_pixel.c.
divide:
    clr r1                              ; 13
    ldi r30, lo8(even_pixel_reciprocals)
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
    find_quotient                       ; 10
    st Z, r20
    std Z + 1, r21

divided:
    sbrs WAYS, EXACT_BIT                ; 2
    rcall forget
    dec PIXELS                          ; 1
    move_position WAYS, r18, r19        ; 14

; Append the pixel to the stream: its length r23:r22 (and TICKS2), the shorter interval r21:r20, the
; number of longer ones r24, the position r19:r18.
    movw r8, r28                        ; 2
    movw r28, r16
    ldd r26, Y + EVEN_PIXEL_WAYPOINT_HEAD   ; 18  its end's waypoint waits; that before gets a slot
    mov r27, r26
    inc r27
    std Y + EVEN_PIXEL_WAYPOINT_HEAD, r27
    std Y + EVEN_PIXEL_WAYPOINT_PLACED, r26
    dec r26
    andi r26, EVEN_PIXEL_WAYPOINT_COUNT - 1
    ldi r27, EVEN_PIXEL_WAYPOINT_BYTES
    mul r26, r27
    movw r30, r0
    clr r1
    add r30, r28
    adc r31, r29
    adiw r30, EVEN_PIXEL_WAYPOINTS
    bst r26, 0                          ; 3   T: it is the last one in memory
    cpi r26, EVEN_PIXEL_WAYPOINT_COUNT - 1
    breq 1f
    clt
1:  ldd r25, Y + EVEN_PIXEL_HEAD        ; 5   behind the first period
    inc r25
    std Z + EVEN_PIXEL_WAYPOINT_SLOT, r25
    ldd r25, Y + EVEN_PIXEL_PLAIN       ; 10
    ldd r26, Z + EVEN_PIXEL_WAYPOINT_WAY
    or r25, r26
    std Z + EVEN_PIXEL_WAYPOINT_WAY, r25
    ldi r25, EVEN_PIXEL_WAY_PLAIN
    std Y + EVEN_PIXEL_PLAIN, r25
    movw r26, r20                       ; 4   which is a longer one if any is
    cpse r24, r1
    adiw r26, 1
    ldd r25, Y + EVEN_PIXEL_END_TICKS   ; 37  time there, and at the end of the pixel
    mov r0, r25
    add r25, r26
    std Z + EVEN_PIXEL_WAYPOINT_TICKS, r25
    ldd r26, Y + EVEN_PIXEL_END_TICKS + 1
    mov r25, r26
    adc r25, r27
    std Z + EVEN_PIXEL_WAYPOINT_TICKS + 1, r25
    ldd r27, Y + EVEN_PIXEL_END_TICKS + 2
    mov r25, r27
    adc r25, r1
    std Z + EVEN_PIXEL_WAYPOINT_TICKS + 2, r25
    ldd r25, Y + EVEN_PIXEL_END_TICKS + 3
    add_number r0, r26, r27, r25, r22, r23, TICKS2, r1
    store_plain EVEN_PIXEL_END_TICKS, r0, r26, r27, r25
    brtc 3f                             ; 10  its end's waypoint waits
    subi r30, lo8(EVEN_PIXEL_WAYPOINT_COUNT * EVEN_PIXEL_WAYPOINT_BYTES)
    sbci r31, hi8(EVEN_PIXEL_WAYPOINT_COUNT * EVEN_PIXEL_WAYPOINT_BYTES)
3:  std Z + EVEN_PIXEL_WAYPOINT_BYTES + EVEN_PIXEL_WAYPOINT_WAY, r1
    std Z + EVEN_PIXEL_WAYPOINT_BYTES + EVEN_PIXEL_WAYPOINT_POSITION, r18
    std Z + EVEN_PIXEL_WAYPOINT_BYTES + EVEN_PIXEL_WAYPOINT_POSITION + 1, r19
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
    cost_of_pixel                       ; 7
    sub LEFT, r24
    brcs far_leave
    breq far_leave
    cpse PIXELS, r1                     ; 6
    rjmp next_pixel
    sbrs WAYS, MORE_BIT
    rjmp next_segment
    rcall load_pixels
    rjmp next_pixel
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

; The sum of the grid's fractions, by 16 bits: r23:r22 is one more where it comes to a whole.
fraction:
    sbrs WAYS, SHORT_BIT                ; 2
    rjmp advance_grid
    ldd r18, Y + EVEN_PIXEL_GRID + PIXEL_GRID_SUM ; 14
    ldd r19, Y + EVEN_PIXEL_GRID + PIXEL_GRID_SUM + 1
    ldd r20, Z + PIXEL_PERIOD_REMAINDER
    ldd r21, Z + PIXEL_PERIOD_REMAINDER + 1
    add r18, r20
    adc r19, r21
    ldd r20, Z + PIXEL_PERIOD_DIVISOR
    ldd r21, Z + PIXEL_PERIOD_DIVISOR + 1
    brcs 1f                             ; 4
    cp r18, r20
    cpc r19, r21
    brlo 2f
1:  sub r18, r20                        ; 6
    sbc r19, r21
    subi r22, 0xFF
    .irp register, r23, r24, r25
    sbci \register, 0xFF
    .endr
2:  std Y + EVEN_PIXEL_GRID + PIXEL_GRID_SUM, r18 ; 6
    std Y + EVEN_PIXEL_GRID + PIXEL_GRID_SUM + 1, r19
    rjmp length_known
look_at_grid:
    look_for_exact_pixel ask
    ldi r18, 1 << EXACT_BIT
    ldd r30, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD
    ldd r31, Y + EVEN_PIXEL_GRID + PIXEL_GRID_PERIOD + 1
    ldd r19, Z + PIXEL_PERIOD_REMAINDER
    .irp byte, 1, 2, 3
    ldd r20, Z + PIXEL_PERIOD_REMAINDER + \byte
    or r19, r20
    .endr
    brne 1f
    ori r18, 1 << WHOLE_BIT
1:  ldd r19, Z + PIXEL_PERIOD_DIVISOR + 2
    ldd r20, Z + PIXEL_PERIOD_DIVISOR + 3
    or r19, r20
    brne 2f
    ori r18, 1 << SHORT_BIT
2:  or WAYS, r18
    rjmp exact
advance_grid:
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
    breq 1f
    rjmp length_known
1:  rjmp not_here

; A pixel of 2^16 ticks and more.
long_pixel:
    mov r24, TICKS2
    cpi r24, EVEN_PIXEL_TICKS_TOO_BIG
    cpc r25, r1
    brsh 1f
    keep_interval divide_long           ; 28
    ldd r20, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE ; 6
    ldd r21, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_BASE + 1
    mov r24, r26
    rjmp divided
1:  rjmp not_here

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
