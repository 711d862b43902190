// SPDX-License-Identifier: MIT
// The Uno image in avr8js, fed with the inputs of a run that pixstep-sim recorded: are its STEP
// edges the same? A test of the simulator, not of the firmware.
//
//     node crosscheck.cjs --image UNO.elf --pins UNO.def --run DIR [--min-steps N]
//
// DIR holds edges.csv, clock.csv (--clock-log) and serial.csv (--serial-log).
'use strict';

const fs = require('fs');
const path = require('path');

const { Uno, CAPTURE_CYCLES, FLASH_BYTES } = require('./board.cjs');
const { compare } = require('./compare.cjs');
const { readFlash } = require('./elf.cjs');
const { play, readClock, readEdges, readSerial } = require('./replay.cjs');

const TOLERANCE_CYCLES = 3;
const MIN_STEPS = 20000;
// Run on after the last recorded edge, so that an edge too many shows.
const RUN_ON_CYCLES = 160000;
const WATCHED = new Set(['STEP', 'DIR', 'ENABLE', 'PERMIT']);

// Pins of axis 0 from the board's own table.
function readPins(file) {
    const row = /^BOARD_PIN\((\w+), 0, ([A-Z]), (\d), "[^"]*"\)/gm;
    return [...fs.readFileSync(file, 'utf8').matchAll(row)]
        .map(([, signal, port, bit]) => ({ signal, port, bit: Number(bit) }))
        .filter(({ signal }) => WATCHED.has(signal));
}

function readArguments(words) {
    const options = { 'min-steps': String(MIN_STEPS) };
    for (let at = 0; at < words.length; at += 2) {
        options[words[at].replace(/^--/, '')] = words[at + 1];
    }
    for (const name of ['image', 'pins', 'run']) {
        if (!options[name]) {
            throw new Error(`--${name} is missing`);
        }
    }
    return options;
}

// How many bytes of the replies are the same. Not judged: replies hold the ring's fill at that very
// moment, which some cycles of the main loop may change, and the replay ends soon after the line.
function sameReplies(sent, recorded) {
    return recorded.filter((byte, at) => byte === sent[at]).length;
}

function main() {
    const options = readArguments(process.argv.slice(2));
    const expected = readEdges(path.join(options.run, 'edges.csv'));
    const clock = readClock(path.join(options.run, 'clock.csv'));
    const serial = readSerial(path.join(options.run, 'serial.csv'));
    if (expected.length === 0) {
        throw new Error(`${options.run}/edges.csv: no edges`);
    }
    const board = new Uno(readFlash(options.image, FLASH_BYTES), readPins(options.pins));
    const endCycle = expected[expected.length - 1].cycle + RUN_ON_CYCLES;

    const start = process.hrtime.bigint();
    play(board, clock, serial.received, CAPTURE_CYCLES, endCycle);
    const seconds = Number(process.hrtime.bigint() - start) / 1e9;

    const { problems, summary } = compare(expected, board.edges, {
        minSteps: Number(options['min-steps']),
        toleranceCycles: TOLERANCE_CYCLES,
    });
    problems.forEach((problem) => console.log(`crosscheck: ${problem}`));
    console.log(`crosscheck: avr8js against pixstep-sim: ${summary}`);
    console.log(
        `crosscheck: ${sameReplies(board.sent, serial.sent)} of ${serial.sent.length} reply ` +
            `bytes the same; ${endCycle} cycles in ${seconds.toFixed(1)} s`,
    );
    return problems.length ? 1 : 0;
}

try {
    process.exitCode = main();
} catch (error) {
    console.error(`crosscheck: ${error.message}`);
    process.exitCode = 2;
}
