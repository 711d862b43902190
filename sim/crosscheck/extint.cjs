// SPDX-License-Identifier: MIT
// External interrupts by edges. avr8js sees an edge at once, forgets one whose interrupt is not
// enabled, and has no INT2 and up; here, as the data sheets have it:
//
//   wire    ______/--------
//                 |<- 3 ->|       as in the timing diagram of the pin change interrupts: the data
//   INTFn   ______________/---    sheets have none for these
'use strict';

const { NEVER } = require('./timer.cjs');

const FLAG_CYCLES = 3;
const EIFR = 0x3c;
const EIMSK = 0x3d;
const EICRA = 0x69; // INT3:0; EICRB behind it INT7:4

const ANY = 1;
const RISING = 3; // 2: falling, 0: low level

class ExternalInterrupt {
    constructor(cpu, number, { wire, address }) {
        const mask = 1 << number;
        this.cpu = cpu;
        this.number = number;
        this.wire = wire;
        this.level = 0;
        this.due = NEVER;
        this.flag = {
            address,
            flagRegister: EIFR,
            flagMask: mask,
            enableRegister: EIMSK,
            enableMask: mask,
        };
    }

    follow(level, cycle) {
        if (level === this.level) {
            return;
        }
        this.level = level;
        const sense = (this.cpu.data[EICRA + (this.number >> 2)] >> (2 * (this.number & 3))) & 3;
        if (sense === ANY || (sense > ANY && (sense === RISING) === (level === 1))) {
            this.due = Math.min(this.due, cycle + FLAG_CYCLES);
        }
    }

    sync(cycle) {
        if (this.due <= cycle) {
            this.due = NEVER;
            this.cpu.setInterruptFlag(this.flag);
        }
    }
}

// Hooks of the flag and mask registers; returns the interrupts.
function externalInterrupts(cpu, access, table) {
    const lines = table.map((row, number) => new ExternalInterrupt(cpu, number, row));
    cpu.writeHooks[EIFR] = (value, old, address, mask) => {
        for (const line of lines) {
            line.sync(access.write());
            if (value & mask & line.flag.flagMask) {
                cpu.clearInterrupt(line.flag);
            }
        }
        return true;
    };
    cpu.writeHooks[EIMSK] = (value) => {
        for (const line of lines) {
            line.sync(access.write());
            cpu.updateInterruptEnable(line.flag, value);
        }
    };
    return lines;
}

module.exports = { externalInterrupts };
