// SPDX-License-Identifier: MIT
// The USART's receiver, from the levels of the wire: samples, two buffered characters and one in
// the shift register, with the errors of each.
//
//   wire     ‾‾\__start__/‾‾bit 0‾‾X ...          X‾‾stop‾‾
//   samples     | 1 2 .. 8 9 10 .. 16 | 1 2 ..       8 9 10     (U2X: 4 5 6 of 8)
//                 majority of three: the bit's value      ^ RXC
//
// The sample clock begins with the start bit: on a part it runs freely, so that every sample and
// RXC may be up to one sample later. pixstep-sim leaves that out too.
'use strict';

const { NEVER } = require('./timer.cjs');

// The samples by which a bit is decided, of 16 and, with U2X, of 8.
const DECIDING = { normal: [8, 9, 10], doubled: [4, 5, 6] };

// The sample of the stop bit with which RXC is set: the last of the three that decide it.
const RECEIVED_AT = { normal: 10, doubled: 6 };

const BUFFERED = 2; // characters, besides the one that waits in the shift register

const FRAME_ERROR = 0x10; // FE0, as in UCSR0A
const OVERRUN = 0x08; // DOR0
const PARITY_ERROR = 0x04; // UPE0

class Receiver {
    // frames: { cycle, levels, bitCycles } in order; format(): { enabled, doubled, sampleCycles,
    // dataBits, parity } as the registers stand; parity: null, 0 even, 1 odd.
    constructor(frames, format) {
        this.frames = frames;
        this.next = 0;
        this.format = format;
        this.frame = null; // being received
        this.buffer = [];
        this.overrun = false;
        this.heard = []; // { cycle, byte } of every character
        this.plan();
    }

    get due() {
        return this.receivedAt ?? this.startAt;
    }

    plan() {
        this.receivedAt = null;
        this.startAt = this.frames[this.next]?.cycle ?? NEVER;
    }

    // True if something came.
    sync(cycle) {
        let came = false;
        while (this.due <= cycle) {
            if (this.receivedAt === null) {
                this.begin();
            } else {
                this.end();
                came = true;
            }
        }
        return came;
    }

    begin() {
        const frame = this.frames[this.next++];
        const format = this.format();
        this.plan();
        if (!format.enabled) {
            this.deafUntil = frame.cycle + frame.levels.length * frame.bitCycles;
            return;
        }
        if (this.buffer.length > BUFFERED) {
            this.overrun = true; // what waits in the shift register is run over
            this.buffer.pop();
        }
        this.frame = frame;
        this.bits = 1 + format.dataBits + (format.parity === null ? 0 : 1);
        const samples = this.bits * (format.doubled ? 8 : 16);
        const last = format.doubled ? RECEIVED_AT.doubled : RECEIVED_AT.normal;
        this.receivedAt = frame.cycle + (samples + last) * format.sampleCycles;
    }

    end() {
        const cycle = this.receivedAt;
        const format = this.format();
        const levels = Array.from({ length: this.bits + 1 }, (_, bit) => this.decide(bit, format));
        this.plan();
        if (!format.enabled) {
            return;
        }
        const data = levels.slice(1, 1 + format.dataBits);
        const byte = data.reduce((sum, level, bit) => sum | (level << bit), 0);
        const ones = levels.slice(1, this.bits).reduce((sum, level) => sum + level, 0);
        let errors = levels[this.bits] ? 0 : FRAME_ERROR;
        if (format.parity !== null && (ones & 1) !== format.parity) {
            errors |= PARITY_ERROR;
        }
        this.buffer.push({ byte, errors });
        this.heard.push({ cycle, byte });
    }

    decide(bit, { doubled, sampleCycles }) {
        const perBit = doubled ? 8 : 16;
        const samples = doubled ? DECIDING.doubled : DECIDING.normal;
        const ones = samples.filter((sample) => this.level((bit * perBit + sample) * sampleCycles));
        return ones.length >= 2 ? 1 : 0;
    }

    // The wire's level so many cycles behind the start of the frame.
    level(cycles) {
        const bit = Math.floor(cycles / this.frame.bitCycles);
        return this.frame.levels[bit] !== '0'; // at rest behind the frame
    }

    // The receiver is switched on at this cycle.
    enabledAt(cycle) {
        if (this.deafUntil > cycle) {
            throw new Error(`cycle ${cycle}: receiver on in a frame's midst: not modelled`);
        }
    }

    // It is switched off: nothing stays in it.
    flush() {
        this.buffer = [];
        this.overrun = false;
        this.plan();
    }

    get status() {
        return (this.buffer[0]?.errors ?? 0) | (this.overrun ? OVERRUN : 0);
    }

    get waiting() {
        return this.buffer.length > 0;
    }

    take() {
        const first = this.buffer.shift();
        this.overrun = false;
        this.last = first?.byte ?? this.last ?? 0;
        return this.last;
    }
}

module.exports = { Receiver };
