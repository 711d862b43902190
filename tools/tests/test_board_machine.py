# SPDX-License-Identifier: MIT
"""`pixstep board` beside a machine file: another board than it says, and what JSON tells."""

import json
from pathlib import Path

import pytest

from console import PORT, put
from pixstep import natives

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
