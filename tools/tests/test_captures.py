# SPDX-License-Identifier: MIT
"""Edges of the pixel clock at every cycle of a step period, placed by the board to the tick.

A line that needs no clock runs on the axis whose timer captures the clock; the clock's edges sweep
the steps' intervals, a cycle further each: captures and step interrupts meet in every order.
"""

from fractions import Fraction

import pytest

from bench import Bench
from effort import cases
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line

pytestmark = pytest.mark.usefixtures("simulator")

# The axis whose timer captures the clock.
CLOCK_AXIS = {board.name: board.axes - 1 for board in boards.all_boards()}
BOARDS = list(CLOCK_AXIS)
PIXEL_TICKS = 160_000
EDGE_TICKS = 96_000  # some time to read where one lay
WRAP = 1 << 32
LOOKS = cases(170, 1000)
# Steps of a pixel: pulse trains of short intervals and of long ones, of two lengths too, and single
# periods, of more than 2^8 ticks each and of more than 2^15; none, which is an axis at rest.
STEPS = (800, 400, 399, 100, 20, 4, 0)


def look(bench):
    """Return the number of the newest edge and its place."""
    found = bench.board.inputs_from("clock_edge", "clock_edge_ticks")
    return found["clock_edge"], found["clock_edge_ticks"]


@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize("board", BOARDS)
def test_every_edge_has_its_tick(board, steps):
    axis = CLOCK_AXIS[board]
    tick_hz = boards.load(board).tick_hz
    with Bench(board, [axis], hz=Fraction(tick_hz, PIXEL_TICKS)) as bench:
        interval = PIXEL_TICKS // steps if steps else 4096
        period = EDGE_TICKS // interval * interval + 1
        bench.sim.command(f"clock hz {tick_hz}/{period}")
        if steps:
            bench.load(Line((steps,) * 2000, PLAIN, clocked=False), axis)
            bench.arm()
            bench.run_until_steps(3 * steps, axis)
        bench.sim.wait_s(0.1)
        first, zero = look(bench)
        for _ in range(LOOKS):
            number, ticks = look(bench)
            assert (ticks - zero) % WRAP == (number - first) % 0x10000 * period
        assert bench.fault() == "none"
        assert number != first
