; SPDX-License-Identifier: MIT
; The assembly half of wide.h:
;
;     struct wide wide_times(struct wide a, uint16_t factor)
;
; r2..r6 are left alone: they are the step interrupt's.

; a is in r20 (its bits 8 to 15) to r23 and r24 (its lowest 8), the factor in r19:r18; the product
; goes to r18 to r21 and r22 likewise. 69 cycles with the call.
#define A0   r24
#define A1   r20
#define A2   r21
#define A3   r22
#define A4   r23
#define B0   r18
#define B1   r19
#define P1   r26                 /* pairs P2:P1 and P4:P3 */
#define P2   r27
#define P3   r30
#define P4   r31
#define ZERO r25

    .section .text.wide_times, "ax", @progbits
    .global wide_times
    .type wide_times, @function
wide_times:
    clr ZERO                            ; 1
    mul A1, B0                          ; 9
    movw P1, r0
    mul A3, B0
    movw P3, r0
    mul A4, B0
    add P4, r0
    mul A2, B0                          ; 5
    add P2, r0
    adc P3, r1
    adc P4, ZERO
    mul A1, B1                          ; 5
    add P2, r0
    adc P3, r1
    adc P4, ZERO
    mul A2, B1                          ; 4
    add P3, r0
    adc P4, r1
    mul A3, B1                          ; 3
    add P4, r0
    mul A0, B1                          ; 6
    add P1, r0
    adc P2, r1
    adc P3, ZERO
    adc P4, ZERO
    mul A0, B0                          ; 7
    mov r22, r0
    add P1, r1
    adc P2, ZERO
    adc P3, ZERO
    adc P4, ZERO
    movw r18, P1                        ; 2
    movw r20, P3
    clr r1                              ; 1
    ret                                 ; 9  and the call
    .size wide_times, . - wide_times
