# SPDX-License-Identifier: MIT
"""`pixstep trajectory` as it is typed, and its tables on simulated boards."""

import csv
import json
import subprocess
from fractions import Fraction

import numpy as np
import pytest

from bench import Bench
from effort import only_long
from pixstep import natives
from pixstep.errors import RefusedError, UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.machine.files import MachineFile
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from pixstep.trajectories import circle, circle_test, runs, table, transitions
from pixstep.trajectories.circle import CircleRequest, Unit
from pixstep.trajectories.circle_test import CircleTest
from pixstep.trajectories.runs import BoardJob
from pixstep.trajectories.transitions import Servo, TablePlay

HZ = Fraction("100.13")
INCH = ("--scale", "1638400 steps/in")
CIRCLE = ("trajectory", "circle", "--diameter", "0.125in", *INCH)
# A small circle: a revolution is 512 points, its play a sixteenth of the published one.
RADIUS, POINTS, PLAY, STEPS = 1600, 512, 117, 8
SMALL = ("trajectory", "circle", "--radius", RADIUS, "--points", POINTS, "--holds", 20,
         "--lead-in", 32)  # fmt: skip
SIM = ("trajectory", "sim", "c.trj", "--board", "mega", "--pixel-hz", HZ, "--play", PLAY,
       "--transition", STEPS, "--scale", "25600 steps/in", "--out", "run")  # fmt: skip


# Without a board


def test_circle_command(pixstep, tmp_path):
    output = pixstep(*CIRCLE, "-o", "c.trj")
    assert "note: axis 2 begins at 78 counts a point: --lead-in brings it up" in output
    assert "25601 records, 1024 of them holds, radius 102400 counts" in output
    assert (tmp_path / "c.trj").stat().st_size == 16 * 25_601
    output = pixstep(*CIRCLE, "--lead-in", 64, "-o", "d.trj")
    assert "note" not in output
    facts = json.loads(pixstep("trajectory", "circle", "--radius", 900, "-o", "e.csv", "--json"))
    assert (facts["radius"], facts["records"], facts["schema"]) == (900, 25_601, 1)


def test_a_table_goes_through_every_form(pixstep, tmp_path):
    pixstep(*SMALL, "-o", "c.trj")
    pixstep("trajectory", "export", "c.trj", "-o", "c.parquet")
    pixstep("trajectory", "export", "c.parquet", "-o", "c.csv")
    pixstep("trajectory", "import", "c.csv", "-o", "d.trj")
    assert (tmp_path / "c.trj").read_bytes() == (tmp_path / "d.trj").read_bytes()


def test_compensate_command_chooses_and_predicts(pixstep):
    pixstep(*CIRCLE, "-o", "c.trj")
    words = ("trajectory", "compensate", "c.trj", "--play", 7485, *INCH, "-o")
    output = pixstep(*words, "m.trj", "--pixel-hz", HZ)
    assert "axis 1: 5 transitions of 57 points for 7485 counts, predicted radius error 0.0000" in (
        output
    )
    facts = json.loads(pixstep(
        *words, "n.trj", "--play", 5000, "--transition", 64, "--transition", 100, "--bandwidth",
        "none", "--json",
    ))  # fmt: skip
    assert facts["play"] == [7485, 5000] and facts["transition_points"] == [64, 100]
    error = facts["predicted_radius_error_counts"][0] / 1_638_400
    assert abs(error - 0.000075) < 1e-6
    assert {row["axis"] for row in facts["transitions"]} == {1, 2}


def test_a_transition_that_is_broken_off_is_a_warning(pixstep, put):
    put(b"p1,p2\n0,0\n9,0\n18,0\n9,0\n0,0\n9,0\n18,0\n", "z.csv")
    output = pixstep("trajectory", "compensate", "z.csv", "--play", 30, "--transition", 9,
                     "-o", "m.csv", status=1)  # fmt: skip
    assert "m.csv: record 3: warning: axis 1: the next reversal comes 24 counts too early" in output


def test_show_command(pixstep, tmp_path):
    pixstep(*CIRCLE, "--lead-in", 64, "-o", "c.trj")
    words = ("trajectory", "show", "c.trj", *INCH)
    output = pixstep(*words)
    assert "circle: radius 102400 counts, 8192 points a revolution, 3 revolutions from" in output
    output = pixstep(*words, "--play", 7485, "--pixel-hz", HZ, "--plot", "c.png")
    assert "original: radius error at most 0.004569 in at 270.0 degrees, passes 0.0" in output
    assert "compensated: radius error at most 0.000061 in" in output
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    pixstep("trajectory", "export", "c.trj", "-o", "-")


def test_show_of_a_table_that_is_no_circle(pixstep, put, tmp_path):
    put(b"p1,p2\n" + b"".join(b"%d,%d\n" % (k * (40 - k), k) for k in range(40)), "own.csv")
    words = ("trajectory", "show", "own.csv", "--play", 9, "--play", 0, "--bandwidth", "none")
    output = pixstep(*words, "--transition", 3, "--plot", "own.png")
    assert "original: load at most 9 and 0 counts off" in output
    assert (tmp_path / "own.png").read_bytes().startswith(b"\x89PNG")
    assert "own.csv: is not a circle, so --transition is needed" in pixstep(*words, status=2)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("circle", "-o", "x"), "a circle has --diameter or --radius"),
        (("circle", "--radius", 5, "--diameter", 9, "-o", "x"), "a circle has --diameter or"),
        (("circle", "--radius", "3mm", "-o", "x"), "3mm: needs --scale, or a motor"),
        (("circle", "--radius", "1000000000", "-o", "x"), "at least 383519 points"),
        (("circle", "--diameter", 1, "-o", "x"), "a radius of 0.5 counts: at least 1"),
        (("compensate", "c.trj", "--play", 9, "-o", "x"), "give --pixel-hz, the points a second"),
        (("compensate", "c.trj", "--play", 9, "--play", 9, "--play", 9, "-o", "x"), "3 times for"),
        (("compensate", "c.trj", "--play", 90, "--max-added", 9, "--transition", 9, "-o", "x"),
         "90 counts add more than 9 in a point: at least 10 points"),
        (("compensate", "c.trj", "--play", 10**9, "--transition", 2, "-o", "x"),
         "c.trj, compensated: record "),
        (("show", "cut.trj"), "cut.trj: record 3 at byte 32 is cut off: 3 of 16 bytes"),
    ],
)  # fmt: skip
def test_misuse_is_one_line_and_nothing_is_written(invoke, tmp_path, words, message):
    invoke(*SMALL, "-o", "c.trj")
    (tmp_path / "cut.trj").write_bytes(bytes(35))
    refused = "compensated" in message or "cut off" in message
    done = invoke("trajectory", *words, status=3 if refused else 2)
    (line,) = done.stderr.splitlines()
    assert line.startswith("pixstep: ") and message in line
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("value", ["nan", "-1", "1e99", ""])
def test_figures_that_are_none_are_misuse(invoke, value):
    invoke(*SMALL, "-o", "c.trj")
    for words in (
        ("circle", "--radius", value, "-o", "x"),
        ("compensate", "c.trj", "--play", value, "-o", "x"),
        ("compensate", "c.trj", "--transition", value, "-o", "x"),
        ("compensate", "c.trj", "--bandwidth", value, "-o", "x"),
    ):
        assert invoke("trajectory", *words, status=2).stderr


def test_a_bandwidth_that_is_too_high_is_told_the_highest(invoke):
    invoke(*SMALL, "-o", "c.trj")
    said = invoke("trajectory", "compensate", "c.trj", "--bandwidth", "1e9", "-o", "x", status=2)
    assert "'1e9': a frequency above 0 Hz and below 1000000 Hz, or none" in said.stderr


MACHINE = """
[clock]
pixel = "100.13 Hz"
[boards.main]
kind = "mega"
[motors.X]
axis = 2
kind = "plain"
steps_per_unit = "25600 steps/in"
backlash = "117 steps"
[motors.Y]
axis = 3
kind = "plain"
steps_per_unit = "25600 steps/in"
backlash = "90 steps"
"""


def test_a_machine_file_knows_plays_scale_and_clock(pixstep, put):
    put(MACHINE.encode(), "machine.toml")
    motors = ("--motor", "X", "--motor", "Y")
    assert "radius 1600 counts" in pixstep(
        "trajectory", "circle", "--diameter", "0.125in", "--points", POINTS, "--motor", "X",
        "-o", "c.trj",
    )  # fmt: skip
    facts = json.loads(pixstep(
        "trajectory", "compensate", "c.trj", *motors, "-o", "m.trj", "--json"
    ))  # fmt: skip
    assert facts["play"] == [117, 90]
    shown = json.loads(pixstep("trajectory", "show", "c.trj", *motors, "--json"))
    assert shown["runs"]["original"]["roundness"]["unit"] == "mm"
    output = pixstep(
        "trajectory", "compensate", "c.trj", "--play", 5, "--motor", "X", "-o", "n.trj"
    )
    assert "axis 2: 5 transitions of" not in output and "for 5 counts" in output


# On simulated boards


def small_circle(revolutions, lead_in=32):
    return circle.make(CircleRequest(RADIUS, POINTS, revolutions, holds=2, lead_in=lead_in))


@pytest.mark.usefixtures("simulator")
def test_sim_command(pixstep, tmp_path):
    pixstep(*SMALL, "--revolutions", 1, "-o", "c.trj")
    output = pixstep(*SIM, "--plot")
    assert output.startswith(
        "PASS  mega, 10013/100 Hz, play 117 and 117 steps, taken up in 8 and 8"
    )
    assert (tmp_path / "run" / "circle.png").read_bytes().startswith(b"\x89PNG")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    original, compensated = (summary["runs"][name]["roundness"] for name in host_names())
    assert abs(original["max_radius_error_counts"] - PLAY) <= 3  # positions are whole counts
    assert original["unit"] == "in" and 0.0045 <= original["max_radius_error"] <= 0.0047
    assert compensated["max_radius_error"] < 0.00035
    assert compensated["places"] > 3 * POINTS  # every step of either motor, not the points alone
    with (tmp_path / "run" / "compensated.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == small_circle(1).without_holds().records
    assert {"time_s", "p1", "v1", "following_error1", "load1", "p2", "radius_error"} <= set(rows[0])
    assert {row["following_error1"] for row in rows} == {"0"}
    files_left = {path.name for path in (tmp_path / "run").iterdir()}
    assert files_left == {
        ".pixstep-results", "circle.png", "compensated.csv", "original.csv", "summary.json"
    }  # fmt: skip


def host_names():
    return (runs.ORIGINAL, runs.COMPENSATED)


@pytest.mark.usefixtures("simulator")
def test_a_board_s_load_is_the_model_s_at_every_point(tmp_path):
    made = small_circle(1).without_holds()
    plays = (TablePlay(PLAY, STEPS), TablePlay(PLAY - 20, STEPS + 3))
    job = BoardJob("mega", HZ, (PLAY, PLAY - 20), axes=(2, 0))
    for name in host_names():
        done = runs.run_on_board(made, plays, name, job, tmp_path / name, circle=circle.find(made))
        assert done.summary["verdict"] == "pass"
        modelled = runs.run_modelled(
            made, plays, name, runs.ModelledMachine(job.plays, float(1 / HZ))
        )
        assert np.array_equal(done.trace.load, modelled.load)
        assert np.array_equal(done.trace.motor, modelled.command.positions)
        points = np.max(np.abs(done.roundness.passes))
        assert points <= abs(done.roundness.worst) <= points + 4


@pytest.mark.usefixtures("simulator")
def test_axes_that_begin_backwards_have_their_play_taken_up_so(tmp_path):
    made = small_circle(1, lead_in=0).without_holds()  # axis 1 goes down first, axis 2 up
    job = BoardJob("mega", HZ, (PLAY, PLAY))
    done = runs.run_on_board(made, (TablePlay(0),) * 2, runs.ORIGINAL, job, tmp_path)
    first = done.trace.load_errors[: POINTS // 4]
    assert not np.any(first)  # neither axis has turned yet
    assert np.max(np.abs(done.trace.load_errors)) == PLAY


def test_what_a_board_would_refuse_is_named_before_anything_is_done(tmp_path):
    steep = np.array([[0, 0], [200, 0], [0, 0]])
    made = table.made(steep, np.zeros_like(steep), "steep")
    with pytest.raises(RefusedError, match="steep, axis 1: reversal_too_fast after record 2"):
        runs.run_on_board(
            made, (TablePlay(0),) * 2, runs.ORIGINAL, BoardJob("mega", HZ, (0, 0)), tmp_path
        )
    with pytest.raises(UserError, match="axis 1: the uno has"):
        runs.run_on_board(
            made, (TablePlay(0),) * 2, runs.ORIGINAL, BoardJob("uno", HZ, (0, 0)), tmp_path
        )
    assert list(tmp_path.iterdir()) == []


def full_test(radius, play, steps, hz, counts_per_in):
    made = circle.make(CircleRequest(radius, lead_in=128)).without_holds()
    return CircleTest(
        made,
        (TablePlay(play, steps),) * 2,
        BoardJob("mega", hz, (play, play)),
        circle.find(made),
        Unit("in", Fraction(counts_per_in)),
    )


@only_long
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("steps", "below"), [(64, 0.0001), (45, 0.00005)])
def test_the_published_circle(tmp_path, steps, below):
    """1/8 in at 1,638,400 counts/in, 7485 counts of play, three passes of 81.8 s."""
    summary = circle_test.simulate(full_test(102_400, 7485, steps, HZ, 1_638_400), tmp_path / "out")
    assert summary["verdict"] == "pass"
    original, compensated = (summary["runs"][name]["roundness"] for name in host_names())
    assert 0.0045 <= original["max_radius_error"] <= 0.0046
    assert compensated["max_radius_error"] < below
    for found in (original, compensated):
        assert found["passes"] == 3 and found["passes_apart_counts"] <= 2


@only_long
@pytest.mark.usefixtures("simulator")
def test_the_large_circle_at_a_quarter_of_the_counts(tmp_path):
    """4 in at 409,600 counts/in, three passes of 150.8 s."""
    hz = Fraction(20480, 377)
    chosen = transitions.choose(transitions.Crest(819_200, 8192, 1871, float(1 / hz), Servo(20)))
    assert chosen.steps == 9
    test = full_test(819_200, 1871, chosen.steps, hz, 409_600)
    summary = circle_test.simulate(test, tmp_path / "out")
    assert summary["verdict"] == "pass"
    original, compensated = (summary["runs"][name]["roundness"] for name in host_names())
    assert 0.0045 <= original["max_radius_error"] <= 0.0046
    assert compensated["max_radius_error"] < 0.0001
    predicted = chosen.error / 409_600
    assert compensated["max_radius_error"] == pytest.approx(predicted, abs=2 / 409_600)
    for found in (original, compensated):
        assert found["passes"] == 3 and found["passes_apart_counts"] <= 2


def test_a_run_that_fails_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_, **__):
        raise UserError("no simulator here")

    monkeypatch.setattr(runs, "run_on_board", fail)
    test = full_test(1600, PLAY, STEPS, HZ, 25_600)
    with pytest.raises(UserError, match="no simulator here"):
        circle_test.simulate(test, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_measurement_records_as_parquet(tmp_path):
    made = small_circle(1).without_holds()
    trace = runs.run_modelled(
        made, (TablePlay(0),) * 2, runs.ORIGINAL, runs.ModelledMachine((0, 0), 0.01)
    )
    table.write_columns(tmp_path / "t.parquet", trace.columns(circle.find(made)))
    import pyarrow.parquet

    rows = pyarrow.parquet.read_table(tmp_path / "t.parquet")
    assert rows.num_rows == made.records and "radius_error" in rows.column_names


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("taken_up", ["plus", "minus"])
def test_play_is_taken_up_before_a_table_whichever_way_it_stood(taken_up):
    made = small_circle(1).without_holds()
    plays = (TablePlay(PLAY, STEPS), TablePlay(PLAY - 30, STEPS))
    ways = tuple(transitions.initial_direction(made, axis) for axis in (0, 1))
    found = runs.taking_up(made, plays, ways)
    assert {line.pixels for line in found} == {made.records - 1 + 2 * STEPS + 8}
    knobs = {(0, axis): f"play={item.play},taken_up={taken_up}" for axis, item in enumerate(plays)}
    with Bench("mega", (0, 1), HZ, plants=knobs) as bench:
        before = [bench.sim.plant(0, axis)[0] for axis in (0, 1)]
        for axis, line in enumerate(found):
            counts = line.counts[: 2 * STEPS + 8]
            assert sum(counts) == 0
            bench.load(Line(counts, PLAIN), axis)
        bench.arm()
        bench.until(lambda: bench.state(0) == bench.state(1) == "done")
        for axis, (way, item) in enumerate(zip(ways, plays, strict=True)):
            motor, load = bench.sim.plant(0, axis)
            assert motor == before[axis]
            assert load - motor == (0 if way > 0 else item.play)  # pushed the way it begins


@pytest.fixture
def on_board(make_console):
    """Return a function that starts a Mega with plants and returns it with its console."""
    started = []

    def start(hz=HZ, **plants):
        by_axis = {(0, int(name[-1])): knobs for name, knobs in plants.items()}
        link = SimLink(SimOptions([("mega", natives.image("mega"))], hz, plants=by_axis))
        started.append(link)
        return link.simulator, make_console(link.simulator, link.world)

    yield start
    for link in started:
        link.close()


@pytest.mark.usefixtures("simulator")
def test_a_table_runs_on_a_board_as_it_is_or_compensated(on_board, put):
    put(b"p1,p2\n" + b"".join(b"%d,%d\n" % (min(k, 19 - k), k) for k in range(20)), "own.csv")
    simulator, console = on_board(axis0="play=3", axis1="play=3")
    words = ("trajectory", "own.csv", "--play", 3, "--transition", 2, "--bandwidth", "none",
             "--pixel-hz", 100)  # fmt: skip
    moved = np.array([0, 0])
    for which, end in (("original", 0), ("compensated", -3)):
        facts = console.json(*words, "--run", which)
        assert [row["state"] for row in facts["axes"]] == ["done", "done"]
        assert (facts["run"], facts["play_steps"]) == (which, [3, 3])
        moved += (end, 19)
        assert [simulator.steps(0, axis) for axis in (0, 1)] == moved.tolist()
        console.out("disarm")
    assert "own.csv, compensated, axis 2, 25 steps in 0.31 s: done" in console.out(*words)
    put(b"p1,v1,p2,v2\n0,0,0,0\n500,0,0,0\n0,0,0,0\n", "steep.csv")
    refused = ("trajectory", "steep.csv", "--transition", 2, "--pixel-hz", 100)
    assert "steep.csv, compensated, axis 1: line refused" in console.err(*refused, status=3)


@pytest.mark.usefixtures("simulator")
def test_measure_play_command(on_board, put, monkeypatch):
    put(MACHINE.replace("117", "1").encode(), "machine.toml")
    simulator, console = on_board(Fraction(30), axis2="play=41,home=300,hyst=6,start=100")
    words = ("measure-play", natives.source("tools/data/AccProf-fast-move.csv"), "--haps", 3,
             "--pixel-hz", 30, "--search", 3000, "--repeat", 2)  # fmt: skip
    assert "play 47 steps, the switch's hysteresis within" in console.out(*words, "--axis", 2)
    text = console.out(*words, "--hysteresis", 6, "--save", "--motor", "X")
    assert "axis 2: play 41 steps, hysteresis of 6 steps taken off; 2 approaches" in text
    assert "machine.toml: motors.X.backlash = 41 steps" in text
    assert MachineFile.load("machine.toml")["X"].backlash_steps == 41
    found = console.json(*words, "--hysteresis", 6, "--motor", "X")
    assert (found["play_steps"], found["spread_steps"], found["saved"]) == (41, 0, None)

    def read(*_, **__):
        _, load = simulator.plant(0, 2)
        return subprocess.CompletedProcess((), 0, f"{load}\n", "")

    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "run", read)
        text = console.out(*words, "--encoder", "read-load", "--axis", 2)
    assert "play 41 steps, by the encoder, the switch's hysteresis 6 steps; 2 approaches" in text
    both = (*words, "--encoder", "x", "--hysteresis", 6, "--axis", 2)
    assert "--encoder finds the hysteresis itself" in console.err(*both, status=2)
    assert "--save: no machine file" in console.err(*words, "--save", "--machine", "none", status=2)
    assert "home_not_found" in console.err(*words, "--axis", 3)
    assert "has no motor on this axis" in console.err(*words, "--axis", 1, status=2)
