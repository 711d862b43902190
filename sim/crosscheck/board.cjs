// SPDX-License-Identifier: MIT
// A board in avr8js 0.21.1: an ATmega328P or ATmega2560 written independently of simavr and of
// pixstep's own models. avr8js runs the instructions, counts the timers, drives the ports and holds
// the EEPROM. What it lacks or has otherwise than the data sheets, and where that is put right:
//
//   timer.cjs        when flags and pins follow a match, TCNT writes, TIFRn, TEMP
//   capture.cjs      no input capture
//   comparator.cjs   no analog comparator
//   extint.cjs       external interrupts: INT3 and up, edges while masked, the synchronizer
//   usart.cjs,       one byte deep both ways, flags at the wrong time
//   receiver.cjs
//   pins.cjs         the cycle of a write, pull-ups, the synchronizer of PINn
//   access.cjs       the cycle of a read or write within its instruction
//   here             CBI takes 1 cycle: 2 on the part; an interrupt response of 2 cycles: 4, and 5
//                    with the wider program counter; one due event an instruction; interrupts right
//                    behind SEI and RETI: one more instruction runs first
//
// Left as it is: the half carry flag, from bit 0 instead of bit 3; nothing here looks at it.
// Left out: watchdog (a program that hangs makes no edges), sleep, resets, GTCCR, the ADC.
'use strict';

const avr8js = require('avr8js');

const { Access } = require('./access.cjs');
const { Capture } = require('./capture.cjs');
const { Comparator } = require('./comparator.cjs');
const { externalInterrupts } = require('./extint.cjs');
const { Pins } = require('./pins.cjs');
const { PRESCALER, Timer } = require('./timer.cjs');
const { Usart } = require('./usart.cjs');

const MCUSR = 0x54;
const POWER_ON = 0x01; // PORF
const SREG = 0x5f;
const INTERRUPTS_ON = 0x80; // I
const GTCCR = 0x43;

const RETI = 0x9518;
const SEI = 0x9478;
// What avr8js counts for an interrupt's response.
const AVR8JS_RESPONSE = 2;

class Board {
    // part: a row of parts.cjs; outputs: rows for pins.cjs; wires: { pins, frames } as read by
    // records.cjs, in order of cycles; prescaler: of timer.cjs.
    constructor(part, flash, outputs, wires, prescaler = PRESCALER.RECORDED) {
        this.cpu = new avr8js.CPU(flash, part.ramBytes);
        this.access = new Access(this.cpu);
        this.responseMissing = part.responseCycles - AVR8JS_RESPONSE;
        this.wires = wires.pins;
        this.nextWire = 0;
        const { cpu, access } = this;
        this.pins = new Pins(cpu, access, part.ports, outputs, {
            sync: (cycle) => this.sync(cycle),
            changed: (cycle) => this.followWires(cycle),
        });
        this.timers = part.timers.map((row) => new Timer(cpu, access, row, prescaler));
        this.usart = new Usart(cpu, access, part.usart, wires.frames);
        this.interrupts = externalInterrupts(cpu, access, part.externalInterrupts);
        this.connectCaptures(part);
        this.connectEeprom(part);
        cpu.writeHooks[GTCCR] = () => {
            throw new Error('GTCCR is not modelled');
        };
        cpu.data[MCUSR] = POWER_ON;
        this.devices = [...this.captures, ...this.timers, ...this.interrupts, this.usart];
        this.horizon = 0; // nothing is due before this cycle
        this.watchRegisters();
    }

    // An instruction that touches a register may make something due earlier than was known.
    watchRegisters() {
        const { cpu } = this;
        for (const [name, hooks] of [['readData', cpu.readHooks], ['writeData', cpu.writeHooks]]) {
            const own = cpu[name].bind(cpu);
            cpu[name] = (address, value, mask) => {
                const result = own(address, value, mask);
                if (hooks[address]) {
                    this.horizon = 0;
                }
                return result;
            };
        }
    }

    connectCaptures(part) {
        this.captures = [];
        this.captureWires = [];
        part.timers.forEach((row, index) => {
            if (row.icp) {
                this.captures.push(new Capture(this.cpu, this.timers[index]));
                this.captureWires.push(row.icp);
            }
        });
        this.comparator = new Comparator(
            this.cpu,
            this.access,
            part.analogPorts,
            (wire) => this.pins.level(wire),
            (cycle) => {
                this.sync(cycle);
                this.followWires(cycle);
            },
        );
    }

    connectEeprom(part) {
        const config = { ...avr8js.eepromConfig, eepromReadyInterrupt: part.eepromReady };
        const memory = new avr8js.EEPROMMemoryBackend(part.eepromBytes);
        new avr8js.AVREEPROM(this.cpu, memory, config);
    }

    get edges() {
        return this.pins.edges;
    }

    // Timer 1, the first that captures, listens to the comparator if told so.
    followWires(cycle) {
        this.captures.forEach((capture, index) => {
            const compared = index === 0 && this.comparator.captures;
            const wire = this.captureWires[index];
            capture.follow(compared ? this.comparator.output : this.pins.level(wire), cycle);
        });
        this.interrupts.forEach((line) => line.follow(this.pins.level(line.wire), cycle));
    }

    // The next change of a wire.
    takeWire() {
        const { cycle, wire, level } = this.wires[this.nextWire++];
        this.syncDevices(cycle - 1); // what came before it has seen the wire as it was
        this.pins.drive(wire, level, cycle);
        this.followWires(cycle);
    }

    // Everything up to and including this cycle happens. A capture comes before its timer goes on.
    sync(cycle) {
        while (this.nextWire < this.wires.length && this.wires[this.nextWire].cycle <= cycle) {
            this.takeWire();
        }
        this.syncDevices(cycle);
        this.horizon = Math.min(
            this.wires[this.nextWire]?.cycle ?? Infinity,
            this.pins.due,
            this.cpu.nextClockEvent?.cycles ?? Infinity,
            ...this.devices.map((device) => device.due),
        );
    }

    syncDevices(cycle) {
        for (const device of this.devices) {
            if (device.due <= cycle) {
                device.sync(cycle);
            }
        }
        this.pins.sync(cycle);
        while (this.cpu.nextClockEvent?.cycles <= cycle) {
            this.takeEvent();
        }
    }

    // An event of avr8js's own: the EEPROM's.
    takeEvent() {
        const { cpu } = this;
        const event = cpu.nextClockEvent;
        event.callback();
        cpu.nextClockEvent = event.next;
    }

    // One instruction, what happens meanwhile, and an interrupt if one may come.
    step() {
        const { cpu, access } = this;
        const opcode = cpu.progMem[cpu.pc];
        const enabledBefore = cpu.data[SREG] & INTERRUPTS_ON;
        access.opcode = opcode;
        avr8js.avrInstruction(cpu);
        if ((opcode & 0xff00) === 0x9800) {
            cpu.cycles++; // CBI
        }
        if (cpu.cycles >= this.horizon) {
            this.sync(cpu.cycles);
        }
        const enabled = cpu.data[SREG] & INTERRUPTS_ON;
        const oneMore = opcode === RETI || opcode === SEI || !enabledBefore;
        if (enabled && !oneMore && cpu.nextInterrupt >= 0) {
            this.serve();
        }
    }

    serve() {
        const { cpu } = this;
        const interrupt = cpu.pendingInterrupts[cpu.nextInterrupt];
        avr8js.avrInterrupt(cpu, interrupt.address);
        cpu.cycles += this.responseMissing;
        if (!interrupt.constant) {
            cpu.clearInterrupt(interrupt);
        }
    }

    // Runs until the cycle is reached or passed (by less than an instruction).
    runTo(cycle) {
        while (this.cpu.cycles < cycle) {
            this.step();
        }
    }
}

module.exports = { Board };
