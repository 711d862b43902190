// SPDX-License-Identifier: MIT
// A timer of avr8js, counted to the exact cycle. avr8js counts at the ends of instructions; here
// its own count() is called for the very cycles in which something happens:
//
//   TCNT      ...  OCRnx - 1   OCRnx      OCRnx + 1   ...  TOP      BOTTOM
//   avr8js                     OCFnx, pin                           TOVn, pin, buffers load
//   the part                              OCFnx, pin                TOVn, pin, buffers load
//
// What avr8js has otherwise than the data sheets, and is mended here:
//  * flag and pin of a match come with the match: the part has them one timer clock later;
//  * an OCRnx above TOP matches at each overflow: the part never reaches it;
//  * a write to TCNTn takes effect with the next count, and may match at once: on the part it
//    stands in the next cycle, and blocks the match of the next timer clock;
//  * a write to TIFRn overwrites the flags that it should leave alone, and does not know ICFn;
//  * reads of TCNTnL and ICRnL leave TEMP alone: on the part they put the high byte there.
'use strict';

const avr8js = require('avr8js');

const NEVER = Infinity;
const CAPTURE_BIT = 0x20; // ICFn and ICIEn

// Prescalers. On the part they have been running since the reset, and before the program a boot
// loader has: a timer's first count comes at any phase, and a write to TCNTn does not change it.
// RECORDED is what pixstep-sim has from simavr: with each write to TCCRnB or TCNTn the prescaler
// begins anew, at the instruction's first cycle. For TCNTn that is wrong by the data sheets: timer
// 2's silence behind a byte is up to one count of 16 us longer for it.
const PRESCALER = { RECORDED: 'recorded', PART: 'part' };

class Timer {
    constructor(cpu, access, { name, config }, prescaler) {
        this.name = name;
        this.prescaler = prescaler;
        this.cpu = cpu;
        this.access = access;
        this.config = config;
        this.core = new avr8js.AVRTimer(cpu, config);
        this.due = NEVER; // the cycle of the next match's effect or BOTTOM
        this.blocked = false; // the next match, by a write to TCNTn
        this.captureFlag = {
            address: config.captureInterrupt,
            flagRegister: config.TIFR,
            flagMask: CAPTURE_BIT,
            enableRegister: config.TIMSK,
            enableMask: CAPTURE_BIT,
        };
        const { OVF, OCFA, OCFB, OCFC } = this.core;
        this.flags = [OVF, OCFA, OCFB];
        if (config.OCRC) {
            this.flags.push(OCFC);
        }
        if (config.bits === 16) {
            this.flags.push(this.captureFlag);
        }
        this.mendMatches();
        this.mendCount();
        this.mendFlags();
        this.follow([config.TCCRA, config.OCRA, config.OCRB, config.OCRC]);
        if (config.bits === 16) {
            this.mendTemp();
        }
    }

    // Everything up to and including this cycle happens.
    sync(cycle) {
        while (this.due <= cycle) {
            const { due } = this;
            this.count(due - this.core.divider);
            this.count(due);
            this.plan();
        }
    }

    // TCNT in this cycle.
    read(cycle) {
        this.sync(cycle);
        this.count(cycle);
        return this.core.tcnt;
    }

    // An edge of the input capture takes effect in this cycle. An instruction that reads TCNTn may
    // have counted on already: by a cycle or two, and not past BOTTOM, which the timer stops at.
    capture(cycle) {
        const count = this.read(cycle);
        const ahead = Math.max(0, this.core.lastCycle - cycle);
        if (ahead > count) {
            throw new Error(`timer ${this.name}: a capture before BOTTOM is seen behind it`);
        }
        this.core.icr = count - ahead;
        this.cpu.setInterruptFlag(this.captureFlag);
    }

    count(cycle) {
        this.access.at(cycle, () => this.core.count(false));
    }

    plan() {
        const { tcnt, lastCycle, divider, ocrA, ocrB, ocrC, TOP } = this.core;
        let next = TOP;
        for (const match of [ocrA, ocrB, ocrC]) {
            if (match >= tcnt && match < next) {
                next = match;
            }
        }
        this.due = divider ? lastCycle + (next - tcnt + 1) * divider : NEVER;
    }

    // A count leaves `before`: only then does its match take effect.
    mendMatches() {
        const { core } = this;
        const matched = core.timerUpdated.bind(core);
        core.timerUpdated = (value, before) => {
            if (this.writing) {
                return;
            }
            if (!this.blocked) {
                matched(before, before - 1);
            }
            this.blocked = false;
        };
    }

    // Runs avr8js's own hook of a register for a write's exact cycle.
    after(address, hook) {
        const own = this.cpu.writeHooks[address];
        this.cpu.writeHooks[address] = (value, old, at, mask) => {
            const cycle = this.access.write() + 1;
            this.read(cycle);
            const done = this.access.at(cycle, () => own(value, old, at, mask));
            hook?.(cycle);
            this.plan();
            return done;
        };
    }

    follow(registers) {
        registers.filter((address) => address > 0).forEach((address) => this.after(address));
    }

    mendCount() {
        const { cpu, core, config } = this;
        const written = cpu.writeHooks[config.TCNT];
        cpu.writeHooks[config.TCNT] = (value, old, address, mask) => {
            this.writing = true;
            written(value, old, address, mask);
            this.writing = false;
        };
        this.after(config.TCNT, (cycle) => {
            this.count(cycle);
            this.blocked = true;
            if (this.prescaler === PRESCALER.RECORDED) {
                this.placePrescaler();
            }
        });
        this.after(config.TCCRB, (cycle) => {
            cpu.clearClockEvent(core.count);
            this.count(cycle); // takes the new clock select
            cpu.clearClockEvent(core.count);
            this.placePrescaler();
        });
        cpu.readHooks[config.TCNT] = () => {
            const count = this.read(this.access.read());
            core.highByteTemp = count >> 8;
            return count & 0xff;
        };
    }

    placePrescaler() {
        const { core, cpu } = this;
        if (core.divider > 1) {
            const since = this.prescaler === PRESCALER.PART ? cpu.cycles % core.divider : 0;
            core.lastCycle = cpu.cycles - since;
        }
    }

    mendFlags() {
        const { cpu, config, flags } = this;
        cpu.readHooks[config.TIFR] = () => {
            this.sync(this.access.read());
            return cpu.data[config.TIFR];
        };
        cpu.writeHooks[config.TIFR] = (value, old, address, mask) => {
            this.sync(this.access.write());
            flags
                .filter((flag) => value & mask & flag.flagMask)
                .forEach((flag) => cpu.clearInterrupt(flag));
            return true;
        };
        cpu.writeHooks[config.TIMSK] = (value) => {
            this.sync(this.access.write());
            flags.forEach((flag) => cpu.updateInterruptEnable(flag, value));
        };
    }

    mendTemp() {
        const { cpu, core, config } = this;
        cpu.readHooks[config.ICR] = () => {
            this.sync(this.access.read());
            core.highByteTemp = core.icr >> 8;
            return core.icr & 0xff;
        };
        cpu.readHooks[config.ICR + 1] = () => core.highByteTemp;
        cpu.readHooks[config.TCNT + 1] = () => core.highByteTemp;
    }
}

module.exports = { PRESCALER, Timer, NEVER };
