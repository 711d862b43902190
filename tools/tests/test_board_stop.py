# SPDX-License-Identifier: MIT
"""`pixstep board stop`: one stop is sent, and what rests is asked for."""

from itertools import pairwise
from pathlib import Path

import pytest

from console import PORT, put
from fake_modbus import FAILURE, RefusalError
from pixstep import natives
from pixstep.board import registers as regs
from pixstep_trials.wire import seal

# A frame for what every board has, one for what each larger kind of board adds.
BROADCAST = [(1 << more) - (1 << axes) for axes, more in pairwise((0, *regs.AXIS_COUNTS))]


def stops(board):
    """Return the masks of the stops that a board has taken."""
    return [mask for name, mask, _ in board.commands if name == "stop"]


def run_a_line(rig, *units):
    for unit in units:
        words = ("upload", put([5] * 300), "--decode", "plain", "--unit", unit, "--arm")
        rig.out(*words, "--no-wait")


def test_a_broadcast_stops_each_axis_once_and_looks(two):
    run_a_line(two, 1, 2)
    lines = two.out("stop").splitlines()
    assert lines[0] == "/dev/ttyTEST: stop sent to all boards"
    assert lines[1].startswith("board 1: at rest: axis 0 at position ")
    assert lines[1].endswith("axis 1 at position 0, axis 2 at position 0, axis 3 at position 0")
    assert lines[2].startswith("board 2: at rest: axis 0 at position ")
    assert stops(two.boards[0]) == BROADCAST
    assert two.boards[1].axes[0].state == "empty"


def test_a_board_that_has_not_heard_the_broadcast_is_stopped_by_its_address(two):
    run_a_line(two, 1, 2)
    answer = two.boards[1].answer
    two.boards[1].answer = lambda unit, pdu: answer(unit, pdu) if unit else None
    done = two.run("stop")
    assert done.stderr == "pixstep: board 2: it has not heard the broadcast\n"
    assert "board 2: at rest: axis 0 at position " in done.stdout
    assert stops(two.boards[1]) == [1]
    assert stops(two.boards[0]) == BROADCAST


def test_what_does_not_rest_is_named(one):
    run_a_line(one, 1)
    one.board.obey_stop = lambda *_: None
    for words in (("stop",), ("stop", "--unit", 1)):
        done = one.run(*words, status=1)
        assert "board 1: NOT at rest: axis 0 is running at position " in done.stderr
        assert "board 1: at rest: axis 1 at position 0, axis 2 at position 0" in done.stdout


def test_an_axis_that_goes_on_although_it_says_otherwise_is_named(one):
    axis = one.board.axes[2]
    one.world.later(0.03, lambda: setattr(axis, "position", axis.position - 7))
    text = one.run("stop", "--unit", 1, status=1).stderr
    assert "board 1: NOT at rest: axis 2 is empty at position -7" in text


def test_a_stop_by_address_is_one_stop(one):
    run_a_line(one, 1)
    assert "board 1: at rest: axis 0 at position" in one.out("stop", "--unit", 1)
    assert stops(one.board) == [0b1111]
    assert one.out("stop", "--unit", 1, "--no-look") == "board 1: stop acknowledged\n"


def test_a_stop_that_was_heard_is_not_repeated_when_its_reply_is_lost(one):
    run_a_line(one, 1)
    stop = one.board.obey_stop

    def stop_and_lose_the_reply(*arguments):
        stop(*arguments)
        one.line.lose = 1

    one.board.obey_stop = stop_and_lose_the_reply
    assert "board 1: at rest" in one.out("stop", "--unit", 1)
    assert stops(one.board) == [0b1111]


def test_a_stop_that_was_not_heard_is_repeated(one):
    run_a_line(one, 1)
    answer = one.board.answer
    heard = []

    def miss_the_first_stop(unit, pdu):
        heard.append(pdu[0])
        return None if heard.count(16) == 1 and pdu[0] == 16 else answer(unit, pdu)

    one.board.answer = miss_the_first_stop
    assert "board 1: at rest" in one.out("stop", "--unit", 1)
    assert stops(one.board) == [0b1111] and heard.count(16) == 2


def test_a_refused_stop_ends_with_its_reason(one):
    run_a_line(one, 1)
    answer = one.board.answer
    one.board.answer = lambda unit, pdu: (
        seal(bytes([1, 0x90, 4])) if pdu[0] == 16 else answer(unit, pdu)
    )
    text = one.err("stop", "--unit", 1, status=3)
    assert text == "board 1: write at 0x0100 answered with exception 4, device failure"
    assert stops(one.board) == []


def test_a_silent_board_is_named(one):
    one.board.answer = lambda *_: None
    assert one.err("stop", "--unit", 1).startswith("board 1 on /dev/ttyTEST")
    text = one.err("stop")
    assert "no board answers at addresses 1 to 8: `pixstep board stop --unit all` looks" in text
    text = one.run("stop", "--unit", "all", status=1).stderr
    assert text.endswith(": no board answers at any address\n")


MACHINE_17 = f"""\
[clock]
pixel = "30 Hz"
[boards.near]
kind = "mega"
port = "{PORT}"
[boards.far]
kind = "uno"
port = "{PORT}"
unit = 17
[boards.elsewhere]
kind = "uno"
port = "/dev/ttyOTHER"
unit = 99
[motors.X]
board = "near"
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
"""


def asked(rig):
    """Return the addresses that were asked for something."""
    return {frame[0] for frame in rig.line.requests} - {0}


def test_boards_of_the_machine_file_are_looked_at_too(two):
    two.boards[1].holdings[0] = 17
    assert "board 17" not in two.out("stop")
    assert asked(two) == set(range(1, 9))
    Path("machine.toml").write_text(MACHINE_17)
    assert "board 17: at rest: axis 0 at position 0" in two.out("stop")
    assert asked(two) == {*range(1, 9), 17}
    assert "board 17: at rest" in two.out("stop", "--machine", "none", "--unit", "all")
    assert asked(two) == set(range(1, 248))


def test_a_mistake_in_the_machine_file_does_not_keep_stop_from_looking(one):
    Path("machine.toml").write_text("[clock\n")
    assert "board 1: at rest: axis 0" in one.out("stop")


# Ended while a line is queued: a part of one must not stay, or the board refuses the next


PROGRAM_MACHINE = f"""\
[clock]
pixel = "200 Hz"
[boards.main]
kind = "mega"
port = "{PORT}"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = {{ max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }}
"""
QUEUEING = (
    ("upload", "line.csv", "--decode", "plain"),
    ("upload", "line.csv", "--decode", "plain", "--arm"),
    ("move", natives.root() / "tools/data/AccProf-fast-move.csv", "--steps", 40),
    ("run", "line.pmc", "--machine", "program.toml"),
)
SEEKING = (natives.root() / "tools/data/AccProf-fast-move.csv", "--search", 200)
RUNNING = (*QUEUEING[1:], ("home", *SEEKING), ("measure-play", *SEEKING))


@pytest.fixture
def files(one):
    put([5, 6] * 50)
    Path("line.pmc").write_text("INC TS0 TA20 TM40\n" + "X0.05\nX0.1\n" * 300)
    Path("program.toml").write_text(PROGRAM_MACHINE)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", QUEUEING)
def test_ctrl_c_while_a_line_is_queued_leaves_no_part_of_it(one, words):
    queue = one.board.queue

    def interrupted(data):
        queue(data)
        raise KeyboardInterrupt

    one.board.queue = interrupted
    assert one.ended(*words).startswith("stopped by Ctrl-C: board 1 axis 0 at position 0")
    assert one.board.commands == [("stop", 1, 0)]
    assert one.board.axes[0].entries == []


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", QUEUEING)
def test_an_axis_with_a_part_of_a_line_takes_no_other(one, words):
    if words[0] == "run":
        one.run("set", "pixel_hz=200")
    one.board.axes[0].state = "loading"
    assert one.err(*words) == (
        "board 1: axis 0 has a part of a line queued, whose upload was broken off: `pixstep board "
        "disarm --axis 0` discards it"
    )
    assert one.board.axes[0].entries == []


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("state", ["loaded", "armed"])
@pytest.mark.parametrize("words", RUNNING)
def test_what_runs_at_once_finds_its_axis_idle(one, words, state):
    if words[0] == "run":
        one.run("set", "pixel_hz=200")
    one.board.axes[0].state = state
    text = one.err(*words)
    assert text.startswith("board 1: axis 0 ") and state in text and "`pixstep board" in text
    assert one.board.axes[0].entries == [] and one.board.axes[0].state == state
    assert one.board.commands == []


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("words", RUNNING)
def test_a_line_that_the_board_does_not_arm_is_discarded(one, words):
    if words[0] == "run":
        one.run("set", "pixel_hz=200")
    one.board.latch("limit_minus", 3, 2, 77)
    text = one.err(*words)
    assert text.startswith("board 1: arm: fault limit_minus on axis 2 at pixel 77: ")
    assert one.board.axes[0].entries == [] and one.board.axes[0].state == "empty"


@pytest.mark.usefixtures("files")
def test_a_program_that_the_board_refuses_leaves_no_part_of_it(one):
    def refusing(_data):
        raise RefusalError(FAILURE)

    one.board.queue = refusing
    assert "exception 4" in one.err("run", "line.pmc", "--machine", "program.toml", status=3)
    assert one.board.commands == [("disarm", 1, 0)]


@pytest.mark.parametrize("command", ["home", "measure-play"])
def test_ctrl_c_in_a_seek_is_a_stop_with_its_status(one, command):
    def interrupted(_data):
        raise KeyboardInterrupt

    one.board.queue = interrupted
    assert one.ended(command, *SEEKING) == "stopped by Ctrl-C: board 1 axis 0 at position 0"
