# SPDX-License-Identifier: MIT
"""The verdict itself, on edges made by hand: passes the ideal, finds every seeded defect."""

from fractions import Fraction

import numpy as np
import pytest

from clock import TICK_HZ
from pixstep.errors import UserError
from pixstep.lines import exact
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import edge_tick, period_ticks
from pixstep.simulation import verdict
from pixstep.simulation.logs import AxisEdges, read_edges
from worked import worked_line

PERIOD = period_ticks(Fraction(30), TICK_HZ)
ZERO = 1_234_567
LINE = worked_line(250, pixels=40)
IDEAL = [when.floor() for _, when in exact.exact_instants(LINE, PERIOD)]


def edges_of(ticks, zero=ZERO, width=100, turns=()):
    rising = np.array(ticks, dtype=np.int64) + zero
    cycles = np.stack([rising, rising + width], axis=1).ravel()
    levels = np.tile([1, 0], len(rising))
    turns = np.array(turns, dtype=np.int64).reshape(-1, 2)
    return AxisEdges(cycles, levels, turns[:, 0] + zero, turns[:, 1])


def reasons(ticks, line=LINE, **options):
    return verdict.judge_axis(line, PERIOD, edges_of(ticks, **options), tick_hz=TICK_HZ).reasons


def test_ideal_edges_pass():
    found = verdict.judge_axis(LINE, PERIOD, edges_of(IDEAL), tick_hz=TICK_HZ)
    assert found.passed and found.line_zero_cycle == ZERO
    assert found.max_edge_error_ticks < 1 and found.rms_edge_error_us < 0.0625
    assert abs(found.rate_error_ppm) < 0.001
    assert found.last_steps_off_edge == 0


@pytest.mark.parametrize("at", [0, 17, 4000, len(IDEAL) - 1])
def test_an_edge_moved_by_two_ticks(at):
    ticks = list(IDEAL)
    ticks[at] += 2
    assert any("a tick or more off" in text for text in reasons(ticks))


@pytest.mark.parametrize("at", [0, 4000, len(IDEAL) - 1])
def test_a_missing_edge(at):
    ticks = [*IDEAL[:at], *IDEAL[at + 1 :]]
    assert f"{len(IDEAL) - 1} steps instead of {len(IDEAL)}" in reasons(ticks)


def test_a_doubled_edge():
    ticks = sorted([*IDEAL, IDEAL[4000] + 150])
    assert f"{len(IDEAL) + 1} steps instead of {len(IDEAL)}" in reasons(ticks)


def test_drift_of_one_ppm():
    ticks = [tick + round(tick * 1e-6) for tick in IDEAL]
    found = verdict.judge_axis(LINE, PERIOD, edges_of(ticks), tick_hz=TICK_HZ)
    assert not found.passed and found.rate_error_ppm == pytest.approx(1.0, abs=0.05)


def test_the_last_step_of_a_pixel_one_tick_off_its_edge():
    pixel, done = exact.edge_ends(LINE)[3]
    ticks = list(IDEAL)
    ticks[done - 1] += 1  # still within one tick of the exact instant at this pixel
    assert any(
        f"the last step of 1 pixels is not on the pixel edge, first pixel {pixel}" in text
        for text in reasons(ticks)
    )


def test_a_line_whose_every_step_is_below_the_exact_instant():
    # floor() everywhere: the best constant in the max norm would be another one
    line = Line((1, 1), PLAIN)
    period = Fraction(1000_9, 10)
    ticks = [when.floor() for _, when in exact.exact_instants(line, period)]
    found = verdict.judge_axis(line, period, edges_of(ticks), tick_hz=TICK_HZ)
    assert found.line_zero_cycle == ZERO and found.passed


def test_wrong_direction_and_tight_direction_change():
    line = Line((10, -10), PLAIN)
    ticks = [when.floor() for _, when in exact.exact_instants(line, PERIOD)]
    between = (ticks[9] + ticks[10]) // 2
    assert reasons(ticks, line, turns=[(between, 1)]) == []
    assert any("10 steps in the wrong direction" in text for text in reasons(ticks, line))
    tight = reasons(ticks, line, turns=[(ticks[9] + 319, 1)])
    assert any("too close to a step" in text for text in tight)


def test_a_pulse_without_end():
    edges = edges_of(IDEAL)
    levels = edges.step_levels.copy()
    levels[5] = 1
    broken = AxisEdges(edges.step_cycles, levels, edges.direction_cycles, edges.direction_levels)
    assert any(
        "doubled" in text
        for text in verdict.judge_axis(LINE, PERIOD, broken, tick_hz=TICK_HZ).reasons
    )


def test_no_edges_at_all():
    found = verdict.judge_axis(LINE, PERIOD, edges_of([]), tick_hz=TICK_HZ)
    assert found.reasons == [f"0 steps instead of {len(IDEAL)}"]


def test_clock():
    clock = np.array([ZERO - edge_tick(1, PERIOD) + 4])
    assert verdict.judge_clock(ZERO, PERIOD, clock)[1] == ""
    assert "-5 cycles off" in verdict.judge_clock(ZERO, PERIOD, clock + 1)[1]
    assert "no edges" in verdict.judge_clock(ZERO, PERIOD, np.array([]))[1]


def test_actual_positions_count_steps_on_the_edge():
    ends = np.array([ZERO + edge_tick(pixel, PERIOD) for pixel in range(1, LINE.pixels + 1)])
    actual = verdict.actual_positions(edges_of(IDEAL), ends)
    assert actual.tolist() == exact.expected_positions(LINE)


@pytest.mark.parametrize(
    ("text", "message"),
    [("cycle\n", ":1: the header"), ("cycle,board,axis,signal,level\n1,2,3\n", ":2: '1,2,3'")],
)
def test_malformed_edge_list(tmp_path, text, message):
    path = tmp_path / "edges.csv"
    path.write_text(text)
    with pytest.raises(UserError, match=message):
        read_edges(path)


@pytest.mark.parametrize(
    "row",
    [
        "",
        "1,0,0,STEP,2",
        "-1,0,0,STEP,1",
        "1,0,-2,STEP,1",
        "1,0,0,7,1",
        "1,0,0\nSTEP,1,1,0,0,STEP,1",
        "1E5,0,0,STEP,1",
        "1,0,0,S,1",
        "1,0,0,STEP,",
    ],
)
def test_a_malformed_edge_is_named(tmp_path, row):
    path = tmp_path / "edges.csv"
    path.write_text(f"cycle,board,axis,signal,level\n1,0,3,STEP,1\n2,0,3,DIR,0\n{row}\n")
    with pytest.raises(UserError, match=r":4: '.*' is not an edge"):
        read_edges(path)


def test_edges_without_a_last_line_end_and_without_any(tmp_path):
    path = tmp_path / "edges.csv"
    path.write_text("cycle,board,axis,signal,level\n")
    assert read_edges(path).axes == {}
    path.write_text("cycle,board,axis,signal,level\n5,1,2,STEP,1")
    assert read_edges(path).axis(1, 2).rising.tolist() == [5]
