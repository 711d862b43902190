# SPDX-License-Identifier: MIT
"""The firmware's check of time on the images: how well it knows when the timers started."""

import pytest

from bench import Bench
from pixstep.board import boards
from pixstep_trials.probe import BoardProbe

SEVERAL_AXES = [board.name for board in boards.all_boards() if board.axes > 1]
IDLE_TICKS = 4096
CAPTURE_DELAY = 3
COUNT_TICKS = 64  # of timer 0, the coarse clock
TCNT0 = 0x46
QUEUE_HEAD, ENTRY_BYTES, ENTRIES = 0, 7, 8  # avr/hal/capture_queue.h: the entries come last
# The instruction that a count of timer 0 ends in, and the cycles between the firmware's two looks.
BETWEEN_LOOKS = (0, 20)

pytestmark = pytest.mark.usefixtures("simulator")


def number(data):
    return int.from_bytes(data, "little")


def captured_edge(bench):
    """Return the cycle of an edge of the pixel clock, and the count of the clock's timer there."""
    (pin,) = (pin for pin in boards.load(bench.name).pins if pin.signal == "PIXEL_CLOCK")
    bench.sim.command("clock off")
    bench.sim.wait_s(0.1)
    cycle = bench.sim.cycle + 1000
    bench.sim.pin(0, pin.port, pin.bit, 1, cycle)
    bench.sim.run(1400)
    queue = BoardProbe(bench.sim).peek(0, "pixel_clock_edges")
    first = len(queue) - ENTRY_BYTES * ENTRIES
    place = first + ENTRY_BYTES * ((queue[QUEUE_HEAD] - 1) % ENTRIES)
    return cycle + CAPTURE_DELAY, number(queue[place : place + 2])


def coarse_ticks_now(bench):
    """Return the coarse clock, right behind a count."""
    before = BoardProbe(bench.sim).peek(0, TCNT0, 1)
    while BoardProbe(bench.sim).peek(0, TCNT0, 1) == before:
        bench.sim.run(1)
    overflows = number(BoardProbe(bench.sim).peek(0, "clock_overflows"))
    return (256 * overflows + BoardProbe(bench.sim).peek(0, TCNT0, 1)[0]) * COUNT_TICKS


# A start that is taken for earlier than it was is an underrun that never happened.
@pytest.mark.parametrize("board", SEVERAL_AXES)
def test_the_start_of_the_timers_is_known_to_a_few_ticks(board):
    with Bench(board) as bench:
        cycle, count = captured_edge(bench)
        now = coarse_ticks_now(bench)
        started = now - (bench.sim.cycle - cycle) - count
        late = (number(BoardProbe(bench.sim).peek(0, "started_ticks")) - started) % IDLE_TICKS
        assert BETWEEN_LOOKS[0] <= late <= BETWEEN_LOOKS[1]
