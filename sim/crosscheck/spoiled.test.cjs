// SPDX-License-Identifier: MIT
// The cross-check can fail: a recorded run agrees with avr8js's, and no longer when it is spoiled.
//
// PIXSTEP_CROSSCHECK_RUN: a run that crosscheck.cjs has been through, its --edges in avr8js.csv;
// PIXSTEP_UNO_IMAGE: the image that made it.
'use strict';

const assert = require('node:assert');
const path = require('node:path');
const { test } = require('node:test');

const { Board } = require('./board.cjs');
const { compareBytes, compareEdges } = require('./compare.cjs');
const { readFlash } = require('./elf.cjs');
const { uno } = require('./parts.cjs');
const { readEdges, readRun } = require('./records.cjs');

const folder = process.env.PIXSTEP_CROSSCHECK_RUN;
const run = readRun(folder);
const until = ({ cycle }) => cycle <= run.end;
const expected = run.edges.filter(until);
const actual = readEdges(path.join(folder, 'avr8js.csv')).filter(until);

// Names of the signals that differ.
function differing(edges) {
    return compareEdges(edges, actual)
        .filter(({ problem }) => problem !== null)
        .map(({ name }) => name);
}

// The index of an edge amid the run.
function amid(signal, level) {
    const found = expected
        .map((edge, index) => ({ ...edge, index }))
        .filter((edge) => edge.signal === signal && edge.level === level);
    assert.ok(found.length > 0);
    return found[Math.floor(found.length / 2)].index;
}

const later = (edge) => ({ ...edge, cycle: edge.cycle + 1 });

test('as recorded it agrees', () => {
    assert.ok(expected.length > 1000);
    assert.deepStrictEqual(differing(expected), []);
});

for (const [signal, level] of [['STEP', 1], ['STEP', 0], ['DIR', 1], ['PERMIT', 1]]) {
    const name = signal === 'PERMIT' ? signal : `${signal} 0`;
    const what = `${level ? 'rise' : 'fall'} of ${signal}`;

    test(`a ${what} shifted by a cycle`, () => {
        const at = amid(signal, level);
        const spoiled = expected.map((edge, index) => (index === at ? later(edge) : edge));
        assert.deepStrictEqual(differing(spoiled), [name]);
    });

    test(`a ${what} left out`, () => {
        const at = amid(signal, level);
        assert.deepStrictEqual(differing(expected.filter((_, index) => index !== at)), [name]);
    });

    test(`a ${what} doubled`, () => {
        const at = amid(signal, level);
        const spoiled = [...expected.slice(0, at), expected[at], ...expected.slice(at)];
        assert.deepStrictEqual(differing(spoiled), [name]);
    });
}

test('all edges shifted by a cycle', () => {
    assert.ok(differing(expected.map(later)).includes('STEP 0'));
});

test('the last edge left out', () => {
    const last = expected.map(({ signal }) => signal).lastIndexOf('STEP');
    assert.deepStrictEqual(differing(expected.filter((_, at) => at !== last)), ['STEP 0']);
});

test('a byte shifted by a cycle', () => {
    const bytes = run.serial.sent;
    assert.strictEqual(compareBytes('sent', bytes, bytes).problem, null);
    assert.notStrictEqual(compareBytes('sent', bytes, bytes.map(later)).problem, null);
});

// avr8js hears the wires: it is not told what the recorded board made of them.
test('the pixel clock a cycle later in avr8js', () => {
    const pins = run.wires.pins.map((edge) => (edge.wire === 'B0' ? later(edge) : edge));
    const outputs = [{ signal: 'STEP', axis: 0, port: 'B', bit: 2 }];
    const flash = readFlash(process.env.PIXSTEP_UNO_IMAGE, uno.flashBytes);
    const board = new Board(uno, flash, outputs, { ...run.wires, pins });
    const steps = expected.filter(({ signal }) => signal === 'STEP');
    const end = steps[100].cycle + 2;
    board.runTo(end);
    const before = ({ cycle }) => cycle < end - 1;
    const [row] = compareEdges(steps.filter(before), board.edges.filter(before));
    assert.notStrictEqual(row.problem, null);
    assert.strictEqual(row.farthest, 1);
});
