; SPDX-License-Identifier: MIT
; Writes a pixel of few even steps of a single axis: the assembly half of even_pixel.c. The C that
; this file stands for is there, too; even_pixel.h and stream.h explain the numbers:
;
;     void even_pixel_put(struct stream *stream, const struct even_rate *rate, uint16_t position)
;
;     r0       high byte of the first entry, last of all        r24, r25  ticks of the pixel, then
;     r18, r19 shorter interval - 1                                       longer interval - 1
;     r20      scratch, then entries still to write             X         first interval, then the
;     r21      scratch, then the fraction that is carried                 next entry's low byte
;     r22      number of steps                                  Y         stream, then first slot
;     r23      so many intervals are a tick longer              Z         a waypoint, then the next
;                                                                         entry's high byte
;
; Cycles: 118 and 12 for each step, 14 for a longer one.
#include "avr/core/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "layout.h" // offsets

#if !SEVERAL_AXES

#define STEPS     r22
#define REMAINDER r23

; Z = stream + the offset of waypoint `index` within the waypoints.
.macro find_waypoint index
    mov r30, \index
    andi r30, EVEN_PIXEL_WAYPOINT_COUNT - 1
    ldi r31, EVEN_PIXEL_WAYPOINT_BYTES
    mul r30, r31
    movw r30, r0
    clr r1
    add r30, r28
    adc r31, r29
.endm

    .section .text.even_pixel_put, "ax", @progbits
function even_pixel_put
    push r28                            ; 6
    push r29
    movw r28, r24
    movw r30, r22
    ldd r24, Z + EVEN_PIXEL_TICKS       ; 12
    ldd r25, Z + EVEN_PIXEL_TICKS + 1
    ldd r18, Z + EVEN_PIXEL_BASE
    ldd r19, Z + EVEN_PIXEL_BASE + 1
    ldd STEPS, Z + EVEN_PIXEL_STEPS
    ldd REMAINDER, Z + EVEN_PIXEL_REMAINDER

    ldd r26, Y + EVEN_PIXEL_WAYPOINT_HEAD   ; 20  the waypoint at the end of this pixel waits
    find_waypoint r26
    inc r26
    std Y + EVEN_PIXEL_WAYPOINT_HEAD, r26
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_WAY, r1
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_POSITION, r20
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_POSITION + 1, r21

    ldd r26, Y + EVEN_PIXEL_WAYPOINT_PLACED ; 19  the one before stands behind the first period
    find_waypoint r26
    inc r26
    std Y + EVEN_PIXEL_WAYPOINT_PLACED, r26
    ldd r20, Y + EVEN_PIXEL_HEAD
    inc r20
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_SLOT, r20
    ldd r20, Y + EVEN_PIXEL_PLAIN       ; 10
    ldd r21, Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_WAY
    or r20, r21
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_WAY, r20
    ldi r20, EVEN_PIXEL_WAY_PLAIN
    std Y + EVEN_PIXEL_PLAIN, r20
    subi r18, 1                         ; 2
    sbci r19, 0
    movw r26, r18                       ; 7   the first interval is a longer one if any is
    cpse REMAINDER, r1
    adiw r26, 1
    adiw r26, 1
    .irp byte, 0, 1, 2                  ; 15  the time of the waypoint
    ldd r20, Y + EVEN_PIXEL_END_TICKS + \byte
    .if \byte == 0
    add r20, r26
    .elseif \byte == 1
    adc r20, r27
    .else
    adc r20, r1
    .endif
    std Z + EVEN_PIXEL_WAYPOINTS + EVEN_PIXEL_WAYPOINT_TICKS + \byte, r20
    .endr
    .irp byte, 0, 1, 2, 3               ; 20  and of the end of the pixel
    ldd r21, Y + EVEN_PIXEL_END_TICKS + \byte
    .if \byte == 0
    add r21, r24
    .elseif \byte == 1
    adc r21, r25
    .else
    adc r21, r1
    .endif
    std Y + EVEN_PIXEL_END_TICKS + \byte, r21
    .endr

    ldd r31, Y + EVEN_PIXEL_RING + 1    ; 15  the slot behind the last period reads empty
    mov r27, r31
    inc r31
    ldd r26, Y + EVEN_PIXEL_HEAD
    mov r30, r26
    add r30, STEPS
    std Y + EVEN_PIXEL_HEAD, r30
    ldi r21, 0xFF
    st Z, r21
    mov r30, r26
    mov r28, r26
    movw r24, r18                       ; 3   the longer interval
    adiw r24, 1
    tst REMAINDER                       ; 7   the first period; the interrupt must not see it yet
    breq 2f
    st X, r24
    mov r0, r25
    mov r21, REMAINDER
    rjmp 3f
2:  st X, r18
    mov r0, r19
    mov r21, STEPS
3:  dec r21                             ; 4
    mov r20, STEPS
    dec r20
    breq 6f

4:  inc r30                             ; 12  a period
    mov r26, r30
    add r21, REMAINDER
    cp r21, STEPS
    brsh 5f
    st X, r18
    st Z, r19
    dec r20
    brne 4b
    rjmp 6f
5:  sub r21, STEPS                      ; 2 more: a longer one
    st X, r24
    st Z, r25
    dec r20
    brne 4b

6:  mov r30, r28                        ; 11
    st Z, r0
    pop r29
    pop r28
    ret
end_function even_pixel_put

#endif
