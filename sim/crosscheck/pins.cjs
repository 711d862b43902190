// SPDX-License-Identifier: MIT
// A part's pins: outputs that are watched, and inputs at the levels of the wires.
//
// avr8js tells of an output's change at once; the pin changes in the cycle after the write, or
// where the timer says. It lacks pull-ups: an input that nobody drives is what its bit of PORTn
// says, and low without a pull-up, where a part's floats (as in pixstep-sim). A pin that the
// program does not drive counts as low, as in pixstep-sim's log.
'use strict';

const avr8js = require('avr8js');

// The synchronizer of PINn: 0.5 to 1.5 cycles from a level to the register.
const PIN_CYCLES = 1;

class Pins {
    // outputs: rows { signal, axis, port, bit }; sync(cycle): the part's other devices come first;
    // changed(cycle): inputs may be at other levels.
    constructor(cpu, access, ports, outputs, { sync, changed }) {
        this.cpu = cpu;
        this.access = access;
        this.edges = []; // { cycle, signal, axis, level }
        this.driven = {}; // levels by wire, 'B0'
        this.arriving = []; // { due, port, bit, level }: not in PINn yet
        this.ports = {};
        for (const [name, registers] of Object.entries(ports)) {
            // External interrupts are modelled in extint.cjs.
            const config = { ...registers, externalInterrupts: [], pinChange: undefined };
            this.ports[name] = new avr8js.AVRIOPort(cpu, config);
            const pulled = (cycle) => {
                this.pullUp(name, cycle);
                changed(cycle);
            };
            this.time(config.PORT, sync, pulled);
            this.time(config.PIN, sync, pulled);
            this.time(config.DDR, sync, changed);
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
    time(address, before, behind) {
        const own = this.cpu.writeHooks[address];
        this.cpu.writeHooks[address] = (value, old, at, mask) => {
            const cycle = this.access.write() + 1;
            before(cycle);
            const done = this.access.at(cycle, () => own(value, old, at, mask));
            behind(cycle);
            return done;
        };
    }

    pullUp(name, cycle) {
        for (let bit = 0; bit < 8; bit++) {
            if (this.driven[name + bit] === undefined) {
                this.arrive(name + bit, cycle);
            }
        }
    }

    // What a wire is at, 'B0'.
    level(wire) {
        const { PORT } = this.ports[wire[0]].portConfig;
        return this.driven[wire] ?? ((this.cpu.data[PORT] >> Number(wire[1])) & 1);
    }

    watch({ signal, axis, port, bit }) {
        const { DDR } = this.ports[port].portConfig;
        let known = 0;
        this.ports[port].addListener((value) => {
            const level = ((value & this.cpu.data[DDR]) >> bit) & 1;
            if (level !== known) {
                known = level;
                this.edges.push({ cycle: this.cpu.cycles, signal, axis, level });
            }
        });
    }

    // A wire is at this level from this cycle on.
    drive(wire, level, cycle) {
        this.driven[wire] = level;
        this.arrive(wire, cycle);
    }

    arrive(wire, cycle) {
        const port = this.ports[wire[0]];
        const level = this.level(wire);
        this.arriving.push({ due: cycle + PIN_CYCLES, port, bit: Number(wire[1]), level });
    }

    get due() {
        return this.arriving[0]?.due ?? Infinity;
    }

    sync(cycle) {
        while (this.arriving.length > 0 && this.arriving[0].due <= cycle) {
            const { port, bit, level } = this.arriving.shift();
            port.setPin(bit, level === 1);
        }
    }
}

module.exports = { Pins };
