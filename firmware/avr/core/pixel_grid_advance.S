; SPDX-License-Identifier: MIT
; Moves a grid of pixel edges by one period: the assembly half of pixel_period.c, where the C is
; that this file stands for.
;
;     uint32_t pixel_grid_advance(struct pixel_grid *grid)
;
;     X  the grid's sum    Z  period    r18..r21  sum    r22..r25  divisor, then the ticks
;
; Cycles with the call: 74 (76 on the ATmega2560), 7 more where the period is a tick longer; 38 (40)
; where the period is a whole number of ticks.
#include "avr/core/asm.inc" // macros
#include "layout.h" // offsets

#define SUM   r18, r19, r20, r21
#define TICKS r22, r23, r24, r25

    .section .text.pixel_grid_advance, "ax", @progbits
function pixel_grid_advance
    movw r26, r24
    ld r30, X+                          ;     PIXEL_GRID_PERIOD, PIXEL_GRID_SUM
    ld r31, X+
    .irp byte, 0, 1, 2, 3
    ldd 18 + \byte, Z + PIXEL_PERIOD_REMAINDER + \byte
    .endr
    clt
    mov r0, r18
    or r0, r19
    or r0, r20
    or r0, r21
    breq 3f                             ;     no fraction: the sum stays
    .irp byte, 0, 1, 2, 3
    ld r22, X+
    .if \byte == 0
    add r18, r22
    .else
    adc 18 + \byte, r22
    .endif
    .endr
    sbc r0, r0                          ;     the sum's fifth byte
    .irp byte, 0, 1, 2, 3
    ldd 22 + \byte, Z + PIXEL_PERIOD_DIVISOR + \byte
    .endr
    sbrc r0, 0
    rjmp 1f
    compare_number SUM, TICKS
    brlo 2f
1:  sub_number SUM, TICKS               ;     a whole tick more
    set
2:  .irp register, r21, r20, r19, r18
    st -X, \register
    .endr
3:  .irp byte, 0, 1, 2, 3
    ldd 22 + \byte, Z + PIXEL_PERIOD_WHOLE + \byte
    .endr
    brtc 4f
    subi r22, -1
    .irp register, r23, r24, r25
    sbci \register, -1
    .endr
4:  ret
end_function pixel_grid_advance
