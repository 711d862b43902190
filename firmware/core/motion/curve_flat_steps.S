; SPDX-License-Identifier: MIT
; The steps of a curve whose interval hardly changes: the assembly half of curve_flat.c. What the
; numbers mean is said in curve_flat.h, what is done to them in curve_flat.c, steps().
;
;     struct progress curve_flat_narrow(struct curve_flat *flat, volatile uint8_t *low,
;                                       uint8_t count)
;     struct progress curve_flat_wide(the same)
;
; Everything that changes is in registers. r2..r6 are left alone: they are the step interrupt's. An
; interrupt may come between any two instructions.
;
; Cycles of a step:                                     narrow  wide
;
;     value = residual + gain                                4     5
;     negative?                                              1     1
;     below difference? (upper 16 bits will nearly always do)3     3
;     low byte into the ring                                 3     3
;     gain += bend                                           4    15
;     difference += turn                                     4     5
;     another one?                                           3     3
;                                                           --    --
;     a step of q ticks                                     22    35
;     difference += 2h, value += difference, gain += turn,
;     one tick more, less the comparison                    15    25
;                                                           --    --
;     a step of q + 1 ticks                                 37    60
;     q moves by one, besides: about                        45    65
#include "motion/curve_flat_layout.h"

#define LOW CURVE_FLAT_WIDE_LOW

    .section .bss.curve_flat_extra, "aw", @nobits
; Ticks that steps of q + 1 and moves of q have added: progress.extra_ticks. Nothing is kept here
; from one call to the next.
extra:
    .zero 2

.macro add4 a0, a1, a2, a3, b0, b1, b2, b3
    add \a0, \b0
    adc \a1, \b1
    adc \a2, \b2
    adc \a3, \b3
.endm

.macro sub4 a0, a1, a2, a3, b0, b1, b2, b3
    sub \a0, \b0
    sbc \a1, \b1
    sbc \a2, \b2
    sbc \a3, \b3
.endm

.macro add5 a0, a1, a2, a3, a4, b0, b1, b2, b3, b4
    add4 \a0, \a1, \a2, \a3, \b0, \b1, \b2, \b3
    adc \a4, \b4
.endm

.macro sub5 a0, a1, a2, a3, a4, b0, b1, b2, b3, b4
    sub4 \a0, \a1, \a2, \a3, \b0, \b1, \b2, \b3
    sbc \a4, \b4
.endm

.macro load4 a0, a1, a2, a3, at
    ldd \a0, Y + \at + LOW
    ldd \a1, Y + \at + 0
    ldd \a2, Y + \at + 1
    ldd \a3, Y + \at + 2
.endm

.macro store4 a0, a1, a2, a3, at
    std Y + \at + LOW, \a0
    std Y + \at + 0, \a1
    std Y + \at + 1, \a2
    std Y + \at + 2, \a3
.endm

; What the caller wants unchanged. 52 cycles each with the call and the return.
.macro save_registers
    .irp reg, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
    push r\reg
    .endr
.endm

.macro restore_registers
    .irp reg, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7
    pop r\reg
    .endr
.endm

; ---------------------------------------------------------------------------------------------
; Modulo 2^32
; ---------------------------------------------------------------------------------------------
#define TOP   r0                 /* low byte of q - 1 */
#define LONGS r1                 /* steps of q + 1 ticks */
#define LEFT  r7                 /* steps still to make */
#define V0    r8                 /* residual, then value */
#define V1    r9
#define V2    r10
#define V3    r11
#define G0    r12                /* gain */
#define G1    r13
#define G2    r14
#define G3    r15
#define D0    r16                /* difference */
#define D1    r17
#define D2    r18
#define D3    r19
#define B0    r20                /* bend */
#define B1    r21
#define B2    r22
#define B3    r23
#define T0    r24                /* turn; its fourth byte is the sign of h */
#define T1    r25
#define T2    r26
#define SIGN  r27
#define H0    r28                /* 2h; its further bytes are the sign */
#define H1    r29
#define VALUE V0, V1, V2, V3
#define GAIN  G0, G1, G2, G3
#define DIFF  D0, D1, D2, D3
#define BEND  B0, B1, B2, B3
#define TURN  T0, T1, T2, SIGN
#define TWICE_HALF H0, H1, SIGN, SIGN

; On to the next step.
.macro narrow_next
    add4 GAIN, BEND                     ; 4  gain += bend
    add4 DIFF, TURN                     ; 4  difference += turn
    dec LEFT                            ; 1
    brne narrow_step                    ; 2
.endm

    .section .text.curve_flat_steps, "ax", @progbits
    .global curve_flat_narrow
    .type curve_flat_narrow, @function
curve_flat_narrow:
    save_registers
    push r25
    push r24
    movw r28, r24
    movw r30, r22
    mov LEFT, r20
    sts extra, r1
    sts extra + 1, r1
    load4 VALUE, CURVE_FLAT_RESIDUAL
    load4 GAIN, CURVE_FLAT_GAIN
    load4 DIFF, CURVE_FLAT_DIFFERENCE
    load4 BEND, CURVE_FLAT_BEND
    ldd T0, Y + CURVE_FLAT_TURN
    ldd T1, Y + CURVE_FLAT_TURN + 1
    ldd T2, Y + CURVE_FLAT_TURN + 2
    ldd SIGN, Y + CURVE_FLAT_TURN + 3
    ldd TOP, Y + CURVE_FLAT_TOP
    ldd LONGS, Y + CURVE_FLAT_TWICE_HALF
    ldd H1, Y + CURVE_FLAT_TWICE_HALF + 1
    mov H0, LONGS
    clr LONGS
    clt                                 ;    nothing carried

narrow_step:
    add4 VALUE, GAIN                    ; 4  value = residual + gain
    brmi narrow_long                    ; 1  (2 when taken)
    cp V2, D2                           ; 1
    cpc V3, D3                          ; 1
    brsh narrow_compare                 ; 1
narrow_short:
    st Z, TOP                           ; 2
    inc r30                             ; 1
    narrow_next                         ; 11
    rjmp narrow_done
narrow_compare:                         ;    value >= difference, all the bits?
    cp V0, D0
    cpc V1, D1
    cpc V2, D2
    cpc V3, D3
    brlo narrow_short
    rjmp narrow_down

narrow_long:                            ;    q is too short
    add4 DIFF, TWICE_HALF               ; 4  difference += 2h
    add4 VALUE, DIFF                    ; 4  value += difference
    brcc narrow_up                      ; 1  and so is q + 1
    add4 GAIN, TURN                     ; 4  gain += turn
    inc LONGS                           ; 1
    inc TOP                             ; 1
    breq narrow_carried                 ; 1
narrow_put:
    st Z, TOP                           ; 2
    dec TOP                             ; 1
    inc r30                             ; 1
    narrow_next                         ; 11
    rjmp narrow_done
narrow_carried:
    set
    rjmp narrow_put

narrow_up:                              ;    q + 1 for q: difference has grown, value is q + 1's
    add4 GAIN, DIFF                     ;    gain += difference
    add4 BEND, TURN                     ;    bend += 2*turn + 2h
    add T0, H0                          ;    turn += 2h
    adc T1, H1
    adc T2, SIGN
    add4 BEND, TURN
    push D0
    lds D0, extra                       ;    extra += left
    add D0, LEFT
    sts extra, D0
    brcc 1f
    lds D0, extra + 1
    inc D0
    sts extra + 1, D0
1:  pop D0
    inc TOP
    brne narrow_long
    sub4 VALUE, GAIN
    ldi SIGN, 1                         ;    q - 1 has the next high byte
    rjmp narrow_leave

narrow_down:                            ;    q - 1 for q: value is that of q
    sub4 VALUE, DIFF                    ;    value -= difference
    sub4 GAIN, DIFF                     ;    gain -= difference
    sub4 DIFF, TWICE_HALF               ;    difference -= 2h
    sub4 BEND, TURN                     ;    bend -= 2*turn - 2h
    sub T0, H0                          ;    turn -= 2h
    sbc T1, H1
    sbc T2, SIGN
    sub4 BEND, TURN
    push D0
    lds D0, extra                       ;    extra -= left
    sub D0, LEFT
    sts extra, D0
    brcc 1f
    lds D0, extra + 1
    dec D0
    sts extra + 1, D0
1:  pop D0
    tst TOP
    breq narrow_lower
    dec TOP
    rjmp narrow_compare
narrow_lower:
    dec TOP
    sub4 VALUE, GAIN
    ldi SIGN, 0xFF                      ;    q - 1 has the high byte before
    rjmp narrow_leave

narrow_done:
    ldi SIGN, 0
narrow_leave:
    pop r28                             ;    flat
    pop r29
    store4 VALUE, CURVE_FLAT_RESIDUAL
    store4 GAIN, CURVE_FLAT_GAIN
    store4 DIFF, CURVE_FLAT_DIFFERENCE
    store4 BEND, CURVE_FLAT_BEND
    std Y + CURVE_FLAT_TURN, T0
    std Y + CURVE_FLAT_TURN + 1, T1
    std Y + CURVE_FLAT_TURN + 2, T2
    std Y + CURVE_FLAT_TOP, TOP
    ldd TOP, Y + CURVE_FLAT_TOP + 1
    add TOP, SIGN
    std Y + CURVE_FLAT_TOP + 1, TOP
    lds r22, extra
    lds r23, extra + 1
    add r22, LONGS
    clr r1
    adc r23, r1
    mov r24, LEFT
    rjmp flat_return
    .size curve_flat_narrow, . - curve_flat_narrow

#undef TOP
#undef LEFT
#undef V0
#undef V1
#undef V2
#undef V3
#undef G0
#undef G1
#undef G2
#undef G3
#undef D0
#undef D1
#undef D2
#undef D3
#undef T0
#undef T1
#undef T2
#undef SIGN
#undef VALUE
#undef GAIN
#undef DIFF
#undef TURN

; ---------------------------------------------------------------------------------------------
; Modulo 2^40: bend and 2h stay in memory
; ---------------------------------------------------------------------------------------------
#define TOP   r0                 /* low byte of q - 1 */
#define SOME  r1                 /* for a moment */
#define V0    r7                 /* residual, then value */
#define V1    r8
#define V2    r9
#define V3    r10
#define V4    r11
#define G0    r12                /* gain */
#define G1    r13
#define G2    r14
#define G3    r15
#define G4    r16
#define D0    r17                /* difference */
#define D1    r18
#define D2    r19
#define D3    r20
#define D4    r21
#define T0    r22                /* turn */
#define T1    r23
#define T2    r24
#define T3    r25
#define SIGN  r26                /* of h, and the fifth byte of turn */
#define LEFT  r27                /* steps still to make */
#define VALUE V0, V1, V2, V3, V4
#define GAIN  G0, G1, G2, G3, G4
#define DIFF  D0, D1, D2, D3, D4
#define TURN  T0, T1, T2, T3, SIGN

; On to the next step.
.macro wide_next
    ldd SOME, Y + CURVE_FLAT_BEND + LOW ; 2  gain += bend
    add G0, SOME                        ; 1
    ldd SOME, Y + CURVE_FLAT_BEND       ; 2
    adc G1, SOME                        ; 1
    ldd SOME, Y + CURVE_FLAT_BEND + 1   ; 2
    adc G2, SOME                        ; 1
    ldd SOME, Y + CURVE_FLAT_BEND + 2   ; 2
    adc G3, SOME                        ; 1
    ldd SOME, Y + CURVE_FLAT_BEND + 3   ; 2
    adc G4, SOME                        ; 1
    add5 DIFF, TURN                     ; 5  difference += turn
    dec LEFT                            ; 1
.endm

; difference op 2h
.macro wide_difference op, op_carry
    ldd SOME, Y + CURVE_FLAT_TWICE_HALF ; 2
    \op D0, SOME                        ; 1
    ldd SOME, Y + CURVE_FLAT_TWICE_HALF + 1 ; 2
    \op_carry D1, SOME                  ; 1
    \op_carry D2, SIGN                  ; 1
    \op_carry D3, SIGN                  ; 1
    \op_carry D4, SIGN                  ; 1
.endm

; bend op turn
.macro wide_bend op, op_carry
    ldd SOME, Y + CURVE_FLAT_BEND + LOW
    \op SOME, T0
    std Y + CURVE_FLAT_BEND + LOW, SOME
    ldd SOME, Y + CURVE_FLAT_BEND
    \op_carry SOME, T1
    std Y + CURVE_FLAT_BEND, SOME
    ldd SOME, Y + CURVE_FLAT_BEND + 1
    \op_carry SOME, T2
    std Y + CURVE_FLAT_BEND + 1, SOME
    ldd SOME, Y + CURVE_FLAT_BEND + 2
    \op_carry SOME, T3
    std Y + CURVE_FLAT_BEND + 2, SOME
    ldd SOME, Y + CURVE_FLAT_BEND + 3
    \op_carry SOME, SIGN
    std Y + CURVE_FLAT_BEND + 3, SOME
.endm

; turn op 2h
.macro wide_turn op, op_carry
    ldd SOME, Y + CURVE_FLAT_TWICE_HALF
    \op T0, SOME
    ldd SOME, Y + CURVE_FLAT_TWICE_HALF + 1
    \op_carry T1, SOME
    \op_carry T2, SIGN
    \op_carry T3, SIGN
.endm

    .global curve_flat_wide
    .type curve_flat_wide, @function
curve_flat_wide:
    save_registers
    movw r28, r24
    movw r30, r22
    mov LEFT, r20
    sts extra, r1
    sts extra + 1, r1
    load4 V0, V1, V2, V3, CURVE_FLAT_RESIDUAL
    ldd V4, Y + CURVE_FLAT_RESIDUAL + 3
    load4 G0, G1, G2, G3, CURVE_FLAT_GAIN
    ldd G4, Y + CURVE_FLAT_GAIN + 3
    load4 D0, D1, D2, D3, CURVE_FLAT_DIFFERENCE
    ldd D4, Y + CURVE_FLAT_DIFFERENCE + 3
    ldd T0, Y + CURVE_FLAT_TURN
    ldd T1, Y + CURVE_FLAT_TURN + 1
    ldd T2, Y + CURVE_FLAT_TURN + 2
    ldd T3, Y + CURVE_FLAT_TURN + 3
    ldd TOP, Y + CURVE_FLAT_TOP
    clr SIGN
    sbrc T3, 7
    com SIGN
    clt                                 ;    nothing carried

wide_step:
    add5 VALUE, GAIN                    ; 5  value = residual + gain
    brmi wide_long                      ; 1  (2 when taken)
    cp V3, D3                           ; 1
    cpc V4, D4                          ; 1
    brsh wide_compare                   ; 1
wide_short:
    st Z, TOP                           ; 2
    inc r30                             ; 1
    wide_next                           ; 21
    brne wide_step                      ; 2
    rjmp wide_done
wide_compare:                           ;    value >= difference, all the bits?
    cp V0, D0
    cpc V1, D1
    cpc V2, D2
    cpc V3, D3
    cpc V4, D4
    brlo wide_short
    rjmp wide_down

wide_long:                              ;    q is too short
    wide_difference add, adc            ; 9  difference += 2h
    add5 VALUE, DIFF                    ; 5  value += difference
    brcc wide_up                        ; 1  and so is q + 1
    add5 GAIN, TURN                     ; 5  gain += turn
    lds SOME, extra                     ; 2  extra++
    inc SOME                            ; 1
    sts extra, SOME                     ; 2
    breq wide_extra                     ; 1
wide_put:
    inc TOP                             ; 1
    breq wide_carried                   ; 1
wide_carry:
    st Z, TOP                           ; 2
    dec TOP                             ; 1
    inc r30                             ; 1
    wide_next                           ; 21
    brne 1f                             ; 2
    rjmp wide_done
1:  rjmp wide_step                      ; 2

wide_extra:
    lds SOME, extra + 1
    inc SOME
    sts extra + 1, SOME
    rjmp wide_put
wide_carried:
    set
    rjmp wide_carry

wide_up:                                ;    q + 1 for q: difference has grown, value is q + 1's
    add5 GAIN, DIFF                     ;    gain += difference
    wide_bend add, adc                  ;    bend += 2*turn + 2h
    wide_turn add, adc                  ;    turn += 2h
    wide_bend add, adc
    lds SOME, extra                     ;    extra += left
    add SOME, LEFT
    sts extra, SOME
    brcc 1f
    lds SOME, extra + 1
    inc SOME
    sts extra + 1, SOME
1:  inc TOP
    breq 2f
    rjmp wide_long
2:  ldi SIGN, 1                         ;    q - 1 has the next high byte
    rjmp wide_back

wide_down:                              ;    q - 1 for q: value is that of q
    sub5 VALUE, DIFF                    ;    value -= difference
    sub5 GAIN, DIFF                     ;    gain -= difference
    wide_difference sub, sbc            ;    difference -= 2h
    wide_bend sub, sbc                  ;    bend -= 2*turn - 2h
    wide_turn sub, sbc                  ;    turn -= 2h
    wide_bend sub, sbc
    lds SOME, extra                     ;    extra -= left
    sub SOME, LEFT
    sts extra, SOME
    brcc 1f
    lds SOME, extra + 1
    dec SOME
    sts extra + 1, SOME
1:  tst TOP
    breq 2f
    dec TOP
    rjmp wide_compare
2:  dec TOP
    ldi SIGN, 0xFF                      ;    q - 1 has the high byte before
wide_back:
    sub5 VALUE, GAIN                    ;    the step is not made
    rjmp wide_leave

wide_done:
    ldi SIGN, 0
wide_leave:
    store4 V0, V1, V2, V3, CURVE_FLAT_RESIDUAL
    std Y + CURVE_FLAT_RESIDUAL + 3, V4
    store4 G0, G1, G2, G3, CURVE_FLAT_GAIN
    std Y + CURVE_FLAT_GAIN + 3, G4
    store4 D0, D1, D2, D3, CURVE_FLAT_DIFFERENCE
    std Y + CURVE_FLAT_DIFFERENCE + 3, D4
    std Y + CURVE_FLAT_TURN, T0
    std Y + CURVE_FLAT_TURN + 1, T1
    std Y + CURVE_FLAT_TURN + 2, T2
    std Y + CURVE_FLAT_TURN + 3, T3
    std Y + CURVE_FLAT_TOP, TOP
    ldd TOP, Y + CURVE_FLAT_TOP + 1
    add TOP, SIGN
    std Y + CURVE_FLAT_TOP + 1, TOP
    lds r22, extra
    lds r23, extra + 1
    mov r24, LEFT
    clr r1
flat_return:
    clr r25
    bld r25, 0
    restore_registers
    ret
    .size curve_flat_wide, . - curve_flat_wide
