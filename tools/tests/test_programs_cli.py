# SPDX-License-Identifier: MIT
"""`pixstep plan`: files, report, mistakes; and plans on the simulated Mega, judged by edges."""

import json
import re
from fractions import Fraction

import numpy as np
import pytest

from effort import cases, only_long
from pixstep.board import registers as regs
from pixstep.board import run
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.machine.files import MachineFile
from pixstep.programs import streaming
from pixstep.programs.motors import of_machine
from pixstep.programs.plan import Plan
from pixstep.programs.plan_data import PlanOptions
from pixstep.simulation.experiment import run_and_judge
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.simulated_board import SimulatedBoard
from programbench import RUN_IN, SHORT_MOVES, planned, random_program, setup

MACHINE = """\
[clock]
pixel = "{hz} Hz"
[program]
segment_time = "5 ms"
[boards.main]
kind = "mega"
[motors.X]
axis = 0
kind = "{kind}"
steps_per_unit = "400 steps/mm"
[motors.X.limits]
max_speed = "30 mm/s"
max_acceleration = "500 mm/s2"
[motors.stage]
word = "Y"
axis = 1
kind = "{kind}"
steps_per_unit = "2.5 um/step"
[motors.stage.limits]
max_speed = "30 mm/s"
max_acceleration = "250 mm/s2"
"""
SQUARE = """\
; a square of 4 mm
ABS LINEAR TA10 TS0 F20
X4
Y4
CIRCLE2 X2 Y4 I-1 J0
LINEAR X0
DWELL20
X0 Y0
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Go to a folder with a machine file and a program."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text(MACHINE.format(hz=200, kind="plain"))
    (tmp_path / "square.pmc").write_text(SQUARE)
    return tmp_path


def test_a_program_becomes_a_line_for_each_motor(folder, pixstep):
    found = json.loads(pixstep("plan", "square.pmc", "--plot", "--json"))
    assert (found["schema"], found["verdict"], found["mode"]) == (1, "fine", "lookahead")
    lines = [np.loadtxt(folder / f"plan/{name}.csv", dtype=int) for name in ("X", "stage")]
    assert len(lines[0]) == len(lines[1]) == found["pixels"]
    assert [line.sum() for line in lines] == [0, 0]
    assert np.cumsum(lines[0]).max() == 1600 and np.cumsum(lines[1]).max() in (2000, 1999)
    for motor in found["motors"]:
        assert motor["acceleration_ratio"] <= 1 + 1e-9 and motor["counted_ratio"] <= 1
    assert {path.name for path in (folder / "plan").iterdir()} == {
        "X.csv", "stage.csv", "report.json", "path.png", "motion.png", ".pixstep-results",
    }  # fmt: skip
    report = json.loads((folder / "plan/report.json").read_text())
    assert report["moves"] == found["moves"] and report["slowed"][0]["line"] == 3
    for name, line in (("X", lines[0]), ("stage", lines[1])):
        pixstep("line", "check", f"plan/{name}.csv", "--decode", "plain", "--machine", "none")
        assert len(line) == report["pixels"]


def test_the_page_says_time_peaks_and_what_was_slowed(folder, invoke):
    text = invoke("plan", "square.pmc").output
    assert "square.pmc:3: 200 -> " in text and "acceleration of X" in text
    assert "moves slowed" in text and "pixels at 200 Hz" in text
    again = invoke("plan", "square.pmc").output  # replaces what the first run left
    assert again == text


def test_one_move_is_not_called_moves(folder, invoke):
    (folder / "one.pmc").write_text("ABS LINEAR TA10 TS0 F29\nX4\n")
    text = invoke("plan", "one.pmc").output
    assert "plan: 1 move, " in text and "\n1 of 1 move slowed: acceleration of X\n" in text


def test_what_a_mode_does_not_have_is_misuse(folder, invoke):
    said = invoke("plan", "square.pmc", "--no-assume-last", status=2).stderr
    assert said == "pixstep: --no-assume-last: only with --mode mode1\n"
    assert not (folder / "plan").exists()


def test_mode1_leaves_the_segments_of_the_machine_file_alone(folder, invoke):
    assert "segment_time" in (folder / "machine.toml").read_text()
    (folder / "line.pmc").write_text(SQUARE.replace("CIRCLE2 X2 Y4 I-1 J0", "X2"))
    invoke("plan", "line.pmc", "--mode", "mode1", "--out", "left")
    invoke("plan", "line.pmc", "--mode", "mode1", "--segment", "0", "--out", "told")
    for name in ("X.csv", "stage.csv"):
        assert (folder / "left" / name).read_bytes() == (folder / "told" / name).read_bytes()
    circle = invoke("plan", "square.pmc", "--mode", "mode1", status=3)
    assert "CIRCLE2: mode1 plans no circles: plan with --mode lookahead" in circle.output
    asked = invoke("plan", "line.pmc", "--mode", "mode1", "--segment", "5ms", status=2)
    assert "mode1 has no segments: leave --segment out" in asked.output


def test_whoever_does_what_a_message_about_segments_says_gets_a_plan(folder, invoke):
    machine = folder / "machine.toml"
    machine.write_text(machine.read_text().replace('segment_time = "5 ms"\n', ""))
    words, advice = ["plan", "square.pmc", "--mode", "mode1", "--segment", "7ms"], []
    for status in (2, 3, 3):
        error = invoke(*words, status=status).stderr
        if "leave --segment out" in error:
            words = words[:-2]
        elif "plan with --mode lookahead" in error:
            words[words.index("mode1")] = "lookahead"
        elif "made of segments: --segment 5ms, or segment_time in [program]" in error:
            words += ["--segment", "5ms"]
        advice.append(error)
    assert len(set(advice)) == 3, advice
    invoke(*words)


def test_the_segments_of_a_circle_are_one_move_of_the_report(folder, invoke):
    text = invoke("plan", "square.pmc").output
    report = json.loads((folder / "plan/report.json").read_text())
    assert report["moves"] == 5
    lines = [item["line"] for item in report["slowed"]]
    assert lines == sorted(set(lines)) and 5 in lines
    circle = next(item for item in report["slowed"] if item["line"] == 5)
    assert circle["asked_ms"] == pytest.approx(np.pi / 20 * 1000)
    assert text.count("square.pmc:5: 157.08 -> ") == 1


@pytest.mark.parametrize("mode", ["mode1", "lookahead"])
def test_the_programmed_time_is_that_of_a_plan_without_limits(mode):
    text = "INC TA30 TS10 TM80 X90 Y10\nX30 Y40\nDWELL40\nX3\nDELAY35\nRAPID X10"
    report = planned(text, setup(1e9, 2), mode=mode)[1]
    assert not report.slowed_moves and not report.clipped
    assert report.programmed_ms == pytest.approx(report.total_ms, abs=1e-6)


def test_limits_that_a_plan_does_not_use_are_named(folder, invoke):
    assert "does not use" not in invoke("plan", "square.pmc").output
    machine = folder / "machine.toml"
    more = 'max_acceleration = "250 mm/s2"\nmax_jerk = "20000 mm/s3"\nstart_stop = "4 steps/px"'
    machine.write_text(machine.read_text().replace('max_acceleration = "250 mm/s2"', more))
    text = invoke("plan", "square.pmc").output
    assert "stage: a plan does not use start_stop of the machine file" in text
    assert "does not use max_jerk" not in text
    assert re.search(r"stage: jerk [\d.]+ of 1 steps/px3 planned, \d of 5 counted", text)
    stage = json.loads((folder / "plan/report.json").read_text())["motors"][1]
    assert stage["unused_limits"] == ["start_stop"]
    assert 0 < stage["jerk_ratio"] <= 1 + 1e-6
    straight = SQUARE.replace("CIRCLE2 X2 Y4 I-1 J0", "X2")
    (folder / "square.pmc").write_text(straight)
    text = invoke("plan", "square.pmc", "--mode", "mode1").output
    for limit in ("max_jerk", "start_stop"):
        assert f"stage: a plan does not use {limit} of the machine file" in text
    counts = np.loadtxt(folder / "plan/stage.csv", dtype=int)
    jerk = np.abs(np.diff(counts, 2, prepend=[0, 0])).max()
    said = 20_000 * 400 / 200**3
    assert f": its acceleration changes by {jerk} steps/px3 at most, {said:g} is said there" in text
    report = json.loads((folder / "plan/report.json").read_text())
    unused = {motor["name"]: motor["unused_limits"] for motor in report["motors"]}
    assert unused == {"X": [], "stage": ["max_jerk", "start_stop"]}
    x, stage = report["motors"]
    assert (x["max_jerk_steps_px3"], stage["max_jerk_steps_px3"]) == (None, said)
    assert stage["counted_jerk_steps_px3"] == jerk


def test_a_limit_of_the_jerk_is_above_0(folder, invoke):
    machine = folder / "machine.toml"
    more = 'max_acceleration = "250 mm/s2"\nmax_jerk = "0 mm/s3"'
    machine.write_text(machine.read_text().replace('max_acceleration = "250 mm/s2"', more))
    text = invoke("plan", "square.pmc", status=3).output
    assert "machine.toml: motors.stage.limits.max_jerk: is 0" in text


def test_what_exceeds_a_limit_is_a_negative_verdict(folder, invoke):
    (folder / "run.pmc").write_text("INC TS0 TA50 TM100 X2.5\nTA1 TM2\n" + "X0.05\n" * 50)
    words = ("plan", "run.pmc", "--mode", "mode1", "--segment", "0", "--out")
    invoke(*words, "kept")
    text = invoke(*words, "over", "--no-assume-last", status=1).output
    assert "run.pmc:52: exceeds the acceleration of X: " in text
    assert (folder / "over/X.csv").is_file()


BAD = {
    "TS0 TA0 TM9 X1": "1:13: X1: TA and TS are 0",
    "TS0 TA5 TM9\nSPLINE1 X1": "2:1: unknown word 'SPLINE1', known are: LINEAR, RAPID, ",
    "TM9 X nan": "1:7: unknown word 'nan'",
    "TM9 X1e9": "1:5: unknown word 'X1e9'",
    "TM9 X1000000000": "1:5: X1000000000: is 4e+11 counts, beyond 2147483648",
    "TM9999999 X1": "1:1: TM9999999: is not in the range 0 to 8388607 ms",
    "TM9 X": "1:6: the line ends where a number is expected",
    "TM9 Z1": "1:5: Z1: no motor has the word Z",
    "TM9 X1 X2": "1:8: X2: stands twice in a line",
    "X1": "1:1: X1: neither TM nor F says how fast",
    "F0 X1": "1:1: F0: a feed rate is above 0",
    "F-5 X1": "1:1: F-5: a feed rate is above 0",
    "TM9 I5": "1:5: I5: is a word of circles",
    "TM9 X1..5": "1:6: '1..5': expected a number",
    "DWELL5": "1:1: nothing moves in this program",
    "; nothing": "1:1: nothing moves in this program",
    "TM9 X\u00e4": "1:6: 'ä': expected a number",
    "TM9 X1\n\x00\x01\xff": "2:1: '\\x00\\x01",
    "X" * 5000: "1:4097: the line is too long",
}


@pytest.mark.parametrize("text", BAD)
def test_a_mistake_is_one_line_that_says_where(folder, invoke, text):
    (folder / "bad.pmc").write_text(text)
    done = invoke("plan", "bad.pmc", "--segment", "0", "--out", "made", status=3)
    assert done.stderr.startswith(f"pixstep: bad.pmc:{BAD[text]}")
    assert done.stderr.count("\n") == 1 and not (folder / "made").exists()


def test_wrong_bytes_are_a_mistake_like_any_other(folder, invoke):
    (folder / "bad.pmc").write_bytes(b"TM9 TS1\n\xff\xfe X1\n")
    done = invoke("plan", "bad.pmc", status=3)
    assert done.stderr.startswith("pixstep: bad.pmc:2:1: ")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('max_acceleration = "500 mm/s2"\n', "", "motors.X.limits.max_acceleration: is missing"),
        ('word = "Y"', 'word = "X"', "motors.stage.word = 'X': motor X has this word"),
        ('word = "Y"', 'word = "Q"', "motors.stage.word = 'Q'"),
        ('"5 ms"', '"300 ms"', "program.segment_time = '300 ms'"),
    ],
)
def test_what_the_machine_file_lacks(folder, invoke, old, new, message):
    (folder / "machine.toml").write_text(MACHINE.format(hz=200, kind="plain").replace(old, new, 1))
    done = invoke("plan", "square.pmc", status=3)
    assert message in done.stderr and done.stderr.count("\n") == 1
    assert not (folder / "plan").exists()


def test_without_a_machine_file_there_is_nothing_to_plan_for(tmp_path, monkeypatch, invoke):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.pmc").write_text("TM9 X1")
    assert "no machine file" in invoke("plan", "a.pmc", status=2).stderr


def test_units_and_limits_come_from_the_machine_file(folder):
    x, y = of_machine(MachineFile.load(folder / "machine.toml")).motors
    assert (x.word, y.word, x.name, y.name) == ("X", "Y", "X", "stage")
    assert x.max_acceleration == pytest.approx(500 * 400 / 1e6)
    assert x.max_speed == pytest.approx(30 * 400 / 1e3)
    assert (x.counts_per_unit, y.counts_per_unit) == (400, 400)


# On the simulated Mega


def _run(of, counts, folder, board="mega"):
    """Run planned counts on the simulated board; return positions at the pixel edges by edges."""
    lines = {
        motor.axis: Line(tuple(counts[:, index].tolist()), SMOOTH if motor.smooth else PLAIN)
        for index, motor in enumerate(of.motors)
    }
    result, judged, _ = run_and_judge(LineExperiment(board, lines, of.pixel_hz), folder)
    assert judged.summary["verdict"] == "pass", judged.summary["reasons"]
    zero = judged.axes[0].line_zero_cycle
    period = Fraction(result.job.tick_hz) / of.pixel_hz
    ends = [zero + int(period * k) for k in range(len(counts) + 1)]
    places = []
    for motor in of.motors:
        edges = result.edges.axis(0, motor.axis)
        steps = np.concatenate([[0], np.cumsum(edges.directions())])
        places.append(steps[np.searchsorted(edges.rising, ends, side="right")])
    return np.array(places).T


def _highest_acceleration(motor, places):
    """Return the acceleration that edges show: of plain counts, of smooth decoded speeds."""
    counts = np.diff(places)
    if not motor.smooth:
        return int(np.abs(np.diff(counts, prepend=0)).max())
    speeds = [0]
    for count in counts.tolist():
        speeds.append(2 * count - speeds[-1])
    return int(np.abs(np.diff(speeds)).max())


@pytest.mark.parametrize(
    ("text", "hz", "acceleration", "smooth"),
    [
        (SHORT_MOVES.replace("100", "40"), 200, 0.4, False),
        (SHORT_MOVES.replace("100", "40"), 100, 0.4, True),
        (RUN_IN.replace("X5000", "X2000").replace("100", "40"), 100, 0.4, True),
        (RUN_IN.replace("X5000", "X2000").replace("100", "40"), 200, 0.4, False),
    ],
)
def test_anchors_on_the_simulated_mega(simulator, tmp_path, text, hz, acceleration, smooth):
    of = setup(acceleration, 1, hz, speed=20, smooth=smooth)
    counts, report = planned(text, of)
    places = _run(of, counts, tmp_path)
    assert places[-1, 0] == report.motors[0].steps == counts.sum()
    found = _highest_acceleration(of.motors[0], places[:, 0])
    assert found / report.motors[0].allowed <= 1
    assert found <= acceleration * (1000 / hz) ** 2 + (0 if smooth else 2)


@pytest.mark.parametrize("seed", range(cases(3, 40)))
def test_random_programs_on_the_simulated_mega(simulator, tmp_path, seed):
    rng = np.random.default_rng(seed)
    motors, smooth = int(rng.integers(1, 5)), bool(seed % 2)
    of = setup(
        rng.uniform(0.1, 0.3, motors), motors, 100, speed=3.0, smooth=smooth,
        reversal_steps=None if smooth else 37,
    )  # fmt: skip
    text, distance = random_program(rng, motors, 8, rising=smooth)
    counts, report = planned(text, of)
    places = _run(of, counts, tmp_path)
    assert places[-1].tolist() == distance.tolist()
    for index, motor in enumerate(report.motors):
        found = _highest_acceleration(motor.motor, places[:, index])
        assert found <= motor.allowed and found == motor.counted_acceleration


# As a stream


class _EnoughError(Exception):
    """The board has run as many pixels as the test wants."""


class _Until:
    """Ends a run that has come so far; no records are read."""

    def __init__(self, pixels):
        self.pixels, self.seen_px, self.lines = pixels, 0, None

    def look_if_due(self, *_):
        self.look()
        if self.seen_px >= self.pixels:
            raise _EnoughError

    def look(self, *_, **__):
        seen = self.lines.seen.values()
        self.seen_px = min(found["pixel"] for found in seen)
        states = {regs.axis_state(found["axis_state"]) for found in seen}
        assert states <= {"armed", "running", "done"}, states


def _endless(moves, motors):
    """Yield a program of so many moves, a line at a time."""
    yield "INC TS0 TA20 TM40\n"
    rng = np.random.default_rng(1)
    for _ in range(moves):
        words = zip("XYZA", rng.integers(-60, 60, motors).tolist(), strict=False)
        yield " ".join(f"{word}{length}" for word, length in words) + "\n"


class _Here:
    """A plan that is made when its counts are asked for."""

    def __init__(self, plan):
        self.over, self._parts = False, plan.counts()

    def more(self, *, wait):
        part = next(self._parts, None)
        self.over = part is None
        return part


def _stream(board, world, plan, watch):
    """Run a plan on one board, while it is planned, to its end."""
    motors = plan.setup.motors
    lines = streaming.prepare(board, streaming.Entries(_Here(plan), motors), motors)
    watch.lines, lines.recorder = lines, watch
    streaming.load(lines)
    run.arm(board, lines.axes)
    run.follow([lines], world)


def _streamed(moves, pixels, hz, motors=2):
    of = setup(0.02, motors, hz, speed=5, reversal_steps=3)
    plan = Plan("p.pmc", _endless(moves, motors), of, PlanOptions())
    watch = _Until(pixels)
    with SimulatedBoard("mega", Fraction(hz)) as made:
        made.set_up(made.pixel_hz, list(range(motors)))
        over = False
        try:
            _stream(made.board, made.link.world, plan, watch)
            over = True
        except _EnoughError:
            made.board.command("stop", list(range(motors)))
        faults = made.board.fault_text()
        positions = [made.board.axis(axis)["position_steps"] for axis in range(motors)]
    return plan, watch, over, faults, positions


def test_a_plan_runs_while_it_is_planned(simulator):
    plan, _, over, faults, positions = _streamed(60, 10**9, 200)
    assert over and not faults
    assert positions == [motor.steps for motor in plan.report.motors]
    assert plan.report.pixels > 700


@only_long
def test_a_million_moves_are_streamed_for_100_000_pixels(simulator):
    plan, watch, _, faults, _ = _streamed(1_000_000, 100_000, 500)
    assert watch.seen_px >= 100_000 and not faults
    assert plan.report.moves < 10_000  # only what the board needed has been planned


def test_a_program_streams_to_one_board():
    of = setup(1, 2)
    motors = tuple(motor.__class__(**{**vars(motor), "axis": 0}) for motor in of.motors)
    plan = Plan("p", ["TM9 X1"], of.__class__(motors, of.pixel_hz))
    with pytest.raises(UserError, match="axes 0, 0: a program streams to one board"):
        streaming.prepare(None, None, plan.setup.motors)


def test_memory_does_not_grow_with_the_program():
    """What a plan holds after many moves: no list of it is longer than the window needs."""
    of = setup(0.02, 2, speed=5)
    held = []
    for moves in (cases(1000, 2000), cases(2200, 6000)):
        plan = Plan("p.pmc", _endless(moves, 2), of, PlanOptions(window=64))
        most = 0
        for _ in plan.counts():
            most = max(most, plan.report.waiting)
        assert plan.report.moves == moves and len(plan.report.slowed) <= 1000
        held.append(most)
    assert held[1] <= 1.1 * held[0] < 2000
