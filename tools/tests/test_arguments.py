# SPDX-License-Identifier: MIT
"""Whatever a program gives to the interface: a result or a UserError of one line, nothing else."""

import inspect
import itertools
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pixstep as px
from effort import cases
from pixstep import natives
from pixstep.api import runs
from pixstep.api.bus import Bus
from pixstep.arguments import shown
from pixstep.board import run as running
from pixstep.profiles.generator import MOST_PIXELS
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

NAN, INF = float("nan"), float("inf")
ODD = [
    None, NAN, INF, -INF, "", "x", "4 12", "-1", "\0", "\ud800", "x" * 300, b"x", -1, 0, 1, 2, 1.5,
    10**9, 10**400, 1e300, True, 1j, Decimal("2"), Decimal("NaN"), Decimal("1e999999"),
    Fraction(1, 3), np.int64(2), np.uint8(200), np.float32(2.5), np.float64(NAN), np.bool_(True),
    np.array(2), np.array([]), np.array([2, 2]), np.array([NAN]), np.ones((2, 2)), np.array("x"),
    np.array([None]), np.datetime64("2020-01-01"), [], {}, set(), (), [2, 2], [[2, 2]], [None],
    ["2"], [INF], {0: 2}, {"0": None}, {None: 1, "a": 2}, {0}, object(), int, len, Path("x"),
]  # fmt: skip
ENDLESS = [-(10**5000), itertools.count()]  # nothing that can be printed
MACHINE = """\
[clock]
pixel = "30 Hz"

[boards.main]
kind = "mega"

[motors.M39]
word = "X"
axis = 0
kind = "smooth"

[motors.M39.limits]
max_acceleration = "20 steps/px2"
"""


class _ReachedError(Exception):
    """The arguments have been taken: what would follow takes too long to be tried each time."""


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """What the calls need, each with arguments that are fine, by its name."""
    folder = tmp_path_factory.mktemp("desk")
    with pytest.MonkeyPatch.context() as patch, _mega() as bus:
        patch.chdir(folder)
        calls = _calls(folder, bus)
        patch.setattr(runs.experiment, "run_and_judge", _reached)
        patch.setattr(running, "arm", _reached)
        yield calls


def _mega():
    return Bus(SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(30))))


def _reached(*_):
    raise _ReachedError


def _calls(folder, bus):
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "own.csv").write_text("steps\n2\n6\n8\n6\n2\n")
    (folder / "move.pmc").write_text("")
    machine = px.Machine.load("machine.toml")
    profile = px.Profile((10, 20, 40))
    profile.write("own.PRN")
    line = px.line([2, 6, 8, 6, 2], pixel_hz=30)
    line.write("line.csv")
    program = px.read_program("move.pmc", machine)
    run = px.simulate(line, "uno")
    board = bus.board()
    fine = [
        (px.Machine.load, {"path": "machine.toml"}),
        (machine.__getitem__, {"name": "M39"}),
        (px.read_profile, {"path": "own.PRN"}),
        (px.make_profile, {"top_speed": 40, "max_acceleration": 16, "max_jerk": 8}),
        (px.make_line, {"profile": profile, "speed": 30, "pixels": 9, "pixel_hz": 30}),
        (px.line, {"counts": [2, 6, 2]}),
        (px.read_line, {"path": "line.csv"}),
        (px.import_line, {"path": "own.csv"}),
        (px.Profile, {"speeds_steps_px": (10, 20)}),
        (px.Profile.nearest, {"speeds_steps_px": [9.6, 21.2]}),
        (profile.write, {"path": "written.PRN"}),
        (px.MotionLine, {"line": line.line}),
        (line.check, {"board": "mega"}),
        (line.check_by, {"bounds": px.Limits()}),
        (line.write, {"path": "written.csv"}),
        (_limits, dict.fromkeys(inspect.signature(px.Limits).parameters)),
        (px.read_program, {"path": "move.pmc", "machine": machine}),
        (px.simulate, {"lines": line, "board": "uno"}),
        (run.plot_motion, {}),
        (run.plot_clock, {}),
        (px.PixelClock, {}),
        (px.connect, {"port": "no/such/port"}),
        (bus.board, {"unit": 1}),
        (board.check, {"line": line}),
        (board.run, {"lines": line}),
        (board.run_program, {"program": program}),
    ]
    return {getattr(call, "__qualname__", str(call)): (call, known) for call, known in fine}


def _limits(**fields):
    px.line([2, 6, 8, 6, 2], pixel_hz=30).check_by(px.Limits(**fields))


NAMES = (
    "Machine.load", "Machine.__getitem__", "read_profile", "make_profile", "make_line", "line",
    "read_line", "import_line", "Profile", "Profile.nearest", "Profile.write", "MotionLine",
    "MotionLine.check", "MotionLine.check_by", "MotionLine.write", "_limits", "read_program",
    "simulate", "Run.plot_motion", "Run.plot_clock", "PixelClock", "connect", "Bus.board",
    "Board.check", "Board.run", "Board.run_program",
)  # fmt: skip


def _parameters(call, known):
    names = inspect.signature(call).parameters
    return [*known] if call is _limits else [*names]


def _try(call, arguments):
    """Make a call; nothing but a result or an error for the user may come of it."""
    try:
        call(**arguments)
    except _ReachedError:
        pass
    except px.PlainError as error:
        assert "\n" not in str(error), shown(arguments)
    except Exception as error:
        odd = {name: shown(value) for name, value in arguments.items()}
        raise AssertionError(f"{call.__qualname__}: {odd}") from error


@pytest.mark.usefixtures("simulator")
def test_every_call_is_tried(desk):
    assert tuple(desk) == NAMES
    for call, known in desk.values():
        try:
            call(**known)
        except _ReachedError:
            pass
        except px.UserError as error:
            assert "no/such/port" in str(error) or "move.pmc" in str(error), call


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("name", NAMES)
def test_odd_values_are_refused_in_a_line(desk, name):
    call, known = desk[name]
    for parameter in _parameters(call, known):
        for value in ODD + ENDLESS:
            _try(call, {**known, parameter: value})


SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5),
   st.binary(max_size=3),    st.decimals(), st.fractions(), st.sampled_from(ODD),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.integers(-1, 4) | st.text(max_size=2), inner, max_size=3)
    ),
    max_leaves=6,
)


@pytest.mark.usefixtures("simulator")
@settings(
    max_examples=cases(150, 5000), deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(data=st.data())
def test_odd_values_of_several_parameters(desk, data):
    call, known = desk[data.draw(st.sampled_from(NAMES))]
    names = _parameters(call, known)
    odd = data.draw(st.dictionaries(st.sampled_from(names), VALUES, min_size=1, max_size=3))
    _try(call, known | odd)


@pytest.mark.parametrize("hz", [
    np.int64(30), np.uint8(30), np.float64(30), np.float32(30), np.array(30), Decimal(30), 30.0,
    Fraction(30), "30",
])  # fmt: skip
def test_a_frequency_of_any_number(hz):
    assert px.line([2, 6, 2], pixel_hz=hz).pixel_hz == 30


def test_a_frequency_is_the_digits_that_a_number_shows():
    for hz in (29.97, np.float64(29.97), np.float32(29.97), Decimal("29.97"), "29.97"):
        assert px.line([2, 6, 2], pixel_hz=hz).pixel_hz == Fraction(2997, 100)
    for hz, says in ((NAN, "expected Hz"), (True, "expected Hz"), (Fraction(0), "above 0 Hz")):
        with pytest.raises(px.UserError, match=says):
            px.line([2, 6, 2], pixel_hz=hz)


def test_numbers_of_numpy_everywhere():
    profile = px.Profile(np.array([10, 20, 40]))
    assert profile.speeds_steps_px == (10, 20, 40)
    made = px.make_line(
        profile, speed=np.float32(30), pixels=np.int8(12), pixel_hz=30, backlash=np.uint16(5),
        lead_in=np.int64(1),
    )  # fmt: skip
    assert made == px.make_line(
        profile, speed=30, pixels=12, pixel_hz=30, backlash=5, lead_in=1
    )  # fmt: skip
    assert type(made.total_steps) is int and type(made.counts[0]) is int
    assert px.make_profile(np.int64(40), Decimal(16), 8.0) == px.make_profile(40, 16, 8)
    for kind in (np.int8, np.uint64, np.float32, np.float64, object):
        assert px.line(np.array([2, 6, 2], kind)).counts == (2, 6, 2)
    assert not made.check("mega", axes=np.int64(4), divider=np.int64(2)).refused
    assert px.PixelClock(drop=np.int64(5)).flaws.drop == 5


@pytest.mark.parametrize(("call", "says"), [
    (lambda line: px.line([2, None]), "line: pixel 2: None: expected a whole number"),
    (lambda line: px.line([2, 1.5]), "line: pixel 2: 1.5: expected a whole number"),
    (lambda line: px.line("4 12"), "line '4 12': expected a list of numbers or an array"),
    (lambda line: px.line([[2, 6], [6, 2]]), "line: pixel 1: [2, 6]: expected a whole number"),
    (lambda line: px.line([2], backlash="3um"),
     "distance 3um: needs a motor's steps per mm: choose a motor of a machine file"),
    (lambda line: px.line([2], backlash=[3]),
     "backlash [3]: expected a whole number, 0 or more"),
    (lambda line: px.line([2], backlash=-5), "backlash -5: expected a whole number, 0 or more"),
    (lambda line: px.Profile((10.5, 20)),
     "speeds_steps_px: pixel 1: 10.5: expected a whole number, 0 or more"),
    (lambda line: px.Profile.nearest([NAN]), "profile: pixel 1: nan: expected a number, 0 or more"),
    (lambda line: px.make_profile("30000steps/s", 128, 64),
     "top_speed 30000steps/s: per second needs a pixel frequency: pixel_hz or motor"),
    (lambda line: px.make_profile([40], 128, 64), "top_speed [40]: expected a number, 0 or more"),
    (lambda line: px.make_line("x.PRN", speed=2, pixels=9), "profile 'x.PRN': expected a Profile"),
    (lambda line: px.make_line(px.Profile((8,)), speed=8, pixels=60.5),
     "pixels 60.5: expected a whole number, 0 or more"),
    (lambda line: line.check("uno", axes=4), "axes 4: the uno has 1 axis: 0"),
    (lambda line: line.check(axes=0), "axes 0: expected a whole number, 1 to 4"),
    (lambda line: line.check(divider=0), "divider 0: expected a whole number, 1 to 1000"),
    (lambda line: line.check(sync="locked"), "sync 'locked': expected one of free, start, lock"),
    (lambda line: px.simulate([line, None], board="mega"),
     "line of axis 1: None: expected a MotionLine"),
    (lambda line: px.simulate([line, line], board="uno"), "axis 1: the uno has 1 axis: 0"),
    (lambda line: px.simulate({"0": line}, board="uno"),
     "axis '0': expected a whole number, 0 or more"),
])  # fmt: skip
def test_what_is_said(call, says):
    with pytest.raises(px.UserError) as error:
        call(px.line([2, 6, 8, 6, 2], pixel_hz=30))
    assert str(error.value) == says


def test_a_line_has_no_more_pixels_than_a_file():
    profile = px.Profile((10, 20))
    for pixels in (MOST_PIXELS + 1, 10**9):
        with pytest.raises(px.UserError) as error:
            px.make_line(profile, speed=20, pixels=pixels)
        assert str(error.value) == f"{pixels} pixels are too many: a line has 2000000 at most"


def test_a_line_without_pixels():
    line = px.line([], pixel_hz=30, name="scan")
    for call in (line.plot, lambda: px.simulate(line, "uno", check=False)):
        with pytest.raises(px.UserError) as error:
            call()
        assert str(error.value) == "scan: has no pixels"


def test_limits_may_be_higher_than_a_board_can_hold():
    line = px.line([2, 6, 8, 6, 2])
    most = px.Limits(max_speed=10**30, max_acceleration=10**30, jerk_warning=10**30)
    assert not line.check_by(most).findings
