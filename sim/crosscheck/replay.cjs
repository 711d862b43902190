// SPDX-License-Identifier: MIT
// The inputs of a recorded run, cycle by cycle, and the run's edges.
'use strict';

const fs = require('fs');

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

// Rising edges of the pixel clock's source.
function readClock(file) {
    return readCsv(file, ['cycle']).map((row) => Number(row.cycle));
}

// Bytes on the serial line: { cycle, byte } as the board received them, and what it sent.
// The cycle of a received byte is that at which the receiver has it, in the middle of its stop bit.
function readSerial(file) {
    const rows = readCsv(file, ['cycle', 'direction', 'byte']);
    const bytes = rows.map((row) => ({
        cycle: Number(row.cycle),
        direction: row.direction,
        byte: parseInt(row.byte, 16),
    }));
    return {
        received: bytes.filter((row) => row.direction === 'rx'),
        sent: bytes.filter((row) => row.direction === 'tx').map((row) => row.byte),
    };
}

// Edges of axis 0 of board 0.
function readEdges(file) {
    return readCsv(file, ['cycle', 'board', 'axis', 'signal', 'level'])
        .filter((row) => row.board === '0' && row.axis === '0')
        .map((row) => ({
            cycle: Number(row.cycle),
            signal: row.signal,
            level: Number(row.level),
        }));
}

// Feeds clock edges and serial bytes to a board at their cycles, up to endCycle.
// captureCycles: an edge is due that long after it reached the pin.
function play(board, clock, received, captureCycles, endCycle) {
    const events = [
        ...clock.map((cycle) => ({ due: cycle + captureCycles, run: () => board.capture(cycle) })),
        ...received.map(({ cycle, byte }) => ({ due: cycle, run: () => board.receive(byte) })),
    ];
    events.sort((one, other) => one.due - other.due);
    for (const { due, run } of events) {
        if (due > endCycle) {
            break;
        }
        board.runTo(due);
        run();
    }
    board.runTo(endCycle);
}

module.exports = { readClock, readSerial, readEdges, play };
