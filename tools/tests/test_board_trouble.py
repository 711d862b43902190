# SPDX-License-Identifier: MIT
"""`pixstep board` when something goes wrong in the middle: lost lines, silent boards, Ctrl-C."""

import json
import os
import pty
import tty

import pytest
from serial import SerialTimeoutException

from console import put
from fake_board import FakeBoard, FakeWorld
from pixstep.board import together
from pixstep.board.device import Device
from pixstep.board.errors import LineLostError
from pixstep.board.modbus import SerialClient
from pixstep.board.port import Port


def interrupt():
    raise KeyboardInterrupt


class Client(SerialClient):
    """A client that lets the other end answer as soon as a request is sent."""

    def write(self, frame):
        super().write(frame)
        self.answer()


class Terminal:
    """A pseudo terminal with a fake board behind it."""

    def __init__(self):
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)
        self.fake = FakeBoard(FakeWorld())
        self.client = Client(Port(self.name, timeout_s=5), retries=0)
        self.client.answer = self.answer
        self.client.connect()

    def answer(self):
        """Read a request and write the board's reply."""
        self.fake.world.wait(0.01)
        frame = os.read(self.master, 512)
        os.write(self.master, self.fake.answer(frame[0], frame[1:-2]) or b"")

    def unplug(self):
        """Let the other end go: reading and writing fail from now on, and so does opening."""
        os.close(self.master)
        os.close(self.slave)


@pytest.fixture
def terminal():
    made = Terminal()
    yield made
    made.client.close()


def test_a_line_that_goes_away_is_named_and_no_misuse(terminal):
    board = Device(terminal.client)
    assert board.who().board == "mega"
    terminal.unplug()
    with pytest.raises(LineLostError, match=f"board 1: {terminal.name} .* is gone: was it unplug"):
        board.input("status")
    with pytest.raises(LineLostError, match="there is no such port"):
        board.input("status")
    with pytest.raises(LineLostError, match="there is no such port"):
        board.stop_all()


def test_a_port_that_takes_no_bytes_is_not_gone(terminal, monkeypatch):
    board = Device(terminal.client)

    def block(_):
        raise SerialTimeoutException("Write timeout")

    monkeypatch.setattr(terminal.client.socket, "write", block)
    with pytest.raises(LineLostError, match="takes no bytes: nobody reads at its other end, or"):
        board.input("status")
    monkeypatch.undo()
    assert board.who().board == "mega"


def test_watch_goes_on_when_the_port_goes_away(terminal, make_console):
    console = make_console(None, terminal.fake.world)
    console.client = terminal.client
    terminal.fake.world.later(0.5, terminal.unplug)
    rows = [json.loads(row) for row in console.out("watch", "--count", 4, "--json").splitlines()]
    assert ["trouble" in row for row in rows] == [False, True, True, True]
    assert "is gone" in rows[1]["trouble"] and "there is no such port" in rows[3]["trouble"]


def test_watch_makes_no_rates_of_a_board_that_was_reset(one):
    one.board.clock = True

    def reset():
        one.board.value = lambda name, value=one.board.value: (
            3 if name == "pixel_edges" else value(name)
        )

    one.world.later(0.7, reset)
    rows = [json.loads(row) for row in one.out("watch", "--count", 3, "--json").splitlines()]
    assert [bool(row["rates_per_s"]) for row in rows] == [False, True, False]
    assert rows[2]["pixel_edges"] == 3 < rows[1]["pixel_edges"]


def test_settings_of_the_line_change_behind_a_pseudo_terminal(terminal, make_console):
    console = make_console(None, terminal.fake.world)
    console.client = terminal.client
    terminal.fake.holdings[13] = 1
    assert console.out("set", "parity=E") == "parity: 1 -> 2 (even)\n"
    assert terminal.client.port.parity == "N"


def test_a_board_that_is_lost_by_its_new_settings(one):
    answer = one.board.answer

    def fall_silent(unit, pdu):
        reply = answer(unit, pdu)
        if pdu[0] == 16:
            one.board.answer = lambda *_: None
        return reply

    one.board.answer = fall_silent
    text = one.err("set", "baud=19200")
    assert "it has taken the change and does not answer any more on /dev/ttyTEST" in text
    assert one.board.setting("baud_100") == 192


def test_a_board_that_is_not_known_to_have_stopped_is_named_first(two):
    """The middle of a long message is left out: what must be read stands before it."""
    two.boards[0].clock = two.boards[1].clock = True
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)
    two.world.later(1.5, lambda: setattr(two.boards[0], "answer", lambda *_: None))
    text = two.err("start", "--unit", "1,2", "--wait")
    said = "NOT STOPPED as far as is known: board 1 on /dev/ttyTEST "
    assert text.startswith(said) and " ... " not in text
    assert "board 2 axis 0 at position " in text and text.count("check its power") == 1


def test_ctrl_c_stops_the_boards_behind_a_silent_one(two):
    two.boards[0].clock = two.boards[1].clock = True
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)

    def silence_the_first():
        two.boards[0].answer = lambda *_: None
        interrupt()

    two.world.later(1.5, silence_the_first)
    text = two.ended("start", "--unit", "1,2", "--wait")
    assert "NOT STOPPED as far as is known: board 1 on /dev/ttyTEST" in text
    assert "board 2 axis 0 at position " in text
    assert two.boards[1].commands[-1] == ("stop", 1, 0)


def test_ctrl_c_before_go_disarms(two, monkeypatch):
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)
    monkeypatch.setattr(together, "_await_ready", lambda *_, **__: interrupt())
    assert "stopped by Ctrl-C" in two.ended("start", "--unit", "1,2")
    for board in two.boards:
        assert board.axes[0].state == "empty"
        assert "disarm" in [name for name, _, _ in board.commands]
        assert "go" not in [name for name, _, _ in board.commands]


@pytest.mark.parametrize(
    ("words", "command"),
    [
        (("stop",), "stop"),
        (("permit", "off"), "permit_off"),
        (("disable",), "disable"),
        (("clear",), "clear_fault"),
    ],
)
def test_a_silent_board_does_not_keep_a_command_from_the_others(two, words, command):
    done = two.run(*words, "--unit", "7,1,8,2", status=1)
    for board in two.boards:
        assert command in [name for name, _, _ in board.commands]
    complaints = done.stderr.splitlines()
    assert [text.partition(" on ")[0] for text in complaints] == [
        "pixstep: board 7",
        "pixstep: board 8",
    ]


def test_an_axis_with_a_fault_takes_no_line_and_says_why(one):
    one.out("upload", put([5] * 90), "--decode", "plain", "--arm", "--no-wait")
    one.board.latch("limit_plus", 0, 0, 3)
    text = one.err("upload", put([5] * 9), "--decode", "plain")
    assert text.startswith("board 1: axis 0 takes no line: fault limit_plus on axis 0 at pixel 3")
    assert text.endswith("Then `pixstep board clear`.")


@pytest.mark.parametrize("rates", ["9600,0", "9600,-4", "9600,", "x", "5000000"])
def test_scan_refuses_rates_that_no_port_has(one, rates):
    text = one.err("scan", "--bauds", rates, status=2)
    assert text.startswith(f"--bauds {rates}: rates from 300 to 4000000 baud are wanted")
    assert not one.line.requests
