// SPDX-License-Identifier: MIT
// An Arduino Uno in avr8js 0.21.1, which is an ATmega328P written independently of simavr and of
// pixstep's own timer model. What avr8js itself lacks, and is put right here:
//
//  * no input capture: an edge on ICP1 sets ICR1 and ICF1 here, from the counter of avr8js;
//  * a write to TIFR1 overwrites the flags that it should leave alone, and does not know ICF1;
//  * GTCCR: timers are not held while TSM is set;
//  * an interrupt response of 2 cycles: the part takes 4;
//  * one due event an instruction: all that are due are served here;
//  * no pull-ups: every pin reads high unless it is an output;
//  * a write to UCSR0A clears UDRE0 and RXC0, and one to UCSR0B loses a received byte that waits.
//
// Left as they are: pin changes of a timer are seen at the ends of instructions (they are snapped
// to the match by the timer's own count), and in fast PWM an OCR1B above TOP makes a pulse of no
// length at each overflow (dropped: the count is then below OCR1B, which no true match can have).
'use strict';

const avr8js = require('avr8js');

const FLASH_BYTES = 32768;
const RAM_BYTES = 2048;
const EEPROM_BYTES = 1024;
const CLOCK_HZ = 16e6;

const GTCCR = 0x43;
const GTCCR_TSM = 0x80;
const TIFR1 = 0x36;
const TIMSK1 = 0x6f;
const TCCR1B = 0x81;
const ICR1L = 0x86;
const ICR1H = 0x87;
const UCSR0A = 0xc0;
const UCSR0B = 0xc1;

const CAPTURE_RISING = 0x40; // ICES1
const CAPTURE_CANCELER = 0x80; // ICNC1
const RECEIVED = 0x80; // RXC0
const SENT = 0x40; // TXC0
const SEND_READY = 0x20; // UDRE0

// From an edge on ICP1 to ICR1: 2.5 to 3.5 cycles by the data sheet.
const CAPTURE_CYCLES = 3;
// What the part's interrupt response takes longer than avr8js says.
const RESPONSE_MISSING_CYCLES = 2;

const CAPTURE_INTERRUPT = {
    address: 0x14,
    flagRegister: TIFR1,
    flagMask: 0x20,
    enableRegister: TIMSK1,
    enableMask: 0x20,
};

class Uno {
    // outputs: rows of { signal, port: 'B' | 'D', bit }; STEP must be OC1B.
    constructor(flash, outputs) {
        this.cpu = new avr8js.CPU(flash, RAM_BYTES);
        this.ports = {
            B: new avr8js.AVRIOPort(this.cpu, avr8js.portBConfig),
            C: new avr8js.AVRIOPort(this.cpu, avr8js.portCConfig),
            D: new avr8js.AVRIOPort(this.cpu, avr8js.portDConfig),
        };
        for (const port of Object.values(this.ports)) {
            for (let bit = 0; bit < 8; bit++) {
                port.setPin(bit, true);
            }
        }
        this.timers = [avr8js.timer0Config, avr8js.timer1Config, avr8js.timer2Config].map(
            (config) => new avr8js.AVRTimer(this.cpu, config),
        );
        this.timer1 = this.timers[1];
        this.usart = new avr8js.AVRUSART(this.cpu, avr8js.usart0Config, CLOCK_HZ);
        new avr8js.AVREEPROM(this.cpu, new avr8js.EEPROMMemoryBackend(EEPROM_BYTES));
        this.edges = []; // { cycle, signal, level }
        this.sent = []; // bytes
        this.usart.onByteTransmit = (byte) => this.sent.push(byte);
        this.lastTop = 0;
        this.mendTimerHold();
        this.mendTimerFlags();
        this.mendSerialFlags();
        this.watch(outputs);
    }

    // Runs until the cycle is reached or passed (by less than an instruction).
    runTo(cycle) {
        const cpu = this.cpu;
        while (cpu.cycles < cycle) {
            avr8js.avrInstruction(cpu);
            this.serve();
        }
    }

    // Events that are due, then at most one interrupt.
    serve() {
        const cpu = this.cpu;
        for (;;) {
            const enabled = cpu.interruptsEnabled;
            cpu.tick();
            if (enabled && !cpu.interruptsEnabled) {
                cpu.cycles += RESPONSE_MISSING_CYCLES;
                return;
            }
            if (!cpu.nextClockEvent || cpu.nextClockEvent.cycles > cpu.cycles) {
                return;
            }
        }
    }

    // A byte is complete in the receiver now.
    receive(byte) {
        if (this.cpu.data[UCSR0A] & RECEIVED) {
            throw new Error(`cycle ${this.cpu.cycles}: receiver overrun`);
        }
        this.usart.writeByte(byte, true);
    }

    // Takes in a rising edge that reached ICP1 at this cycle, CAPTURE_CYCLES or a little more ago.
    capture(edgeCycle) {
        const control = this.cpu.data[TCCR1B];
        if (!(control & CAPTURE_RISING) || control & CAPTURE_CANCELER) {
            return; // not the edge that the firmware asked for, or not yet
        }
        const timer = this.timer1;
        timer.count(false);
        let count = timer.tcnt - (timer.lastCycle - (edgeCycle + CAPTURE_CYCLES));
        if (count < 0) {
            count += this.lastTop + 1; // the edge was before the last BOTTOM
        }
        timer.icr = count;
        this.cpu.data[ICR1L] = count & 0xff;
        this.cpu.setInterruptFlag(CAPTURE_INTERRUPT);
    }

    // GTCCR: while TSM is set, the timers' clocks stand still.
    mendTimerHold() {
        const cpu = this.cpu;
        let held = false;
        for (const timer of this.timers) {
            const count = timer.count;
            timer.count = (reschedule = true, external = false) => {
                if (held) {
                    timer.lastCycle = cpu.cycles;
                }
                return count(reschedule, external);
            };
        }
        cpu.writeHooks[GTCCR] = (value) => {
            this.timers.forEach((timer) => timer.count(false));
            held = (value & GTCCR_TSM) !== 0;
            // The reset bits are cleared by the part at once, unless TSM holds them.
            cpu.data[GTCCR] = held ? value : 0;
            return true;
        };
    }

    mendTimerFlags() {
        const cpu = this.cpu;
        const timer = this.timer1;
        const flags = [timer.OVF, timer.OCFA, timer.OCFB, CAPTURE_INTERRUPT];
        cpu.writeHooks[TIFR1] = (value, old, address, mask) => {
            flags
                .filter((flag) => value & mask & flag.flagMask)
                .forEach((flag) => cpu.clearInterrupt(flag));
            return true;
        };
        cpu.writeHooks[TIMSK1] = (value) => {
            flags.forEach((flag) => cpu.updateInterruptEnable(flag, value));
        };
        // The low byte is read first and holds the high one for the second read.
        cpu.readHooks[ICR1L] = () => {
            cpu.data[ICR1H] = timer.icr >> 8;
            return timer.icr & 0xff;
        };
        // Remember TOP of the period before, for a capture that belongs to it. A compare value
        // above TOP is never reached: no flag at the overflow either.
        const updated = timer.timerUpdated.bind(timer);
        timer.timerUpdated = (value, before) => {
            const flagged = (cpu.data[TIFR1] & timer.OCFB.flagMask) !== 0;
            const reachable = timer.ocrB <= timer.TOP;
            if (value < before) {
                this.lastTop = timer.TOP;
            }
            updated(value, before);
            if (!reachable && !flagged) {
                cpu.clearInterrupt(timer.OCFB);
            }
        };
    }

    mendSerialFlags() {
        const cpu = this.cpu;
        const writeStatus = cpu.writeHooks[UCSR0A];
        cpu.writeHooks[UCSR0A] = (value, old, address, mask) => {
            // Only SENT can be cleared by a write, with a one.
            const kept = cpu.data[UCSR0A] & (RECEIVED | SEND_READY | (SENT & ~value));
            writeStatus(value, old, address, mask);
            cpu.data[UCSR0A] |= kept;
            return true;
        };
        const writeControl = cpu.writeHooks[UCSR0B];
        cpu.writeHooks[UCSR0B] = (value, old, address, mask) => {
            const waiting = cpu.data[UCSR0A] & RECEIVED;
            writeControl(value, old, address, mask);
            if (waiting) {
                cpu.setInterruptFlag(this.usart.RXC);
            }
            return true;
        };
    }

    watch(outputs) {
        for (const { signal, port, bit } of outputs) {
            this.ports[port].addListener((value, before) => {
                const level = (value >> bit) & 1;
                if (level !== ((before >> bit) & 1)) {
                    this.note(signal, level);
                }
            });
        }
    }

    note(signal, level) {
        const cycle = signal === 'STEP' ? this.stepCycle(level) : this.cpu.cycles;
        if (cycle !== null) {
            this.edges.push({ cycle, signal, level });
        }
    }

    // The exact cycle of a STEP edge, from the timer's own count: a rise one timer clock after the
    // match with OCR1B, a fall at BOTTOM. null: a pulse of no length at an overflow.
    stepCycle(level) {
        const { tcnt, lastCycle, ocrB } = this.timer1;
        if (level === 0) {
            const last = this.edges[this.edges.length - 1];
            return this.droppedRise === lastCycle || !last ? null : lastCycle - tcnt;
        }
        this.droppedRise = tcnt < ocrB ? lastCycle : null;
        return this.droppedRise === null ? lastCycle - (tcnt - ocrB) + 1 : null;
    }
}

module.exports = { Uno, CAPTURE_CYCLES, FLASH_BYTES };
