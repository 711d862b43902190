# SPDX-License-Identifier: MIT
"""`pixstep sim` with lines locked to the pixel clock: its clock, its judge, the whole command."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from effort import cases, only_long
from pixstep import natives
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.lines import exact
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.profiles import generator
from pixstep.simulation import clock_judge, pixel_clock, report, verdict
from pixstep.simulation.experiment import run_and_judge
from pixstep.simulation.job import LOCK, START, LineExperiment
from pixstep.simulation.judge import judge
from pixstep.simulation.logs import AxisEdges, ClockLog, read_clock_log, read_edges
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.simulated_board import BoardUnderTest, SerialLoad, SimLink
from pixstep.simulation.simulator import SimOptions

BOARDS = ("uno", "mega")
HZ = Fraction(100)
PERIOD = Fraction(160_000)
PLAIN_LINE = Line((20,) * 60, PLAIN)
JITTER_US = 5.0
MACHINE = """
[clock]
pixel = "1 kHz"
[boards.one]
kind = "{board}"
[motors.X]
name = "X"
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
[motors.X.limits]
max_acceleration = "500 mm/s2"
"""


def smooth_line(backlash=12):
    """Speed up, hold, slow down; with the backlash taken up where the speed is reached."""
    made = generator.generate([8, 16, 24, 32, 40], generator.LineRequest(40, 40, backlash))
    return Line(tuple(made.counts), SMOOTH, backlash)


def run(folder, board, lines, hz=HZ, **world):
    """Run lines, locked to the clock; return what the run left and its judgement."""
    result, judged, _ = run_and_judge(
        LineExperiment(board, lines, Fraction(hz), **{"sync": LOCK, **world}), folder
    )
    return result, judged


def kept(judged, axis=0):
    """The figures of how an axis kept to the clock, of a run that passed."""
    assert judged.summary["reasons"] == []
    return judged.summary["axes"][axis]["clock"]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("line", [PLAIN_LINE, smooth_line()], ids=["plain", "smooth"])
@pytest.mark.parametrize("ppm", [10_000, -9_900])
def test_a_locked_line_ends_its_pixels_on_the_clocks_edges(tmp_path, board, line, ppm):
    result, judged = run(tmp_path, board, {0: line}, pixel_ppm=ppm)
    found = kept(judged)
    assert found["max_error_ticks"] <= 2 and abs(found["drift_steps"]) < 0.01
    assert found["max_position_error_steps"] <= 1
    assert found["pixels"] == len(exact.edge_ends(line))
    assert judged.summary["axes"][0]["last_steps_on_edge"] == found["pixels"]
    clock = judged.summary["clock"]
    assert clock["board_period_ticks"] == pytest.approx(160_000 / (1 + ppm / 1e6), abs=0.5)
    assert len(result.clock.true) == clock["true_edges"]


@pytest.mark.usefixtures("simulator")
def test_the_same_run_without_the_lock_drifts(tmp_path):
    _, judged = run(tmp_path, "mega", {0: PLAIN_LINE}, sync=START, pixel_ppm=10_000)
    found = kept(judged)
    # From the end of the first pixel to that of the last: 59 pixels, 1 % of each.
    assert found["drift_pixels"] == pytest.approx(59 * 0.01, rel=0.02)
    assert found["drift_steps"] == pytest.approx(20 * 59 * 0.01, rel=0.02)
    assert found["max_position_error_steps"] >= 11 and found["ripple_ticks"] == 0


# Each change of the edge error by 1/64 of a pixel has a record of its own, which the host must read
# before the board overwrites it.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("ppm", [9000, -9000])
def test_a_line_that_runs_away_from_the_clock_has_its_records(tmp_path, ppm):
    lines = dict.fromkeys(range(2), Line((10,) * 500, PLAIN))
    result, judged = run(tmp_path, "mega", lines, 200, sync=START, pixel_ppm=ppm)
    assert judged.summary["reasons"] == [] and result.record_every > 1
    assert len(result.records[1]) > 2 * 500 / result.record_every


@pytest.mark.usefixtures("simulator")
def test_the_judge_of_locked_lines_refuses_a_line_that_is_not(tmp_path):
    """The edges of a line on the board's own time, judged as if it had been locked."""
    result, _ = run(tmp_path, "uno", {0: PLAIN_LINE}, sync=START, pixel_ppm=3000)
    result.job = replace(result.job, sync=LOCK)
    (first, second) = judge(result).summary["reasons"]
    assert "the last step of 60 pixels is more than 2 ticks off the clock's true edge" in first
    assert "the position is more than 1 step off at " in second


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_jitter_missing_and_false_edges(tmp_path, board):
    flaws = ClockFlaws(jitter_us=JITTER_US, drop=20, double=60)
    line = Line((20,) * cases(150, 1000), PLAIN)
    _, judged = run(tmp_path, board, {0: line}, pixel_ppm=300, flaws=flaws)
    found, clock = kept(judged), judged.summary["clock"]
    assert found["rms_error_ticks"] < 0.6 * JITTER_US * 16
    assert found["ripple_ticks"] > 0 and judged.summary["axes"][0]["max_edge_error_ticks"] < 1
    log = read_clock_log(tmp_path / "clock.csv")
    assert (log.missing, log.false) == (clock["missing_edges"], clock["false_edges"])
    # The board counts from arming on, the log from the beginning.
    assert 6 <= clock["board_missing"] <= log.missing
    assert 2 <= clock["board_glitches"] <= log.false


# The ring of an armed line is filled with its slow first steps. The clock's edges come meanwhile,
# of which the Uno can keep four: more than four lost ones would be a hold-over to the filter. What
# the line loses later, slowing down, is another fault.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("hz", [3400, 3800])
def test_filling_the_ring_leaves_time_for_the_clock(tmp_path, hz):
    made = generator.generate([2, 4, 6, 8, 10], generator.LineRequest(10, 200))
    result, judged = run(tmp_path, "uno", {0: Line(tuple(made.counts), SMOOTH)}, hz)
    assert judged.summary["axes"][0]["steps"] > 500
    assert not any("clock_hold_over" in text for text in result.trouble)


@pytest.mark.usefixtures("simulator")
def test_axes_end_their_pixels_together(tmp_path):
    lines = {0: PLAIN_LINE, 1: smooth_line(), 3: Line((0, 7, 0, -3) * 10, PLAIN)}
    _, judged = run(tmp_path, "mega", lines, flaws=ClockFlaws(wander_ppm=500), pixel_ppm=-400)
    assert [axis for axis in judged.kept if kept(judged) is not None] == [0, 1, 3]
    grids = dict(judged.grids)
    shifted = grids[3]
    grids[3] = replace(shifted, knots_cycle=shifted.knots_cycle + 1)
    job = LineExperiment("mega", lines, HZ, sync=LOCK)
    (reason,) = clock_judge.apart(job, grids)
    assert "20 pixels do not end together" in reason


# One axis is decoded ahead of line zero, the other one is not: the filter hears of more edges
# between.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("board", "fast", "slow"), [("mega", 50, 1), ("m1284", 38, 1)])
def test_axes_decoded_ahead_unequally_end_their_pixels_together(tmp_path, board, fast, slow):
    lines = {0: Line((fast,) * 60, PLAIN), 1: Line((slow,) * 60, PLAIN)}
    _, judged = run(tmp_path, board, lines, 1000, flaws=ClockFlaws(jitter_us=JITTER_US))
    assert all(kept(judged, axis)["pixels"] == 60 for axis in lines)


# While nothing moves nothing tells of the clock: the first step behind it does.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("zeros", "ppm"), [(60, 9000), (150, -5000), (400, 9900)])
def test_a_locked_line_begins_with_pixels_without_steps(tmp_path, zeros, ppm):
    line = Line((0,) * zeros + (20,) * 30, PLAIN)
    _, judged = run(tmp_path, "uno", {0: line}, 1000, pixel_ppm=ppm)
    found = kept(judged)
    assert found["max_error_ticks"] <= 2 and found["pixels"] == 30


# What a locked line made before a fault is right, up to its last step.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("line", [PLAIN_LINE, smooth_line()], ids=["plain", "smooth"])
@pytest.mark.parametrize("ppm", [5000, -5000])
def test_edges_before_a_fault_are_not_accused(tmp_path, line, ppm):
    flaws = ClockFlaws(step_ppm=30_000, step_edge=50)
    lines = {0: line, 2: Line((7,) * 60, PLAIN)}
    _, judged = run(tmp_path, "mega", lines, pixel_ppm=ppm, flaws=flaws)
    fault, *others = judged.summary["reasons"]
    assert fault.startswith("fault clock_drifted")
    words = [reason.split(": ")[1].split(" ") for reason in others]
    assert {tuple(of[1:3]) if of[0].isdigit() else tuple(of[:2]) for of in words} == {
        ("steps", "instead"),
        ("no", "record"),
    }


# The edges of such a clock take most of the processor's time while an axis waits for its line zero,
# and what is left may be too little for the start or for the first pixels: each cure must say so.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize(("board", "axes", "hz"), [("uno", 1, 5300), ("mega", 4, 4500)])
def test_a_clock_that_leaves_no_time_is_told_so(tmp_path, board, axes, hz, seed):
    lines = dict.fromkeys(range(axes), Line((10,) * 100, PLAIN))
    result, _ = run(tmp_path, board, lines, hz, pixel_ppm=-100 * seed, seed=seed)
    (fault,) = result.trouble
    assert fault.split()[1] in ("start_late", "decoder_late", "clock_edge_lost")
    assert "ower the clock's frequency" in fault or "ower the speed" in fault


def without_steps(result, *stretches):
    """Take steps out of axis 0's edges, and its records from the pixel of the last stretch on."""
    edges = result.edges.axis(0, 0)
    kept_steps = np.ones(len(edges.rising), dtype=bool)
    for stretch in stretches:
        kept_steps[stretch] = False
    both = np.repeat(kept_steps, 2)  # edges of each pulse
    cut = replace(edges, step_cycles=edges.step_cycles[both], step_levels=edges.step_levels[both])
    result.edges.axes[0, 0] = cut
    made = stretches[-1].start // PLAIN_LINE.counts[0]
    records = result.records[0].items()
    result.records[0] = {pixel: record for pixel, record in records if pixel <= made}


# Behind the fault the clock goes on and the axis does not. What came before it is judged as ever.
@pytest.mark.usefixtures("simulator")
def test_pixels_behind_a_fault_are_not_accused(tmp_path):
    result, _ = run(tmp_path, "uno", {0: PLAIN_LINE}, pixel_ppm=3000)
    without_steps(result, slice(607, None))
    assert any("the position is more than 1 step" in text for text in judge(result).axes[0].reasons)
    result.trouble.append("fault decoder_late on axis 0 at pixel 31")
    judged = judge(result)
    assert judged.summary["reasons"] == [
        "fault decoder_late on axis 0 at pixel 31",
        "axis 0: 607 steps instead of 1200",
        "axis 0: no record of 30 pixels, first 31: the line was stopped before their end",
    ]
    assert judged.summary["axes"][0]["clock"]["max_position_error_steps"] <= 1
    assert judged.summary["axes"][0]["pixels_equal"] == 30
    result.record_every = 7  # of most pixels there is none to be had
    assert judge(result).axes[0].reasons[1:] == [
        "no record of 4 pixels, first 35: the line was stopped before their end"
    ]
    without_steps(result, slice(200, 203), slice(604, None))
    (reason,) = (text for text in judge(result).axes[0].reasons if "position" in text)
    assert "more than 1 step off at 20 of the clock's edges, first edge 11 of the line" in reason


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_under_a_saturated_serial_line_a_lock_is_a_lock(tmp_path, board):
    _, judged = run(tmp_path, board, {0: PLAIN_LINE}, pixel_ppm=3000, serial_load=True)
    assert kept(judged)["max_error_ticks"] <= 2
    assert judged.summary["requests"]["load"] > 20


# Bytes at 1,000,000 baud and a step every 85 cycles: the coarse clock's handler needs its
# instructions between them, or edges are placed by time that has been lost.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("hz", "count", "axis", "ppm"),
    [
        (100, 1819, 0, -5000),
        (100, 1845, 0, -5000),
        (200, 901, 2, 0),
        (200, 906, 2, 0),
        (200, 911, 0, -5000),
    ],
)
def test_the_fastest_traffic_beside_a_fast_axis_takes_no_time_away(tmp_path, hz, count, axis, ppm):
    lines = {axis: Line((count,) * (hz // 5), PLAIN)}
    _, judged = run(tmp_path, "mega", lines, hz, pixel_ppm=ppm, baud=1_000_000, serial_load=True)
    errors_ticks = judged.kept[axis].errors_ticks
    assert len(errors_ticks) >= 8 and max(map(abs, errors_ticks)) <= 2


# The cable is pulled in the middle of the load.
@pytest.mark.usefixtures("simulator")
def test_a_board_that_falls_silent_beside_a_saturated_line_is_named(tmp_path, monkeypatch):
    sent = SerialLoad.until

    def until(load, simulator, cycle):
        sent(load, simulator, cycle)
        raise BoardError("board 1: no reply")

    monkeypatch.setattr(SerialLoad, "until", until)
    _, judged = run(tmp_path, "uno", {0: PLAIN_LINE}, serial_load=True)
    assert any("no reply" in reason for reason in judged.summary["reasons"])
    assert judged.summary["requests"]["load"] > 0
    console = Console(width=200, record=True)
    report.print_page(console, judged.summary)
    shown = f"serial line saturated ({judged.summary['requests']['load']} requests)"
    assert shown in console.export_text()


@pytest.mark.usefixtures("simulator")
def test_a_clock_beyond_the_tolerance_is_a_named_fault(tmp_path):
    _, judged = run(
        tmp_path, "uno", {0: PLAIN_LINE}, flaws=ClockFlaws(step_ppm=30_000, step_edge=70)
    )
    assert judged.summary["verdict"] == "fail"
    assert "fault clock_" in " ".join(judged.summary["reasons"])


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("names", "hz", "ppm", "jitter_us", "first"),
    [
        (("uno", "mega"), 1000, 0, 0.0, 0),
        (("uno", "mega"), 1000, 0, 1.0, 30),
        (("uno", "mega"), 1000, 900, 0.0, 0),
        (("mega", "m1284"), 1000, -900, 0.0, 0),
        # One board needs a missing edge's time in front of a pixel, the other one does not.
        (("uno", "mega"), 100, 300, 5.0, 30),
        (("uno", "mega"), 700, 300, 5.0, 30),
        # The same time is another number of ticks, and of edges if ticks are compared.
        (("mega", "m1284"), 70, 300, 5.0, 30),
        (("uno", "m1284"), 200, 300, 5.0, 30),
    ],
)
def test_two_boards_on_one_clock_end_their_pixels_together(
    tmp_path, names, hz, ppm, jitter_us, first
):
    """From the first pixel on; with jitter once a waiting line's own guess of it has died out."""
    line = Line((4,) * cases(300, 10_000), PLAIN)
    clock_hz = Fraction(hz)
    edges = tmp_path / "edges.csv"
    images = [(name, natives.image(name)) for name in names]
    flaws = ClockFlaws(jitter_us=jitter_us)
    off = {1: ppm} if ppm else {}
    options = SimOptions(
        images, clock_hz, pixel_ppm=-700, edges=edges, flaws=flaws, oscillators_ppm=off
    )
    with SimLink(options) as link:
        runs = [BoardUnderTest(link, unit + 1) for unit in range(len(images))]
        for each in runs:
            each.set_up(clock_hz, [0], sync=regs.SYNCS[LOCK])
            each.load({0: line})
            each.await_clock()
        for each in runs:
            each.arm()
            link.world.wait(0.05)  # so that the second line begins some pixels later
        while {"armed", "running"} & {each.states()[0] for each in runs}:
            link.world.wait(0.1)
        assert [each.board.fault_text() for each in runs] == ["", ""]
        link.simulator.quit()
    log = read_edges(edges)
    ends = [log.axis(board, 0).rising[3::4] for board in range(2)]
    behind = round(float(ends[1][0] - ends[0][0]) / (16_000_000 / hz))  # pixels
    early, late = (ends[0][behind:], ends[1]) if behind >= 0 else (ends[1][-behind:], ends[0])
    together = min(len(early), len(late))
    assert behind > 0 and together > 0.7 * line.pixels
    assert np.max(np.abs((early[:together] - late[:together])[first:])) <= 2


@only_long
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("ppm", [10_000, -9_900])
@pytest.mark.parametrize("board", BOARDS)
def test_a_million_pixels_without_drift(tmp_path, board, ppm):
    line = Line((2,) * 1_000_000, PLAIN)
    _, judged = run(tmp_path, board, {0: line}, hz=2000, pixel_ppm=ppm)
    found = kept(judged)
    assert found["pixels"] == line.pixels and found["max_error_ticks"] <= 2
    assert found["drift_steps"] == 0 and found["max_position_error_steps"] <= 1


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_made_checked_and_run_at_a_kilohertz(tmp_path, invoke, board):
    """400 steps/mm at 1 kHz with 500 mm/s2: a pixel has as many clock edges as that needs."""
    Path("machine.toml").write_text(MACHINE.format(board=board))
    made = json.loads(
        invoke(
            "line", "make", "--speed", "100mm/s", "--length", "20mm", "-o", "l.csv", "--json"
        ).stdout
    )
    assert made["divider"] == 4 and made["steps"] == 8000
    divider = ("--divider", "4")
    assert "fine" in invoke("line", "check", "l.csv", *divider).stdout
    ran = invoke("sim", "l.csv", *divider, "--sync", "lock", "--pixel-ppm", "300", "--out", "run")
    assert ran.stdout.startswith("PASS") and "drift" in ran.stdout
    summary = json.loads(Path("run/summary.json").read_text())
    (axis,) = summary["axes"]
    assert axis["clock"]["max_position_error_steps"] <= 1 and axis["steps"] == 8000
    refused = invoke("line", "check", "l.csv", status=3).stderr
    assert "made for 250 Hz" in refused and "--divider 4, not 1" in refused


@pytest.mark.usefixtures("simulator")
def test_the_drawing_and_the_words_of_a_locked_run(tmp_path, invoke):
    Path("p.csv").write_bytes(b"    20\r\n" * 12)
    words = ("sim", "p.csv", "--board", "uno", "--decode", "plain", "--pixel-hz", "200")
    flaws = ("--pixel-jitter-us", "5", "--pixel-wander-ppm", "50", "--pixel-drop", "40")
    more = ("--pixel-double", "90", "--pixel-step-ppm", "100@50", "--plot", "--out", "run")
    more += ("--pixel-gate", "250,5")
    page = " ".join(invoke(*words, "--sync", "lock", *flaws, *more).stdout.split())
    assert "locked to the clock, jitter 5 us rms, wander 50 ppm, +100 ppm from edge 50 on" in page
    assert "1 edge of 40 missing, 1 edge of 90 doubled, gate of 250 edges, rests of 5 ms" in page
    assert Path("run/clock.png").stat().st_size > 10_000
    assert "free of the clock" in " ".join(
        invoke(*words, "--sync", "free", "--out", "run").stdout.split()
    )


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--pixel-step-ppm", "5", "expected PPM@EDGE"),
        ("--pixel-step-ppm", "1e9@5", "at most 100000 ppm"),
        ("--pixel-step-ppm", "5@0", "from edge 1 on"),
        ("--pixel-jitter-us", "nan", "'nan' is not a number"),
        ("--pixel-ppm", "NaN", "'NaN' is not a number"),
        ("--pixel-wander-ppm", "nan", "'nan' is not a number"),
        ("--pixel-drop", "1", "x>=2"),
        ("--pixel-gate", "5", "expected EDGES,REST_MS"),
        ("--pixel-gate", "0,5", "an edge at least"),
        ("--pixel-gate", "5,nan", "a rest of 3600000 ms at most"),
        ("--divider", "1001", "1<=x<=1000"),
        ("--sync", "phase", "'free', 'start', 'lock'"),
    ],
)
def test_wrong_options_of_the_clock_are_misuse(invoke, option, value, says):
    words = ("sim", "x.csv", "--board", "uno", "--decode", "plain", "--pixel-hz", "30")
    assert says in invoke(*words, "--out", "run", option, value, status=2).stderr


# The judge by itself: edges that are laid by hand on a grid that moves.


def moving_edges(line, ends):
    """The edges of a line whose pixel k ends in cycle ends[k], by straight lines between."""
    units = exact.instants(line, Fraction(1))
    rising = np.floor(np.interp(units, np.arange(len(ends)), ends) + 1e-6).astype(np.int64)
    cycles = np.sort(np.concatenate([rising, rising + 40]))
    levels = np.tile([1, 0], len(rising))
    return AxisEdges(step_cycles=cycles, step_levels=levels)


def moving_ends(pixels, jitter=100):
    """Whole cycles of pixel edges, the first one line zero."""
    source = np.random.default_rng(5)
    lasts = 160_000 + source.integers(-jitter, jitter + 1, pixels)
    return 1_000_000 + np.concatenate([[0], np.cumsum(lasts)])


def test_the_grid_is_found_from_the_steps():
    line = Line((20, 0, 0, 7, 1, 1, 30), PLAIN)
    ends = moving_ends(line.pixels)
    found, grid = verdict.judge_locked_axis(
        line, PERIOD, moving_edges(line, ends), tick_hz=16_000_000
    )
    assert found.reasons == [] and found.max_edge_error_ticks < 1
    made = [1, 4, 5, 6, 7]  # pixels with steps
    assert grid.at(np.array(made)).tolist() == ends[made].tolist()
    assert abs(found.line_zero_cycle - ends[0]) <= 2
    assert grid.pixels_at(grid.at(np.array([0.3, 4.5, 9.0]))) == pytest.approx([0.3, 4.5, 9.0])


def first_pixel_reasons(steps, seed, late=0):
    """Judge a line whose pixels end within ticks, its first step but two so many ticks late."""
    source = np.random.default_rng(seed)
    line = Line((steps, *[2 * steps] * 3, steps), SMOOTH)
    ends = moving_ends(line.pixels) + source.random(line.pixels + 1)
    edges = moving_edges(line, ends)
    edges.step_cycles[4:6] += late
    return verdict.judge_locked_axis(line, PERIOD, edges, tick_hz=16_000_000)[0].reasons


def test_a_first_pixel_is_right_wherever_in_a_tick_it_begins_and_ends():
    steps = (3, 5, 20, 141, 321)
    assert [first_pixel_reasons(n, k) for n in steps for k in range(200)] == [[]] * 1000
    assert all(first_pixel_reasons(n, k, late=3) for n in (20, 141) for k in range(200))


def test_a_first_pixel_that_ends_just_before_the_next_tick_is_right():
    """Its last step is nearly a tick early: the least squares of all put line zero too late."""
    line = Line((321, 642, 321), SMOOTH)
    ends = 16_151_969 + 444_220.997 * np.arange(4)
    edges = moving_edges(line, ends)
    found, grid = verdict.judge_locked_axis(line, Fraction(444_444), edges, tick_hz=16_000_000)
    assert found.reasons == []
    assert abs(grid.at(np.array([0.0]))[0] - ends[0]) < 0.5


def test_a_step_off_the_boards_own_grid_is_found():
    edges = moving_edges(PLAIN_LINE, moving_ends(60))
    edges.step_cycles[2 * 500 : 2 * 501] += 3
    found, _ = verdict.judge_locked_axis(PLAIN_LINE, PERIOD, edges, tick_hz=16_000_000)
    (reason,) = found.reasons
    assert "1 edges are a tick or more off the board's own grid, first step 501" in reason


@pytest.mark.parametrize(("late", "wrong"), [(2, 0), (3, 1)])
def test_a_pixel_edge_off_the_clocks_is_found(late, wrong):
    ends = moving_ends(60, jitter=0)
    true = ends.astype(float)
    ends[30] += late
    edges = moving_edges(PLAIN_LINE, ends)
    job = LineExperiment("uno", {0: PLAIN_LINE}, HZ, sync=LOCK)
    grid = pixel_clock.of_steps(PLAIN_LINE, PERIOD, edges.rising)
    found = clock_judge.keep(job, 0, PLAIN_LINE, edges, grid, ClockLog(true=true))
    assert len(clock_judge.reasons(job, found)) == wrong
    assert found.summary()["max_error_ticks"] == late
    assert found.summary()["max_error_pixel"] == 30
    assert found.ripple_ticks == 2 * late
    assert clock_judge.reasons(replace(job, sync=START), found) == []
