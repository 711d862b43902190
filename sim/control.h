// SPDX-License-Identifier: MIT
//
// The control protocol: one command a line in, one line out. Simulated time advances only by
// `run` and `tx`, so that a run is the same every time. A command that cannot be done answers
// `error <text>`.
//
//   run CYCLES              ok CYCLE            run so far on; CYCLE = now
//   tx HEX [TIMEOUT]        rx HEX CYCLE        send, then run until 1750 us of silence after the
//                                               answer (rx - CYCLE if none begins within TIMEOUT
//                                               cycles, 100 ms if not given)
//   send HEX [PAUSE_US]     ok CYCLE            the master sends, behind what it still has to send,
//                                               and waits so long before it sends again. No time
//                                               passes: `run` or `tx` follows. CYCLE = its end
//   baud RATE N|O|E         ok                  the master's rate and parity (N: two stop bits) for
//                                               what it sends from now on; at first 115200 E
//   clock on|off            ok                  pulses of the pixel clock
//   clock drop N            ok                  leave the next N pulses out
//   clock ppm X             ok                  frequency error
//   clock hz N/D            ok                  another frequency: the next pulse rises one period
//                                               from now
//   steps BOARD AXIS        steps N CYCLE       rising edges, signed: DIR low counts up
//   counts BOARD AXIS       counts N            rising edges
//   last BOARD AXIS         last N STEPS CYCLE BEFORE
//                                               rising edges, the same signed, and the cycles of
//                                               the last edge and of the one before it (0: none)
//   peek BOARD PLACE [LEN]  mem HEX             RAM and registers as they stand (no side effects).
//                                               PLACE: an address, or a variable of the image's
//                                               symbols: NAME or NAME+OFFSET, then LEN may be left
//                                               out
//   poke BOARD PLACE HEX    ok                  RAM
//   symbol BOARD NAME       symbol SPACE ADDRESS SIZE
//                                               where it is in flash, ram or eeprom, in bytes
//   eeprom BOARD read PLACE [LEN]
//                           mem HEX             a byte that is being written is still the old one
//   eeprom BOARD write PLACE HEX
//                           ok                  from outside, at once
//   eeprom BOARD state      eeprom WRITES ADDRESS LEFT
//                                               bytes that the program has begun to write so far;
//                                               the one on its way (- for none) and its cycles left
//   pin BOARD PORT BIT L [at CYCLE]
//                           ok                  drive an input pin, now or at a cycle to come
//   permit BOARD            permit LEVEL CHANGES CYCLE RISE
//                                               the permit output, its edges so far, the cycles of
//                                               the last one and of the last rise (0: never)
//   power BOARD off|on [at CYCLE]
//                           ok [CYCLE]          the supply fails or comes back. Off: the byte of
//                                               EEPROM on its way is anything, every pin an input.
//                                               On: RAM is noise. CYCLE: when it happened, at the
//                                               end of the instruction that was running
//   cycle BOARD [at CYCLE]  ok [CYCLE]          power off and on in the same cycle
//   reset BOARD external|brownout [at CYCLE]
//                           ok [CYCLE]          RAM and EEPROM are kept, a write on its way ends
//   hang BOARD main         ok CYCLE            the main program stands still, where interrupts are
//                                               next on; interrupts are served
//   hang BOARD interrupts   ok CYCLE            nothing runs: a loop with interrupts off
//   hang BOARD axis N       ok CYCLE            its step interrupt returns at its vector
//   hang BOARD at PLACE     ok CYCLE            the instruction at this flash address (bytes) or
//                                               function jumps to itself
//   hang BOARD ... kept     ok CYCLE            resets end a hang; only a power cut ends this one
//   hang BOARD off          ok CYCLE            all hangs of the board end
//   plant BOARD AXIS        plant MOTOR LOAD
//   knobs BOARD AXIS KNOBS  ok                  mechanics, as --plant (--help lists the knobs);
//                                               those not named stay. start=N puts motor and load
//                                               there, seed=S begins the bouncing's row anew.
//                                               Contacts are at once what their switches are:
//                                               nothing stays under way
//   switches BOARD AXIS     switches HOME_CYCLE HOME_LEVEL MINUS_CYCLE MINUS_LEVEL PLUS_CYCLE
//                                    PLUS_LEVEL HOME_FIRST_CYCLE
//                                               last change of each switch's pin as driven from
//                                               outside (0: never), and the level it reads.
//                                               HOME_FIRST_CYCLE: home's last change began here;
//                                               HOME_CYCLE is the last edge of its bouncing so far
//   stats                   one line of JSON
//   mark                    ok CYCLE            handlers' figures in `stats` begin anew here
//   flush                   ok                  output files are complete up to now, EEPROM files
//                                               too
//   quit                    ok                  and exit with status 0
#pragma once

#include "bench.h"

// Serves standard input until `quit` or its end. Returns the exit status.
int control_serve(struct bench *bench);
