# SPDX-License-Identifier: MIT
"""Homing and play by switches that bounce, on every board, and what is said of a wrong one."""

import json

import pytest

from effort import cases
from pixstep.board import boards
from pixstep.simulation.simulator import Simulator
from pixstep_dev.robustness import homings

PLANTS = cases(2, 60)
# Bounces that end before the capture's interrupt has read the edge, within it, and long after it.
BOUNCES_TICKS = [(1, 100), (100, 600), (600, 20_000)]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("ticks", BOUNCES_TICKS)
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_every_switch_is_found_to_a_step(invoke, board, ticks):
    words = ("robustness", "homings", "--board", board, "--count", PLANTS, "--json")
    done = invoke(*words, "--seed", 3, "--bounce-ticks", *ticks)
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert sum(outcome["homed_off_steps"].values()) == outcome["plants"] == PLANTS
    assert sum(outcome["play_off_steps"].values()) == 2 * PLANTS
    assert all(abs(int(off)) <= 1 for off in outcome["homed_off_steps"])


@pytest.mark.usefixtures("simulator")
def test_a_motor_somewhere_else_is_a_complaint(monkeypatch):
    monkeypatch.setattr(Simulator, "plant", lambda *_: (123, 123))
    outcome = homings.run(homings.HomingsPlan("uno", 1))
    assert any("homed 123 steps off" in text for text in outcome.complaints)


@pytest.mark.usefixtures("simulator")
def test_a_fault_is_a_complaint(monkeypatch):
    knobs = homings.HomingPlant.knobs
    monkeypatch.setattr(
        homings.HomingPlant, "knobs", property(lambda self: knobs.fget(self) + ",stuck=home:open")
    )
    outcome = homings.run(homings.HomingsPlan("uno", 2))
    assert len(outcome.complaints) == 2
    assert "limit" in outcome.complaints[0] or "home_not_found" in outcome.complaints[0]


def test_the_figures_are_said(invoke, monkeypatch):
    said = homings.HomingsOutcome(
        homings.HomingsPlan("uno", 3), 3, {0: 2, -1: 1}, {0: 6}, ["plant 1: lost"]
    )
    monkeypatch.setattr(homings, "run", lambda *_: said)
    done = invoke("robustness", "homings", "--board", "uno", "--count", 3, status=1)
    assert "homed: -1 1 times, 0 2 times; play: 0 6 times" in done.stdout
    assert "FAIL: plant 1: lost" in done.stdout
