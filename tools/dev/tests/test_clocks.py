# SPDX-License-Identifier: MIT
"""Pixel clocks of another frequency on every board, and what is said of one that is followed."""

import json

import pytest

from effort import cases
from pixstep.board import boards
from pixstep_dev.robustness import clocks

CLOCKS = cases(8, 250)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_each_wrong_clock_is_refused_or_named(invoke, board):
    words = ("robustness", "clocks", "--board", board, "--count", CLOCKS, "--seed", 7, "--json")
    done = invoke(*words)
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert sum(outcome["named"].values()) == CLOCKS and "" not in outcome["named"]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("moves", [False, True])
def test_the_right_clock_is_a_complaint(monkeypatch, moves):
    """A clock that nobody names: here because it is the right one."""
    trial = clocks.ClocksTrial("lock", 200, 1.0, moves, 0.5)
    monkeypatch.setattr(clocks, "make", lambda _: trial)
    monkeypatch.setattr(clocks.ClocksBench, "_change", lambda *_: None)
    outcome = clocks.run(clocks.ClocksPlan("mega", 1))
    assert len(outcome.complaints) == 1 and "not named" in outcome.complaints[0]


def test_the_figures_are_said(invoke, monkeypatch):
    said = clocks.ClocksOutcome(
        clocks.ClocksPlan("uno", 3), 3, 1, {"refused": 2, "": 1}, ["30 Hz: not named"]
    )
    monkeypatch.setattr(clocks, "run", lambda *_: said)
    done = invoke("robustness", "clocks", "--board", "uno", "--count", 3, status=1)
    assert "3 wrong clocks, 1 of them in motion" in done.stdout and "2 refused" in done.stdout
    assert "FAIL: 30 Hz: not named" in done.stdout
