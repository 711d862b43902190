# SPDX-License-Identifier: MIT
"""Ctrl-C, SIGTERM and SIGHUP stop what a command moves, each with its own exit status."""

import os
import signal
import subprocess
import sys
import time

import pytest

from console import put
from pixstep import natives, signals

LOOK_S = 0.02  # between two looks at what another process does; decides nothing
SIGNALS = [
    (signal.SIGINT, "Ctrl-C", 130),
    (signal.SIGTERM, "SIGTERM", 143),
    (signal.SIGHUP, "SIGHUP", 129),
]
each_signal = pytest.mark.parametrize(("number", "name", "status"), SIGNALS)


def send(number):
    """Return what sends a signal to this process."""
    return lambda: os.kill(os.getpid(), number)


@each_signal
def test_a_line_is_stopped(one, number, name, status):
    one.world.later(0.5, send(number))
    words = ("upload", put([5] * 60), "--decode", "plain", "--arm")
    text = one.ended(*words, status=status)
    assert text.startswith(f"stopped by {name}: board 1 axis 0 at position ")
    assert one.board.commands[-1] == ("stop", 1, 0) and one.board.axes[0].state == "empty"


@each_signal
def test_lines_of_several_boards_are_stopped(two, number, name, status):
    two.boards[0].clock = two.boards[1].clock = True
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)
    two.world.later(1.5, send(number))
    text = two.ended("start", "--unit", "1,2", "--wait", status=status)
    assert text.count(" axis 0 at position ") == 2 and f"stopped by {name}" in text
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


@each_signal
def test_a_move_is_stopped(one, number, name, status):
    one.world.later(0.3, send(number))
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    text = one.ended("move", profile, "--steps", 20_000, status=status)
    assert text.startswith(f"stopped by {name}: board 1 axis 0 at position ")
    assert one.board.axes[0].state == "empty"


@each_signal
def test_a_homing_is_stopped(one, number, name, status):
    one.world.later(0.3, send(number))
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    text = one.ended("home", profile, "--axis", 1, "--search", 20_000, status=status)
    assert text.startswith(f"stopped by {name}: board 1 axis 1 at position ")
    assert one.board.axes[1].state == "empty"


@each_signal
def test_a_selftest_stops_its_motor(one, number, name, status):
    one.board.clock = True
    one.world.later(4, send(number))
    answers = "n\n" * 3 + "y\n" * 3
    done = one.run("selftest", "--axis", 0, "--steps", 10_000, status=status, say=answers)
    assert done.stderr.endswith(f"pixstep: ended by {name}\n")
    assert "stop" in [found for found, _, _ in one.board.commands]
    assert one.board.axes[0].state == "empty" and one.board.drivers == 0


def test_a_second_signal_does_not_break_the_stopping_off(one):
    stop = one.board.obey_stop

    def stop_and_send_more(*arguments):
        for number, _, _ in SIGNALS:
            os.kill(os.getpid(), number)
        stop(*arguments)

    one.board.obey_stop = stop_and_send_more
    one.world.later(0.5, send(signal.SIGHUP))
    words = ("upload", put([5] * 60), "--decode", "plain", "--arm")
    assert "stopped by SIGHUP: board 1 axis 0 at" in one.ended(*words, status=129)
    assert one.board.axes[0].state == "empty"


def test_a_failure_of_the_program_stops_what_moves(one):
    def fail():
        raise OSError(5, "the terminal is gone")

    one.world.later(0.5, fail)
    text = one.err("upload", put([5] * 60), "--decode", "plain", "--arm", status=2)
    assert text == "the terminal is gone"
    assert one.board.commands[-1] == ("stop", 1, 0)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_watching_ends_by_ctrl_c(one, number, status):
    one.world.later(2, send(number))
    assert "board 1 axis 0: empty" in one.out("watch", "--interval", 1, status=status)


def test_a_log_keeps_its_rows(one, tmp_path):
    one.out("upload", put([3] * 90), "--decode", "plain", "--arm", "--no-wait")
    one.world.later(1, send(signal.SIGTERM))
    one.run("log", "--axis", 0, "-o", "log.csv", status=143)
    assert len((tmp_path / "log.csv").read_text().splitlines()) > 10


def test_handlers_are_as_before(one):
    before = [signal.getsignal(number) for number, _, _ in SIGNALS]
    one.world.later(0.5, send(signal.SIGTERM))
    one.ended("upload", put([5] * 60), "--decode", "plain", "--arm", status=143)
    assert [signal.getsignal(number) for number, _, _ in SIGNALS] == before


def test_a_signal_that_is_ignored_stays_ignored(monkeypatch):
    old = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with signals.caught():
            os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, old)


def test_a_system_without_sighup(monkeypatch):
    monkeypatch.delattr(signal, "SIGHUP")
    with signals.caught(), pytest.raises(signals.EndedBySignal):
        os.kill(os.getpid(), signal.SIGTERM)
    with signals.ignored():
        os.kill(os.getpid(), signal.SIGTERM)


@each_signal
def test_a_simulation_leaves_nothing_behind(simulator, tmp_path, number, name, status):
    (tmp_path / "long.csv").write_text("".join(f"{9:6d}\r\n" for _ in range(200_000)), newline="")
    words = ("sim", "long.csv", "--decode", "plain", "--pixel-hz", "30", "--board", "uno")
    process = subprocess.Popen(
        [sys.executable, "-m", "pixstep", *words, "--out", "out"],
        cwd=tmp_path, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while not list(tmp_path.glob("out/.pixstep-part-*/.run-*/edges.csv")):
        assert process.poll() is None
        time.sleep(LOOK_S)
    process.send_signal(number)
    _, errors = process.communicate()
    assert process.returncode == status and errors == f"pixstep: ended by {name}\n"
    assert not (tmp_path / "out").exists()
