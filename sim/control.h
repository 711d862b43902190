// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// The control protocol: one command a line in, one line out. Simulated time advances only by
// `run` and `tx`, so that a run is the same every time. A command that cannot be done answers
// `error <text>`.
//
//   run CYCLES              ok CYCLE            run so far on; CYCLE = now
//   tx HEX [TIMEOUT]        rx HEX CYCLE        send, then run until 1750 us of silence after the
//                                               answer (rx - CYCLE if none begins within TIMEOUT
//                                               cycles, 100 ms if not given)
//   clock on|off            ok                  pulses of the pixel clock
//   clock drop N            ok                  leave the next N pulses out
//   clock ppm X             ok                  frequency error
//   steps BOARD AXIS        steps N CYCLE       rising edges, signed: DIR low counts up
//   counts BOARD AXIS       counts N            rising edges
//   peek BOARD ADDR LEN     mem HEX             RAM and registers as they stand (no side effects)
//   poke BOARD ADDR HEX     ok                  RAM
//   pin BOARD PORT BIT L    ok                  drive an input pin
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
//   flush                   ok                  output files are complete up to now
//   quit                    ok                  and exit with status 0
#pragma once

#include "lockstep.h"

// Serves standard input until `quit` or its end. Returns the exit status.
int control_serve(struct bench *bench);
