# SPDX-License-Identifier: MIT
"""Starts of several boards on one clock edge, and what is said of boards that begin apart."""

import json

import pytest

from effort import cases
from pixstep.board import clock_marks, together
from pixstep_dev.robustness import starts

STARTS = cases(5, 400)
KINDS = [("uno", "mega"), ("mega", "m1284"), ("m1284", "uno")]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("kinds", KINDS, ids="+".join)
def test_no_board_begins_apart_in_silence(invoke, kinds):
    chosen = [word for kind in kinds for word in ("--board", kind)]
    done = invoke("robustness", "starts", *chosen, "--count", STARTS, "--seed", 11, "--json")
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert outcome["together"] + outcome["named"] + outcome["named_moved"] == STARTS
    assert outcome["together"] > STARTS // 4 and outcome["apart_edges"] < 0.1


@pytest.mark.usefixtures("simulator")
def test_a_board_that_is_told_another_edge_is_a_complaint(monkeypatch):
    """Neither the boards nor the host would notice: the judge looks at STEP edges alone."""
    number = clock_marks.number
    told = []

    def another(first, mark, ahead):
        told.append(mark)
        return number(first, mark, ahead) + (mark is not first)

    monkeypatch.setattr(clock_marks, "number", another)
    monkeypatch.setattr(together.Together, "compare", lambda *_: None)
    monkeypatch.setattr(starts, "FLAWS", ("none",))
    outcome = starts.run_plan(starts.StartsPlan(("mega",), 2, 4))
    assert told and any("clock periods apart in silence" in text for text in outcome.complaints)


def test_the_figures_are_said(invoke, monkeypatch):
    plan = starts.StartsPlan(("uno",), 3)
    said = starts.StartsOutcome(plan, 3, 1, 1, 1, {"board #: late": 2}, 0.01, ["start 2: apart"])
    monkeypatch.setattr(starts, "run_plan", lambda *_: said)
    done = invoke("robustness", "starts", "--count", 3, status=1)
    assert "3 starts: 1 together (at most 0.010 clock periods apart)" in done.stdout
    assert "2 board #: late" in done.stdout and "FAIL: start 2: apart" in done.stdout
