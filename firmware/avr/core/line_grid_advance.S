; SPDX-License-Identifier: MIT
; Moves a line by one pixel of its grid, on boards of several axes: the assembly half of
; lock_grid.c, where the C is that this file stands for.
;
;     uint32_t line_grid_advance(struct line_grid *grid)
;
;     r18..r21  time of the pixel edge, then how far the pixel is from its nominal length
;     r22..r25  ticks of the pixel                  X  its edge    Z  grid
;
; Cycles of a locked pixel whose edge has its time, with the call: 97 (99 on the ATmega2560), 6
; more where it is shorter than nominal.
#include "avr/core/asm.inc" // macros
#include "build_features.h" // SEVERAL_AXES
#include "layout.h" // offsets

#if SEVERAL_AXES

#define NEWEST lock_grid + LOCK_GRID_NEWEST
#define TIMES  lock_grid + LOCK_GRID_TIMES

    .section .text.line_grid_advance, "ax", @progbits
function line_grid_advance
    movw r30, r24
    ldd r18, Z + LINE_GRID_MODE         ;     6
    cpi r18, LINE_GRID_MODE_LOCKED
    breq .Llocked
    cpse r18, r1
    jmp line_grid_wait
    adiw r24, LINE_GRID_EXACT_GRID
    jmp pixel_grid_advance
.Llocked:
    ldd r26, Z + LINE_GRID_EDGE         ;     10
    ldd r27, Z + LINE_GRID_EDGE + 1
    adiw r26, 1
    std Z + LINE_GRID_EDGE, r26
    std Z + LINE_GRID_EDGE + 1, r27
.Llook:
    lds r18, NEWEST                     ;     7
    lds r19, NEWEST + 1
    cp r18, r26
    cpc r19, r27
    brpl 1f
    rjmp .Lfix
1:  andi r26, LOCK_GRID_EDGES - 1       ;     6
    lsl r26
    lsl r26
    ldi r27, 0
    subi r26, lo8(-(TIMES))
    sbci r27, hi8(-(TIMES))
    ld r18, X+                          ;     10
    ld r19, X+
    ld r20, X+
    ld r21, X+
    movw r22, r18
    movw r24, r20
    .irp byte, 0, 1, 2, 3               ;     20
    ldd r0, Z + LINE_GRID_REACHED + \byte
    .if \byte == 0
    sub r22, r0
    .else
    sbc 22 + \byte, r0
    .endif
    std Z + LINE_GRID_REACHED + \byte, 18 + \byte
    .endr
    movw r18, r22                       ;     16  how far from nominal
    movw r20, r24
    .irp byte, 0, 1, 2, 3
    lds r0, lock_grid + LOCK_GRID_WHOLE + \byte
    .if \byte == 0
    sub r18, r0
    .else
    sbc 18 + \byte, r0
    .endif
    .endr
    brpl 2f
    com r21                             ;     7   the magnitude
    com r20
    com r19
    neg r18
    sbci r19, -1
    sbci r20, -1
    sbci r21, -1
2:  .irp byte, 0, 1, 2, 3               ;     13  more than the slack?
    lds r0, lock_grid + LOCK_GRID_SLACK + \byte
    .if \byte == 0
    cp r0, r18
    .else
    cpc r0, 18 + \byte
    .endif
    .endr
    brlo .Llimit
    ret

.Llimit:                                  ;         line_grid_limit(grid, ticks)
    movw r20, r22
    movw r22, r24
    movw r24, r30
    jmp line_grid_limit

.Lfix:                                    ;         the edge's time is to be predicted yet
    .irp register, r26, r27, r30, r31
    push \register
    .endr
    call lock_grid_next
    .irp register, r31, r30, r27, r26
    pop \register
    .endr
    rjmp .Llook
end_function line_grid_advance

#endif
