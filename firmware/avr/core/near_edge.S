; SPDX-License-Identifier: MIT
; Places an edge of the pixel clock and compares it with the plan: the assembly half of near_edge.c,
; where the C is that this file stands for.
;
;     struct near_edge near_edge_take(const struct captured_edge *edge, struct ledger *ledger,
;                                     struct stream *stream, struct clock_watch *watch)
;
;     r12, r13  watch     r16, r17  stream     Y  ledger, then watch
;     r14, r15  edge, then scratch
;     r26, r27  error     r22..r25  time of the edge, then the result
;
; Cycles: 333 on a grid of whole ticks, 36 more on any other, 16 for each period between the edge
; and the account's place, and ledger_take_pixels().
#include "avr/core/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES, FEATURE_CLOCK_STATISTICS
#include "ring/captured_edge.h" // CAPTURED_EDGE_*
#include "layout.h" // offsets
#include "avr/core/ledger_place.inc" // macros, layouts

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#define TIME   r22, r23, r24, r25
#define PERIOD (CLOCK_WATCH_GRID + PIXEL_GRID_PERIOD)

; Carry set: the number r15:r14 is below -r19:r18 or above r19:r18, which becomes twice as much. 6
; cycles.
.macro compare_with_most
    add r14, r18
    adc r15, r19
    lsl r18
    rol r19
    cp r18, r14
    cpc r19, r15
.endm

    .section .text.near_edge_take, "ax", @progbits

elsewhere:
    .irp register, 29, 28, 17, 16, 15, 14, 13, 12
    pop r\register
    .endr
not_expected:
    clr r24
    ret

function near_edge_take
    movw r30, r18                       ; 7   the last edge was near its planned time
    ldd r0, Z + CLOCK_WATCH_FOLLOWING
    ldd r26, Z + CLOCK_WATCH_NEAR
    and r26, r0
    breq not_expected
    .irp register, 12, 13, 14, 15, 16, 17, 28, 29 ; 16
    push r\register
    .endr
    movw r12, r18                       ; 5
    movw r14, r24
    movw r16, r20
    movw r28, r22
    movw r30, r24
    ldd r20, Z + CAPTURED_EDGE_TAIL     ; 31  not at rest, and no train was cut off?
    ldd r19, Z + CAPTURED_EDGE_NOTES
    andi r19, 0xFF - CAPTURED_EDGE_BACK
    look_for_pixels elsewhere, CAPTURED_EDGE_IDLE_COUNT, r16
    movw r22, r16                       ; 7   inside a whole pixel?
    movw r24, r28
    call ledger_take_pixels
    tst r24                             ; 2
    breq elsewhere
    movw r30, r14                       ; 10
    ldd r22, Z + CAPTURED_EDGE_TICKS
    ldd r23, Z + CAPTURED_EDGE_TICKS + 1
    ldd r24, Z + CAPTURED_EDGE_TAIL
    ldd r25, Z + CAPTURED_EDGE_NOTES
    movw r30, r16
    place_in_ring not_near              ; 54
    movw r28, r12                       ; 1
    subi r22, CAPTURED_EDGE_DELAY_TICKS ; 4
    .irp register, r23, r24, r25
    sbc \register, r1
    .endr

    ldd r20, Y + CLOCK_WATCH_NEXT_TICKS ; 15  its error, r20:r0:r27:r26
    ldd r21, Y + CLOCK_WATCH_NEXT_TICKS + 1
    movw r26, r22
    sub r26, r20
    sbc r27, r21
    ldd r20, Y + CLOCK_WATCH_NEXT_TICKS + 2
    ldd r21, Y + CLOCK_WATCH_NEXT_TICKS + 3
    mov r0, r24
    sbc r0, r20
    mov r20, r25
    sbc r20, r21
    mov r21, r27                        ; 7   fits 16 bits?
    lsl r21
    sbc r21, r21
    eor r0, r21
    eor r20, r21
    or r0, r20
    brne not_near
    ldd r20, Y + CLOCK_WATCH_ERROR      ; 18  is that of the edge before, but for near_ticks?
    ldd r21, Y + CLOCK_WATCH_ERROR + 1
    movw r14, r26
    sub r14, r20
    sbc r15, r21
    ldd r18, Y + CLOCK_WATCH_NEAR_TICKS
    ldd r19, Y + CLOCK_WATCH_NEAR_TICKS + 1
    compare_with_most
    brlo not_near
    .rept 3                             ; 14  and at most 16 times these?
    lsl r18
    rol r19
    .endr
    movw r14, r26
    compare_with_most
    brsh 1f
not_near:
    rjmp elsewhere

1:  store_plain CLOCK_WATCH_EDGE_TICKS, TIME ; 8
    store_plain CLOCK_WATCH_ERROR, r26, r27 ; 4
    ldd r24, Y + CLOCK_WATCH_EDGES      ; 11
    ldd r25, Y + CLOCK_WATCH_EDGES + 1
    adiw r24, 1
    store_plain CLOCK_WATCH_EDGES, r24, r25
    brne 2f
    ldd r24, Y + CLOCK_WATCH_EDGES + 2
    ldd r25, Y + CLOCK_WATCH_EDGES + 3
    adiw r24, 1
    store_plain CLOCK_WATCH_EDGES + 2, r24, r25
2:  sbrs r27, 7                         ; 10  the largest error?
    rjmp 3f
    com r27
    neg r26
    sbci r27, 0xFF
3:  ldd r24, Y + CLOCK_WATCH_ERROR_MAX
    ldd r25, Y + CLOCK_WATCH_ERROR_MAX + 1
    cp r24, r26
    cpc r25, r27
    brsh 4f
    store_plain CLOCK_WATCH_ERROR_MAX, r26, r27

4:  movw r24, r28                       ; 8   the next planned time
    adiw r24, CLOCK_WATCH_GRID
    call pixel_grid_advance
    plain_op add, adc, r18, CLOCK_WATCH_NEXT_TICKS, TIME ; 20
    store_plain CLOCK_WATCH_NEXT_TICKS, TIME

    ldd r22, Y + CLOCK_WATCH_PIXEL      ; 11  an edge is a pixel?
    ldd r23, Y + CLOCK_WATCH_PIXEL + 1
    ldd r18, Y + CLOCK_WATCH_DIVIDER
    ldd r19, Y + CLOCK_WATCH_DIVIDER + 1
    ldi r25, 1
    cpi r18, 2
    cpc r19, r1
    brlo next_pixel
    ldd r20, Y + CLOCK_WATCH_PHASE
    ldd r21, Y + CLOCK_WATCH_PHASE + 1
    mov r24, r20
    or r24, r21
    breq 5f
    clr r25
5:  subi r20, 0xFF
    sbci r21, 0xFF
    cp r20, r18
    cpc r21, r19
    brlo 6f
    clr r20
    clr r21
6:  store_plain CLOCK_WATCH_PHASE, r20, r21
    brlo taken
next_pixel:
    movw r26, r22                       ; 7
    adiw r26, 1
    store_plain CLOCK_WATCH_PIXEL, r26, r27
taken:
    ldi r24, 1                          ; 22
    .irp register, 29, 28, 17, 16, 15, 14, 13, 12
    pop r\register
    .endr
    ret
end_function near_edge_take

#endif
