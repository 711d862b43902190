// SPDX-License-Identifier: MIT
// What the two parts have where, from their data sheets: all that makes an avr8js CPU an ATmega328P
// or an ATmega2560. Interrupt addresses are words: two for each vector.
'use strict';

const avr8js = require('avr8js');

const vector = (number) => 2 * number;

// TIFRn and TIMSKn of a 16-bit timer with three channels.
const BITS_A_TO_C = {
    TOV: 0x01,
    OCFA: 0x02,
    OCFB: 0x04,
    OCFC: 0x08,
    TOIE: 0x01,
    OCIEA: 0x02,
    OCIEB: 0x04,
    OCIEC: 0x08,
};

// A 16-bit timer of the ATmega2560: control registers from `base`, vectors from `capture` on in the
// order capture, compare A, B, C, overflow; stepPort and stepPin are OCnB.
function timer16(name, base, TIFR, TIMSK, capture, stepPort, stepPin, icp) {
    const config = {
        ...avr8js.timer1Config,
        ...BITS_A_TO_C,
        captureInterrupt: vector(capture),
        compAInterrupt: vector(capture + 1),
        compBInterrupt: vector(capture + 2),
        compCInterrupt: vector(capture + 3),
        ovfInterrupt: vector(capture + 4),
        TIFR,
        TIMSK,
        TCCRA: base,
        TCCRB: base + 1,
        TCCRC: base + 2,
        TCNT: base + 4,
        ICR: base + 6,
        OCRA: base + 8,
        OCRB: base + 10,
        OCRC: base + 12,
        compPortA: stepPort.PORT,
        compPinA: stepPin - 1,
        compPortB: stepPort.PORT,
        compPinB: stepPin,
        compPortC: stepPort.PORT,
        compPinC: stepPin + 1,
        externalClockPort: 0,
    };
    return { name, config, icp };
}

// An 8-bit timer of the ATmega2560: the registers are the ATmega328P's.
function timer8(name, config, compareA) {
    return {
        name,
        config: {
            ...config,
            compAInterrupt: vector(compareA),
            compBInterrupt: vector(compareA + 1),
            ovfInterrupt: vector(compareA + 2),
            externalClockPort: 0,
        },
    };
}

function usart(receive) {
    return {
        ...avr8js.usart0Config,
        rxCompleteInterrupt: vector(receive),
        dataRegisterEmptyInterrupt: vector(receive + 1),
        txCompleteInterrupt: vector(receive + 2),
    };
}

const uno = {
    flashBytes: 32768,
    ramBytes: 2048,
    eepromBytes: 1024,
    responseCycles: 4,
    ports: { B: avr8js.portBConfig, C: avr8js.portCConfig, D: avr8js.portDConfig },
    timers: [
        { name: '0', config: avr8js.timer0Config },
        { name: '1', config: avr8js.timer1Config, icp: 'B0' },
        { name: '2', config: avr8js.timer2Config },
    ],
    usart: usart(18),
    externalInterrupts: [{ wire: 'D2', address: vector(1) }, { wire: 'D3', address: vector(2) }],
    eepromReady: vector(22),
    analogPorts: ['C', ''], // of ADC7:0 and ADC15:8
};

const mega = {
    flashBytes: 262144, // more than 64 K words: avr8js then has the wider program counter
    ramBytes: 8192 + 256, // 256 more registers, which avr8js counts as RAM
    eepromBytes: 4096,
    responseCycles: 5,
    ports: {
        A: avr8js.portAConfig,
        B: avr8js.portBConfig,
        C: avr8js.portCConfig,
        D: avr8js.portDConfig,
        E: avr8js.portEConfig,
        F: avr8js.portFConfig,
        G: avr8js.portGConfig,
        H: avr8js.portHConfig,
        J: avr8js.portJConfig,
        K: avr8js.portKConfig,
        L: avr8js.portLConfig,
    },
    timers: [
        timer8('0', avr8js.timer0Config, 21),
        timer16('1', 0x80, 0x36, 0x6f, 16, avr8js.portBConfig, 6, 'D4'),
        timer8('2', avr8js.timer2Config, 13),
        timer16('3', 0x90, 0x38, 0x71, 31, avr8js.portEConfig, 4, 'E7'),
        timer16('4', 0xa0, 0x39, 0x72, 41, avr8js.portHConfig, 4, 'L0'),
        timer16('5', 0x120, 0x3a, 0x73, 46, avr8js.portLConfig, 4, 'L1'),
    ],
    usart: usart(25),
    externalInterrupts: ['D0', 'D1', 'D2', 'D3', 'E4', 'E5', 'E6', 'E7'].map((wire, number) => ({
        wire,
        address: vector(1 + number),
    })),
    eepromReady: vector(30),
    analogPorts: ['F', 'K'],
};

module.exports = { uno, mega };
