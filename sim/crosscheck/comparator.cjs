// SPDX-License-Identifier: MIT
// The analog comparator as timer 1's capture source, which avr8js lacks: the bandgap against the
// pin that the ADC's multiplexer chooses. Pins are digital: the output is 1 while that pin is low.
// It takes no time here; on a part some 0.5 us.
'use strict';

const ACSR = 0x50;
const ADCSRB = 0x7b;
const ADMUX = 0x7c;

const BANDGAP = 0x40; // ACBG
const CAPTURES = 0x04; // ACIC
const MULTIPLEXED = 0x40; // ACME in ADCSRB
const UPPER = 0x08; // MUX5 in ADCSRB
const CHANNEL = 0x07; // MUX2:0 in ADMUX

class Comparator {
    // levelOf: a wire's level now; changed: called when output or use may be another.
    constructor(cpu, access, analogPorts, levelOf, changed) {
        this.cpu = cpu;
        this.analogPorts = analogPorts;
        this.levelOf = levelOf;
        for (const address of [ACSR, ADCSRB, ADMUX]) {
            cpu.writeHooks[address] = (value) => {
                cpu.data[address] = value;
                changed(access.write() + 1);
                return true;
            };
        }
    }

    // Timer 1 captures it instead of its pin.
    get captures() {
        return (this.cpu.data[ACSR] & CAPTURES) !== 0;
    }

    get output() {
        const { data } = this.cpu;
        if (!(data[ACSR] & BANDGAP) || !(data[ADCSRB] & MULTIPLEXED)) {
            return 0; // other inputs
        }
        const port = this.analogPorts[data[ADCSRB] & UPPER ? 1 : 0];
        return this.levelOf(port + (data[ADMUX] & CHANNEL)) ? 0 : 1;
    }
}

module.exports = { Comparator };
