// SPDX-License-Identifier: MIT
// When, to the cycle, an instruction touches a register. avr8js calls a register's hook with
// cpu.cycles at the instruction's first cycle (behind it for a load); the part reads and writes
//
//   IN, OUT, SBIC, SBIS                   in the first cycle
//   LD, LDS, ST, STS, SBI, CBI            in the second
//
// What is read in a cycle is what stands there in that cycle; what is written stands there from the
// next cycle on.
'use strict';

class Access {
    constructor(cpu) {
        this.cpu = cpu;
        this.opcode = 0; // of the running instruction
    }

    // The cycle in which the running instruction reads.
    read() {
        return this.cpu.cycles + (this.isBitWrite() ? 1 : 0);
    }

    // The cycle in which it writes.
    write() {
        return this.cpu.cycles + ((this.opcode & 0xf800) === 0xb800 ? 0 : 1);
    }

    // SBI or CBI.
    isBitWrite() {
        return (this.opcode & 0xfd00) === 0x9800;
    }

    // Does something as if it were that cycle: avr8js and its listeners take the time from the CPU.
    at(cycle, action) {
        const { cpu } = this;
        const now = cpu.cycles;
        cpu.cycles = cycle;
        const result = action();
        cpu.cycles = now;
        return result;
    }
}

module.exports = { Access };
