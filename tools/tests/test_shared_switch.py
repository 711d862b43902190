# SPDX-License-Identifier: MIT
"""One switch as home and limit switch, on the simulated boards: found, and left one way only."""

import json
import random

import pytest
from click.testing import CliRunner

from effort import cases
from homebench import HomeBench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.machine import files
from pixstep.moves import experiments, homing
from pixstep.moves.legs import shared_limits
from worked import DATA

pytestmark = pytest.mark.usefixtures("simulator")
PROFILE = DATA / "AccProf-fast-move.csv"
BUILT = [board for board in boards.all_boards() if board.all_features]
AXES = [(board.name, axis) for board in BUILT for axis in range(board.axes)]
BOARDS = [("mega", 3), ("m1284", 0)]
START, END = (0x01, 0), (2, 0)
AT_ONCE_STEPS = 20
TRIALS = cases(2, 40)
# The switch is where the travel ends: pressed by the same cam, it trips both pins.
PLUS = "home=0,hyst=2,travel=-900..0,over=400"
MINUS = "home=2,hyst=2,travel=0..900,over=400,active=high"  # closed from 0 on downwards


def bench(board, axis, way, more=""):
    made = HomeBench(board, axis, f"{PLUS if way > 0 else MINUS},start={-300 * way}{more}")
    made.way = way
    return made


def share(made, limit=None):
    """Say that home is the limit at its end, and which levels the switches have."""
    limit = limit or ("plus" if made.way > 0 else "minus")
    made.board.write_setting("home_is_limit", shared_limits(0, made.axis, limit))
    made.board.write_setting("inputs_inverted", 0 if made.way > 0 else 2)
    made.sim.wait_s(0.01)


def line(made, count, pixels):
    """Run a line to its end, a fault or a stop; return the steps made and the fault."""
    before = made.sim.steps(0, made.axis)
    upload = LineUpload(made.board, made.axis, [START, (0, 0), (count, pixels), END])
    upload.push()
    made.board.command("arm", [made.axis])
    made.until(lambda: made.state(made.axis) in ("done", "fault"))
    made.sim.wait_s(0.01)
    return made.sim.steps(0, made.axis) - before, made.fault()


def forget(made):
    made.board.command("clear_fault", [made.axis])
    made.board.command("discard", [made.axis])


def assert_away_only(made):
    """On towards the switch is a fault at once, as often as it is tried; away from it is none."""
    name = "limit_plus" if made.way > 0 else "limit_minus"
    for _ in range(2):
        steps, fault = line(made, 3 * made.way, 40)
        assert fault == name and 0 < steps * made.way <= AT_ONCE_STEPS, (steps, fault)
        forget(made)
    steps, fault = line(made, -3 * made.way, 40)
    assert fault == "none" and steps == -120 * made.way


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize(("board", "axis"), cases(BOARDS, AXES))
def test_homing_onto_a_limit(board, axis, way):
    with bench(board, axis, way) as made:
        share(made)
        homed = made.home(direction=way)
        assert homed.position_steps == 0 and made.fault() == "none"
        assert made.load_position() == 0
        assert_away_only(made)
        assert made.home(direction=way).position_steps == 0


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_without_the_setting_it_is_a_limit_like_any_other(board, axis):
    with bench(board, axis, 1) as made:
        share(made, "none")
        with pytest.raises(homing.HomingError) as caught:
            made.home()
        assert caught.value.name == "limit_plus"


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_the_home_pin_alone_is_enough(board, axis):
    """Nothing is wired to the limit's pin: lines stop at the home switch."""
    with HomeBench(board, axis, "home=0,hyst=2,start=-300") as made:
        made.way = 1
        share(made)
        assert made.home().position_steps == 0
        assert_away_only(made)
        steps, fault = line(made, 3, 100)
        assert fault == "limit_plus" and 120 <= steps <= 120 + AT_ONCE_STEPS


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_a_line_that_trips_it_stops(board, axis):
    with bench(board, axis, 1) as made:
        share(made)
        steps, fault = line(made, 3, 200)
        assert fault == "limit_plus" and 300 <= steps <= 300 + AT_ONCE_STEPS
        forget(made)
        assert_away_only(made)


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_homing_from_the_switch_after_a_fault(board, axis):
    with bench(board, axis, 1) as made:
        share(made)
        line(made, 3, 200)
        forget(made)
        homed = made.home()
        assert homed.legs[0].name == "leave the switch"
        assert homed.position_steps == 0 and made.load_position() == 0


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_a_broken_wire_to_the_home_pin(board, axis):
    """The limit's own pin ends the search."""
    with bench(board, axis, 1, ",stuck=home:open") as made:
        share(made)
        with pytest.raises(homing.HomingError) as caught:
            made.home()
        assert caught.value.name == "limit_plus"


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_switches_that_bounce(board, axis):
    """Each pin has bounces of its own, sooner or later than the other's."""
    rng = random.Random(f"{board} shared")
    for number in range(TRIALS):
        way = 1 - 2 * (number % 2)
        bounce = rng.choice((2, 4, 10))
        ticks = max(bounce, round(12_000 ** rng.random()))
        more = f",bounce={bounce},bounce_ticks={ticks},seed={rng.randrange(1 << 30)}"
        with bench(board, axis, way, more) as made:
            share(made)
            decode = rng.choice((PLAIN, SMOOTH))
            assert made.home(direction=way, decode=decode).position_steps == 0
            assert_away_only(made)


def test_one_axis_seeks_while_another_meets_its_limit():
    with HomeBench("mega", 0, f"{PLUS},start=-300") as made:
        made.way = 1
        made.sim.knobs(0, 1, "home=0,hyst=2,start=-200")
        made.board.write_setting("home_is_limit", 0b1010)
        made.board.command("enable", [1])
        upload = LineUpload(made.board, 1, [START, (0, 0), (1, 500), END])
        upload.push()
        made.board.command("arm", [1])
        with pytest.raises(BoardError):
            made.home()
        assert made.fault() == "limit_plus" and made.board.input("fault_axis") == 1
        assert regs.AXIS_STATES[made.board.axis(1)["axis_state"]] == "fault"


def test_the_command_has_it(tmp_path):
    words = ("home", "sim", PROFILE, "--pixel-hz", 90, "--board", "m1284", "--out", tmp_path)
    words += ("--plant", "home=2000,hyst=8,travel=-500..2000,over=2000,start=100", "--json")
    found = {}
    for limit in ("none", "plus"):
        done = CliRunner().invoke(main, [str(word) for word in (*words, "--home-is-limit", limit)])
        found[limit] = json.loads(done.stdout)
    assert (found["none"]["fault"], found["plus"]["fault"]) == ("limit_plus", "")
    assert found["plus"]["verdict"] == "pass"


MACHINE = """\
[clock]
pixel = "90 Hz"
[boards.main]
kind = "mega"
[motors.X]
axis = 2
kind = "plain"
direction = "-"
home_is_limit = "minus"
"""


@pytest.mark.parametrize(
    ("words", "expected"), [((), "minus"), (("--home-is-limit", "none"), "none")]
)
def test_a_machine_file_says_it(tmp_path, monkeypatch, words, expected):
    """It is the motor's limit, whatever the motor's direction."""
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE)
    jobs = []
    monkeypatch.setattr(
        experiments, "simulate_homing", lambda job, *_, **__: jobs.append(job) or {}["end"]
    )
    words = ("home", "sim", PROFILE, "--machine", path, "--motor", "X", "--plant", "home=1", *words)
    CliRunner().invoke(main, [str(word) for word in words])
    assert [(job.plan.axis, job.home_is_limit) for job in jobs] == [(2, expected)]


def test_a_machine_file_with_another_word_is_refused(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE.replace('"minus"', '"both"'))
    with pytest.raises(UserError, match=r"motors\.X\.home_is_limit = 'both'"):
        files.MachineFile.load(path)


def test_the_bits_of_an_axis():
    assert shared_limits(0, 0, "minus") == 1 and shared_limits(0, 3, "plus") == 128
    assert shared_limits(255, 1, "none") == 0b11110011
    assert shared_limits(0b1010, 1, "minus") == 0b0110
