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
; Cycles of a pixel: some 150, line_pixel_ticks() and even_pixel_put(); with another number of steps
; than the pixel before, line_even_steps() and even_pixel_divide() besides.
#include "build_features.h" // SEVERAL_AXES
#include "avr/core/even_pixels.inc" // macros, registers

#if !SEVERAL_AXES

#define SPENT    r10
#define BUDGET   r11
#define NEGATIVE r14

; One pixel less of the segment. `low`, `high` is a pair that SBIW takes. 10 cycles.
.macro take_pixel_of_segment low, high
    ldd \low, Y + EVEN_PIXEL_REPEAT
    ldd \high, Y + EVEN_PIXEL_REPEAT + 1
    sbiw \low, 1
    std Y + EVEN_PIXEL_REPEAT, \low
    std Y + EVEN_PIXEL_REPEAT + 1, \high
.endm

; Zero flag clear: the segment has another pixel. 5 cycles.
.macro look_for_pixel_of_segment
    ldd r24, Y + EVEN_PIXEL_REPEAT
    ldd r25, Y + EVEN_PIXEL_REPEAT + 1
    or r24, r25
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
    call_divide
    cpse r24, r1
    rjmp forget
    rjmp leave

next_segment:
    movw r24, r28
    mov r22, NEGATIVE
    call line_even_steps
    mov STEPS, r24
    subi r24, 1                         ;     0 is no such pixel either
    cpi r24, EVEN_PIXEL_MOST_STEPS
    brsh leave

next_pixel:
    look_for_room wait, no_room         ; 16
    movw r24, r28                       ; 9   how long is the pixel? 0: not known yet
    call line_pixel_ticks
    mov TICKS2, r24                     ; 8
    cpi r24, EVEN_PIXEL_TICKS_TOO_BIG
    brsh leave
    mov r18, r22
    or r18, r23
    or r18, r24
    breq leave

    keep_interval divide                ; 28

forget:
    forget_length r24                   ; 13
    take_pixel_of_segment r24, r25      ; 10
    move_position NEGATIVE, r20, r21    ; 14

    movw r22, r28                       ; 8   r20, r21 are the position
    subi r22, -EVEN_PIXEL_RATE
    sbci r23, -1
    movw r24, r16
    call even_pixel_put
    cpse TICKS2, r1                     ; 2
    rcall longer_than_16_bits

    cost_of_pixel                       ; 6
    add SPENT, r24
    cp SPENT, BUDGET
    brlo 2f
    rjmp leave
2:  look_for_pixel_of_segment           ; 9
    breq 3f
    rjmp next_pixel
3:  rjmp next_segment

; The time above 16 bits.
longer_than_16_bits:
    movw r30, r16
    ldd r24, Z + EVEN_PIXEL_END_TICKS + 2
    add r24, TICKS2
    std Z + EVEN_PIXEL_END_TICKS + 2, r24
    ldd r24, Z + EVEN_PIXEL_END_TICKS + 3
    adc r24, r1
    std Z + EVEN_PIXEL_END_TICKS + 3, r24
    ret
end_function even_pixels_write

#endif
