# SPDX-License-Identifier: MIT
"""Python as a laboratory writes it: units, positions, tables, short texts, pickles, words."""

import inspect
import pickle
import subprocess
import sys
import types
import typing
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from pathlib import Path

import numpy as np
import pyarrow
import pytest

import pixstep as px
from pixstep import arguments
from pixstep.api import words
from pixstep.board import boards, port
from pixstep.board import registers as regs
from pixstep.board.errors import MapVersionError
from pixstep.formats.files import KINDS
from pixstep.moves.legs import INVERTED, SHARED
from pixstep.owndata.columns import QUANTITIES
from pixstep.owndata.table import BLANK, DECIMALS, NONE, SEPARATORS
from pixstep.programs.plan_data import MODES

MACHINE = """\
[clock]
pixel = "2 kHz"
divider = 4

[boards.main]
kind = "mega"

[motors.X]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
backlash = "0.05 mm"

[motors.Y]
axis = 1
kind = "plain"
direction = "-"
steps_per_unit = "100 steps/mm"
"""


@pytest.fixture
def machine(tmp_path):
    (tmp_path / "machine.toml").write_text(MACHINE)
    return px.Machine.load(tmp_path / "machine.toml")


RNG = np.random.default_rng(8)


def test_positions_become_counts_that_follow_them(machine):
    places = np.cumsum(RNG.normal(0.03, 0.05, 300))
    line = px.line_from_positions(places, unit="mm", motor=machine["Y"], name="walk")
    assert (line.line.decode, line.axis, line.pixel_hz, line.pixels) == ("plain", 1, 500, 299)
    wanted = -100 * (places[1:] - places[0])  # the motor runs the other way
    off = np.abs(np.cumsum(line.counts) - wanted)
    assert off.max() <= 0.5 + 1e-6
    assert line.deviation_steps == pytest.approx(off.max(), abs=1e-5)
    (note,) = line.notes
    assert note.startswith("rounded to whole steps: at most 0.5 steps = 0.005 mm from the pos")
    assert note.endswith(f"after pixel {1 + int(off.argmax())}")


def test_play_that_a_plain_line_leaves_is_told(tmp_path):
    text = MACHINE + 'backlash = "16 steps"\n'
    (tmp_path / "machine.toml").write_text(text)
    motor = px.Machine.load(tmp_path / "machine.toml")["Y"]
    (note,) = px.line_from_positions([0, 9, 3], motor=motor).notes
    assert note.startswith("the play of 16 steps is not taken up")
    assert "line compensate" in note
    assert px.line_from_positions([0, 9, 13], motor=motor).notes == ()
    assert px.line_from_positions([0, 9, 3], decode="plain").notes == ()


@pytest.mark.parametrize("seed", range(5))
def test_a_fit_is_legal_and_near(seed):
    rng = np.random.default_rng(seed)
    share = np.linspace(0, 1, rng.integers(40, 200))
    places = rng.uniform(5, 60) * share**2 * (3 - 2 * share)
    line = px.line_from_positions(-places, unit="mm", steps_per_unit="200 steps/mm", pixel_hz=30)
    assert not line.check("mega").refused and line.line.negative
    off = np.abs(np.cumsum(line.counts) - 200 * places[1:]).max()
    assert line.deviation_steps == pytest.approx(off, abs=1e-4) and off < 2
    raw = px.line_from_positions(
        -places, unit="mm", steps_per_unit="200 steps/mm", pixel_hz=30, fit=False
    )
    assert raw.deviation_steps <= 0.5 and raw.check("mega").refused


def smooth_counts(rng, largest):
    """Return the counts of a smooth line whose speeds rise by random even amounts, and fall."""
    rising = np.cumsum(2 * rng.integers(1, largest + 1, rng.integers(3, 40)))
    speeds = np.concatenate([[0], rising, np.full(5, rising[-1]), rising[::-1], [0]])
    return (speeds[1:] + speeds[:-1]) // 2


@pytest.mark.parametrize("seed", range(6))
def test_a_fit_leaves_a_line_as_it_is_and_follows_one_that_was_measured(seed):
    rng = np.random.default_rng(seed)
    counts = smooth_counts(rng, 2 + 10 * (seed % 3))
    places = np.concatenate([[0], np.cumsum(counts)]).astype(float)
    same = px.line_from_positions(places)
    assert same.counts == tuple(counts) and same.deviation_steps == 0 and same.notes == ()
    places[1:-1] += rng.normal(0, 0.4, len(places) - 2)
    near = px.line_from_positions(places, pixel_hz=30)
    assert not near.check("mega").errors and near.deviation_steps < 2
    changes = np.abs(np.array(near.line.speeds) - same.line.speeds)
    assert changes.max() <= 12  # and no swing that stays


def test_a_fit_of_what_does_not_begin_at_rest_is_legal_and_says_how_far_it_is():
    moving = px.line_from_positions(np.arange(60) * 40.0, pixel_hz=30)
    assert not moving.check("mega").errors
    assert 3 < moving.deviation_steps < 20 and "fitted: at most" in moving.notes[0]
    assert px.line_from_positions([0, 0]).counts == (0,)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: px.line_from_positions([1]), "expected two positions or more"),
        (lambda: px.line_from_positions([0, 1], unit="mm"), "needs steps per mm: give motor or st"),
        (lambda: px.line_from_positions([0, 1], unit="px"), "unit 'px': expected one of step, "),
        (lambda: px.line_from_positions([0, 1], unit="mm", steps_per_unit=400),
         "steps_per_unit 400: expected a text"),
        (lambda: px.line_from_positions([0, 2, 1]), "line: pixel 2: a smooth line has one direct"),
        (lambda: px.line_from_positions([0, 2, 1]), "turns back; a line of a plain motor may"),
        (lambda: px.line_from_positions([0, 1e6], decode="plain"), "pixel 1: 1000000 steps in a p"),
        (lambda: px.line_from_positions([0, "a"]), "pixel 2: 'a': expected a number"),
        (lambda: px.line_from_positions([0, 1], unit="deg", steps_per_unit="4 steps/mm"),
         "needs steps per deg, the motor has 4 steps/mm"),
        (lambda: px.make_line(speed=4, pixels=9), "a line needs profile or max_acceleration"),
        (lambda: px.make_line(px.Profile((4,)), speed=4, length=9), "length: only with max_accel"),
        (lambda: px.make_line(speed=4), "a line has pixels or length: give one of them"),
        (lambda: px.make_line(px.Profile((4,)), speed=4, pixels=9, max_acceleration=2),
         "profile and max_acceleration: a line is made by one of them"),
        (lambda: px.make_line(px.Profile((4,)), speed=4, pixels=9, max_jerk=2), "max_jerk: only w"),
        (lambda: px.make_line(speed=4, pixels=9, max_acceleration=2), "pixel_hz or motor"),
        (lambda: px.make_line(speed="1 mm/s", pixels=9, max_acceleration=2, pixel_hz=30),
         "speed 1 mm/s: needs a motor's steps per mm"),
        (lambda: px.line([2, 2], backlash="1 mm"), "needs a motor's steps per mm"),
        (lambda: px.make_profile("3 steps/s", 2, 2), "per second needs a pixel frequency"),
    ],
)  # fmt: skip
def test_refusals_name_what_is_missing(call, says):
    with pytest.raises(px.UserError) as error:
        call()
    assert says in str(error.value) and "\n" not in str(error.value)


def test_units_in_every_call(machine):
    motor = machine["X"]
    line = px.line([2, 6, 8, 6, 2], motor=motor, backlash="0.01 mm")
    assert line.line.backlash == 4
    profile = px.make_profile("60 mm/s", "3000 mm/s2", "1000000 mm/s3", motor=motor)
    assert profile.top_speed_steps_px == 48 and profile.pixel_hz == 500
    made = px.make_line(
        profile, speed="50 mm/s", pixels="60 px", lead_in="2 px", motor=motor, backlash=0
    )
    assert (made.pixels, made.line.line_speed) == (60, 40)
    assert px.simulate.__kwdefaults__["sync"] is None


def test_lines_by_acceleration_and_length(machine):
    motor = machine["X"]
    line = px.make_line(
        speed="50 mm/s", max_acceleration="500 mm/s2", length="20 mm", motor=motor, backlash=0
    )
    assert line.total_steps == 8000 and line.divider == 7 and line.pixel_hz == Fraction(2000, 7)
    accelerations = np.abs(np.diff([0, *line.line.speeds])) * (2000 / 7) ** 2 / 400
    assert 0.8 * 500 <= accelerations.max() <= 500
    assert not line.check().refused
    own = px.make_line(
        speed="50 mm/s", max_acceleration="5000 mm/s2", pixels=60, motor=motor, backlash=0
    )
    assert (own.divider, own.pixel_hz) == (4, 500)
    given = px.make_line(
        speed=40, max_acceleration=10, max_jerk=6, pixels=60, pixel_hz=500, decode="plain"
    )
    assert (given.divider, given.pixel_hz, given.counts[:5]) == (None, 500, (10, 20, 30, 40, 40))
    short = px.make_line(speed=400, max_acceleration=20, length=100, pixel_hz=100)
    assert short.total_steps == 100 and "the length allows a speed of" in short.notes[0]


@pytest.mark.usefixtures("simulator")
def test_a_run_takes_the_divider_that_a_line_was_made_for(machine):
    line = px.make_line(
        speed="50 mm/s", max_acceleration="500 mm/s2", length="5 mm", motor=machine["X"], backlash=0
    )
    run = px.simulate(line)
    assert run.passed and (run.clock.divider, run.clock.clock_hz) == (7, 2000)
    with pytest.raises(px.UserError, match="its pixels are 7 edges of the clock, the run has 4"):
        px.simulate(line, divider=4)


@pytest.fixture(scope="module")
def run():
    return px.simulate([SHORT, px.line([3, 3], decode="plain", pixel_hz=100)], "mega")


SHORT = px.line([2, 6, 8, 6, 2], pixel_hz=100, name="short")


def results(run):
    """Return one of each kind of result."""
    records = px.AxisRecords(1, 0, 1, 0, *(np.arange(500, dtype=np.int32) for _ in range(5)))
    return [
        SHORT, SHORT.check("uno"), px.Profile((2, 4)), run, *run.axes, run.clock, records,
        px.ClockErrors(
            np.arange(80), np.linspace(0, 1, 80), *[px.Ticks(1, 16_000_000)] * 3, 0.1, 1,
            px.Ticks(2, 16_000_000),
        ),
        px.AxisState(0, "done", 24), px.AxisProgress(1, 0, "running", 4, 2, 5, 0.4),
        px.MoveResult(1, 0, 5, 0, 5, 3, 0.1, 2), px.SeekResult(1, 0, None, 4, 4),
        px.HomeResult(1, 0, "plus", 4, 0, 1.5, ()),
        px.Converted(Path("a.csv"), "csv", 1, 5, ("line ends were LF",)),
    ]  # fmt: skip


@pytest.mark.usefixtures("simulator")
def test_every_result_is_short_and_has_a_table_for_notebooks(run, machine):
    made = [*results(run), machine, machine["X"]]
    for one in made:
        text = repr(one)
        assert type(one).__name__ in text and len(text) < 200 and "\n" not in text, text
        if hasattr(one, "_repr_html_"):
            html = one._repr_html_()
            assert html.startswith("<div><b>") and html.count("<tr>") == html.count("</tr>") < 30
    assert repr(SHORT) == "<MotionLine short: smooth, 5 pixels at 100 Hz, 24 steps>"
    assert repr(run) == "<Run pass, 2 axes of a mega at 100 Hz>"
    assert repr(SHORT.check("uno")) == "<CheckResult of short: fine, 0 errors, 0 warnings>"
    hostile = px.line([2], name="<script>")
    assert "<script>" not in hostile._repr_html_() and "&lt;script&gt;" in hostile._repr_html_()


class Without:
    """Lets a package not be found."""

    def __init__(self, name):
        self.name = name

    def find_spec(self, name, path=None, target=None):
        if name == self.name:
            raise ModuleNotFoundError(name)


@pytest.mark.usefixtures("simulator")
def test_results_are_tables_of_arrow_without_pandas(run, monkeypatch):
    monkeypatch.delitem(sys.modules, "pandas", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Without("pandas"), *sys.meta_path])
    table = SHORT.to_dataframe()
    assert isinstance(table, pyarrow.Table)
    assert table.to_pydict() == {
        "pixel": [1, 2, 3, 4, 5], "steps": [2, 6, 8, 6, 2], "position_steps": [2, 8, 16, 22, 24],
    }  # fmt: skip
    names = {"pixel", "severity", "name", "message"}
    assert set(SHORT.check().to_dataframe().column_names) == names
    assert run.to_dataframe().num_rows == 7
    assert run.to_dataframe()["expected_steps"].to_pylist() == [2, 8, 16, 22, 24, 3, 6]
    edges = run.axes[0].to_dataframe()
    assert edges.num_rows == 24 and edges["cycle"].to_pylist() == run.axes[0].edge_cycles.tolist()
    tables = [one for one in results(run) if hasattr(one, "to_dataframe")]
    assert len(tables) == 8 and all(one.to_dataframe().num_columns >= 2 for one in tables)
    monkeypatch.delitem(sys.modules, "pyarrow")
    monkeypatch.setattr(sys, "meta_path", [Without("pyarrow"), *sys.meta_path])
    with pytest.raises(px.UserError, match="needs pandas or pyarrow: `pip install pandas`"):
        SHORT.to_dataframe()


def test_results_are_data_frames_where_there_is_pandas(monkeypatch):
    pandas = types.ModuleType("pandas")
    pandas.DataFrame = lambda columns: ("frame", columns)
    monkeypatch.setitem(sys.modules, "pandas", pandas)
    kind, columns = px.Profile((2, 4)).to_dataframe()
    assert kind == "frame" and list(columns["speed_steps_px"]) == [2, 4]


@pytest.mark.usefixtures("simulator")
def test_results_pass_between_processes_small_and_whole(run):
    for one in results(run):
        again = pickle.loads(pickle.dumps(one))
        assert repr(again) == repr(one)
    line = px.make_line(speed=400, max_acceleration=100, pixels=60, pixel_hz=100)
    long = px.simulate(line, "mega")
    data = pickle.dumps(long)
    assert len(data) < 4 * line.total_steps
    again = pickle.loads(data)
    for name in ("edge_cycles", "edge_errors_ticks"):
        before, after = getattr(long.axes[0], name), getattr(again.axes[0], name)
        assert np.array_equal(before, after) and before.dtype == after.dtype
    assert again.plot_motion().axes and again.to_dataframe().num_rows == 60


def test_arrays_of_any_kind_are_packed_and_come_back():
    for values in (
        RNG.integers(-(2**62), 2**62, 100), np.arange(0, 10**12, 10**9), RNG.normal(size=100),
        np.arange(100, dtype=np.int32), np.zeros(100), np.full(100, np.nan), np.arange(3),
        RNG.integers(0, 2, (50, 2)), np.array([True] * 100), np.array([-(2**63), 2**63 - 1] * 40),
    ):  # fmt: skip
        records = px.AxisRecords(1, 0, 1, 0, *[values] * 5)
        again = pickle.loads(pickle.dumps(records)).pixel
        assert again.dtype == values.dtype and again.shape == values.shape
        assert np.array_equal(again, values, equal_nan=values.dtype.kind == "f")


def fails(number):
    """Raise an error of each kind in another process."""
    raise errors()[number]


def errors():
    finding = px.Finding("odd_count", "error", 3, "odd")
    return [
        px.UserError("wrong"), px.LineRefusedError("refused", (finding,)),
        px.LineRefusedByBoardError(1, "odd_count", 3, "text"), px.NoReplyError(1, "read", "ttyX"),
        px.MissingFeatureError(1, "gate", 2, "no gate"), px.BusyError(1, 6, "moves"),
        px.FaultError("board 1: fault", "estop"), px.HomingError("axis 0", "home_stuck"),
        px.MotionTimeoutError("late"), px.MotionStoppedError("stopped"), MapVersionError("map"),
    ]  # fmt: skip


def test_errors_pass_between_processes():
    with ProcessPoolExecutor(1) as pool:
        for number, error in enumerate(errors()):
            with pytest.raises(type(error)) as raised:
                pool.submit(fails, number).result()
            assert str(raised.value) == str(error)
            assert vars(raised.value).keys() >= vars(error).keys()
    assert isinstance(px.MotionTimeoutError("late"), TimeoutError)


def test_errors_have_kinds():
    kinds = [getattr(px, name) for name in px.__all__ if name.endswith("Error")]
    assert all(issubclass(kind, px.PlainError) for kind in kinds) and len(kinds) > 12
    with pytest.raises(px.LineRefusedError) as error:
        px.line([2, 9, 8, 6, 2]).check().raise_if_refused()
    assert error.value.findings[0].pixel == 5 and error.value.findings[0].severity == "error"


def test_dir_has_the_interface_alone():
    code = (
        "import pixstep as px; px.line([2, 2]).check('uno');"
        "print(sorted(name for name in dir(px) if not name.startswith('__')) == sorted(px.__all__))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"


WORDS = {
    "Decode": ("smooth", "plain"),
    "Sync": tuple(regs.SYNCS),
    "BoardKind": tuple(boards.BOARD_NAMES),
    "Parity": tuple(port.PARITIES),
    "Direction": ("plus", "minus"),
    "Until": ("closed", "open"),
    "Switches": tuple(INVERTED),
    "SharedLimit": tuple(SHARED),
    "Quantity": QUANTITIES,
    "Separator": (*SEPARATORS, BLANK, NONE),
    "Decimals": tuple(DECIMALS),
    "Mode": MODES,
    "FileKind": KINDS,
}


def test_words_are_those_that_are_taken():
    kinds = {name: typing.get_args(kind) for name, kind in vars(words).items() if name[0].isupper()}
    del kinds["Literal"]
    assert {name: set(said) for name, said in kinds.items()} == {
        name: set(taken) for name, taken in WORDS.items()
    }


def test_everything_public_says_its_types():
    for name in px.__all__:
        found = getattr(px, name)
        calls = [found] if inspect.isfunction(found) else []
        if inspect.isclass(found):
            calls = [
                call for own, call in vars(found).items()
                if inspect.isfunction(call) and not own.startswith("_")
            ]  # fmt: skip
        for call in calls:
            assert call.__doc__, (name, call)
            says = inspect.signature(call).parameters.values()
            untyped = [one.name for one in says if one.annotation is one.empty]
            assert set(untyped) <= {"self", "cls"}, (name, call, untyped)


def test_files_from_one_format_to_another(tmp_path):
    line = px.line([3, 5, 7], decode="plain")
    source = line.write(tmp_path / "a.csv")
    made = px.convert_file(source, tmp_path / "a.csb")
    assert (made.kind, made.lines, made.values, made.notes) == ("csb", 1, 3, ())
    assert px.read_line(made.path, decode="plain").counts == line.counts
    prn = px.convert_file(made.path, tmp_path / "a.prn", decode="plain")
    assert px.read_profile(prn.path).speeds_steps_px == line.counts
    named = px.convert_file(source, tmp_path / "b.csv", header="mine", pixel_hz=30, haps=2)
    assert named.notes == ("header 'mine' added",)
    for call, says in (
        (lambda: px.convert_file(source, tmp_path / "a.txt"), "which format"),
        (lambda: px.convert_file(source, tmp_path / "a.prn"), ": decode plain says"),
        (lambda: px.convert_file(source, tmp_path / "c.csv", to="csb"), "its name says csv"),
        (lambda: px.convert_file(tmp_path / "none.csv", tmp_path / "d.csb"), "none.csv"),
    ):
        with pytest.raises(px.UserError, match=says):
            call()
    assert not (tmp_path / "c.csv").exists() and not (tmp_path / "a.txt").exists()


def test_times_and_hertz_as_texts():
    assert px.line([2, 2], pixel_hz="1 kHz").pixel_hz == 1000
    assert px.line([2, 2], pixel_hz="30000/1001 Hz").pixel_hz == Fraction(30000, 1001)
    assert arguments.finite("x", 1) == 1.0
