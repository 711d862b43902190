# SPDX-License-Identifier: MIT
"""`pixstep board` beside a machine file: another board than it says, and what JSON tells."""

import json
from pathlib import Path

import pytest

from command_tree import commands
from console import PORT, put
from pixstep import natives
from pixstep.cli.main import main

FAST = natives.root() / "tools/data/AccProf-fast-move.csv"
MACHINE = f"""\
[clock]
pixel = 30
[boards.main]
kind = "KIND"
port = "{PORT}"
unit = 1
[motors.M40]
axis = 0
kind = "plain"
"""


@pytest.fixture
def says(monkeypatch, one):
    """Return a function that makes a machine file which says what kind of board there is."""
    monkeypatch.delenv("PIXSTEP_PORT")
    return lambda kind: Path("machine.toml").write_text(MACHINE.replace("KIND", kind))


@pytest.mark.parametrize(
    "words",
    [
        ("upload", "line.csv"),
        ("move", FAST, "--steps", 40),
        ("home", FAST),
        ("set", "dir_setup_us=8"),
        ("get",),
        ("enable",),
        ("selftest", "--yes"),
    ],
)
def test_another_board_than_the_machine_says_is_refused(one, says, words):
    says("uno")
    put([5] * 6)
    before = dict(one.board.holdings)
    told = one.err(*words, status=3)
    assert told == (f"board 1 on {PORT} is a mega; machine.toml has boards.main as a uno")
    assert one.board.holdings == before and not one.board.commands


def test_it_is_stopped_and_shown_all_the_same(one, says):
    says("uno")
    note = "note: board 1 on /dev/ttyTEST is a mega; machine.toml has boards.main as a uno\n"
    assert note in one.run("stop", "--unit", 1).stderr
    assert one.board.commands[-1][0] == "stop"
    assert note in one.run("info").stderr


def test_a_board_that_no_machine_file_names_is_taken_as_it_is(one, says):
    says("uno")
    assert one.out("get", "board_id", "--machine", "none", "--port", PORT)
    assert one.out("get", "board_id", "--port", "/dev/other")


def test_json_names_the_machine_file_that_was_used(one, says):
    says("mega")
    asked = ("get", "board_id", "--json")
    assert json.loads(one.out(*asked))["machine"] == "machine.toml"
    given = ("--port", PORT, "--unit", 1, "--baud", 115200, "--parity", "E")
    assert json.loads(one.out(*asked, *given))["machine"] is None
    put([5] * 6)
    uploaded = json.loads(one.out("upload", "line.csv", "--decode", "plain", "--json"))
    assert uploaded["machine"] == "machine.toml"


# Motors of two boards, of which the file says no port

TWO_BOARDS = """\
[clock]
pixel = 30
[boards.a]
kind = "mega"
unit = 1
[boards.b]
kind = "uno"
unit = 2
[motors.X]
board = "a"
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }
[motors.Y]
board = "b"
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }
"""
GIVEN = {  # what a command needs to get as far as its board
    "get": ("board_id",),
    "home": (FAST,),
    "log clear": ("--yes",),
    "measure-play": (FAST,),
    "move": (FAST, "--steps", 40),
    "permit": ("on",),
    "run": ("corner.pmc",),
    "selftest": ("--yes",),
    "set": ("dir_setup_us=8",),
    "settings diff": ("settings.toml",),
    "settings export": ("out.toml",),
    "settings import": ("settings.toml",),
    "trajectory": ("circle.csv",),
    "upload": ("line.csv",),
    "watch": ("--count", 1),
}
ONLY_NOTED = ("info", "stop")
NOT_ASKED = ("scan", "simulate")  # a scan takes what answers; the bench is no board


def talking():
    """Return all commands of `board` with --motor, by their words."""
    return sorted(
        words
        for words, command in commands(main.get_command(None, "board")).items()
        if words not in NOT_ASKED and any("--motor" in param.opts for param in command.params)
    )


def change_over(two):
    """Let the boards change their addresses over."""
    first, second = (board.holdings for board in two.boards)
    first[0], second[0] = second[0], first[0]


@pytest.fixture
def files(tmp_path, two):
    """Make what the commands of `GIVEN` read."""
    Path("machine.toml").write_text(TWO_BOARDS)
    put([5] * 6)
    Path("corner.pmc").write_text("ABS LINEAR TA100 TS0 F20\nX1\n")
    Path("settings.toml").write_text("[settings]\ndir_setup_us = 8\n")
    Path("circle.csv").write_text("p1,v1,p2,v2\n0,0,0,0\n5,5,5,5\n10,0,10,0\n")


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", [words for words in talking() if words not in ONLY_NOTED])
@pytest.mark.parametrize("unit", [2, 1])
def test_a_motor_of_another_board_than_the_one_that_answers(two, words, unit):
    before = [dict(board.holdings) for board in two.boards]
    motors = ("--motor", "X") * (2 if words == "trajectory" else 1)
    given = (*words.split(), *GIVEN.get(words, ()), "--unit", unit, *motors)
    if unit == 2:
        told = two.err(*given, status=2)
        said = "in machine.toml motor X is on board a, unit 1: leave --unit or --motor out"
        assert told == f"--unit 2: {said}"
    else:
        change_over(two)
        told = two.err(*given, status=3)
        assert told == f"board 1 on {PORT} is a uno; machine.toml has boards.a as a mega"
        change_over(two)
    assert [dict(board.holdings) for board in two.boards] == before
    assert not any(board.commands for board in two.boards)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", ONLY_NOTED)
def test_it_is_only_noted_where_a_board_is_shown_or_stopped(two, words):
    note = f"note: board 2 on {PORT} is a uno; machine.toml has boards.a as a mega\n"
    assert note in two.run(words, "--unit", 2, "--motor", "X").stderr


@pytest.mark.usefixtures("files")
def test_the_motor_that_is_meant_needs_no_name_to_be_compared(two):
    text = TWO_BOARDS.replace("[motors.X]", '[line]\nmotor = "X"\n[motors.X]')
    Path("machine.toml").write_text(text)
    told = two.err("move", FAST, "--steps", 40, "--unit", 2, status=2)
    assert told == (
        "--unit 2: in machine.toml that is board b, motor X, which lines are for, is on board a: "
        "choose by --motor or --axis"
    )
    change_over(two)
    told = two.err("move", FAST, "--steps", 40, status=3)
    assert told == f"board 1 on {PORT} is a uno; machine.toml has boards.a as a mega"
    told = two.err("get", "board_id", "--unit", 1, status=3)
    assert told == f"board 1 on {PORT} is a uno; machine.toml has boards.a as a mega"


@pytest.mark.usefixtures("files")
def test_a_motor_s_own_board_gets_the_command(two):
    two.run("permit", "on", "--motor", "Y")
    assert [[name for name, *_ in board.commands] for board in two.boards] == [[], ["permit_on"]]


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("units", ["1,2", "2,1"])
def test_an_axis_of_several_boards_is_that_of_each(two, units):
    two.run("enable", "--axis", 0, "--unit", units)
    assert [[name for name, *_ in board.commands] for board in two.boards] == [["enable"]] * 2
    change_over(two)
    told = two.err("disable", "--axis", 0, "--unit", units, status=3)
    said = {
        "2,1": f"board 2 on {PORT} is a mega; machine.toml has boards.b as a uno",
        "1,2": f"board 1 on {PORT} is a uno; machine.toml has boards.a as a mega",
    }
    assert told == said[units]


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", [("start",), ("move", FAST, "--steps", 40), ("enable",)])
def test_two_motors_for_a_command_that_takes_one(two, words):
    told = two.err(*words, "--motor", "X", "--motor", "Y", status=2)
    assert "this command takes one motor" in told or "a run has one board" in told
    assert not any(board.commands for board in two.boards)
