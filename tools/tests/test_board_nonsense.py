# SPDX-License-Identifier: MIT
"""`pixstep board` beside devices that answer nonsense: one line of text, never a traceback."""

import random

import pytest

from console import put
from effort import cases
from pixstep import natives
from pixstep_trials.wire import seal

PROFILE = natives.root() / "tools/data/AccProf-fast-move.csv"
COMMANDS = {
    "scan": ("scan", "--unit", "1"),
    "info": ("info",),
    "get": ("get",),
    "set": ("set", "dir_hold_us=30", "--store"),
    "watch": ("watch", "--once"),
    "watch json": ("watch", "--once", "--json"),
    "export": ("settings", "export", "-"),
    "diff": ("settings", "diff"),
    "defaults": ("settings", "defaults"),
    "upload": ("upload", "line.csv", "--decode", "plain"),
    "run": ("upload", "line.csv", "--decode", "smooth", "--arm"),
    "start": ("start", "--wait"),
    "arm": ("arm",),
    "stop": ("stop", "--unit", "1"),
    "clear": ("clear",),
    "permit": ("permit", "on"),
    "move": ("move", PROFILE, "--steps", "40"),
    "home": ("home", PROFILE),
    "log": ("log",),
    "events": ("log", "events"),
    "selftest": ("selftest", "--yes"),
}
each_command = pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS.keys())
WRONG = {
    "another function": bytes([1, 3, 2, 0, 7]),
    "too few registers": bytes([1, 4, 2, 0, 7]),
    "no registers": bytes([1, 4, 0]),
    "too many registers": bytes([1, 4, 240]) + bytes(240),
    "an odd count": bytes([1, 4, 3, 0, 7, 9]),
    "a count beyond the frame": bytes([1, 4, 200, 0, 7]),
    "another address": bytes([1, 16, 0, 9, 0, 1]),
    "an empty identity": bytes([1, 17, 0]),
    "a short identity": bytes([1, 17, 1, 1]),
    "an exception of another function": bytes([1, 0x85, 2]),
    "exception 0": bytes([1, 0x84, 0]),
    "function 0": bytes([1, 0]),
    "a diagnosis": bytes([1, 8, 0, 11]),
    "identification": bytes([1, 43, 14, 2, 0x82, 0xFF, 0, 9]),
}


def endures(rig, words):
    """Run a command; it ends in order, and says why if it fails."""
    put([4, 8, 4])
    done = rig.finish(*words)
    assert done.exit_code in (0, 1, 2, 3)
    assert done.exit_code == 0 or done.output


@each_command
@pytest.mark.parametrize("reply", WRONG.values(), ids=WRONG.keys())
def test_a_whole_reply_that_does_not_fit_its_request(one, words, reply):
    one.line.garble = seal(reply)
    put([4, 8, 4])
    text = one.finish(*words).output
    wanted = ("unreadable", "nothing answers", "no reply", "exception", "another device")
    assert any(found in text for found in wanted), text


@pytest.mark.parametrize("seed", range(cases(4, 40)))
def test_replies_of_random_bytes(one, seed):
    rng = random.Random(seed)
    real = one.line.transmit

    def spoil(data, timeout=None):
        reply = real(data, timeout)
        if rng.random() < 0.2:
            return seal(bytes([1, rng.choice((data[1], rng.randrange(256)))])
                        + rng.randbytes(rng.randrange(40)))  # fmt: skip
        return reply

    one.line.transmit = spoil
    for words in COMMANDS.values():
        endures(one, words)


@each_command
@pytest.mark.parametrize("word", [0, 1, 77, 0x7FFF, 0x8000, 0xFFFF])
def test_every_register_says_the_same(one, words, word):
    """All but what names the board: its map, its axes."""
    real = one.board.read

    def read(inputs, first, count):
        found = real(inputs, first, count)
        kept = range(4) if inputs else range(0)
        return [
            old if first + index in kept else word
            for index, old in enumerate(found)
        ]  # fmt: skip

    one.board.read = read
    endures(one, words)


def test_watch_names_a_state_that_it_does_not_know(one):
    one.board.axis_value = lambda axis, name: 77
    assert "board 1 axis 0: state 77, position_steps 77" in one.out("watch", "--once")


def test_an_event_log_larger_than_any(one):
    one.board.values["event_capacity"] = 65535
    one.board.latch("starved")
    assert "starved" in one.out("log", "events")
    reads = [item for item in one.line.requests if item[1] == 4]
    assert max(int.from_bytes(item[2:4]) for item in reads) < 0x300 + 256 * 8 + 1


@pytest.mark.parametrize("count", [0, 5, 77, 0xFFFF])
def test_a_number_of_axes_that_no_board_has(one, count):
    one.board.axes = one.board.axes[:1]
    value = one.board.value
    one.board.value = lambda name: count if name == "axis_count" else value(name)
    assert one.err("info") == f"board 1 says that it has {count} axes: no board has"


def test_a_pixel_frequency_that_is_none(one):
    one.board.tick = lambda: None
    for address in range(2, 6):
        one.board.holdings[address] = 0
    text = one.err("upload", put([4, 4]), "--decode", "plain")
    assert text == "the pixel frequency is set to 0/0 Hz"
