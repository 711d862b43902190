# SPDX-License-Identifier: MIT
"""The real images in the simulator: every edge and every position of whole lines."""

import json
from fractions import Fraction

import pytest

from clock import TICK_HZ
from effort import cases
from pixstep import ops
from pixstep.board import boards
from pixstep.lines import core
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import read_edges
from pixstep_trials.cases import rate_case
from worked import EXPECTED, worked_line

pytestmark = pytest.mark.usefixtures("simulator")
HZ = Fraction(30)
BOARDS = boards.BOARD_NAMES
AXES = {board.name: board.axes for board in boards.all_boards()}


def passed(judged):
    assert judged.summary["reasons"] == []
    assert judged.passed
    return judged


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("backlash", sorted(EXPECTED))
def test_worked_example(tmp_path, board, backlash):
    line = worked_line(backlash, pixels=34)
    judged = passed(simulate(LineExperiment(board, {0: line}, HZ), tmp_path))
    assert [row.expected_steps for row in judged.pixels[:17]] == EXPECTED[backlash]
    assert judged.summary["axes"][0]["last_steps_off_edge"] == 0


@pytest.mark.parametrize("board", BOARDS)
def test_serial_load_changes_no_edge(tmp_path, board):
    line = worked_line(250, pixels=34)
    passed(simulate(LineExperiment(board, {0: line}, HZ), tmp_path / "quiet"))
    judged = passed(
        simulate(LineExperiment(board, {0: line}, HZ, serial_load=True), tmp_path / "loaded")
    )
    assert judged.summary["requests"]["load"] > 50
    quiet = (tmp_path / "quiet" / "edges.csv").read_bytes()
    assert (tmp_path / "loaded" / "edges.csv").read_bytes() == quiet


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("rate", [10_000, 20_000, 30_000])
def test_constant_rate_is_exact(tmp_path, board, rate):
    steps = cases(14_400, 60_000)
    tested = rate_case(rate, steps, tick_hz=boards.load(board).tick_hz)
    judged = passed(simulate(LineExperiment(board, {0: tested.line}, tested.pixel_hz), tmp_path))
    (axis,) = judged.summary["axes"]
    assert axis["steps"] == steps
    assert axis["rate_error_ppm"] == 0
    assert axis["max_interval_error_ticks"] <= 0.67


@pytest.mark.parametrize("serial_load", [False, True])
def test_four_axes_run_four_lines_at_once(tmp_path, serial_load):
    smooth = worked_line(250, pixels=34)
    lines = {
        0: smooth,
        1: Line((5, 40, 200, 200, 30, 0, -30, -200, -7, 0, 3, 3), PLAIN),
        2: Line((4, 12, 20, 28, 32, 28, 20, 12, 4), negative=True),
        3: Line((0, 100, 200, 200, 100, 0), backlash=200),
    }
    judged = passed(simulate(LineExperiment("mega", lines, HZ, serial_load=serial_load), tmp_path))
    assert len(judged.axes) == 4


@pytest.mark.parametrize("ppm", [-80.0, 80.0])
def test_clock_error_moves_no_edge(tmp_path, ppm):
    line = worked_line(0, pixels=32)
    passed(simulate(LineExperiment("uno", {0: line}, HZ, pixel_ppm=ppm), tmp_path))


def test_rational_frequency(tmp_path):
    line = worked_line(250, pixels=34)
    passed(simulate(LineExperiment("uno", {0: line}, Fraction(30000, 1001)), tmp_path))


def test_line_longer_than_the_queue_is_streamed(tmp_path):
    counts = [n + 40 * (n % 2) for n in range(60, 260)]
    passed(simulate(LineExperiment("uno", {0: Line(tuple(counts), PLAIN)}, HZ), tmp_path))


# Cycles, response and RETI included: the budgets written at the handlers in firmware/avr/hal. The
# step handler's shortest case, a single period, is its minimum; its commands are its maximum.
# A part with more than 128 KB of flash takes two cycles more: its return address is longer.
STEP_CYCLES = {
    board.name: 43 if board.flash_bytes > 0x20000 else 41 for board in boards.all_boards()
}
BUDGETS = {"OVF": 320, "CAPT": 165, "RX": 126, "UDRE": 115, "TX": 145}
# The pixel clock's capture where its axis is parked, and the coarse clock that it then reads.
PARKED_CAPTURE = 215
CLOCK_BUDGET = {board: 70 if AXES[board] == 1 else 95 for board in BOARDS}
# A serial handler ends by a RET (firmware/avr/hal/uart.c): what it takes behind its RETI counts as
# the time of a handler that it came between.
SERIAL_TAIL = 15


@pytest.mark.parametrize("board", BOARDS)
def test_handlers_keep_their_budgets_and_never_wait_a_whole_interval(tmp_path, board):
    lines = {axis: worked_line(0, pixels=28, speed=256) for axis in range(AXES[board])}
    judged = passed(simulate(LineExperiment(board, lines, HZ, serial_load=True), tmp_path))
    assert judged.summary["handlers"]
    for handler in judged.summary["handlers"]:
        name = handler["name"]
        if name == "TIMER0_OVF":
            assert handler["cycles_max"] <= CLOCK_BUDGET[board] + SERIAL_TAIL, handler
            continue
        kind = name.rpartition("_")[2]
        tail = SERIAL_TAIL if kind in ("OVF", "CAPT") else 0
        budget = BUDGETS[kind]
        if kind == "CAPT" and AXES[board] > 1:
            budget = PARKED_CAPTURE
        assert handler["cycles_max"] <= budget + tail, handler
        if name.endswith("OVF"):
            assert handler["cycles_min"] == STEP_CYCLES[board], handler
            assert handler["latency_max"] < boards.load(board).min_interval_ticks, handler


def test_demo(tmp_path):
    done = ops.demo(out=tmp_path)
    assert done.fine, done.page()
    made = {path.name for path in tmp_path.iterdir()}
    assert made >= {"line.csv", "ticks.csv", "edges.csv", "pixels.csv", "summary.json", "run.vcd"}
    assert len([name for name in made if name.endswith(".png")]) == 3


def test_planned_ticks_are_the_boards_edges(tmp_path):
    line = worked_line(250, pixels=34)
    simulate(LineExperiment("uno", {0: line}, HZ), tmp_path)
    zero = json.loads((tmp_path / "summary.json").read_text())["line_zero_cycle"]
    made = read_edges(tmp_path / "edges.csv").axis(0, 0).rising - zero
    assert made.tolist() == core.plan(line, HZ, tick_hz=TICK_HZ).columns()[:, 1].tolist()
