# SPDX-License-Identifier: MIT
"""Every fault of motion, provoked on the real image: what it says, and that nothing moves on."""

from fractions import Fraction

import pytest

from faultbench import FaultBench
from pixstep import natives
from pixstep.board import boards
from pixstep.board.upload import LineUpload
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, Line
from pixstep_trials import lines

STARTING = 8  # enum axis_state

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = boards.BOARD_NAMES
LONG = Line((40,) * 60, PLAIN)
HZ = Fraction(100)
STARTING = 8  # enum axis_state
START, SEEK, OPEN, DOWN, END = 0x01, 0x80, 0x100, (3, 0), (2, 0)


def seek(bench, axis, count, pixels, flags=0):
    """Queue a seek of constant speed."""
    upload = LineUpload(
        bench.board, axis, [(START | SEEK | flags, 0), (0, 0), (count, pixels), DOWN, END]
    )
    upload.push()
    assert upload.done


@pytest.mark.provokes("starved")
@pytest.mark.parametrize("board", BOARDS)
def test_starved(board):
    """The queue is filled, but the line's end never comes."""
    with FaultBench(board, hz=200) as bench:
        pixels = bench.board.room()[0] * 3 // 4 + 1
        line = Line(tuple(20 + n % 2 for n in range(pixels)), PLAIN)
        upload = LineUpload(bench.board, 0, runs.queue_entries(line)[:-1])
        upload.push()
        assert upload.done and bench.state() == "loaded"
        bench.arm()
        bench.sim.wait_s(0.9 * pixels / 200)
        assert not bench.latched()
        bench.run_into_fault()
        bench.assert_fault("starved", pixel=pixels)
        # Only the step on the last edge has nothing behind it that could carry it.
        assert bench.count() == line.total_steps - 1


@pytest.mark.provokes("decoder_late")
@pytest.mark.parametrize(
    ("board", "rate", "axes"),
    [("uno", 120_000, range(1)), ("mega", 45_000, range(4)), ("m1284", 90_000, range(2))],
)
def test_decoder_late(board, rate, axes):
    """Every pixel accelerates or brakes, at a rate that the board cannot decode."""
    top = rate // 30
    ramp = list(range(0, top, top // 10 * 2))
    line = lines.smooth([*ramp, *lines.wobble(top - 40, top, 12), *reversed(ramp)])
    with FaultBench(board, axes, 30) as bench:
        for axis in bench.axes:
            bench.load(line, axis)
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault(
            "decoder_late", bench.peek("fault.axis"), pixel=range(1, line.pixels + 1)
        )
        assert 0 < bench.count() < line.total_steps


# The clock's edges come with the last steps before the ring runs dry, and are looked at late.
@pytest.mark.provokes("decoder_late")
@pytest.mark.parametrize(
    ("hz", "count"), [(2100, 120), (2050, 118), (1250, 120), (2100, 100), (3000, 60), (5000, 40)]
)
def test_decoder_late_beside_an_edge_of_the_clock(hz, count):
    with FaultBench("uno", range(1), hz) as bench:
        bench.load(Line((count,) * 200, PLAIN))
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault("decoder_late", 0, pixel=range(1, 200))


@pytest.mark.provokes("underrun")
@pytest.mark.parametrize(
    ("board", "axis", "ticks"), [("uno", 0, 48), ("mega", 1, 48.5), ("m1284", 1, 46.5)]
)
def test_underrun(board, axis, ticks):
    """The check of lines is told longer pixels, and lets pass what the step interrupt cannot do.

    With several axes only intervals that differ: equal ones may come late.
    """
    with FaultBench(board, (axis,), HZ) as bench:
        bench.poke("limits.pixel_ticks", 2 * bench.pixel_ticks)
        bench.load(Line((int(bench.pixel_ticks / ticks),) * 20, PLAIN), axis)
        bench.arm()
        bench.run_into_fault()
        # So far below its shortest interval the mega may miss a whole period: home again.
        known = board == "uno"
        bench.assert_fault("underrun", axis, pixel=range(1, 21), argument=1, known=known)
        assert bench.board.axis(axis)["underruns"] == 1


@pytest.mark.provokes("pixel_clock_missing")
@pytest.mark.parametrize("board", BOARDS)
def test_pixel_clock_missing(board):
    with FaultBench(board) as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(400)
        pixel = bench.board.axis(0)["pixel"] + 1
        bench.sim.command("clock off")
        bench.run_into_fault()
        bench.assert_fault("pixel_clock_missing", pixel=range(pixel, pixel + 4))


@pytest.mark.provokes("start_late")
@pytest.mark.parametrize("board", BOARDS)
def test_start_late(board):
    """The main loop is held up from before a line's release until after its zero."""
    with FaultBench(board, hz=30) as bench:
        bench.load(LONG)
        bench.arm()
        bench.until_true(lambda: bench.peek("axes[0].life.state") == STARTING)
        bench.sim.wait_s(0.024)  # of the 33 between the clock's edge and line zero
        with bench.main_loop_held():
            bench.sim.wait_s(0.010)
        bench.run_into_fault()
        bench.assert_fault("start_late", pixel=1)
        assert bench.count() == 0


@pytest.mark.provokes("internal")
@pytest.mark.parametrize("board", BOARDS)
def test_internal(board):
    """A line is to be released whose front is not held."""
    with FaultBench(board, hz=30) as bench:
        bench.load(LONG)
        bench.arm()
        bench.until_true(lambda: bench.peek("axes[0].life.state") == STARTING)
        bench.poke("axes[0].feed.held", 0)
        bench.run_into_fault()
        bench.assert_fault("internal", pixel=1, argument=promise("stream/feed.c", "feed->held"))
        assert bench.count() == 0


def promise(name, condition):
    """Return the line of a promise in the motion core."""
    text = natives.source(f"firmware/core/{name}").read_text()
    (line,) = [n for n, row in enumerate(text.split("\n"), 1) if f"REQUIRE({condition}" in row]
    return line


@pytest.mark.provokes("clock_edge_lost")
@pytest.mark.parametrize("board", BOARDS)
def test_clock_edge_lost(board):
    """More pulses on the clock's wire than wait for the main loop."""
    (pin,) = [one for one in boards.load(board).pins if one.signal == "PIXEL_CLOCK"]
    with FaultBench(board) as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(400)
        pixel = bench.board.axis(0)["pixel"] + 1
        with bench.main_loop_held():
            for level in (0, 1) * 12:
                bench.sim.command(f"pin 0 {pin.port} {pin.bit} {level}")
                bench.sim.run(500)
        bench.run_into_fault(bench.pixel_ticks)
        bench.assert_fault("clock_edge_lost", pixel=range(pixel, pixel + 2), argument=range(1, 12))


def clock_argument(interval_ticks):
    """The fault's argument for an interval, give or take a little."""
    return range(int(interval_ticks) // 256 - 1, int(interval_ticks) // 256 + 3)


class LockedFaultBench(FaultBench):
    """A board whose lines are locked to the clock, which has settled."""

    def __enter__(self):
        super().__enter__()
        self.board.write_setting("sync", 2)
        self.until_true(lambda: self.board.input("status") & 0x80, look=100_000)
        self.load(LONG)
        self.arm()
        self.run_until_steps(400)
        return self


@pytest.mark.provokes("clock_hold_over")
@pytest.mark.parametrize("board", BOARDS)
def test_clock_hold_over(board):
    """The clock of a locked line stops."""
    with LockedFaultBench(board) as bench:
        bench.sim.command("clock off")
        begin = bench.sim.cycle
        bench.run_into_fault(10 * bench.pixel_ticks)
        assert 4.4 < (bench.sim.cycle - begin) / bench.pixel_ticks < 5.7
        pixel = bench.count() // LONG.counts[0] + 1
        bench.assert_fault("clock_hold_over", pixel=range(pixel - 1, pixel + 2), argument=4)


@pytest.mark.provokes("clock_drifted")
@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("ppm", [-15_000, 15_000])
def test_clock_drifted(board, ppm):
    """The clock of a locked line leaves the tolerance of 10,000 ppm."""
    with LockedFaultBench(board) as bench:
        bench.sim.command(f"clock ppm {ppm}")
        bench.run_into_fault(40 * bench.pixel_ticks)
        pixel = bench.count() // LONG.counts[0] + 1
        argument = clock_argument(bench.pixel_ticks / (1 + ppm / 1e6))
        bench.assert_fault(
            "clock_drifted",
            pixel=range(pixel - 1, pixel + 2),
            argument=range(argument[0] - 4, argument[-1] + 4),
        )


@pytest.mark.provokes("pixel_clock_off")
@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("ppm", [-90_000, 90_000])
def test_pixel_clock_off_while_running(board, ppm):
    """The clock's frequency is not the one that was set."""
    with FaultBench(board) as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(400)
        pixel = bench.count() // LONG.counts[0] + 1
        bench.sim.command(f"clock ppm {ppm}")
        bench.run_into_fault(4 * bench.pixel_ticks)
        argument = clock_argument(bench.pixel_ticks / (1 + ppm / 1e6))
        bench.assert_fault("pixel_clock_off", pixel=range(pixel, pixel + 4), argument=argument)


@pytest.mark.provokes("pixel_clock_off")
@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("set_hz", [50, 75, 90, 110, 140])
def test_pixel_clock_off_while_armed(board, set_hz):
    """The board takes a clock of 100 Hz for another one: the line never begins."""
    with FaultBench(board) as bench:
        bench.board.set_pixel_hz(Fraction(set_hz))
        bench.sim.run(4 * bench.pixel_ticks)
        bench.load(LONG)
        bench.arm()
        bench.run_into_fault(4 * bench.pixel_ticks)
        argument = clock_argument(bench.pixel_ticks)
        bench.assert_fault("pixel_clock_off", pixel=1, argument=argument)
        assert bench.count() == 0


@pytest.mark.provokes("pixel_clock_off")
@pytest.mark.parametrize("board", BOARDS)
def test_a_false_clock_edge_while_armed(board):
    """A glitch half a pixel from the clock's own edges: no line begins there."""
    (pin,) = [one for one in boards.load(board).pins if one.signal == "PIXEL_CLOCK"]
    with FaultBench(board, hz=10) as bench:
        bench.load(LONG)
        edges = bench.board.input("pixel_edges")
        bench.until(lambda: bench.board.input("pixel_edges") > edges)
        bench.arm()
        bench.sim.wait_s(0.05)
        for level in (0, 1):
            bench.sim.pin(0, pin.port, pin.bit, level)
            bench.sim.run(500)
        bench.run_into_fault(bench.sim.tick_hz // 5)
        assert bench.count() == 0
        # In 256 ticks: shorter than a period by a quarter and more.
        short = range(1, bench.pixel_ticks * 3 // 4 // 256)
        bench.assert_fault("pixel_clock_off", pixel=1, argument=short)


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("ppm", [-50_000, 50_000])
def test_a_clock_five_percent_off_runs(board, ppm):
    with FaultBench(board) as bench:
        bench.sim.command(f"clock ppm {ppm}")
        bench.sim.run(4 * bench.pixel_ticks)
        bench.load(Line((7,) * 10, PLAIN))
        bench.arm()
        bench.until(lambda: bench.state() == "done")
        assert bench.fault() == "none"
        assert bench.count() == 70


@pytest.mark.provokes("limit_plus")
@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 2), ("m1284", 1)])
def test_limit_plus(board, axis):
    with FaultBench(board, (axis,), plants={(0, axis): "travel=-500..500"}) as bench:
        bench.load(LONG, axis)
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault("limit_plus", axis, pixel=range(12, 15))


@pytest.mark.provokes("limit_minus")
@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 2), ("m1284", 1)])
def test_limit_minus(board, axis):
    with FaultBench(board, (axis,), plants={(0, axis): "travel=-500..500"}) as bench:
        bench.load(Line((-40,) * 60, PLAIN), axis)
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault("limit_minus", axis, pixel=range(12, 15))


@pytest.mark.provokes("home_not_found")
@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 1), ("m1284", 1)])
def test_home_not_found(board, axis):
    with FaultBench(board, (axis,), plants={(0, axis): "home=9000"}) as bench:
        seek(bench, axis, 40, 30)
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault("home_not_found", axis, pixel=31)
        assert bench.count(axis) == 1200


@pytest.mark.provokes("home_stuck")
@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 1), ("m1284", 1)])
def test_home_stuck(board, axis):
    with FaultBench(board, (axis,), plants={(0, axis): "home=9000,stuck=home:closed"}) as bench:
        bench.sim.run(100_000)
        seek(bench, axis, 40, 30, OPEN)
        bench.arm()
        bench.run_into_fault()
        bench.assert_fault("home_stuck", axis, pixel=31)
        assert bench.count(axis) == 1200
