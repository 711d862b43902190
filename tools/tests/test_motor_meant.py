# SPDX-License-Identifier: MIT
"""`--axis N` is the motor of that axis in the machine file, wherever there is the option."""

import json
import tomllib
from pathlib import Path

import click
import pytest
from click.core import ParameterSource

import pixstep as px
from command_tree import commands
from console import PORT, put
from pixstep import natives
from pixstep.cli.main import main

FAST = natives.root() / "tools/data/AccProf-fast-move.csv"
SMOOTH = natives.root() / "tools/data/AccProfM39-30Hz-1.PRN"
MOTOR = """\
[motors.{name}]
board = "{board}"
axis = {axis}
kind = "{kind}"
steps_per_unit = "{scale} steps/mm"
direction = "{way}"
backlash = {backlash}
home_is_limit = "{limit}"
profiles = {{ line = "AccProfM39-30Hz-1.PRN", move = "{profile}", home = "{profile}" }}
limits = {{ max_speed = {speed}, max_acceleration = {speed} }}
"""
CLOCK = """\
[clock]
pixel = "30 Hz"
[line]
motor = "M39"
"""
BOARD = """\
[boards.{name}]
kind = "mega"
port = "{port}"
unit = {unit}
"""
M39 = {
    "name": "M39", "board": "a", "axis": 0, "kind": "smooth", "scale": 400, "way": "+",
    "backlash": 11, "limit": "plus", "speed": 30, "profile": "one.csv",
}  # fmt: skip
M40 = {
    "name": "M40", "board": "a", "axis": 1, "kind": "plain", "scale": 100, "way": "-",
    "backlash": 22, "limit": "minus", "speed": 20, "profile": "two.csv",
}  # fmt: skip
M41 = M39 | {"name": "M41", "axis": 2, "scale": 50, "backlash": 33, "way": "-", "speed": 10}
OTHER = M40 | {"name": "Y", "board": "b", "axis": 1, "backlash": 44, "way": "+"}


def with_axis():
    """Return all commands that have --axis, by their words."""
    return {
        words: command
        for words, command in commands().items()
        if any("--axis" in param.opts for param in command.params)
    }


COMMANDS = with_axis()
STOP = "board stop"  # stops any axis, whatever a file has
TABLES = [words for words in COMMANDS if "trajectory" in words]
MEANT = [words for words in COMMANDS if words != STOP and words not in TABLES]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Put a machine with three motors on one board and one on another into the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PIXSTEP_PORT", raising=False)
    write(M39, M40, M41)
    (tmp_path / SMOOTH.name).write_bytes(SMOOTH.read_bytes())
    for name in ("one.csv", "two.csv"):
        (tmp_path / name).write_bytes(FAST.read_bytes())
    put([10, 30, 40, 40, 30, 10], "line.csv")
    Path("circle.csv").write_text("p1,v1,p2,v2\n0,0,0,0\n5,5,5,5\n10,0,10,0\n")
    return tmp_path


def write(*motors, path="machine.toml"):
    """Write a machine file with some motors and the boards that they are on."""
    units = {"a": 1, "b": 2}
    boards = dict.fromkeys(str(motor["board"]) for motor in motors)
    parts = [BOARD.format(name=name, port=PORT, unit=units[name]) for name in boards]
    text = "".join([CLOCK, *parts, *(MOTOR.format(**motor) for motor in motors)])
    tomllib.loads(text)
    Path(path).write_text(text)


def given(words):
    """Return the arguments that a command cannot do without beside a machine file."""
    command = COMMANDS[words]
    files = {"csv": "line.csv", "table": "circle.csv"}
    needed = [files[param.name] for param in command.params if param.name in files]
    names = {param.name for param in command.params}
    more = ["--steps", "1mm"] if "steps" in names and "profile" in names else []
    more += ["--plant", "home=2000"] if words == "home sim" else []
    return [*needed, *more]


def asked(words, *more):
    """Return what a command gets for its parameters, and which of them a file gave."""
    group, ctx, rest = main, click.Context(main, info_name="pixstep"), words.split()
    for name in rest[:-1]:
        group = group.get_command(ctx, name)
        ctx = click.Context(group, info_name=name, parent=ctx)
    command = group.get_command(ctx, rest[-1])
    with command.make_context(rest[-1], [*given(words), *more], parent=ctx) as made:
        return made.params, {
            name
            for name in made.params
            if made.get_parameter_source(name) == ParameterSource.DEFAULT_MAP
        }


@pytest.mark.parametrize("words", MEANT)
@pytest.mark.parametrize("motor", [M39, M40, M41], ids=lambda motor: motor["name"])
def test_an_axis_is_its_motor(here, words, motor):
    """Whatever the motor's name gives a command, the number of its axis gives it too."""
    by_name, from_file = asked(words, "--motor", motor["name"])
    by_axis, _ = asked(words, "--axis", str(motor["axis"]))
    assert by_axis == by_name
    assert from_file >= {"port"} & {*by_name}
    assert int(motor["axis"]) in (by_axis.get("axis"), *_flat(by_axis.get("axis")),
                                  *_flat(by_axis.get("axes")))  # fmt: skip


def _flat(value):
    return value if isinstance(value, tuple) else ()


@pytest.mark.parametrize("words", MEANT)
def test_an_axis_without_a_motor_is_refused(here, invoke, words):
    said = invoke(*words.split(), *given(words), "--axis", "3", status=2).stderr
    assert said == (
        "pixstep: axis 3: machine.toml has no motor on this axis: M39 is axis 0, M40 is axis 1, "
        "M41 is axis 2 (--machine none does without the file)\n"
    )


@pytest.mark.parametrize("words", [*MEANT, STOP])
def test_a_name_and_an_axis_that_contradict_each_other(here, invoke, words):
    more = ("--motor", "M39", "--axis", "1")
    said = invoke(*words.split(), *given(words), *more, status=2).stderr
    assert said == (
        "pixstep: --axis 1: in machine.toml motor M39 is axis 0: leave --axis or --motor out\n"
    )
    params, _ = asked(words, "--motor", "M40", "--axis", "1")
    assert 1 in (params.get("axis"), *_flat(params.get("axis")), *_flat(params.get("axes")))


@pytest.mark.parametrize("words", TABLES)
def test_the_axes_of_a_table_are_their_motors(here, invoke, words):
    named, _ = asked(words, "--motor", "M40", "--motor", "M41")
    assert named["axis"] == (1, 2) and named["play"] == (22, 33)
    by_axis, _ = asked(words, "--axis", "1")
    assert by_axis == named | {"axis": (1,)}
    turned, _ = asked(words, "--axis", "2", "--axis", "0")
    assert turned["play"] == (33, 11)
    for more, said in (
        (("--axis", "2"), "axis 3: machine.toml has no motor on this axis"),
        (("--motor", "M40", "--motor", "M41", "--axis", "0"), "motor M40 is axis 1, motor M41"),
        (("--motor", "M40"), "2 lines for 1 motor: give --motor once for each line"),
    ):
        assert said in invoke(*words.split(), *given(words), *more, status=2).stderr


def test_any_axis_can_be_stopped(here):
    params, _ = asked(STOP, "--unit", "1", "--axis", "3")
    assert params["axes"] == (3,) and params["port"] == PORT


def test_without_a_file_an_axis_is_the_board_s(here):
    params, found = asked("sim", "--axis", "3", "--machine", "none", "--board", "mega", "--out",
                          "x", "--pixel-hz", "30", "--decode", "plain")  # fmt: skip
    assert params["axis"] == (3,) and not found


@pytest.mark.parametrize("words", ["sim", "board upload"])
def test_any_set_of_axes_has_its_motors(here, invoke, words):
    two = ("line.csv", "--axis", "2", "--axis", "1")
    params, _ = asked(words, *two)
    assert params["decode"] == ("smooth", "plain") and params["backlash"] == (33, 0)
    named, _ = asked(words, "line.csv", "--motor", "M41", "--motor", "M40")
    assert named == params and named["axis"] == (2, 1)
    row, _ = asked(words, "line.csv", "--axis", "0")
    assert row["decode"] == ("smooth", "plain")
    for more, said in (
        (("--axis", "2"), "axis 3: machine.toml has no motor on this axis"),
        (("--axis", "0", "--axis", "0"), "axis 0: has 2 lines, one is possible"),
        (("--motor", "M41", "--motor", "M40", "--axis", "1", "--axis", "2"), "contradict"),
        (("--motor", "M41", "--decode", "plain"), "2 lines for 1 motor: give --motor once"),
        (
            ("--decode", "plain"),
            "2 lines for 1 motor of machine.toml: give --motor or --axis once for each",
        ),
    ):
        done = invoke(*words.split(), "line.csv", "line.csv", *more, status=2).stderr
        assert said in done or (said == "contradict" and "leave --axis or --motor out" in done)


MOVES = [words for words in MEANT if "axis" in {param.name for param in COMMANDS[words].params}]


@pytest.mark.parametrize("words", MOVES)
def test_an_axis_that_several_boards_have(here, invoke, words):
    write(M39, M40, OTHER)
    said = invoke(*words.split(), *given(words), "--axis", "1", status=2).stderr
    assert "machine.toml has motors M40 of board a, Y of board b: choose by --motor" in said
    if "board" in words:
        params, _ = asked(words, "--axis", "1", "--unit", "2")
        assert params == asked(words, "--motor", "Y")[0] | {"unit": 2}
        said = invoke(*words.split(), *given(words), "--motor", "Y", "--unit", "1", status=2).stderr
        assert "--unit 1: in machine.toml motor Y is on board b, unit 2: leave --unit or" in said


@pytest.mark.parametrize("words", MOVES)
def test_one_of_several_motors_is_never_taken_by_chance(here, invoke, words):
    text = Path("machine.toml").read_text().replace('[line]\nmotor = "M39"\n', "")
    Path("machine.toml").write_text(text)
    said = invoke(*words.split(), *given(words), status=2).stderr
    assert "has motors M39, M40, M41: choose by --motor" in said


def test_a_bus_of_several_boards_is_meant_by_their_addresses(here):
    write(M39, M40, OTHER)
    params, _ = asked("board start", "--unit", "1,2", "--axis", "1")
    assert params["axes"] == (1,) and params["port"] == PORT and params["units"] == (1, 2)
    params, _ = asked("board log records", "--unit", "2")
    assert params["port"] == PORT


def test_the_play_of_the_axis_that_was_measured_is_saved(here, invoke, monkeypatch):
    """Without a board: what would be written, and into which motor."""
    from pixstep.operations.board.motion import MeasurePlay

    seen = []
    found = MeasurePlay.motor_to_save
    monkeypatch.setattr(
        MeasurePlay, "motor_to_save",
        lambda asked, desk: seen.append(found(asked, desk)) or seen[-1],
    )  # fmt: skip
    invoke("board", "measure-play", "--axis", "1", "--save", status=2)
    assert [(str(path), name) for path, name in seen] == [("machine.toml", "M40")]


# The interface for programs


@pytest.mark.parametrize("lines", ["in order", "by axis"])
def test_lines_of_motors_go_to_their_axes(here, simulator, lines):
    machine = px.Machine.load("machine.toml")
    made = [px.line([2, 4, 2], motor=machine[name], backlash=0) for name in ("M41", "M39")]
    found = made if lines == "in order" else {item.axis: item for item in made}
    run = px.simulate(found)
    assert [axis.axis for axis in run.axes] == [0, 2] and run.passed
    assert [axis.line.motor.name for axis in run.axes] == ["M39", "M41"]


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ({1: "M39"}, "is for motor M39, axis 0, not for axis 1"),
        (["M39", "M39"], "axis 0: has two lines, of motor M39"),
        (["M39", None], "has no motor, the others have: give lines by axis"),
        ([], "no line is given"),
    ],
)
def test_lines_that_name_an_axis_twice(here, axes, said):
    machine = px.Machine.load("machine.toml")

    def made(name):
        return px.line([2, 4, 2], motor=machine[name] if name else None, pixel_hz=30)

    lines = (
        {axis: made(name) for axis, name in axes.items()}
        if isinstance(axes, dict)
        else [made(name) for name in axes]
    )
    with pytest.raises(px.UserError, match=said):
        px.simulate(lines, board="mega")


def test_a_board_runs_a_line_on_its_motor_s_axis_only(here, one):
    made = px.line([2, 4, 2], motor=px.Machine.load("machine.toml")["M40"])
    with px.connect(PORT) as bus, pytest.raises(px.UserError, match="is for motor M40, axis 1"):
        bus.board(1).run(made, 0)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("axes", [(0, 2), (2, 0)])
def test_lines_on_axes_apart_run_together(here, invoke, axes):
    put([10, 30, 40, 40, 30, 10], "other.csv")
    put([2, 6, 8, 8, 6, 2], "other.csv")
    names = {0: "M39", 2: "M41"}
    motors = [word for axis in axes for word in ("--motor", names[axis])]
    words = ("sim", "other.csv", "line.csv", "--backlash", "0", "--no-check", *motors)
    assert invoke(*words).stdout.startswith("PASS")
    summary = json.loads(Path("run/summary.json").read_text())
    steps = {axis["axis"]: axis["steps"] for axis in summary["axes"]}
    assert steps == dict(zip(axes, (32, 160), strict=True))
