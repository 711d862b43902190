// SPDX-License-Identifier: MIT
// What pixstep-sim recorded of a run: the wires into the board, the edges out of it, its bytes.
'use strict';

const fs = require('fs');
const path = require('path');

// Rows of a CSV file as objects, by its header; `wanted` are the columns that must be there.
function readCsv(file, wanted) {
    const [header, ...lines] = fs.readFileSync(file, 'utf8').trimEnd().split('\n');
    const columns = header.split(',');
    for (const column of wanted) {
        if (!columns.includes(column)) {
            throw new Error(`${file}:1: no column '${column}'`);
        }
    }
    return lines.map((line, index) => {
        const fields = line.split(',');
        if (fields.length !== columns.length) {
            throw new Error(`${file}:${index + 2}: ${fields.length} fields, not ${columns.length}`);
        }
        return Object.fromEntries(columns.map((column, at) => [column, fields[at]]));
    });
}

const inOrder = (rows) => rows.sort((one, other) => one.cycle - other.cycle);

// { pins: [{ cycle, wire, level }], frames: [{ cycle, levels, bitCycles }] } (sim/wire_log.h).
function readWires(file) {
    const rows = readCsv(file, ['cycle', 'wire', 'levels', 'bit_cycles_x1000']);
    const serial = rows.filter((row) => row.wire === 'RXD');
    return {
        pins: inOrder(
            rows
                .filter((row) => row.wire !== 'RXD')
                .map(({ cycle, wire, levels }) => ({
                    cycle: Number(cycle),
                    wire,
                    level: Number(levels),
                })),
        ),
        frames: inOrder(
            serial.map(({ cycle, levels, bit_cycles_x1000: thousandths }) => ({
                cycle: Number(cycle),
                levels,
                bitCycles: Number(thousandths) / 1000,
            })),
        ),
    };
}

// Bytes that the board received and sent: { cycle, byte }, in order.
function readSerial(file) {
    const rows = readCsv(file, ['cycle', 'direction', 'byte']);
    const of = (direction) =>
        rows
            .filter((row) => row.direction === direction)
            .map(({ cycle, byte }) => ({ cycle: Number(cycle), byte: parseInt(byte, 16) }));
    return { received: of('rx'), sent: of('tx') };
}

// Edges of the first board.
function readEdges(file) {
    return readCsv(file, ['cycle', 'board', 'axis', 'signal', 'level'])
        .filter((row) => row.board === '0')
        .map(({ cycle, axis, signal, level }) => ({
            cycle: Number(cycle),
            axis: Number(axis),
            signal,
            level: Number(level),
        }));
}

// A recorded run; `end` is the cycle that the recording has reached.
function readRun(folder) {
    return {
        edges: readEdges(path.join(folder, 'edges.csv')),
        wires: readWires(path.join(folder, 'wires.csv')),
        serial: readSerial(path.join(folder, 'serial.csv')),
        end: Number(fs.readFileSync(path.join(folder, 'end.txt'), 'utf8')),
    };
}

module.exports = { readEdges, readRun };
