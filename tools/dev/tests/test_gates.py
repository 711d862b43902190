# SPDX-License-Identifier: MIT
"""Lines on a gated pixel clock, and what the campaign says of lines that are elsewhere."""

import json
from dataclasses import replace

import pytest

from effort import cases, only_long
from pixstep.board import boards
from pixstep_dev.robustness import gates as campaign

GATED = [name for name in boards.BOARD_NAMES if boards.load(name).all_features]
TRIALS = cases(3, 60)
LINES = cases(2, 5)
PIXELS = cases(30, 100)


def found(invoke, board, *more):
    words = ("robustness", "gates", "--board", board, "--json", *map(str, more))
    return json.loads(invoke(*words).stdout)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", GATED)
def test_every_line_is_on_its_burst(invoke, board):
    size = ("--count", TRIALS, "--lines", LINES, "--pixels", PIXELS, "--rest-s", 0.001, 0.2)
    outcome = found(invoke, board, *size, "--no-flaws", "--seed", 5)
    assert outcome["complaints"] == []
    assert outcome["right"] + outcome["faults"].get(campaign.LATE, 0) == TRIALS
    assert outcome["lines"] >= LINES * outcome["right"] > 0


@pytest.mark.usefixtures("simulator")
def test_flaws_are_named(invoke):
    size = ("--count", cases(6, 120), "--lines", 3, "--pixels", 30, "--rest-s", 0.001, 0.1)
    outcome = found(invoke, "mega", *size, "--seed", 3)
    assert outcome["complaints"] == []
    assert outcome["named"] > 0


# Whole lines of a scanner, with rests of up to five seconds.
@pytest.mark.usefixtures("simulator")
@only_long
@pytest.mark.parametrize("board", GATED)
def test_scans(invoke, board):
    outcome = found(invoke, board, "--count", 8, "--no-flaws", "--seed", 7)
    assert outcome["complaints"] == []


@pytest.mark.usefixtures("simulator")
def test_a_line_elsewhere_is_a_complaint(monkeypatch):
    """The judge expects line zero an edge later than the board was told."""
    real = campaign.GatesBench._judge

    def judge(bench, trial, *more, **options):
        later = replace(trial, gate_edges=trial.gate_edges + 1)
        real(bench, later, *more, **options)

    monkeypatch.setattr(campaign.GatesBench, "_judge", judge)
    plan = campaign.GatesPlan("mega", 1, 1, 20, flaws=("none",), rest_s=(0.05, 0.1))
    outcome = campaign.run_plan(plan)
    assert "clock periods off" in outcome.complaints[0]


def test_the_figures_are_said(invoke, monkeypatch):
    plan = campaign.GatesPlan("mega", 2)
    said = campaign.GatesOutcome(
        plan, 2, 1, 1, 20, 900, 1.25, 0.012, {"start_late": 1}, ["trial 1: off"]
    )
    monkeypatch.setattr(campaign, "run_plan", lambda *_: said)
    done = invoke("robustness", "gates", "--board", "mega", status=1)
    assert "2 trials, 1 right, 1 named (1 start_late)" in done.stdout
    assert "FAIL: trial 1: off" in done.stdout
