; SPDX-License-Identifier: MIT
; Writes pixels of few even steps of a single axis, one after the other: the assembly half of
; even_pixel.c. The C that this file stands for is even_pixels_write() there.
;
;     uint8_t even_pixels_write(struct line *line, struct stream *stream, bool negative,
;                               uint8_t budget)
;
;     r10  what the pixels have cost         r14       steps go in negative direction
;     r11  budget                            r16, r17  stream
;     r12  third byte of the pixel's length  r22..r25  length of the pixel, ticks
;     r13  steps of a pixel                  Y         line
;
; Cycles of a pixel: some 175, pixel_grid_advance() and even_pixel_put(); of a locked line some 150,
; line_pixel_ticks() and even_pixel_put(); with another number of steps than the
; pixel before, line_even_steps() and even_pixel_divide() besides.
#include "base/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "motion/even_pixel_layout.h"

#if !SEVERAL_AXES

#define SPENT    r10
#define BUDGET   r11
#define TICKS2   r12
#define STEPS    r13
#define NEGATIVE r14
#define NEGATIVE_BIT 0
#define TICKS    r22, r23, r24, r25

; The length of the pixel, as line_pixel_ticks() leaves it.
.macro note_length
    store_plain EVEN_PIXEL_TO_EDGE, TICKS
    ldd r18, Y + EVEN_PIXEL_FLAGS
    andi r18, 0xFF - EVEN_PIXEL_EDGE_OPEN
    std Y + EVEN_PIXEL_FLAGS, r18
.endm

    .section .text.even_pixels_write, "ax", @progbits
function even_pixels_write
    .irp register, 10, 11, 12, 13, 14, 16, 17, 28, 29
    push r\register
    .endr
    movw r28, r24
    movw r16, r22
    mov NEGATIVE, r20                   ;     the other bits are 0
    mov BUDGET, r18
    clr SPENT
    rjmp next_segment

no_room:
    std Y + EVEN_PIXEL_ROOM, STEPS
wait:
    cpse SPENT, r1
    rjmp leave
    com SPENT                           ;     EVEN_PIXEL_WAITS
leave:
    mov r24, SPENT
    .irp register, 29, 28, 17, 16, 14, 13, 12, 11, 10
    pop r\register
    .endr
    ret


divide:
    movw r18, r22                       ;     length and steps to their places
    movw r20, r24
    movw r24, r28
    adiw r24, EVEN_PIXEL_RATE
    mov r22, STEPS
    call even_pixel_divide
    cpse r24, r1
    rjmp forget_length
    rjmp leave

next_segment:
    movw r24, r28
    mov r22, NEGATIVE
    andi r22, 1 << NEGATIVE_BIT
    call line_even_steps
    mov STEPS, r24
    subi r24, 1                         ;     0 is no such pixel either
    cpi r24, EVEN_PIXEL_MOST_STEPS
    brsh leave

next_pixel:
    movw r30, r16                       ; 8   a mark is free?
    ldd r18, Z + EVEN_PIXEL_MARK_HEAD
    ldd r19, Z + EVEN_PIXEL_MARK_TAIL
    sub r18, r19
    cpi r18, EVEN_PIXEL_MARK_COUNT - 1
    brsh wait
    ldd r18, Z + EVEN_PIXEL_RETIRED     ; 9   room in the ring?
    ldd r19, Z + EVEN_PIXEL_HEAD
    sub r18, r19
    subi r18, 256 - EVEN_PIXEL_RING_CAPACITY
    cp r18, STEPS
    brlo no_room
    ldd r18, Y + EVEN_PIXEL_FLAGS       ; 19  a pixel of the exact grid, as a whole?
    sbrs r18, EVEN_PIXEL_EDGE_OPEN_BIT
    rjmp ask
    ldd r19, Y + EVEN_PIXEL_GRID_MODE
    .irp byte, 0, 1, 2, 3
    ldd r20, Y + EVEN_PIXEL_TO_EDGE + \byte
    or r19, r20
    .endr
    brne ask
exact:
    movw r24, r28                       ; 5
    adiw r24, EVEN_PIXEL_GRID
    call pixel_grid_advance
    note_length
    rjmp length_known
far_divide:
    rjmp divide
far_leave:
    rjmp leave
ask:
    movw r24, r28                       ; 9   how long is the pixel? 0: not known yet
    call line_pixel_ticks
length_known:
    mov TICKS2, r24                     ; 8
    cpi r24, EVEN_PIXEL_TICKS_TOO_BIG
    brsh far_leave
    mov r18, r22
    or r18, r23
    or r18, r24
    breq far_leave

    ldd r18, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_STEPS ; 4 as many steps as in the last pixel?
    cp r18, STEPS
    brne far_divide
    ldd r18, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS ; 18 then the remainder may take the difference
    ldd r19, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS + 1
    ldd r20, Y + EVEN_PIXEL_RATE + EVEN_PIXEL_REMAINDER
    movw r26, r22
    sub r26, r18
    sbc r27, r19
    add r26, r20
    adc r27, r1
    brne far_divide
    cp r26, STEPS
    brsh far_divide
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_REMAINDER, r26 ; 6
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS, r22
    std Y + EVEN_PIXEL_RATE + EVEN_PIXEL_TICKS + 1, r23

forget_length:
    ldd r24, Y + EVEN_PIXEL_FLAGS       ; 13  the pixel behind has no length yet
    ori r24, EVEN_PIXEL_EDGE_OPEN
    std Y + EVEN_PIXEL_FLAGS, r24
    .irp byte, 0, 1, 2, 3
    std Y + EVEN_PIXEL_TO_EDGE + \byte, r1
    .endr
4:
    ldd r24, Y + EVEN_PIXEL_REPEAT      ; 10  one pixel less of the segment
    ldd r25, Y + EVEN_PIXEL_REPEAT + 1
    sbiw r24, 1
    std Y + EVEN_PIXEL_REPEAT, r24
    std Y + EVEN_PIXEL_REPEAT + 1, r25
    ldd r20, Y + EVEN_PIXEL_POSITION    ; 15  position
    ldd r21, Y + EVEN_PIXEL_POSITION + 1
    sbrc NEGATIVE, NEGATIVE_BIT
    rjmp 1f
    add r20, STEPS
    adc r21, r1
    rjmp 2f
1:  sub r20, STEPS
    sbc r21, r1
2:  std Y + EVEN_PIXEL_POSITION, r20
    std Y + EVEN_PIXEL_POSITION + 1, r21

    movw r22, r28                       ; 8   r20, r21 are the position
    subi r22, -EVEN_PIXEL_RATE
    sbci r23, -1
    movw r24, r16
    call even_pixel_put
    cpse TICKS2, r1                     ; 2
    rcall longer_than_16_bits

    mov r24, STEPS                      ; 6   what the pixel costs
    lsr r24
    lsr r24
    subi r24, -EVEN_PIXEL_COST
    add SPENT, r24
    cp SPENT, BUDGET
    brlo 2f
    rjmp leave
2:  ldd r24, Y + EVEN_PIXEL_REPEAT      ; 9   another one of the segment?
    ldd r25, Y + EVEN_PIXEL_REPEAT + 1
    or r24, r25
    breq 3f
    rjmp next_pixel
3:  rjmp next_segment

; The time above 16 bits, of which the marks know nothing.
longer_than_16_bits:
    movw r30, r16
    ldi r24, 0xFF
    std Z + EVEN_PIXEL_BEHIND_PERIODS, r24
    ldd r24, Z + EVEN_PIXEL_END_TICKS + 2
    add r24, TICKS2
    std Z + EVEN_PIXEL_END_TICKS + 2, r24
    ldd r24, Z + EVEN_PIXEL_END_TICKS + 3
    adc r24, r1
    std Z + EVEN_PIXEL_END_TICKS + 3, r24
    ret
end_function even_pixels_write

#endif
