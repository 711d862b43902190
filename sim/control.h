// SPDX-License-Identifier: MIT
//
// The control protocol: one command a line in, one line out. Simulated time advances only by `run`
// and `tx`, so that a session gives the same results every time. A command that cannot be done
// answers `error <text>`. Times are in cycles since the start, numbers decimal or 0x...
//
//   run CYCLES              ok CYCLE        runs for so many cycles; CYCLE = now
//   tx HEX [TIMEOUT]        rx HEX CYCLE    sends the bytes, then runs until 1750 us of silence
//                                           follow the answer (rx - CYCLE if no answer begins
//                                           within TIMEOUT cycles; default 100 ms)
//   send HEX [PAUSE_US]     ok CYCLE        the master sends the bytes after what it still has to
//                                           send, then pauses. No time passes: `run` or `tx`
//                                           must follow. CYCLE = the end of the last byte
//   baud RATE N|O|E         ok              rate and parity (N: two stop bits) of what the master
//                                           sends from now on; at first 115200 E
//   clock on|off            ok              pulses of the pixel clock
//   clock drop N            ok              drops the next N pulses
//   clock ppm X             ok              frequency error
//   clock hz N/D            ok              frequency; the next pulse rises one period from now
//   clock jitter NS         ok              each edge is off by at most so much from now on,
//   clock jitter-rms NS     ok              normally distributed, by this standard deviation
//   clock rest US           ok              the clock stands still for so long, and goes on where
//                                           it was
//   clock gate EDGES US     ok              from the next pulse on: so many edges, then the clock
//                                           stands still for so long, and so on; 0 0 ends this
//   edge BOARD miss N       ok              on this board's pin alone the Nth edge from now (1: the
//                                           next) is missing
//   edge BOARD add N PHASE  ok              a false one follows it, PHASE thousandths of a period
//                                           later; sim/pin_flaws.h has the rules
//   edge BOARD double N     ok              the same at a random 5 to 70 % of the period
//   edge BOARD pulse [at CYCLE]
//                           ok              a false edge, now or at a cycle to come
//   edge BOARD jitter NS    ok              each edge is off by at most so much
//   steps BOARD AXIS        steps N CYCLE   rising STEP edges, signed: DIR low counts up
//   counts BOARD AXIS       counts N        rising STEP edges
//   last BOARD AXIS         last N STEPS CYCLE BEFORE
//                                           rising STEP edges, their signed number, and the
//                                           cycles of the last one and of the one before (0:
//                                           none)
//   peek BOARD PLACE [LEN]  mem HEX         RAM and registers, without the side effects of reading
//                                           them. PLACE: an address, or a variable of the image,
//                                           NAME or NAME+OFFSET, whose length is LEN's default
//   poke BOARD PLACE HEX    ok              writes RAM
//   symbol BOARD NAME       symbol SPACE ADDRESS SIZE
//                                           where a symbol is, in flash, ram or eeprom, in bytes
//   eeprom BOARD read PLACE [LEN]
//                           mem HEX         a byte that is being written still reads as before
//   eeprom BOARD write PLACE HEX
//                           ok              writes from outside, in no time
//   eeprom BOARD state      eeprom WRITES ADDRESS LEFT
//                                           bytes that the program has begun to write so far; the
//                                           byte being written (- for none) and its cycles left
//   pin BOARD PORT BIT L [at CYCLE]
//                           ok              drives an input pin, now or at a cycle to come
//   permit BOARD            permit LEVEL CHANGES CYCLE RISE
//                                           the permit output, its edges so far, the cycles of
//                                           the last edge and of the last rise (0: never)
//   power BOARD off|on [at CYCLE]
//                           ok [CYCLE]      the supply fails or comes back. Off: the byte of
//                                           EEPROM being written becomes random, every pin an
//                                           input. On: RAM is noise. CYCLE: when it happened, at
//                                           the end of the instruction that was running
//   cycle BOARD [at CYCLE]  ok [CYCLE]      power off and on in the same cycle
//   reset BOARD external|brownout [at CYCLE]
//                           ok [CYCLE]      RAM and EEPROM keep their content; a write in progress
//                                           is completed
//   hang BOARD main         ok CYCLE        the main program stands still, where interrupts are
//                                           next on; interrupts are served
//   hang BOARD interrupts   ok CYCLE        nothing runs: a loop with interrupts off
//   hang BOARD for CYCLES   ok CYCLE        the processor stands still for up to 100000 cycles
//   hang BOARD axis N       ok CYCLE        the axis's step interrupt returns at its vector
//   hang BOARD at PLACE     ok CYCLE        the instruction at this flash address (bytes) or
//                                           function jumps to itself
//   hang BOARD ... kept     ok CYCLE        resets end a hang; only a power cut ends this one
//   hang BOARD off          ok CYCLE        ends all hangs of the board
//   plant BOARD AXIS        plant MOTOR LOAD    positions in steps
//   knobs BOARD AXIS PARAMETERS
//                           ok              changes parameters of the mechanics, written as for
//                                           --plant (--help lists them); the others stay. start=N
//                                           puts motor and load there, seed=S restarts the
//                                           random cycles of the bouncing. All contacts are at
//                                           once what their switches are
//   switches BOARD AXIS     switches HOME_CYCLE HOME_LEVEL MINUS_CYCLE MINUS_LEVEL PLUS_CYCLE
//                                    PLUS_LEVEL HOME_FIRST_CYCLE
//                                           for each switch the last change of its pin from
//                                           outside (0: never), and the level that it reads.
//                                           HOME_CYCLE is home's last edge so far, bouncing
//                                           included; HOME_FIRST_CYCLE is the first edge of that
//                                           change
//   stats                   one line of JSON    stats.h describes it
//   mark                    ok CYCLE        the handlers' figures in `stats` restart here
//   flush                   ok              completes all output files up to now, and the files
//                                           of the EEPROMs
//   pty                     pty NAME        offers the bus as a pseudo terminal. From now on `run`
//                                           passes on its bytes and takes as long as a board would;
//                                           `tx` is refused
//   lost                    lost CYCLES     by which the simulation has fallen behind real time
//                                           since then; what is lost is not caught up
//   quit                    ok              ends the program with status 0
#pragma once

#include "bench.h"

// Serves standard input until `quit` or its end. Returns the exit status.
int control_serve(struct bench *bench);
