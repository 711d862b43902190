// SPDX-License-Identifier: MIT
// USART 0: its registers and its transmitter, in the place of avr8js's. That one has no second byte
// in the transmitter, says UDRE0 and TXC0 at the same time, forgets UDRE0 when its interrupt is
// served, loses a received byte that waits when UCSR0B is written, and keeps only one of them.
//
// A frame goes out at once; on a part it waits for the bit clock, up to one bit. pixstep-sim leaves
// that out too.
'use strict';

const { NEVER } = require('./timer.cjs');
const { Receiver } = require('./receiver.cjs');

const RECEIVED = 0x80; // in UCSR0A: RXC0
const SENT = 0x40; // TXC0
const SEND_READY = 0x20; // UDRE0
const DOUBLE_SPEED = 0x02; // U2X0
const RECEIVE_ON = 0x10; // in UCSR0B: RXEN0
const SEND_ON = 0x08; // TXEN0
const ENABLE_OF_FLAG = 0xe0; // each interrupt's enable is the bit of its flag

class Usart {
    constructor(cpu, access, config, frames) {
        this.cpu = cpu;
        this.access = access;
        this.config = config;
        this.receiver = new Receiver(frames, () => this.format());
        this.sent = []; // { cycle, byte }
        this.sendingUntil = NEVER;
        this.waiting = null; // the byte that follows
        const flag = (mask, address, constant) => ({
            address,
            flagRegister: config.UCSRA,
            flagMask: mask,
            enableRegister: config.UCSRB,
            enableMask: mask & ENABLE_OF_FLAG,
            constant, // a level: serving it does not end it
        });
        this.flags = {
            received: flag(RECEIVED, config.rxCompleteInterrupt, true),
            ready: flag(SEND_READY, config.dataRegisterEmptyInterrupt, true),
            sent: flag(SENT, config.txCompleteInterrupt, false),
        };
        cpu.data[config.UCSRA] = SEND_READY;
        cpu.data[config.UCSRC] = 0x06;
        this.hook();
    }

    get due() {
        return Math.min(this.sendingUntil, this.receiver.due);
    }

    sync(cycle) {
        while (this.sendingUntil <= cycle) {
            this.sendNext();
        }
        if (this.receiver.sync(cycle)) {
            this.cpu.setInterruptFlag(this.flags.received);
        }
    }

    format() {
        const { data } = this.cpu;
        const { UCSRA, UCSRB, UCSRC, UBRRL, UBRRH } = this.config;
        const parity = (data[UCSRC] >> 4) & 3; // 2 even, 3 odd
        return {
            enabled: (data[UCSRB] & RECEIVE_ON) !== 0,
            doubled: (data[UCSRA] & DOUBLE_SPEED) !== 0,
            sampleCycles: ((data[UBRRH] << 8) | data[UBRRL]) + 1,
            dataBits: 5 + ((data[UCSRC] >> 1) & 3),
            parity: parity === 0 ? null : parity & 1,
            stopBits: data[UCSRC] & 0x08 ? 2 : 1,
        };
    }

    send(byte, cycle) {
        const { doubled, sampleCycles, dataBits, parity, stopBits } = this.format();
        const bits = 1 + dataBits + (parity === null ? 0 : 1) + stopBits;
        this.sent.push({ cycle, byte });
        this.sendingUntil = cycle + bits * sampleCycles * (doubled ? 8 : 16);
    }

    // The frame on its way has ended.
    sendNext() {
        const cycle = this.sendingUntil;
        this.sendingUntil = NEVER;
        if (this.waiting === null) {
            this.cpu.setInterruptFlag(this.flags.sent);
            return;
        }
        this.send(this.waiting, cycle);
        this.waiting = null;
        this.cpu.setInterruptFlag(this.flags.ready);
    }

    write(byte) {
        const cycle = this.access.write();
        this.sync(cycle);
        if (!(this.cpu.data[this.config.UCSRB] & SEND_ON) || this.waiting !== null) {
            return;
        }
        if (this.sendingUntil === NEVER) {
            this.send(byte, cycle + 1);
        } else {
            this.waiting = byte;
            this.cpu.clearInterrupt(this.flags.ready);
        }
    }

    read() {
        this.sync(this.access.read());
        const byte = this.receiver.take();
        if (!this.receiver.waiting) {
            this.cpu.clearInterrupt(this.flags.received);
        }
        return byte;
    }

    hook() {
        const { cpu, access, config, flags } = this;
        cpu.readHooks[config.UDR] = () => this.read();
        cpu.writeHooks[config.UDR] = (value) => {
            this.write(value);
            return true;
        };
        cpu.readHooks[config.UCSRA] = () => {
            this.sync(access.read());
            return cpu.data[config.UCSRA] | this.receiver.status;
        };
        cpu.writeHooks[config.UCSRA] = (value) => {
            this.sync(access.write());
            if (value & SENT) {
                cpu.clearInterrupt(flags.sent);
            }
            cpu.data[config.UCSRA] &= ~DOUBLE_SPEED;
            cpu.data[config.UCSRA] |= value & DOUBLE_SPEED;
            return true;
        };
        cpu.writeHooks[config.UCSRB] = (value, old) => {
            const cycle = access.write();
            this.sync(cycle);
            if (!(value & RECEIVE_ON)) {
                this.receiver.flush();
                cpu.clearInterrupt(flags.received);
            } else if (!(old & RECEIVE_ON)) {
                this.receiver.enabledAt(cycle);
            }
            cpu.data[config.UCSRB] = value;
            Object.values(flags).forEach((flag) => cpu.updateInterruptEnable(flag, value));
            return true;
        };
    }
}

module.exports = { Usart };
