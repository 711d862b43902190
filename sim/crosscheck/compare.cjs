// SPDX-License-Identifier: MIT
// Two lists of edges of the same run: the same STEP edges, and DIR and ENABLE at the same steps?
'use strict';

// Share of the run at each end over which the difference is averaged to see a drift.
const END_SHARE = 0.1;
const DRIFT_MAX_CYCLES = 0.5;

function rises(edges) {
    return edges.filter((edge) => edge.signal === 'STEP' && edge.level === 1);
}

function mean(values) {
    return values.reduce((sum, value) => sum + value, 0) / values.length;
}

// 'DIR 1 after 250 steps', ... : where the other signals change, counted in steps.
function changes(edges) {
    let steps = 0;
    const found = [];
    for (const { signal, level } of edges) {
        if (signal !== 'STEP') {
            found.push(`${signal} ${level} after ${steps} steps`);
        } else if (level === 1) {
            steps++;
        }
    }
    return found;
}

// { problems: [text], summary: text }
function compare(expected, actual, { minSteps, toleranceCycles }) {
    const problems = [];
    const want = rises(expected);
    const got = rises(actual);
    if (want.length < minSteps) {
        problems.push(`the recorded run has ${want.length} steps, not ${minSteps} or more`);
    }
    if (got.length !== want.length) {
        problems.push(`${got.length} STEP edges instead of ${want.length}`);
    }
    const count = Math.min(want.length, got.length);
    const differences = Array.from({ length: count }, (_, at) => got[at].cycle - want[at].cycle);
    const worst = differences.findIndex((cycles) => Math.abs(cycles) > toleranceCycles);
    if (worst >= 0) {
        problems.push(
            `step ${worst + 1}: ${differences[worst]} cycles apart ` +
                `(cycle ${got[worst].cycle} instead of ${want[worst].cycle})`,
        );
    }
    const end = Math.max(1, Math.floor(count * END_SHARE));
    const drift = count ? mean(differences.slice(-end)) - mean(differences.slice(0, end)) : 0;
    if (Math.abs(drift) > DRIFT_MAX_CYCLES) {
        problems.push(`the edges drift by ${drift.toFixed(2)} cycles over the run`);
    }
    const [wantChanges, gotChanges] = [changes(expected), changes(actual)];
    if (wantChanges.join() !== gotChanges.join()) {
        problems.push(`DIR/ENABLE: ${gotChanges.join(', ')} instead of ${wantChanges.join(', ')}`);
    }
    const farthest = differences.reduce((most, cycles) => Math.max(most, Math.abs(cycles)), 0);
    const summary =
        `${count} STEP edges, at most ${farthest} cycles apart, ` +
        `drift ${drift.toFixed(2)} cycles, ${gotChanges.length} changes of DIR and ENABLE`;
    return { problems, summary };
}

module.exports = { compare };
