# SPDX-License-Identifier: MIT
"""The console where replies are late, lost, unreadable, or among stray bytes."""

import os
import random
import subprocess
import sys
import time
from collections import Counter
from itertools import pairwise

import pytest

from bad_bus import Terminal
from console import put
from effort import cases
from pixstep import natives
from pixstep.board import registers as regs
from pixstep_trials.wire import seal

AXES = [f"axis{axis}.position_steps" for axis in range(4)]
PLACES = [8, 16, 24, 32]
TIMEOUT_S = 0.2
WORDS = ("--timeout", f"{TIMEOUT_S}s")


@pytest.fixture
def terminal(tmp_path, monkeypatch):
    """Yield a pseudo terminal with a fake Mega; the test sets `plan`."""
    monkeypatch.chdir(tmp_path)
    made = Terminal()
    monkeypatch.setenv("PIXSTEP_PORT", made.name)
    for axis, place in zip(made.board.axes, PLACES, strict=True):
        axis.position = place
    yield made
    made.close()


def is_order(frame, name):
    """True for a frame that gives an order."""
    return frame[1] == 16 and frame[2:4] == b"\x01\x00" and frame[10] == regs.COMMANDS[name]


def lose_first(terminal, wanted):
    """Lose the reply to the first request that is wanted."""
    lost = []

    def plan(_number, frame, reply):
        if not lost and wanted(frame):
            lost.append(frame)
            return []
        return [(0, reply)]

    terminal.plan = plan
    return lost


def orders(terminal, name):
    return [order for order, _, _ in terminal.board.commands if order == name]


# A late reply is nobody else's


@pytest.mark.parametrize("seed", range(cases(3, 30)))
def test_a_late_reply_is_not_that_to_the_next_request(terminal, invoke, seed):
    rng = random.Random(seed)
    held = rng.randint(1, 8)
    late_s = TIMEOUT_S * rng.uniform(1.02, 1.08)
    terminal.plan = lambda number, _, reply: [(late_s if number == held else 0, reply)]
    rows = invoke("board", "get", *AXES, *WORDS).stdout.splitlines()
    assert rows == [f"{name} = {place} steps" for name, place in zip(AXES, PLACES, strict=True)]


@pytest.mark.parametrize("seed", range(cases(3, 30)))
def test_a_refused_order_behind_a_late_reply_is_refused(terminal, invoke, seed):
    """The reply to `enable` comes late, nothing is loaded: `arm` is no success."""
    rng = random.Random(seed)
    late_s = TIMEOUT_S * rng.uniform(1.02, 1.08)
    late = []

    def plan(_number, frame, reply):
        if frame[1] == 16 and not late:
            late.append(frame)
            return [(late_s, reply)]
        return [(0, reply)]

    terminal.plan = plan
    invoke("board", "enable", "--axis", 0, *WORDS)
    assert late
    late.clear()
    text = invoke("board", "arm", "--axis", 0, *WORDS, status=3).stderr
    assert "arm: not possible now: axis 0 is empty" in text


# An order whose reply is lost


def line(tmp_name="line.csv"):
    return put([4, 12, 20, 24, 24, 24, 24, 20, 12, 4], tmp_name)


@pytest.mark.parametrize("pixel_hz", [30, 1000])
def test_upload_and_run_with_the_reply_to_arm_lost(terminal, invoke, pixel_hz):
    """Of a line that is over before the time-out, and of one that is not."""
    lost = lose_first(terminal, lambda frame: is_order(frame, "arm"))
    invoke("board", "set", f"pixel_hz={pixel_hz}", *WORDS)
    words = ("board", "upload", line(), "--decode", "plain", "--arm", *WORDS)
    assert "168 steps" in invoke(*words).stdout
    assert lost and orders(terminal, "arm") == ["arm"]
    assert terminal.board.axes[0].position == PLACES[0] + 168
    assert terminal.board.begun[0] == 1


def test_start_with_the_reply_to_arm_lost(terminal, invoke):
    invoke("board", "set", "pixel_hz=1000", *WORDS)
    invoke("board", "upload", line(), "--decode", "plain", *WORDS)
    lost = lose_first(terminal, lambda frame: is_order(frame, "arm"))
    text = invoke("board", "start", "--wait", *WORDS).stdout
    assert lost and text == f"board 1 axis 0: done, position {PLACES[0] + 168}\n"
    assert terminal.board.begun[0] == 1


def test_a_second_line_that_is_queued_does_not_begin_by_itself(terminal, invoke):
    invoke("board", "set", "pixel_hz=1000", *WORDS)
    for _ in range(2):
        invoke("board", "upload", line(), "--decode", "plain", *WORDS)
    lose_first(terminal, lambda frame: is_order(frame, "arm"))
    invoke("board", "arm", "--axis", 0, *WORDS)
    time.sleep(0.1)
    terminal.board.tick()
    assert terminal.board.axes[0].position == PLACES[0] + 168
    assert (terminal.board.begun[0], terminal.board.axes[0].state) == (1, "loaded")


def test_move_with_the_reply_to_arm_lost(terminal, invoke):
    lost = lose_first(terminal, lambda frame: is_order(frame, "arm"))
    profile = natives.root() / "tools/data/AccProf-fast-move.csv"
    text = invoke("board", "move", profile, "--steps", 40, *WORDS).stdout
    assert lost and text.endswith(f"from position {PLACES[0]} to {PLACES[0] + 40}\n")


@pytest.mark.parametrize("assigned", ["unit_address=5", "baud=19200"])
def test_a_changed_address_or_rate_with_its_reply_lost(terminal, invoke, assigned):
    lost = lose_first(terminal, lambda frame: frame[1] == 16)
    text = invoke("board", "set", assigned, *WORDS).stdout
    assert lost and " -> " in text
    assert terminal.board.holdings[0] == (5 if "5" in assigned.partition("=")[2][0] else 1)


def test_an_address_that_was_not_heard_is_sent_again(terminal, invoke):
    answer, missed = terminal.board.answer, []

    def deaf_once(unit, pdu):
        if pdu[0] == 16 and not missed:
            missed.append(pdu)
            return None
        return answer(unit, pdu)

    terminal.board.answer = deaf_once
    assert "unit_address: 1 -> 5" in invoke("board", "set", "unit_address=5", *WORDS).stdout
    assert missed and terminal.board.holdings[0] == 5


def test_settings_are_stored_once_with_the_reply_lost(terminal, invoke):
    lost = lose_first(terminal, lambda frame: is_order(frame, "store"))
    text = invoke("board", "set", "dir_hold_us=30", "--store", *WORDS).stdout
    assert lost and text.endswith("stored as record 1\n")
    assert orders(terminal, "store") == ["store"]


def test_another_fault_than_the_one_that_was_to_be_cleared_stays(terminal, invoke):
    terminal.board.latch("limit_plus")

    def plan(_number, frame, reply):
        if is_order(frame, "clear_fault") and terminal.board.fault[0] == 0:
            terminal.board.latch("limit_minus")
            return []
        return [(0, reply)]

    terminal.plan = plan
    text = invoke("board", "clear", *WORDS, status=1).stderr
    assert "limit_minus" in text and orders(terminal, "clear_fault") == ["clear_fault"]


# Stray bytes, unreadable replies


@pytest.mark.parametrize("strays", [b"\xff", b"\x00", b"\x00\xff\x00", b"\x01", b"\x01\x04\x20"])
def test_stray_bytes_before_each_reply(terminal, invoke, strays):
    terminal.plan = lambda _number, _frame, reply: [(0, strays + reply)]
    invoke("board", "set", "pixel_hz=1000", *WORDS)
    words = ("board", "upload", line(), "--decode", "plain", "--arm", *WORDS)
    assert "done, position" in invoke(*words).stdout
    frames = [frame for _, frame in terminal.frames]
    assert not any(one == following for one, following in pairwise(frames) if one[1] == 16)


def test_a_reply_that_comes_twice_counts_once(terminal, invoke):
    terminal.plan = lambda _number, _frame, reply: [(0, reply + reply)]
    rows = invoke("board", "get", *AXES, *WORDS).stdout.splitlines()
    assert rows == [f"{name} = {place} steps" for name, place in zip(AXES, PLACES, strict=True)]


def running(terminal, plan):
    """Run a line of some seconds with a plan from its beginning on; return the ended process."""
    put([5] * 300)

    def begin(number, frame, reply):
        if terminal.board.axes[0].state == "running":
            return plan(number, frame, reply)
        return [(0, reply)]

    terminal.plan = begin
    words = ("board", "upload", "line.csv", "--decode", "plain", "--arm", *WORDS)
    return subprocess.run(
        [sys.executable, "-m", "pixstep", *words], capture_output=True, text=True, check=False
    )


UNREADABLE = {
    "spoilt": lambda reply: reply[:-1] + bytes([reply[-1] ^ 0x10]),
    "cut": lambda reply: reply[:-3],
    "of another request": lambda _: seal(bytes([1, 4, 6, 0, 1, 0, 2, 0, 3])),
}


@pytest.mark.parametrize("spoil", UNREADABLE.values(), ids=UNREADABLE.keys())
def test_an_unreadable_reply_while_a_line_runs_is_asked_for_again(terminal, spoil):
    terminal.board.holdings[3] = 100
    spoilt = []

    def plan(_number, frame, reply):
        if frame[1] == 4 and not spoilt:
            spoilt.append(frame)
            return [(0, spoil(reply))]
        return [(0, reply)]

    done = running(terminal, plan)
    assert (done.returncode, done.stderr) == (0, "") and spoilt
    assert "done, position" in done.stdout


def test_a_host_that_gives_up_stops_the_motor_first(terminal):
    """Reads are no longer answered, but orders are."""
    terminal.board.holdings[3] = 20

    def plan(_number, frame, reply):
        return [] if frame[1] == 4 else [(0, reply)]

    done = running(terminal, plan)
    assert done.returncode == 1 and "no reply to read" in done.stderr
    assert "(stopped: " in done.stderr
    assert orders(terminal, "stop") and terminal.board.axes[0].state == "empty"
    assert terminal.board.fault[0] == 0


# Stop


@pytest.mark.parametrize("count", [1, 4])
def test_stop_is_sent_before_anything_is_asked(count):
    """And few enough requests follow that the command is back soon: the times are printed."""
    bus = Terminal(count)
    begun = time.monotonic()
    words = ("board", "stop", "--port", bus.name)
    done = subprocess.run(
        [sys.executable, "-m", "pixstep", *words], capture_output=True, text=True, check=True
    )
    took_s = time.monotonic() - begun
    bus.close()
    frames = [frame for _, frame in bus.frames]
    stops = len(set(regs.AXIS_COUNTS))
    assert all(frame[0] == 0 and is_order(frame, "stop") for frame in frames[:stops])
    assert 0 not in {frame[0] for frame in frames[stops:]}
    asked = Counter(frame[0] for frame in frames[stops:])
    silent = range(count + 1, 9)
    assert {unit: asked[unit] for unit in silent} == dict.fromkeys(silent, 1)
    assert max(asked) == 8 and sum(asked.values()) <= 8 + 7 * count
    assert done.stdout.count(": at rest: axis 0 at position 0") == count
    first_s, last_s = (bus.frames[at][0] - begun for at in (0, stops - 1))
    print(
        f"{count} boards: the stop was heard {1000 * first_s:.0f} to {1000 * last_s:.0f} ms after "
        f"the command's start, which was back after {took_s:.2f} s"
    )


def test_stop_of_all_boards_is_a_broadcast_too(terminal, invoke):
    invoke("board", "stop", "--unit", "all", "--no-look")
    terminal.close()
    assert {frame[0] for _, frame in terminal.frames} == {0}


@pytest.mark.skipif(os.name != "posix", reason="a port has one user")
def test_stop_goes_out_beside_a_command_that_has_the_port(terminal, invoke):
    terminal.board.holdings[3] = 5
    put([5] * 100)
    words = ("board", "upload", "line.csv", "--decode", "plain", "--arm", *WORDS)
    other = subprocess.Popen(
        [sys.executable, "-m", "pixstep", *words], stderr=subprocess.PIPE, text=True
    )
    while terminal.board.axes[0].state != "running":
        assert other.poll() is None, other.stderr.read()
        time.sleep(0.01)
    text = invoke("board", "stop", status=1).stderr
    assert "in use by another program: stop sent to all boards beside it" in text
    said = other.communicate()[1]
    assert "axis 0 is empty: stopped before its end" in said
    assert "stop" in orders(terminal, "stop") and terminal.board.axes[0].state == "empty"
