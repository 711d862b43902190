# SPDX-License-Identifier: MIT
"""Emergency stops at random cycles, and what the campaign says when a promise is broken."""

import json

import pytest

from pixstep.hostile import estops

BOARDS = ("uno", "mega")


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_stops_at_random_cycles(invoke, board):
    done = invoke("hostile", "estops", "--board", board, "--count", 60, "--seed", 7, "--json")
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert outcome["stops"] == 60
    assert outcome["moving"] > 40
    assert 0 < outcome["latest_cycles"] <= estops.BOUND_CYCLES
    assert 0 < outcome["permit_cycles"] <= estops.BOUND_CYCLES


@pytest.mark.usefixtures("simulator")
def test_an_edge_too_many_is_a_complaint(monkeypatch):
    monkeypatch.setattr(estops, "BOUND_CYCLES", -1_000_000)
    outcome = estops.run(estops.Plan("uno", 12))
    assert any("cycles behind it" in text for text in outcome.complaints)


@pytest.mark.usefixtures("simulator")
def test_a_wrong_position_is_a_complaint(monkeypatch):
    monkeypatch.setattr(estops.Simulator, "steps", lambda *_: 123_456_789)
    outcome = estops.run(estops.Plan("uno", 2))
    assert any("123456789 steps made" in text for text in outcome.complaints)


def test_the_figures_are_said(invoke, monkeypatch):
    said = estops.Outcome(estops.Plan("uno", 3), 3, 2, 641, 607, 1234, ["stop 1: lost"])
    monkeypatch.setattr(estops, "run", lambda *_: said)
    done = invoke("hostile", "estops", "--board", "uno", "--count", 3, status=1)
    assert "641 cycles" in done.stdout
    assert "FAIL: stop 1: lost" in done.stdout
