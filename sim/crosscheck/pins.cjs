// SPDX-License-Identifier: MIT
// A part's pins: outputs that are watched, and inputs at the levels of the wires.
//
// avr8js tells of an output's change at once; the pin changes in the cycle after the write, or where
// the timer says. What nobody drives reads high: all inputs have pull-ups, which avr8js lacks. A pin
// that the program does not drive counts as low, as in pixstep-sim's log.
'use strict';

const avr8js = require('avr8js');

// The synchronizer of PINn: 0.5 to 1.5 cycles from a level to the register.
const PIN_CYCLES = 1;

class Pins {
    // outputs: rows { signal, axis, port, bit }; sync(cycle): the part's other devices come first.
    constructor(cpu, access, ports, outputs, sync) {
        this.cpu = cpu;
        this.access = access;
        this.edges = []; // { cycle, signal, axis, level }
        this.arriving = []; // { due, port, bit, level }: not in PINn yet
        this.ports = {};
        for (const [name, registers] of Object.entries(ports)) {
            // External interrupts are modelled in extint.cjs.
            const config = { ...registers, externalInterrupts: [], pinChange: undefined };
            this.ports[name] = new avr8js.AVRIOPort(cpu, config);
            for (let bit = 0; bit < 8; bit++) {
                this.ports[name].setPin(bit, true);
            }
            [config.PORT, config.DDR, config.PIN].forEach((address) => this.time(address, sync));
            cpu.readHooks[config.PIN] = () => {
                const cycle = access.read();
                sync(cycle);
                this.sync(cycle);
                return cpu.data[config.PIN];
            };
        }
        outputs.forEach((output) => this.watch(output));
    }

    // A write takes effect in the cycle after it.
    time(address, sync) {
        const own = this.cpu.writeHooks[address];
        this.cpu.writeHooks[address] = (value, old, at, mask) => {
            const cycle = this.access.write() + 1;
            sync(cycle);
            return this.access.at(cycle, () => own(value, old, at, mask));
        };
    }

    watch({ signal, axis, port, bit }) {
        const { DDR } = this.ports[port].portConfig;
        let known = 0;
        this.ports[port].addListener((value) => {
            const level = (value & this.cpu.data[DDR]) >> bit & 1;
            if (level !== known) {
                known = level;
                this.edges.push({ cycle: this.cpu.cycles, signal, axis, level });
            }
        });
    }

    // A wire, 'B0', is at this level from this cycle on.
    drive(wire, level, cycle) {
        const port = this.ports[wire[0]];
        this.arriving.push({ due: cycle + PIN_CYCLES, port, bit: Number(wire[1]), level });
    }

    sync(cycle) {
        while (this.arriving.length > 0 && this.arriving[0].due <= cycle) {
            const { port, bit, level } = this.arriving.shift();
            port.setPin(bit, level === 1);
        }
    }
}

module.exports = { Pins };
