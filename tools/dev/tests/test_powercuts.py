# SPDX-License-Identifier: MIT
"""Power cuts at random cycles of a store, and what the campaign says of half a record."""

import json

import pytest

from effort import TRIED_BOARDS, cases
from pixstep.board import settings
from pixstep_dev.robustness import powercuts

BOARDS = TRIED_BOARDS
CUTS = cases(25, 60)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_cuts_at_random_cycles(invoke, board):
    words = ("robustness", "powercuts", "--board", board, "--count", CUTS, "--seed", 4, "--json")
    done = invoke(*words)
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert outcome["old"] + outcome["new"] == outcome["cuts"] == CUTS
    assert outcome["old"] > CUTS // 2
    assert outcome["new"] > 0
    assert outcome["in_a_byte"] > CUTS // 2


@pytest.mark.usefixtures("simulator")
def test_settings_that_are_neither_are_a_complaint(monkeypatch):
    reads = iter(range(1000))
    monkeypatch.setattr(settings, "read", lambda _: {"number": next(reads)})
    outcome = powercuts.run(powercuts.PowercutsPlan("uno", 2))
    assert len(outcome.complaints) == 2
    assert "neither" in outcome.complaints[0]


def test_the_figures_are_said(invoke, monkeypatch):
    said = powercuts.PowercutsOutcome(powercuts.PowercutsPlan("uno", 3), 3, 2, 1, 2, [])
    monkeypatch.setattr(powercuts, "run", lambda *_: said)
    done = invoke("robustness", "powercuts", "--board", "uno", "--count", 3)
    assert done.exit_code == 0
    assert "2 times the old settings, 1 times the new" in done.stdout
