# SPDX-License-Identifier: MIT
"""Lines locked to the pixel clock, on the images: pixel edges against the clock's true edges."""

import itertools
import random
import statistics
from fractions import Fraction

import pytest

from lockbench import LockBench, gauss
from pixstep.board import boards
from pixstep.board.errors import BoardError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.profiles import generator
from test_bus import OTHER, Master, frame

BOARDS = ("uno", "mega")
PER_PIXEL = 20
JITTER_TICKS = 80  # 5 us


def ppm(hz, offset, tick_hz=16_000_000):
    """Period of a clock that is off by so many parts per million, ticks."""
    return Fraction(tick_hz, hz) * (1 + Fraction(offset) / 1_000_000)


@pytest.fixture
def bench_of(tmp_path):
    """Make benches that record their edges."""
    return lambda board, hz, **more: LockBench(board, hz=hz, edges=tmp_path / "edges.csv", **more)


def run_line(bench, line, axis=0, seconds=20):
    """Run a line on a clock that has settled; return the cycle of each pixel's last step."""
    return run_together(bench, {axis: line}, seconds)[axis]


def run_together(bench, lines, seconds=3):
    """Run a line on each axis; return the cycles of each pixel's last step by axis."""
    bench.settle()
    before = {axis: bench.count(axis) for axis in lines}
    for axis, line in lines.items():
        assert bench.load(line, axis).done
    bench.board.command("arm", list(lines))
    bench.until(
        lambda: all(bench.state(axis) not in ("armed", "running") for axis in lines), seconds
    )
    assert [bench.state(axis) for axis in lines] == ["done"] * len(lines)
    assert bench.fault_name() == "none"
    return {axis: bench.last_steps(line, axis, before[axis]) for axis, line in lines.items()}


def assert_on_edges(bench, counts, pixels):
    """Run a line of one count on each axis: every pixel ends within 2 ticks of the clock's edge."""
    lines = {axis: Line((count,) * pixels, PLAIN) for axis, count in counts.items()}
    ends = run_together(bench, lines)
    assert all(max(map(abs, errors(bench, found))) <= 2 for found in ends.values())


def errors(bench, ends, divider=1):
    """Cycles of pixel edges minus those of the clock's true edges, the first one the nearest."""
    true = [float(edge) for edge in bench.own.true]
    first = min(range(len(true)), key=lambda k: abs(true[k] - ends[0]))
    return [end - true[first + divider * i] for i, end in enumerate(ends) if end is not None]


# Intervals of the clock's axis, the last one, that are as short as the waits of its interrupt.
@pytest.mark.parametrize(
    ("board", "tick_hz", "counts", "offset"),
    [
        ("mega", 16_000_000, {0: 450, 1: 450, 2: 450, 3: 450}, -9000),
        ("mega", 16_000_000, {0: 450, 1: 450, 2: 450, 3: 450}, 300),
        ("mega", 16_000_000, {0: 477, 2: 440, 3: 600}, 0),
        ("m1284", 20_000_000, {0: 964, 1: 740}, 9000),
        ("m1284", 20_000_000, {0: 900, 1: 900}, 300),
        ("uno", 16_000_000, {0: 2510}, -9000),
        ("uno", 16_000_000, {0: 2168}, 700),
        ("uno", 16_000_000, {0: 803}, 20),
    ],
)
def test_fast_axes_follow_the_clock(bench_of, board, tick_hz, counts, offset):
    with bench_of(board, 100, axes=tuple(counts)) as bench:
        bench.follow()
        bench.clock(ppm(100, offset, tick_hz))
        assert_on_edges(bench, counts, 60)


# A false edge so close behind the true one takes the place of the captured count before the
# interrupt has read it.
@pytest.mark.parametrize("behind", [205, 260, 320, 400])
@pytest.mark.parametrize(
    ("board", "tick_hz", "counts"),
    [
        ("mega", 16_000_000, {0: 450, 1: 450, 2: 450, 3: 450}),
        ("m1284", 20_000_000, {0: 964, 1: 740}),
        ("uno", 16_000_000, {0: 2400}),
    ],
)
def test_double_edges_beside_fast_axes_move_no_pixel(bench_of, board, tick_hz, counts, behind):
    with bench_of(board, 100, axes=tuple(counts)) as bench:
        bench.follow()
        bench.clock(
            ppm(100, 300, tick_hz),
            extra=lambda k: [behind] if k > 60 and k % 7 == 0 else [],
        )
        assert_on_edges(bench, counts, 60)
        assert bench.board.input("clock_glitches") >= 5


# The time of the pixel that follows is fixed late: at 100 Hz a period before it begins. A missing
# edge leaves five eighths of that for all axes.
@pytest.mark.parametrize("every", [10, 13])
@pytest.mark.parametrize(
    ("board", "axes", "hz", "count"),
    [("mega", 4, 100, 450), ("mega", 2, 500, 80), ("mega", 1, 100, 1900), ("uno", 1, 100, 2400)],
)
def test_fast_axes_bridge_a_missing_edge(bench_of, board, axes, hz, count, every):
    with bench_of(board, hz, axes=range(axes)) as bench:
        bench.follow()
        bench.clock(ppm(hz, 300), keep=lambda k: k < 60 or k % every)
        assert_on_edges(bench, dict.fromkeys(range(axes), count), 120)


# More steps a pixel than 64, in pixels that are shorter than a reply to the host takes.
@pytest.mark.parametrize(
    ("board", "axes", "hz", "count"),
    [("mega", 4, 400, 80), ("mega", 2, 500, 100), ("mega", 1, 800, 99), ("uno", 1, 1000, 110)],
)
def test_kilohertz_pixels_of_many_steps(bench_of, board, axes, hz, count):
    with bench_of(board, hz, axes=range(axes)) as bench:
        bench.follow()
        bench.clock(ppm(hz, 7))
        assert_on_edges(bench, dict.fromkeys(range(axes), count), 600)


# Of 120 steps a pixel two fit the ring: the room of the one before last is awaited, and must be
# seen as soon as it is free, whatever the steep ends of the other lines take.
def test_a_pixel_that_waits_for_room_gets_it_in_time(bench_of):
    steep = Line((33, 50, 48, 46, 44, 42, 40, 27), SMOOTH)
    with bench_of("mega", 200, axes=(0, 1, 2)) as bench:
        bench.follow()
        bench.clock(ppm(200, 0))
        ends = run_together(bench, {0: steep, 1: steep, 2: Line((120,) * 20, PLAIN)})
        assert max(map(abs, errors(bench, ends[2]))) <= 2


# The clock's axis is parked; bytes without a pause hold its interrupt for longer than one of the
# idle periods by which the edge is placed.
@pytest.mark.parametrize("pause_us", [300, 500])
def test_a_saturated_line_moves_no_edge_of_a_parked_axis(bench_of, pause_us):
    with bench_of("mega", 100, axes=(1,)) as bench:
        bench.follow()
        bench.clock(ppm(100, 300))
        master = Master(bench.sim, "mega")
        master.change(1_000_000, "N")
        bench.settle()
        line, before = Line((800,) * 40, PLAIN), bench.count(1)
        bench.load(line, 1)
        bench.board.command("arm", [1])
        rng = random.Random(1)
        for _ in range(130):
            length = rng.randint(10, 255)
            master.send(frame(OTHER, 4, 250, range(125))[:length], pause_us)
            bench.sim.run(length * 11 * 16 + pause_us * 16)
        bench.sim.wait_s(0.3)
        assert (bench.state(1), bench.fault_name()) == ("done", "none")
        assert max(map(abs, errors(bench, bench.last_steps(line, 1, before)))) <= 2


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize(("hz", "offset"), [(30, 10_000), (30, -10_000), (1000, 300)])
def test_a_clock_that_is_off_is_followed(bench_of, board, hz, offset):
    with bench_of(board, hz) as bench:
        bench.follow()
        bench.clock(ppm(hz, offset))
        ends = run_line(bench, Line((PER_PIXEL,) * 60, PLAIN))
        assert max(map(abs, errors(bench, ends))) <= 2
        measured = bench.board.input("clock_period_ticks")
        assert (
            abs(measured + bench.board.input("clock_period_fraction") / 65536 - ppm(hz, offset)) < 1
        )


@pytest.mark.parametrize(
    ("board", "tick_hz"), [("uno", 16_000_000), ("mega", 16_000_000), ("m1284", 20_000_000)]
)
@pytest.mark.parametrize("sync", ["free", "start", "lock"])
def test_a_board_at_rest_measures_a_clock_of_kilohertz(bench_of, board, tick_hz, sync):
    for hz in (1000, 5000):
        with bench_of(board, hz) as bench:
            bench.follow(sync)
            bench.clock(ppm(hz, 300, tick_hz))
            bench.settle()
            for _ in range(5):  # a host that asks does not disturb it
                measured = bench.board.input("clock_period_ticks")
                assert abs(measured - ppm(hz, 300, tick_hz)) <= 1
                assert bench.board.input("status") & 0x80
                bench.sim.wait_s(0.02)


# Axis 0 is armed beside a running line that ends before axis 0's line zero; the axis armed then
# must not count pixels anew, of which axis 0 has some.
@pytest.mark.parametrize("before", [0.6, 1.2, 1.5])
@pytest.mark.parametrize("hz", [30, 100, 500])
def test_a_line_that_waits_for_its_zero_keeps_the_grid(bench_of, hz, before):
    with bench_of("mega", hz, axes=(0, 1, 2)) as bench:
        bench.follow(divider=8)
        bench.clock(ppm(hz, 100))
        bench.settle(60)
        pixel = int(8 * ppm(hz, 100))
        line = Line((2,) * 30, PLAIN)
        for axis, own in enumerate((line, Line((3, 3), PLAIN), Line((1,) * 12, PLAIN))):
            assert bench.load(own, axis).done
        bench.board.command("arm", [1])
        bench.until(lambda: bench.state(1) == "running", 20)
        bench.sim.run(int(before * pixel))
        bench.board.command("arm", [0])
        bench.until(lambda: bench.state(1) == "done", 10)
        bench.board.command("arm", [2])
        bench.until(lambda: {bench.state(0), bench.state(2)} == {"done"}, 60)
        assert bench.fault_name() == "none"
        assert max(map(abs, errors(bench, bench.last_steps(line), divider=8)[1:])) <= 2


@pytest.mark.parametrize("board", BOARDS)
def test_jitter_is_averaged(bench_of, board):
    with bench_of(board, 100) as bench:
        bench.follow()
        bench.clock(ppm(100, 300), jitter=gauss(1, JITTER_TICKS))
        found = errors(bench, run_line(bench, Line((PER_PIXEL,) * 300, PLAIN)))
        rms = statistics.fmean(one * one for one in found) ** 0.5
        assert rms < 0.6 * JITTER_TICKS


def test_without_the_lock_the_line_drifts(bench_of):
    with bench_of("mega", 100) as bench:
        bench.clock(ppm(100, 300))
        found = errors(bench, run_line(bench, Line((PER_PIXEL,) * 60, PLAIN)))
        assert found[-1] - found[0] == pytest.approx(-59 * 48, abs=2)


@pytest.mark.parametrize("board", BOARDS)
def test_missing_edges_are_bridged(bench_of, board):
    with bench_of(board, 200) as bench:
        bench.follow()
        bench.clock(ppm(200, 500), keep=lambda k: k % 20 != 0 and k % 20 != 7)
        ends = run_line(bench, Line((PER_PIXEL,) * 100, PLAIN))
        assert max(map(abs, errors(bench, ends))) <= 2
        assert bench.board.input("clock_missing") >= 10


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("part", [Fraction(1, 500), Fraction(1, 3), Fraction(7, 10)])
def test_false_edges_are_counted_and_dropped(bench_of, board, part):
    with bench_of(board, 100) as bench:
        bench.follow()
        beside = int(part * ppm(100, 0))
        bench.clock(ppm(100, -500), extra=lambda k: [beside] if k > 60 and k % 7 == 0 else [])
        before = bench.board.input("clock_glitches")
        ends = run_line(bench, Line((PER_PIXEL,) * 100, PLAIN))
        assert max(map(abs, errors(bench, ends))) <= 2
        assert 10 <= bench.board.input("clock_glitches") - before <= 40


@pytest.mark.parametrize("board", BOARDS)
def test_a_jump_of_the_period(bench_of, board):
    """No worse than DESIGN's table says for two edges ahead: 115 us for 1000 ppm at 30 Hz."""
    jump = 45
    with bench_of(board, 30) as bench:
        bench.follow()
        bench.clock(lambda k: ppm(30, 1000 if k > jump else 0))
        found = errors(bench, run_line(bench, Line((PER_PIXEL,) * 50, PLAIN)))
        assert 1600 < max(map(abs, found)) < 1.03 * 115 * 16
        assert max(map(abs, found[-5:])) <= 60


@pytest.mark.parametrize("board", BOARDS)
def test_a_pixel_of_many_edges(bench_of, board):
    divider = 32
    with bench_of(board, 1000) as bench:
        bench.follow(divider=divider)
        bench.clock(ppm(1000, 2000))
        ends = run_line(bench, Line((4, 8, 16, 32, 40, 40, 40, 32, 16, 8, 4), PLAIN))
        assert max(map(abs, errors(bench, ends, divider))) <= 2


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("backlash", [0, 12])
def test_smooth_lines(bench_of, board, backlash):
    """Behind the take-up of the backlash the last step of each pixel is on the clock's edge."""
    speeds = [8, 16, 24, 32, 40]
    made = generator.generate(speeds, generator.LineRequest(40, 60, backlash, 0))
    line = Line(tuple(made.counts), SMOOTH, backlash)
    with bench_of(board, 100) as bench:
        bench.follow()
        bench.clock(ppm(100, 4000))
        ends = run_line(bench, line)
        skip = line.counts.index(40) + 1
        found = errors(bench, [end for end in ends[skip:] if end is not None])
        assert max(map(abs, found)) <= 2


def test_axes_share_one_grid(bench_of):
    line = Line((PER_PIXEL,) * 60, PLAIN)
    with bench_of("mega", 100, axes=(0, 1, 3)) as bench:
        bench.follow()
        bench.clock(ppm(100, 700), jitter=gauss(3, JITTER_TICKS))
        bench.settle()
        for axis in (0, 1, 3):
            bench.load(line, axis)
        bench.board.command("arm", [0, 1])
        bench.run_until_steps(5 * PER_PIXEL)
        bench.board.command("arm", [3])
        bench.until(lambda: {bench.state(axis) for axis in (0, 1, 3)} == {"done"})
        ends = {axis: bench.last_steps(line, axis) for axis in (0, 1, 3)}
        assert ends[0] == ends[1]
        later = next(i for i, end in enumerate(ends[0]) if abs(end - ends[3][0]) < 10_000)
        # The first pixel of the later line had its length before its line zero was known.
        assert abs(ends[0][later] - ends[3][0]) <= JITTER_TICKS
        assert ends[0][later + 1 :] == ends[3][1 : len(ends[0]) - later]


@pytest.mark.parametrize("board", BOARDS)
def test_a_clock_that_has_not_settled_holds_arming_back(bench_of, board):
    with bench_of(board, 30) as bench:
        bench.follow()
        bench.load(Line((PER_PIXEL,) * 4, PLAIN))
        with pytest.raises(BoardError):
            bench.arm()
        assert bench.state() == "loaded"
        bench.settle()
        bench.arm()
        bench.until(lambda: bench.state() == "done")


@pytest.mark.parametrize("board", BOARDS)
def test_a_free_line_needs_no_clock(bench_of, board):
    with bench_of(board, 100) as bench:
        bench.follow("free")
        bench.sim.command("clock off")
        line = Line((PER_PIXEL,) * 20, PLAIN)
        bench.load(line)
        bench.arm()
        bench.until(lambda: bench.state() == "done")
        assert bench.fault_name() == "none"
        ends = bench.last_steps(line)
        assert {b - a for a, b in itertools.pairwise(ends)} == {160_000}


# The account of an axis that is not the clock's may lag by more pixels than it can note errors for:
# at kilohertz, with a step a pixel, a turn of all accounts takes some twenty of them.
@pytest.mark.parametrize(("axes", "hz"), [((2,), 2850), ((0, 1, 3), 1400), ((0, 1, 3), 2000)])
def test_every_record_has_the_error_of_its_edge(bench_of, axes, hz):
    for pixels in range(60, 66):
        with bench_of("mega", hz, axes=axes) as bench:
            bench.run.talk_at(500_000)
            bench.follow("start", record_every=1)
            bench.clock(ppm(hz, 1800))
            bench.settle()
            for axis in axes:
                bench.load(Line((1,) * pixels, PLAIN), axis)
            bench.board.command("arm", list(axes))
            bench.until(lambda: all(bench.state(axis) == "done" for axis in axes))
            for axis in axes:
                records = bench.board.records(axis)
                assert records[-1].pixel == pixels
                drift = 0.0018 * 16e6 / hz  # ticks a pixel, since an edge before line zero
                off = [one.edge_error_ticks - drift * one.pixel for one in records]
                assert max(off) - min(off) < 3


# A stop discards what the place of an edge is told by; an edge that waits then is taken first. The
# grid of the other axis's line would miss it, which without a hold-over is a fault.
@pytest.mark.parametrize(
    ("board", "tick_hz", "axis"), [("mega", 16_000_000, 3), ("m1284", 20_000_000, 1)]
)
@pytest.mark.parametrize("count", [1, 2])
def test_a_stop_of_the_clocks_own_axis_loses_no_edge(bench_of, board, tick_hz, axis, count):
    source = random.Random(count)
    lines = {0: Line((10,) * 400, PLAIN), axis: Line((count,) * 400, PLAIN)}
    for _ in range(20):
        with bench_of(board, 1000, axes=(0, axis)) as bench:
            bench.run.talk_at(250_000)
            bench.follow(hold_over_edges=0)
            bench.clock(ppm(1000, 0, tick_hz))
            bench.settle()
            for at, line in lines.items():
                bench.load(line, at)
            bench.board.command("arm", list(lines))
            bench.until(lambda bench=bench: bench.state(0) == "running")
            bench.sim.run(int(tick_hz * source.uniform(0.03, 0.1)))
            bench.board.command("stop", [axis])
            bench.sim.wait_s(0.05)
            assert (bench.fault_name(), bench.state(0)) == ("none", "running")
            assert bench.state(axis) == "empty" and bench.board.input("clock_missing") == 0


# Edges that come faster than they can be taken must not hold the stop of an axis for good.
@pytest.mark.parametrize(("board", "axis"), [("mega", 3), ("m1284", 1), ("uno", 0)])
@pytest.mark.parametrize("noise_hz", [3000, 12_000])
def test_noise_does_not_hold_up_a_stop(bench_of, board, axis, noise_hz):
    with bench_of(board, 100, axes=(axis,)) as bench:
        bench.follow("free")
        bench.load(Line((20,) * 200, PLAIN), axis)
        bench.board.command("arm", [axis])
        bench.until(lambda: bench.state(axis) == "running")
        bench.sim.command(f"clock hz {noise_hz}/1")
        bench.sim.wait_s(0.1)
        bench.board.command("stop", [axis])
        bench.sim.wait_s(0.05)
        assert (bench.fault_name(), bench.state(axis)) == ("none", "empty")


def _estop(bench):
    (pin,) = (p for p in boards.load(bench.name).pins if p.signal == "ESTOP")
    bench.sim.pin(0, pin.port, pin.bit, 0)
    bench.sim.wait_s(0.02)
    bench.sim.pin(0, pin.port, pin.bit, 1)
    bench.sim.wait_s(0.02)


def _disarm(bench):
    try:
        bench.board.command("disarm", [0])
    except BoardError:  # it runs already
        bench.board.command("stop", [0])


def _clock_stops(bench):
    bench.own.on = False
    bench.sim.wait_s(0.2)
    bench.own.on = True


def _clock_jumps(bench):
    bench.own.next += Fraction(60_000)


ENDS = {
    "stop": lambda bench: bench.board.command("stop", [0]),
    "disarm": _disarm,
    "estop": _estop,
    "clock stops": _clock_stops,
    "clock jumps": _clock_jumps,
}
# Milliseconds behind the command to arm: armed, line zero placed, first pixels, in the middle.
MOMENTS = (0, 7, 13, 22, 250)


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("end", ENDS)
def test_a_locked_line_that_ends_early_leaves_nothing_behind(bench_of, board, end):
    """Positions are the edges made, and the next line is locked from its line zero on."""
    line = Line((PER_PIXEL,) * 40, PLAIN)
    with bench_of(board, 100) as bench:
        bench.follow()
        bench.clock(ppm(100, -3000))
        for moment in MOMENTS:
            bench.settle()
            bench.load(line)
            bench.arm()
            bench.sim.wait_s(moment / 1000 + 0.0001)
            ENDS[end](bench)
            bench.until(lambda: bench.state() not in ("armed", "running"))
            bench.assert_rest()
            if bench.board.input("fault_code"):
                bench.board.command("clear_fault", [])
            bench.board.command("discard", [0])
        found = errors(bench, run_line(bench, line))
        assert max(map(abs, found)) <= 2
