// SPDX-License-Identifier: MIT
// A board's image in avr8js, on the wires of a run that pixstep-sim recorded (record.py): are its
// edges the same, to the cycle? A test of the simulator, not of the firmware.
//
//     node crosscheck.cjs --part uno|mega --image IMAGE.elf --pins BOARD.def --run DIR
//                         [--least STEPS] [--edges FILE] [--prescaler recorded|part]
//
// --least: so many rising STEP edges, or the run is no test. --edges: write avr8js's edges there.
// --prescaler part: of timers 0 and 2 at the part's phase instead of pixstep-sim's (timer.cjs). The
// main program then is elsewhere in its loop, and what it writes comes some hundred cycles earlier
// or later: only STEP is judged.
'use strict';

const fs = require('fs');

const { Board } = require('./board.cjs');
const { compareBytes, compareEdges, isHardware } = require('./compare.cjs');
const { readFlash } = require('./elf.cjs');
const parts = require('./parts.cjs');
const { readRun } = require('./records.cjs');
const { PRESCALER } = require('./timer.cjs');

const WATCHED = new Set(['STEP', 'DIR', 'ENABLE', 'PERMIT']);

// Output pins from the board's own table.
function readPins(file) {
    const row = /^BOARD_PIN\((\w+), (\d), ([A-Z]), (\d), "[^"]*"\)/gm;
    return [...fs.readFileSync(file, 'utf8').matchAll(row)]
        .map(([, signal, axis, port, bit]) => ({
            signal,
            axis: Number(axis),
            port,
            bit: Number(bit),
        }))
        .filter(({ signal }) => WATCHED.has(signal));
}

function readArguments(words) {
    const options = { least: '1', prescaler: PRESCALER.RECORDED };
    for (let at = 0; at < words.length; at += 2) {
        options[words[at].replace(/^--/, '')] = words[at + 1];
    }
    for (const name of ['part', 'image', 'pins', 'run']) {
        if (!options[name]) {
            throw new Error(`--${name} is missing`);
        }
    }
    if (!parts[options.part]) {
        throw new Error(`--part ${options.part}: one of ${Object.keys(parts).join(', ')}`);
    }
    if (!Object.values(PRESCALER).includes(options.prescaler)) {
        throw new Error(`--prescaler ${options.prescaler}: recorded or part`);
    }
    return options;
}

function writeEdges(file, edges) {
    const rows = edges.map((edge) => `${edge.cycle},0,${edge.axis},${edge.signal},${edge.level}\n`);
    fs.writeFileSync(file, `cycle,board,axis,signal,level\n${rows.join('')}`);
}

function print({ name, count, farthest, problem }) {
    const what = name.startsWith('bytes') ? 'bytes' : 'edges';
    console.log(`crosscheck: ${name}: ${count} ${what}, at most ${farthest} cycles apart`);
    if (problem !== null) {
        console.log(`crosscheck: ${name}: ${problem}`);
    }
}

function main() {
    const options = readArguments(process.argv.slice(2));
    const part = parts[options.part];
    const run = readRun(options.run);
    const steps = run.edges.filter((edge) => edge.signal === 'STEP' && edge.level === 1).length;
    const board = new Board(
        part,
        readFlash(options.image, part.flashBytes),
        readPins(options.pins),
        run.wires,
        options.prescaler,
    );
    const start = process.hrtime.bigint();
    board.runTo(run.end);
    const seconds = Number(process.hrtime.bigint() - start) / 1e9;
    const until = ({ cycle }) => cycle <= run.end;
    const rows = [
        ...compareEdges(run.edges.filter(until), board.edges.filter(until)),
        compareBytes(
            'bytes received',
            run.serial.received.filter(until),
            board.usart.receiver.heard.filter(until),
        ),
        compareBytes('bytes sent', run.serial.sent.filter(until), board.usart.sent.filter(until)),
    ];
    rows.forEach(print);
    if (options.edges) {
        writeEdges(options.edges, board.edges);
    }
    console.log(`crosscheck: ${run.end} cycles in ${seconds.toFixed(1)} s`);
    if (steps < Number(options.least)) {
        console.log(`crosscheck: the run has ${steps} steps, not ${options.least} or more`);
        return 1;
    }
    const judged = ({ name }) => options.prescaler === PRESCALER.RECORDED || isHardware(name);
    return rows.some((row) => judged(row) && row.problem !== null) ? 1 : 0;
}

try {
    process.exitCode = main();
} catch (error) {
    console.error(`crosscheck: ${error.message}`);
    process.exitCode = 2;
}
