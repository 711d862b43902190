# SPDX-License-Identifier: MIT
"""The flyer in bluesky's RunEngine, on simulated boards; each document judged by its schema."""

import csv
import itertools
import threading
import time

import bluesky.plan_stubs as bps
import bluesky.plans as bp
import bluesky.preprocessors as bpp
import numpy as np
import pytest
from bluesky.protocols import Collectable, EventPageCollectable, Flyable, Pausable, Stoppable
from bluesky.utils import FailedStatus, RunEngineInterrupted
from flying import at_rest

import pixstep as px

pytestmark = pytest.mark.usefixtures("simulator")

HZ = 100
SCAN = px.make_line(speed=40, max_acceleration=4, length=3000, pixel_hz=HZ)
LONG = px.make_line(speed=40, max_acceleration=4, length=400_000, pixel_hz=HZ)


class Detector:
    """Counts how often it was read, in real time."""

    name, parent = "detector", None

    def __init__(self, seconds=0.0):
        self.seconds, self.count = seconds, 0

    def read(self):
        time.sleep(self.seconds)
        self.count += 1
        return {"detector": {"value": self.count, "timestamp": time.time()}}

    def describe(self):
        return {"detector": {"source": "test", "dtype": "integer", "shape": []}}


def steps_at(file, seconds, hz, board=0, axis=0):
    """Return the steps that the pins of an axis have made at some instants."""
    rows = csv.DictReader(file.read_text().splitlines())
    mine = (row for row in rows if (row["board"], row["axis"]) == (str(board), str(axis)))
    level, cycles, signs = "0", [], []
    for row in mine:
        if row["signal"] == "DIR":
            level = row["level"]
        elif (row["signal"], row["level"]) == ("STEP", "1"):
            cycles.append(int(row["cycle"]))
            signs.append(-1 if level == "1" else 1)
    made = np.concatenate([[0], np.cumsum(signs)])
    return made[np.searchsorted(np.array(cycles) / hz, seconds, side="right")]


def reached(flyer, pixel):
    """Wait until a flight has come so far."""
    end_s = time.monotonic() + 20
    while flyer.pixel < pixel:
        assert time.monotonic() < end_s
        time.sleep(0.002)


def test_a_flyer_has_what_bluesky_asks_for():
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, SCAN)
        for protocol in (Collectable, EventPageCollectable, Flyable, Pausable, Stoppable):
            assert isinstance(flyer, protocol)


@pytest.mark.parametrize(
    ("kind", "clock", "options"),
    [
        ("mega", {}, {}),
        ("uno", {}, {}),
        ("m1284", {"ppm": 3000, "jitter_us": 5}, {"sync": "lock"}),
        ("mega", {}, {"divider": 4}),
    ],
)
def test_each_pixel_is_where_its_edges_are(engine, documents, tmp_path, kind, clock, options):
    edges = tmp_path / "edges.csv"
    with px.simulated_board(
        kind, pixel_hz=HZ, divider=options.get("divider", 1), clock=px.PixelClock(**clock),
        edges=edges,
    ) as board:  # fmt: skip
        flyer = px.fly.LineFlyer(board, SCAN, **options)
        engine(bp.fly([flyer]))
        assert board.made_steps() == SCAN.total_steps
        hz = 16e6 if kind != "m1284" else 20e6
    assert documents.stop["exit_status"] == "success"
    pixels = documents.column("fly_pixel")
    actual = documents.column("fly_axis0_actual")
    assert list(actual) == list(documents.column("fly_axis0_expected"))
    assert not documents.column("fly_axis0_deviation").any()
    assert list(actual) == list(np.cumsum(SCAN.counts)[pixels - 1])
    assert list(pixels) == list(range(1, SCAN.pixels + 1))
    every = 2 if kind == "uno" else 1  # of which the bus can carry the records in time
    assert list(documents.column("fly_records")) == [int(pixel % every == 0) for pixel in pixels]
    stamps = documents.column("fly_pixel", "timestamps")
    begun_s = flyer._flight._epoch_s  # of the simulator's time 0
    assert list(steps_at(edges, stamps - begun_s, hz)) == list(actual)
    lengths = np.diff(stamps) / np.diff(pixels)
    nominal = 1 / HZ / (1 + clock.get("ppm", 0) * 1e-6)
    assert np.allclose(lengths, nominal, rtol=2e-4)
    assert np.allclose(documents.column("fly_time"), pixels * nominal, atol=2e-4)


def test_descriptors_have_all_units(engine, documents, machine):
    x = px.make_line(speed=40, length=4000, max_acceleration=4, motor=machine["X"])
    y = px.make_line(speed=10, length=500, max_acceleration=4, motor=machine["Y"])
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        engine(bp.fly([px.fly.LineFlyer(board, [x, y], name="scan")]))
        assert board.made_steps(0) == 4000 + 12
        assert board.made_steps(1) == -500
    (descriptor,) = documents.of("descriptor")
    assert descriptor["name"] == "scan"
    assert {key: one["units"] for key, one in descriptor["data_keys"].items()} == {
        "scan_pixel": "px", "scan_time": "s", "scan_records": "1", "scan_clock_error": "us",
        "scan_X_expected": "mm", "scan_X_actual": "mm", "scan_X_deviation": "steps",
        "scan_Y_expected": "deg", "scan_Y_actual": "deg", "scan_Y_deviation": "steps",
    }  # fmt: skip
    configured = descriptor["configuration"]["scan"]
    assert {key: one["units"] for key, one in configured["data_keys"].items()} == {
        "scan_pixel_hz": "Hz",
        "scan_X_scale": "steps/mm", "scan_X_backlash": "steps", "scan_X_pixels": "px",
        "scan_Y_scale": "steps/deg", "scan_Y_backlash": "steps", "scan_Y_pixels": "px",
    }  # fmt: skip
    assert configured["data"]["scan_X_backlash"] == 12
    assert documents.column("scan_X_actual")[-1] == 10.03  # of the motor: 12 steps of play
    assert documents.column("scan_Y_actual")[-1] == 10.0  # of the load: the motor runs backwards
    # Two axes have the bus for every other pixel. X takes up play until it has its full speed: what
    # has no record before is not known.
    pixels = documents.column("scan_pixel")
    assert set(range(11, 113)) <= set(pixels) and set(pixels[pixels < 11]) >= {2, 4, 6, 8, 10}
    for name in "XY":
        expected = documents.column(f"scan_{name}_expected")
        assert list(expected) == list(documents.column(f"scan_{name}_actual"))
    shorter = min(x.pixels, y.pixels)
    name, place = ("Y", 10.0) if y.pixels == shorter else ("X", 10.03)
    assert set(documents.column(f"scan_{name}_actual")[pixels >= shorter]) == {place}


def test_two_boards_begin_on_one_edge(engine, documents, tmp_path):
    edges = tmp_path / "edges.csv"
    y = px.line([0, 5, 9, 9, 5, 1] * 6, decode="plain", pixel_hz=HZ)
    with px.simulated_bus(["mega", "uno"], pixel_hz=HZ, edges=edges) as bus:
        flyer = px.fly.LineFlyer(bus, {1: [SCAN, y], 2: SCAN})
        engine(bp.fly([flyer]))
        assert [bus.made_steps(1, 0), bus.made_steps(1, 1), bus.made_steps(2, 0)] == [
            3000, y.total_steps, 3000,
        ]  # fmt: skip
        epoch_s = flyer._flight._epoch_s
    assert documents.stop["exit_status"] == "success"
    stamps = documents.column("fly_pixel", "timestamps") - epoch_s
    places = (("board1_axis0", 0, 0), ("board1_axis1", 0, 1), ("board2_axis0", 1, 0))
    for name, board, axis in places:
        actual = documents.column(f"fly_{name}_actual")
        assert list(actual) == list(documents.column(f"fly_{name}_expected"))
        made = steps_at(edges, stamps, 16e6, board, axis)
        # The boards' quartzes differ by some ppm: a step at an edge may be on its other side.
        assert np.abs(made - actual).max() <= (board == 1)
    assert documents.column("fly_board2_axis0_actual")[-1] == 3000


def test_four_axes_at_a_kilohertz(engine, documents):
    axes = range(4)
    lines = {
        axis: px.make_line(speed=8, max_acceleration=2, length=4000 + 2 * axis, pixel_hz=1000)
        for axis in axes
    }
    with px.simulated_board("mega", pixel_hz=1000) as board:
        engine(bp.fly([px.fly.LineFlyer(board, lines)]))
        made = [board.made_steps(axis) for axis in axes]
    assert made == [4000, 4002, 4004, 4006]
    longest = max(line.pixels for line in lines.values())
    assert list(documents.column("fly_pixel")) == list(range(1, longest + 1))
    for axis, line in lines.items():
        actual = documents.column(f"fly_axis{axis}_actual")
        assert list(actual[: line.pixels]) == list(np.cumsum(line.counts))
        assert actual[-1] == made[axis]
    assert 0 < np.count_nonzero(documents.column("fly_records")) < longest // 10


def test_beside_a_detector(engine, documents):
    detector = Detector()
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, SCAN)
        engine(bpp.fly_during_wrapper(bp.count([detector], 3), [flyer]))
    assert documents.stop["exit_status"] == "success"
    assert documents.stop["num_events"] == {"primary": 3, "fly": SCAN.pixels}


def test_the_same_flyer_again_and_again(engine, documents):
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, SCAN)
        engine(bp.fly([flyer]))
        engine(bp.fly([flyer]))

        @bpp.run_decorator()
        def twice():
            for _ in range(2):
                yield from bps.kickoff(flyer, wait=True)
                yield from bps.complete(flyer, wait=True)
                yield from bps.collect(flyer)

        engine(twice())
        assert board.made_steps() == 4 * SCAN.total_steps
    assert [stop["num_events"]["fly"] for stop in documents.of("stop")] == [85, 85, 170]
    lasts = [page["data"]["fly_axis0_actual"][-1] for page in documents.of("event_page")]
    assert lasts == [3000, 6000, 9000, 12_000]


def test_pages_come_while_it_flies(engine, documents):
    line = px.make_line(speed=40, max_acceleration=4, length=20_000, pixel_hz=HZ)

    @bpp.run_decorator()
    def live(flyer):
        yield from bps.declare_stream(flyer, name="fly", collect=True)
        yield from bps.kickoff(flyer, wait=True)
        yield from bps.collect_while_completing(
            [flyer], [flyer], flush_period=0.02, stream_name="fly"
        )

    with px.simulated_board("mega", pixel_hz=HZ) as board:
        engine(live(px.fly.LineFlyer(board, line, declared=True)))
    assert documents.stop["exit_status"] == "success"
    assert len(documents.of("event_page")) > 2
    assert list(documents.column("fly_pixel")) == list(range(1, line.pixels + 1))
    assert list(documents.column("fly_axis0_actual")) == list(np.cumsum(line.counts))
    stamps = documents.column("fly_pixel", "timestamps")
    assert np.allclose(np.diff(stamps), 1 / HZ, rtol=1e-3)


def test_a_stop_in_the_middle(engine, documents):
    @bpp.run_decorator()
    def stopping(flyer):
        reached(flyer, 100)
        yield from bps.stop(flyer)

    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, LONG)
        with pytest.raises(FailedStatus, match=r"stopped: .*board 1 axis 0 at position \d+"):
            engine(bpp.fly_during_wrapper(stopping(flyer), [flyer]))
        check_stopped(documents, board, "fail")
        assert f"at position {board.made_steps()}" in documents.stop["reason"]
        engine(bp.fly([px.fly.LineFlyer(board, SCAN)]))  # nothing is in its way
    assert documents.stop["exit_status"] == "success"


def test_a_stop_that_is_meant(engine, documents):
    @bpp.run_decorator()
    def stopping(flyer):
        reached(flyer, 100)
        flyer.stop(success=True)
        yield from bps.null()

    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, LONG)
        engine(bpp.fly_during_wrapper(stopping(flyer), [flyer]))
        check_stopped(documents, board, "success")


def check_stopped(documents, board, exit_status):
    """Assert that a flight ended early, at rest, and its documents have all that was reached."""
    at_rest(board)
    assert documents.stop["exit_status"] == exit_status
    actual = documents.column("fly_axis0_actual")
    pixels = len(actual)
    assert 100 <= pixels < LONG.pixels
    assert list(documents.column("fly_pixel")) == list(range(1, pixels + 1))
    assert list(actual) == list(documents.column("fly_axis0_expected"))
    # It rests in the pixel behind the last one, or two where that one's edge was just seen.
    made = board.made_steps()
    assert actual[-1] <= made <= actual[-1] + sum(LONG.counts[pixels : pixels + 2])


@pytest.mark.parametrize("ask", ["abort", "stop", "halt"])
def test_a_run_that_is_broken_off(engine, documents, ask):
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, LONG)

        def asking():
            reached(flyer, 100)
            reason = ["shutter"] if ask == "abort" else []
            asked = getattr(engine, f"_{ask}_coro")(*reason)
            engine.loop.call_soon_threadsafe(engine.loop.create_task, asked)

        thread = threading.Thread(target=asking)
        thread.start()
        with pytest.raises(RunEngineInterrupted):
            engine(bp.fly([flyer]))
        thread.join()
        check_stopped(documents, board, {"stop": "success"}.get(ask, "abort"))


@pytest.mark.parametrize("then", ["resume", "abort", "stop"])
def test_a_pause(engine, documents, then):
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, LONG)
        thread = threading.Thread(target=lambda: (reached(flyer, 100), engine.request_pause()))
        thread.start()
        with pytest.raises(RunEngineInterrupted):
            engine(bp.fly([flyer]))
        thread.join()
        at_rest(board)
        if then == "resume":
            with pytest.raises(FailedStatus, match="stopped by a pause"):
                engine.resume()
        else:
            getattr(engine, then)()
        status = {"resume": "fail", "abort": "abort", "stop": "success"}[then]
        check_stopped(documents, board, status)


@pytest.mark.parametrize("closes", [True, False])
def test_a_plan_that_forgets_its_flyer(engine, documents, closes):
    def forgetful():
        yield from bps.open_run()
        yield from bps.kickoff(flyer, wait=True)
        reached(flyer, 100)
        if closes:
            yield from bps.close_run()

    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, LONG)
        engine(forgetful())
        flyer.complete().wait(10)
        at_rest(board)
        assert flyer.pixel < LONG.pixels
        if not closes:
            check_stopped(documents, board, "success")


def test_a_detector_that_fails(engine, documents):
    class Failing(Detector):
        def read(self):
            raise RuntimeError("no photons")

    with px.simulated_board("mega", pixel_hz=HZ) as board:
        flyer = px.fly.LineFlyer(board, SCAN)
        with pytest.raises(RuntimeError, match="no photons"):
            engine(bpp.fly_during_wrapper(bp.count([Failing()]), [flyer]))
        at_rest(board)
        # bluesky completes and collects a flyer before it closes a run that has failed.
        assert documents.stop["exit_status"] == "fail"
        assert documents.stop["num_events"] == {"fly": SCAN.pixels}


def test_a_fault_in_the_middle(engine, documents):
    with px.simulated_board("mega", pixel_hz=HZ, plant="travel=-500..6000") as board:
        flyer = px.fly.LineFlyer(board, LONG)
        with pytest.raises(FailedStatus, match="limit_plus"):
            engine(bp.fly([flyer]))
        at_rest(board)
        assert board.axes()[0].state == "fault"
        assert documents.stop["exit_status"] == "fail"
        assert "fault limit_plus" in documents.stop["reason"]
        actual = documents.column("fly_axis0_actual")
        assert len(actual) > 100 and actual[-1] <= board.made_steps() <= actual[-1] + 40
        with pytest.raises(FailedStatus, match="limit_plus"):  # it stays until it is cleared
            engine(bp.fly([flyer]))
        assert "event_page" not in [name for name, _ in itertools.islice(documents.all[::-1], 2)]


def test_without_a_clock(engine, documents):
    clock = px.PixelClock(gate_edges=1, gate_rest_ms=1_000_000)
    with px.simulated_board("mega", pixel_hz=HZ, clock=clock) as board:
        with pytest.raises(FailedStatus, match="fault pixel_clock_missing"):
            engine(bp.fly([px.fly.LineFlyer(board, SCAN)]))
        board.clear_fault()
        locked = px.fly.LineFlyer(board, SCAN, sync="lock")
        with pytest.raises(FailedStatus, match="no steady pixel clock"):
            engine(bp.fly([locked]))
        gated = px.fly.LineFlyer(board, SCAN, sync="start", gate_edges=20, clock_timeout="2 s")
        with pytest.raises(FailedStatus, match="no pixel clock in 2 s, nothing has moved"):
            engine(bp.fly([gated]))
        at_rest(board)
        assert board.made_steps() == 0
        assert [stop["exit_status"] for stop in documents.of("stop")] == ["fail"] * 3
        assert not documents.of("event_page")


def test_a_gated_clock_that_rests_at_first(engine, documents):
    clock = px.PixelClock(gate_edges=500, gate_rest_ms=4000)
    with px.simulated_board("mega", pixel_hz=HZ, clock=clock) as board:
        board.let_pass("5.5 s")  # the clock rests
        before_s = board.time_s
        engine(bp.fly([px.fly.LineFlyer(board, SCAN, gate_edges=20)]))
        assert board.time_s - before_s > 3
    assert documents.stop["num_events"] == {"fly": SCAN.pixels}
    stamps = documents.column("fly_pixel", "timestamps")
    assert np.allclose(np.diff(stamps), 1 / HZ, rtol=1e-3)


def test_what_is_refused_ends_the_run_in_one_line(engine, documents):
    with px.simulated_board("mega", pixel_hz=HZ) as board:
        wrong = px.fly.LineFlyer(board, px.line([2, 9, 8, 6, 2], pixel_hz=HZ, name="wrong"))
        with pytest.raises(FailedStatus, match="wrong: line refused"):
            engine(bp.fly([wrong]))
        assert documents.stop["exit_status"] == "fail"
        assert "wrong: line refused: reverses_inside_pixel at pixel 5" in documents.stop["reason"]
        flyer = px.fly.LineFlyer(board, SCAN)
        with pytest.raises(px.UserError, match="fly: nothing flies: kickoff comes before complete"):
            flyer.complete()
        flyer.kickoff().wait(10)
        with pytest.raises(px.UserError, match="flies already"):
            flyer.kickoff()
        flyer.complete().wait(10)
        assert flyer.stop() is None and flyer.pause() is None
    with pytest.raises(px.UserError, match="where 7: expected a Board or a Bus"):
        px.fly.LineFlyer(7, SCAN)
