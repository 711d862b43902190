# SPDX-License-Identifier: MIT
"""Reversals on the simulated boards: where the load is, DIR's times, and the commands."""

import csv
import json
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from bench import Bench
from effort import TRIED_BOARDS
from pixstep import formats
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import period_ticks
from pixstep.reversals.compensate import MotionLimits, TakeUpRequest, compensate
from pixstep.simulation import verdict
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import read_edges, read_plant
from pixstep.simulation.simulator import SimOptions
from strokes_line import LIMITS, PLAY, four_reversals

HZ = Fraction(100)
IDEAL = tuple(four_reversals())
TRANSITION_PX = 12
BOARDS = TRIED_BOARDS


def compensated(transition_px=TRANSITION_PX):
    return compensate(IDEAL, TakeUpRequest(PLAY, LIMITS, transition_px))


def run(board, counts, out, axis=0, **more):
    job = LineExperiment(
        board=board,
        lines={axis: Line(tuple(counts), PLAIN)},
        pixel_hz=HZ,
        plants={axis: f"play={PLAY}"},
        **more,
    )
    return simulate(job, out)


def columns(out):
    """Signed motor steps (from the edges) and load steps at every pixel edge."""
    with (out / "pixels.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [[int(row[name]) for row in rows] for name in ("actual_steps", "load_steps")]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("ppm", [-317, 500, 900])
@pytest.mark.parametrize("divider", [1, 5])
@pytest.mark.parametrize(
    ("board", "baud"),
    [("uno", 1_000_000), ("mega", 500_000), ("mega", 115_200), ("m1284", 500_000)],
)
def test_all_axes_turn_at_once_as_fast_as_they_may(tmp_path, board, baud, divider, ppm):
    """DIR changes in the middle of an interval, when edges and bytes have let the interrupt."""
    kind, hz = boards.load(board), Fraction(113)
    most = int(kind.tick_hz / hz / kind.reversal_ticks(20)) - 1
    line = Line((most, -most) * 50, PLAIN)
    job = LineExperiment(
        board,
        dict.fromkeys(range(kind.axes), line),
        hz * divider,
        divider=divider,
        pixel_ppm=ppm,
        serial_load=True,
        baud=baud,
    )
    reasons = simulate(job, tmp_path).summary["reasons"]
    assert [text for text in reasons if "no record of" not in text] == []


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("transition_px", [TRANSITION_PX, None])
@pytest.mark.parametrize("board", BOARDS)
def test_compensated_run(tmp_path, board, transition_px):
    made = compensated(transition_px)
    judged = run(board, made.counts, tmp_path, ideals={0: IDEAL})
    assert judged.summary["reasons"] == [] and judged.passed
    motor, load = columns(tmp_path)
    errors = load - np.cumsum(IDEAL)
    away = np.ones(len(errors), dtype=bool)
    for item in made.transitions:
        away[item.pixel - 1 : item.last_pixel] = False
    assert len(made.transitions) == 4 and 60 <= np.sum(away) < len(IDEAL)
    assert np.max(np.abs(errors[away])) <= 1
    speeds = np.diff([0, *motor])
    assert np.max(np.abs(np.diff([0, *speeds, 0]))) <= LIMITS.max_acceleration
    assert errors.tolist() == list(made.load_errors)  # as predicted, in the transitions too
    (axis,) = judged.summary["axes"]
    assert axis["load"]["transitions"] == [[t.pixel, t.last_pixel] for t in made.transitions]
    assert axis["load"]["max_load_error_outside_steps"] == 0
    assert abs(axis["load"]["max_load_error_steps"]) == np.max(np.abs(errors)) > 1


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_the_same_run_without_compensation(tmp_path, board):
    judged = run(board, IDEAL, tmp_path)
    assert judged.summary["reasons"] == [] and judged.passed
    _, load = columns(tmp_path)
    errors = load - np.cumsum(IDEAL)
    assert np.max(np.abs(errors)) == PLAY
    assert np.sum(np.abs(errors) == PLAY) > 30  # over whole strokes, not in passing
    (axis,) = judged.summary["axes"]
    assert axis["load"]["max_load_error_steps"] == PLAY and axis["load"]["transitions"] == []


@pytest.mark.usefixtures("simulator")
def test_with_four_zero_pixels_at_each_reversal_the_load_is_never_off(tmp_path):
    ideal = [
        count for start in range(0, 120, 24) for count in (*IDEAL[start : start + 24], *[0] * 4)
    ]
    made = compensate(ideal, TakeUpRequest(PLAY, LIMITS))
    run("mega", made.counts, tmp_path, ideals={0: tuple(ideal)})
    motor, load = columns(tmp_path)
    assert load == np.cumsum(ideal).tolist() != motor


@pytest.mark.usefixtures("simulator")
def test_a_line_that_begins_in_the_minus_direction(tmp_path):
    # The simulated play is taken up in + at the start: the first motion is a reversal too.
    ideal = tuple(-count for count in IDEAL)
    made = compensate(ideal, TakeUpRequest(PLAY, LIMITS, TRANSITION_PX, "+"))
    run("mega", made.counts, tmp_path, axis=2, ideals={2: ideal})
    _, load = columns(tmp_path)
    assert len(made.transitions) == 5
    assert (load - np.cumsum(ideal)).tolist() == list(made.load_errors)


def direction_gaps(edges, tick_hz):
    """Turns, and the smallest times (us) from DIR to the next step and from the last to DIR."""
    rising, turns = edges.rising, edges.direction_cycles
    after = np.searchsorted(rising, turns)
    inside = (after > 0) & (after < len(rising))
    turns, after = turns[inside], after[inside]
    us = tick_hz // 1_000_000
    return len(turns), min(rising[after] - turns) / us, min(turns - rising[after - 1]) / us


def fast_turns():
    """The counts of a line that turns with 417 us between the steps around DIR."""
    ideal = [way * 24 for way in (1, -1, 1, -1, 1) for _ in range(6)]
    return compensate(ideal, TakeUpRequest(PLAY, MotionLimits(10, 24))).counts


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("setting_us", "counts"),
    [(None, compensated().counts), (None, fast_turns()), (1000, compensated().counts)],
    ids=["default", "default, fast", "1000 us"],
)
@pytest.mark.parametrize("board", BOARDS)
def test_direction_times_at_every_reversal(tmp_path, board, setting_us, counts):
    path = tmp_path / "edges.csv"
    line = Line(counts, PLAIN)
    with Bench(board, hz=HZ, edges=path) as bench:
        if setting_us:
            bench.board.write_setting("dir_setup_us", setting_us)
            bench.board.write_setting("dir_hold_us", setting_us)
        upload = bench.load(line)
        bench.arm()

        def done():
            upload.push()  # the Uno's queue does not hold all of it
            return bench.state() == "done"

        bench.until(done)
        bench.assert_rest()
        bench.sim.command("flush")
        edges = read_edges(path).axis(0, 0)
    tick_hz = boards.load(board).tick_hz
    judged = verdict.judge_axis(line, period_ticks(HZ, tick_hz), edges, tick_hz=tick_hz)
    assert judged.reasons == []
    turns, setup_us, hold_us = direction_gaps(edges, tick_hz)
    assert turns == 4
    assert setup_us >= (setting_us or 20) and hold_us >= (setting_us or 20)


@pytest.fixture
def pixstep(pixstep, tmp_path):
    """Return a function that runs a command line in a folder that holds ideal.csv."""
    formats.write_csv(tmp_path / "ideal.csv", list(IDEAL))
    return pixstep


LIMIT_WORDS = ("--max-acceleration", LIMITS.max_acceleration, "--start-stop", LIMITS.start_stop)
COMPENSATE = ("line", "compensate", "ideal.csv", "--play", PLAY, *LIMIT_WORDS, "-o", "made.csv")


def test_compensate_command(pixstep, tmp_path):
    output = pixstep(*COMPENSATE, "--transition-px", TRANSITION_PX, "--plot", "made.png")
    assert "4 transitions of 40 steps" in output and "0 steps away from the transitions" in output
    assert formats.read_csv(tmp_path / "made.csv").values == compensated().counts
    assert (tmp_path / "made.png").read_bytes().startswith(b"\x89PNG")
    pixstep("line", "check", "made.csv", "--decode", "plain", *LIMIT_WORDS)


def test_compensate_json(pixstep):
    report = json.loads(pixstep(*COMPENSATE, "--json"))
    made = compensated(None)
    assert [row["pixel"] for row in report["transitions"]] == [25, 49, 73, 97]
    assert [row["window_px"] for row in report["transitions"]] == [
        item.window_px for item in made.transitions
    ]
    assert report["complete"] and report["worst_load_error_outside_steps"] == 0


def test_compensate_refusals_are_one_line_and_write_nothing(pixstep, tmp_path):
    output = pixstep(*COMPENSATE, "--transition-px", 5, status=2)
    assert output.count("\n") == 1 and "ideal.csv: pixel 25: " in output
    assert output.endswith("smallest --transition-px for this line is 7\n")
    pixstep(*COMPENSATE, "--transition-px", 0, status=2)
    pixstep(*COMPENSATE, "--transition-px", "few", status=2)
    assert not (tmp_path / "made.csv").exists()


def test_a_broken_off_transition_is_a_warning(pixstep, tmp_path):
    formats.write_csv(tmp_path / "ideal.csv", [4, 12, 4, -4, -8, -4, 4, 12, *[20] * 8, 12, 4])
    output = pixstep(*COMPENSATE, status=1)
    assert "pixel 4: warning: the next reversal breaks the transition off" in output
    assert (tmp_path / "made.csv").exists()


def test_an_unknown_start_is_said(pixstep):
    assert "up to 40 steps ahead" in pixstep(*COMPENSATE, "--initial-direction", "unknown")


SIM = ("sim", "made.csv", "--board", "uno", "--decode", "plain", "--pixel-hz", 100, "--out", "run")


@pytest.mark.usefixtures("simulator")
def test_sim_command_with_a_plant(pixstep, tmp_path):
    pixstep(*COMPENSATE)
    output = pixstep(*SIM, "--plant", f"play={PLAY}", "--ideal", "ideal.csv", "--plot")
    assert "away from the transitions 0" in " ".join(output.split())
    assert (tmp_path / "run" / "load.png").read_bytes().startswith(b"\x89PNG")
    plant = read_plant(tmp_path / "run" / "plant.csv")[0, 0]
    assert (plant.cycles[0], plant.load[0]) == (0, 0)
    assert np.all(plant.load - plant.motor >= 0) and np.max(plant.load - plant.motor) == PLAY
    assert np.max(np.abs(np.diff(plant.motor))) == 1


def test_sim_command_misuse(pixstep, tmp_path):
    pixstep(*COMPENSATE)
    assert "give the axis a --plant" in pixstep(*SIM, "--ideal", "ideal.csv", status=2)
    formats.write_csv(tmp_path / "short.csv", [4, 4])
    output = pixstep(*SIM, "--plant", "play=40", "--ideal", "short.csv", status=2)
    assert "short.csv: 2 pixels, made.csv has 120" in output
    assert not (tmp_path / "run").exists()


def test_a_malformed_plant_log_names_its_line(tmp_path):
    path = tmp_path / "plant.csv"
    for text, place in (("cycle\n", ":1:"), ("cycle,board,axis,motor,load\n0,0,0,1\n", ":2:")):
        path.write_text(text)
        with pytest.raises(UserError, match=place):
            read_plant(path)


def test_plant_options_of_the_runner(tmp_path):
    options = SimOptions(
        [], HZ, plants={(0, 2): "play=4"}, plant_log=tmp_path / "plant.csv"
    ).arguments()
    pairs = list(pairwise(options))
    assert ("--plant", "0.2:play=4") in pairs
    assert ("--plant-log", str(tmp_path / "plant.csv")) in pairs
