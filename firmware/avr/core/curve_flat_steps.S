; SPDX-License-Identifier: MIT
; The steps of a curve whose interval hardly changes: the assembly half of curve_flat.c. The C that
; this file stands for is make_flat_steps() there; curve_flat.h explains the numbers:
;
;     struct progress curve_flat_narrow(struct curve_flat *flat, volatile uint8_t *low,
;                                       uint8_t count)
;     struct progress curve_flat_wide(the same)
;
; Both are one macro, flat_steps. The narrow function computes modulo 2^32 and has room for
; everything that changes in registers. The wide one computes modulo 2^40 and keeps gain_growth, 2h
; and the count of long steps in memory.
;
;                  narrow                wide
;     r0           low byte of q - 1     the same
;     r1           long steps so far     scratch
;     value        r8..r11               r7..r11              the residual, after a guess the value
;     gain         r12..r15              r12..r16
;     difference   r16..r19              r17..r21
;     gain_growth  r20..r23              in *flat
;     slope_growth r24..r26, sign        r22..r25, sign       the sign is its top byte
;     sign         r27                   r26                  of h: 0 or 0xFF
;     2h           r28, r29              in *flat
;     left         r7                    r27                  steps still to make
;     Y            (holds 2h)            flat
;     Z            next entry's low byte: the slot in r30 wraps, r31 stays
;     T            set: some q had a low byte of 0, by a carry (progress.carried)
;
; Cycles of a step:
;
;                                                         narrow  wide
;     value = residual + gain                                4     5
;     negative?                                              1     1
;     below difference? (the upper 16 bits nearly always do) 3     3
;     low byte into the ring                                 3     3
;     gain += gain_growth                                    4    15
;     difference += slope_growth                             4     5
;     another one?                                           3     3
;                                                           --    --
;     a step of q ticks                                     22    35
;     difference += 2h, value += difference,
;     gain += slope_growth, one tick more,
;     less the comparison                                   15    29
;                                                           --    --
;     a step of q + 1 ticks                                 37    64
;     q + 1 for q, besides                                  39    90
;     q - 1 for q, besides                                  57   109
;
; The paths through a step:
;
;     step: value = residual + gain
;       |
;       +-- value >= 0 --> compare: value < difference?
;       |                    +-- yes --> short: a step of q ticks --> next step
;       |                    +-- no ---> shorten: q - 1 for q --> compare again, or leave
;       |
;       +-- value < 0 ---> lengthen: value += difference, which is that of q + 1
;                            +-- value >= 0 --> long: a step of q + 1 ticks --> next step
;                            +-- value < 0 ---> move_up: q + 1 for q --> lengthen again, or leave
;
; It leaves when q - 1 has another high byte: the step is then undone.
#include "avr/core/asm.inc" // macros
#include "layout.h" // offsets

#define TOP        r0 /* low byte of q - 1 */
#define LONG_STEPS r1 /* narrow: steps of q + 1 ticks */
#define SCRATCH    r1 /* wide */

    .section .bss.curve_flat_extra, "aw", @nobits
; Ticks that steps of q + 1 and moves of q have added: progress.extra_ticks. Only valid during a
; call.
extra_ticks:
    .zero 2

; extra_ticks op left. `step` (inc or dec) is what a carry does to the upper byte.
.macro extra_op kind, op, step, left, lent
    .ifc \kind, narrow
    push \lent
    extra_scratch_op \op, \step, \left, \lent
    pop \lent
    .else
    extra_scratch_op \op, \step, \left, SCRATCH
    .endif
.endm

.macro extra_scratch_op op, step, left, scratch
    lds \scratch, extra_ticks
    \op \scratch, \left
    sts extra_ticks, \scratch
    brcc .Lkept\@
    lds \scratch, extra_ticks + 1
    \step \scratch
    sts extra_ticks + 1, \scratch
.Lkept\@:
.endm

; register op one byte of 2h, which is a register or in memory.
.macro half_byte_op op, register, byte, half
    .ifc \half, memory
    ldd SCRATCH, Y + CURVE_FLAT_TWICE_HALF + \byte
    \op \register, SCRATCH
    .else
    \op \register, \half
    .endif
.endm

; number op 2h.
.macro half_op first, further, half_low, half_high, sign, number:vararg
    .set .Lbyte, 0
    .irp register, \number
    .if .Lbyte == 0
    half_byte_op \first, \register, 0, \half_low
    .elseif .Lbyte == 1
    half_byte_op \further, \register, 1, \half_high
    .else
    \further \register, \sign
    .endif
    .set .Lbyte, .Lbyte + 1
    .endr
.endm

; gain_growth op slope_growth, where gain_growth is in memory.
.macro gain_growth_memory_op first, further, memory, slope_growth:vararg
    .set .Lat, CURVE_FLAT_GAIN_GROWTH + WIDE_LOW
    .irp byte, \slope_growth
    ldd SCRATCH, Y + .Lat
    .if .Lat == CURVE_FLAT_GAIN_GROWTH + WIDE_LOW
    \first SCRATCH, \byte
    std Y + .Lat, SCRATCH
    .set .Lat, CURVE_FLAT_GAIN_GROWTH
    .else
    \further SCRATCH, \byte
    std Y + .Lat, SCRATCH
    .set .Lat, .Lat + 1
    .endif
    .endr
.endm

; gain_growth op slope_growth.
.macro gain_growth_op kind, first, further, growths:vararg
    .ifc \kind, narrow
    number_op \first, \further, \growths
    .else
    gain_growth_memory_op \first, \further, \growths
    .endif
.endm

; kind: narrow or wide. Numbers are lists of registers (base/asm.inc); `upper` ones are the upper 16
; bits. slope_growth_bytes is slope_growth as it is in memory, slope_growth_top the last of these
; bytes; slope_growth itself has the sign on top. gain_growth, half_low and half_high may be
; `memory`. lent: a register that the narrow function saves, and uses where it needs a scratch
; register.
.macro flat_steps kind, left, sign, value, value_upper, gain, difference, difference_upper, \
    slope_growth, slope_growth_bytes, slope_growth_top, gain_growth, half_low, half_high, lent
function curve_flat_\kind
    save_registers 7                    ; 26
    .ifc \kind, narrow
    push r25                            ;    flat, because Y will hold 2h
    push r24
    .endif
    movw r28, r24                       ;    Y: flat
    movw r30, r22                       ;    Z: low
    mov \left, r20
    sts extra_ticks, r1
    sts extra_ticks + 1, r1
    load_wide CURVE_FLAT_RESIDUAL, \value
    load_wide CURVE_FLAT_GAIN, \gain
    load_wide CURVE_FLAT_DIFFERENCE, \difference
    .ifc \kind, narrow
    load_wide CURVE_FLAT_GAIN_GROWTH, \gain_growth
    load_plain CURVE_FLAT_SLOPE_GROWTH, \slope_growth
    ldd TOP, Y + CURVE_FLAT_TOP
    ldd r1, Y + CURVE_FLAT_TWICE_HALF
    ldd \half_high, Y + CURVE_FLAT_TWICE_HALF + 1
    mov \half_low, r1
    clr LONG_STEPS
    .else
    load_plain CURVE_FLAT_SLOPE_GROWTH, \slope_growth_bytes
    ldd TOP, Y + CURVE_FLAT_TOP
    clr \sign                           ;    h has the sign of slope_growth
    sbrc \slope_growth_top, 7
    com \sign
    .endif
    clt                                 ;    no carry so far

\kind\()_step:
    add_number \value, \gain            ; 4 or 5  value = residual + gain
    brmi \kind\()_lengthen              ; 1  (2 when taken)
    compare_number \value_upper, \difference_upper ; 2
    brsh \kind\()_compare               ; 1
\kind\()_short:
    st Z, TOP                           ; 2
    inc r30                             ; 1
    .ifc \kind, narrow
    add_number \gain, \gain_growth     ; 4  gain += gain_growth
    .else
    wide_op add, adc, SCRATCH, CURVE_FLAT_GAIN_GROWTH, \gain ; 15
    .endif
    add_number \difference, \slope_growth; 4 or 5  difference += slope_growth
    dec \left                           ; 1
    brne \kind\()_step                  ; 2
    rjmp \kind\()_done
\kind\()_compare:                       ;    value >= difference, all the bits?
    compare_number \value, \difference
    brlo \kind\()_short
    rjmp \kind\()_shorten

\kind\()_lengthen:                      ;    q is too short
    half_op add, adc, \half_low, \half_high, \sign, \difference ; 4 or 9  difference += 2h
    add_number \value, \difference      ; 4 or 5  value += difference
    brcc \kind\()_move_up               ; 1  and so is q + 1
    add_number \gain, \slope_growth     ; 4 or 5  gain += slope_growth
    .ifc \kind, narrow
    inc LONG_STEPS                      ; 1
    .else
    lds SCRATCH, extra_ticks            ; 2  extra_ticks++
    inc SCRATCH                         ; 1
    sts extra_ticks, SCRATCH            ; 2
    breq \kind\()_extra_carry           ; 1
\kind\()_long:
    .endif
    inc TOP                             ; 1
    breq \kind\()_top_carry             ; 1
\kind\()_long_store:
    st Z, TOP                           ; 2
    dec TOP                             ; 1
    inc r30                             ; 1
    .ifc \kind, narrow
    add_number \gain, \gain_growth     ; 4  gain += gain_growth
    .else
    wide_op add, adc, SCRATCH, CURVE_FLAT_GAIN_GROWTH, \gain ; 15
    .endif
    add_number \difference, \slope_growth; 4 or 5  difference += slope_growth
    dec \left                           ; 1
    .ifc \kind, narrow
    brne \kind\()_step                  ; 2
    rjmp \kind\()_done
    .else
    brne 1f                             ; 2
    rjmp \kind\()_done
1:  rjmp \kind\()_step                  ; 2  out of a branch's reach

\kind\()_extra_carry:
    lds SCRATCH, extra_ticks + 1
    inc SCRATCH
    sts extra_ticks + 1, SCRATCH
    rjmp \kind\()_long
    .endif
\kind\()_top_carry:
    set
    rjmp \kind\()_long_store

    ; q + 1 for q. difference has grown already, and value is that of q + 1.
\kind\()_move_up:
    add_number \gain, \difference       ;    gain += difference
    gain_growth_op \kind, add, adc, \gain_growth, \slope_growth ; gain_growth += 2*slope_growth + 2h
    half_op add, adc, \half_low, \half_high, \sign, \slope_growth_bytes ; slope_growth += 2h
    gain_growth_op \kind, add, adc, \gain_growth, \slope_growth
    extra_op \kind, add, inc, \left, \lent ; extra_ticks += left
    inc TOP
    .ifc \kind, narrow
    brne \kind\()_lengthen
    sub_number \value, \gain            ;    the step is not made
    ldi \sign, 1                        ;    q - 1 has the next high byte
    rjmp \kind\()_leave
    .else
    breq 2f
    rjmp \kind\()_lengthen
2:  ldi \sign, 1                        ;    q - 1 has the next high byte
    rjmp \kind\()_undo
    .endif

    ; q - 1 for q. value is that of q.
\kind\()_shorten:
    sub_number \value, \difference      ;    value -= difference
    sub_number \gain, \difference       ;    gain -= difference
    half_op sub, sbc, \half_low, \half_high, \sign, \difference ; difference -= 2h
    gain_growth_op \kind, sub, sbc, \gain_growth, \slope_growth ; gain_growth -= 2*slope_growth - 2h
    half_op sub, sbc, \half_low, \half_high, \sign, \slope_growth_bytes ; slope_growth -= 2h
    gain_growth_op \kind, sub, sbc, \gain_growth, \slope_growth
    extra_op \kind, sub, dec, \left, \lent ; extra_ticks -= left
    tst TOP
    breq 3f
    dec TOP
    rjmp \kind\()_compare
3:  dec TOP
    .ifc \kind, narrow
    sub_number \value, \gain            ;    the step is not made
    ldi \sign, 0xFF                     ;    q - 1 has the high byte before
    rjmp \kind\()_leave
    .else
    ldi \sign, 0xFF                     ;    q - 1 has the high byte before
\kind\()_undo:
    sub_number \value, \gain            ;    the step is not made
    rjmp \kind\()_leave
    .endif

    ; `sign` now holds what is added to the high byte of q - 1.
\kind\()_done:
    ldi \sign, 0
\kind\()_leave:
    .ifc \kind, narrow
    pop r28                             ;    flat
    pop r29
    .endif
    store_wide CURVE_FLAT_RESIDUAL, \value
    store_wide CURVE_FLAT_GAIN, \gain
    store_wide CURVE_FLAT_DIFFERENCE, \difference
    .ifc \kind, narrow
    store_wide CURVE_FLAT_GAIN_GROWTH, \gain_growth
    .endif
    store_plain CURVE_FLAT_SLOPE_GROWTH, \slope_growth_bytes
    std Y + CURVE_FLAT_TOP, TOP
    ldd TOP, Y + CURVE_FLAT_TOP + 1
    add TOP, \sign
    std Y + CURVE_FLAT_TOP + 1, TOP
    lds r22, extra_ticks                ;    progress.extra_ticks
    lds r23, extra_ticks + 1
    .ifc \kind, narrow
    add r22, LONG_STEPS
    clr r1
    adc r23, r1
    mov r24, \left                      ;    progress.left
    jmp flat_return                     ;    the linker makes it RJMP where that reaches
    .else
    mov r24, \left                      ;    progress.left
    clr r1
flat_return:
    clr r25                             ;    progress.carried
    bld r25, 0
    restore_registers 7                 ; 26
    ret
    .endif
end_function curve_flat_\kind
.endm

; One section each: the linker drops the narrow one where no image uses it.
    .section .text.curve_flat_narrow, "ax", @progbits
    flat_steps narrow, left=r7, sign=r27, value="r8, r9, r10, r11", \
        value_upper="r10, r11", gain="r12, r13, r14, r15", \
        difference="r16, r17, r18, r19", difference_upper="r18, r19", \
        slope_growth="r24, r25, r26, r27", slope_growth_bytes="r24, r25, r26", \
        gain_growth="r20, r21, r22, r23", half_low=r28, half_high=r29, lent=r16
    .section .text.curve_flat_wide, "ax", @progbits
    flat_steps wide, left=r27, sign=r26, value="r7, r8, r9, r10, r11", \
        value_upper="r10, r11", gain="r12, r13, r14, r15, r16", \
        difference="r17, r18, r19, r20, r21", difference_upper="r20, r21", \
        slope_growth="r22, r23, r24, r25, r26", slope_growth_bytes="r22, r23, r24, r25", \
        slope_growth_top=r25, gain_growth=memory, half_low=memory, half_high=memory
