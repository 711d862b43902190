// SPDX-License-Identifier: MIT
// Input capture of a 16-bit timer, which avr8js lacks.
//
//   wire      _____/--------            ICPn, or for timer 1 the comparator's output
//                  |<- 3 ->|
//   ICRn, ICFn             ^ TCNTn of this cycle
//
// "The input capture is delayed": synchronizer and edge detector take 2.5 to 3.5 cycles by the data
// sheet; an edge exactly on a clock edge, as all edges of a simulator are, takes 3.
'use strict';

const { NEVER } = require('./timer.cjs');

const CAPTURE_CYCLES = 3;
const RISING = 0x40; // ICESn in TCCRnB
const CANCELER = 0x80; // ICNCn

class Capture {
    constructor(cpu, timer) {
        this.cpu = cpu;
        this.timer = timer;
        this.level = 0;
        this.coming = []; // cycles of the captures that are still on their way
    }

    get due() {
        return this.coming.length === 0 ? NEVER : this.coming[0];
    }

    // The front end's input is at this level from this cycle on.
    follow(level, cycle) {
        if (level === this.level) {
            return;
        }
        this.level = level;
        const control = this.cpu.data[this.timer.config.TCCRB];
        if (control & CANCELER) {
            throw new Error(`timer ${this.timer.name}: its noise canceler is not modelled`);
        }
        if (level === (control & RISING ? 1 : 0)) {
            this.coming.push(cycle + CAPTURE_CYCLES);
        }
    }

    sync(cycle) {
        while (this.due <= cycle) {
            this.timer.capture(this.coming.shift());
        }
    }
}

module.exports = { Capture };
