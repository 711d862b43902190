// SPDX-License-Identifier: MIT
// Two lists of what happened in the same run: edges of every output, rising and falling, one by
// one.
'use strict';

// STEP is made by a timer, out of intervals that the program has loaded in time: nothing that the
// program does may move it.
const HARDWARE_CYCLES = 0;
// The other outputs, and bytes, are written by instructions. Both simulators count every cycle of
// every instruction and see the same wires in the same cycles, so these agree too.
const SOFTWARE_CYCLES = 0;

const isHardware = (name) => name.startsWith('STEP');
const toleranceOf = (name) => (isHardware(name) ? HARDWARE_CYCLES : SOFTWARE_CYCLES);

// { 'STEP 0': [{ cycle, level }], 'DIR 0': ..., 'PERMIT': ... }
function bySignal(edges) {
    const lists = {};
    for (const { signal, axis, cycle, level } of edges) {
        const name = signal === 'PERMIT' ? signal : `${signal} ${axis}`;
        (lists[name] ??= []).push({ cycle, level });
    }
    return lists;
}

const kind = (edge) => (edge.level ? 'rise' : 'fall');

// { count, farthest, problem }: problem is null where all agree.
function compareList(want, got, tolerance) {
    const count = Math.min(want.length, got.length);
    let farthest = 0;
    let problem = null;
    for (let at = 0; at < count; at++) {
        const apart = Math.abs(got[at].cycle - want[at].cycle);
        farthest = Math.max(farthest, apart);
        if (problem === null && (got[at].level !== want[at].level || apart > tolerance)) {
            problem =
                `edge ${at + 1}: a ${kind(got[at])} at cycle ${got[at].cycle} ` +
                `instead of a ${kind(want[at])} at cycle ${want[at].cycle}`;
        }
    }
    if (problem === null && want.length !== got.length) {
        problem = `${got.length} edges instead of ${want.length}`;
    }
    return { count, farthest, problem };
}

// Rows { name, count, farthest, problem }, one for every signal that either list has.
function compareEdges(expected, actual) {
    const [want, got] = [bySignal(expected), bySignal(actual)];
    const names = [...new Set([...Object.keys(want), ...Object.keys(got)])].sort();
    return names.map((name) => ({
        name,
        ...compareList(want[name] ?? [], got[name] ?? [], toleranceOf(name)),
    }));
}

// The same for bytes on the serial line.
function compareBytes(name, want, got) {
    const edges = (bytes) => bytes.map(({ cycle, byte }) => ({ cycle, level: byte }));
    return { name, ...compareList(edges(want), edges(got), SOFTWARE_CYCLES) };
}

module.exports = { compareBytes, compareEdges, isHardware };
