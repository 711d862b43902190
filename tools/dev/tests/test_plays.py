# SPDX-License-Identifier: MIT
"""Axes with play that are stopped anywhere, and what the campaign says when a load is elsewhere."""

import json

import pytest

from effort import TRIED_BOARDS, cases
from pixstep.board.device import Device
from pixstep.lines.line import SMOOTH, Line
from pixstep_dev.robustness.plays import campaign, motions
from pixstep_dev.robustness.plays.load import PlayLoad, follow

SEQUENCES = cases(5, 60)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", TRIED_BOARDS)
def test_random_sequences(invoke, board):
    words = ("robustness", "plays", "--board", board, "--count", SEQUENCES, "--seed", 5, "--json")
    outcome = json.loads(invoke(*words).stdout)
    assert outcome["complaints"] == []
    assert outcome["sequences"] == SEQUENCES
    assert outcome["lines"] > outcome["warned"] > 0
    assert outcome["edges"] > 4 * SEQUENCES
    assert set(outcome["ends"]) >= {"none", "stop", "estop"}


def test_a_load_stands_still_in_its_play():
    load = PlayLoad(play=3, slack=-1)
    rows = ["5,0,0,STEP,1", "6,0,0,STEP,0", "7,0,0,STEP,1", "8,0,0,DIR,1"]
    follow([*rows, *(f"{cycle},0,0,STEP,1" for cycle in (10, 11, 12, 13))], {0: load})
    assert load.places == [0, 1, 1, 1, 1, 0]
    assert load.lacking(-1) == 0
    assert load.lacking(1) == 3
    assert [load.at(cycle) for cycle in (4, 5, 9, 13)] == [None, 0, 1, 0]


def test_where_a_load_must_be():
    """V 40, 10 of 20 steps lacking: the ramp begins a quarter of a pixel early."""
    line = Line((0, 10, 30, 40, 30, 10, 0), SMOOTH, backlash=20)
    clock = motions.ClockEdges(first=100, pixel=1000)
    first = 100 + 5000 + 750 + 317
    found = list(motions.edges(motions.PlayMotion((line,)), first, 10, clock))
    assert [cycle // 1000 for cycle, _ in found] == [8, 9, 10, 11, 12]
    assert [way for _, way in found] == [40, 80, 110, 120, 120]


@pytest.mark.usefixtures("simulator")
def test_a_load_elsewhere_is_a_complaint(monkeypatch):
    lacking = PlayLoad.lacking
    monkeypatch.setattr(
        PlayLoad, "lacking", lambda load, sign: lacking(load, sign) + 2 * (sign < 0)
    )
    outcome = campaign.run(campaign.PlaysPlan("uno", 4))
    assert any("steps off at cycle" in text for text in outcome.complaints)


@pytest.mark.usefixtures("simulator")
def test_a_board_that_does_not_know_is_a_complaint(monkeypatch):
    real = Device.input

    def says_unknown(board, name):
        return 0xF000 if name == "status" else real(board, name)

    monkeypatch.setattr(Device, "input", says_unknown)
    outcome = campaign.run(campaign.PlaysPlan("uno", 4))
    assert any("unknown to the board" in text for text in outcome.complaints)


def test_the_figures_are_said(invoke, monkeypatch):
    said = campaign.PlaysOutcome(
        campaign.PlaysPlan("uno", 3), 3, 20, 2, 345, 1, {"stop": 7}, ["act 1: off"]
    )
    monkeypatch.setattr(campaign, "run", lambda *_: said)
    done = invoke("robustness", "plays", "--board", "uno", "--count", 3, status=1)
    assert "20 lines with backlash, of 2 the board did not know" in done.stdout
    assert "FAIL: act 1: off" in done.stdout
