# SPDX-License-Identifier: MIT
"""Emergency stops at random cycles, and what the campaign says when a promise is broken."""

import json

import pytest

from effort import TRIED_BOARDS, cases
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.simulation.simulator import Simulator
from pixstep_dev.robustness import estops

BOARDS = TRIED_BOARDS
STOPS = cases(20, 60)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_stops_at_random_cycles(invoke, board):
    done = invoke("robustness", "estops", "--board", board, "--count", STOPS, "--seed", 7, "--json")
    outcome = json.loads(done.stdout)
    assert done.exit_code == 0, outcome["complaints"]
    assert outcome["stops"] == STOPS
    assert outcome["moving"] > STOPS // 2
    assert 0 < outcome["latest_cycles"] <= estops.ESTOP_CYCLES
    assert 0 < outcome["permit_cycles"] <= estops.ESTOP_CYCLES


STEP_CYCLES = 80_000  # between two steps of two in a pixel of 10 ms


class AtCommands(estops.Stopper):
    """Slow lines: each step has commands around it, which the step interrupt needs time for."""

    def stop_behind_a_step(self, counts, offset, outcome):
        for axis in self.axes:
            LineUpload(self.board, axis, queue_entries(Line(counts, PLAIN))).push()
        self.board.command("arm", self.axes)
        made = self.sim.count(0, 0)
        while self.sim.count(0, 0) < made + 2:
            self.sim.run(STEP_CYCLES // 4)
        newest = self.newest_edge()
        trip = newest + 2 * STEP_CYCLES + offset
        self.press(trip)
        self.judge(trip, outcome, f"{counts[:2]}, {offset} cycles behind a step")
        self.recover()

    def newest_edge(self):
        self.sim.command("flush")
        rows = [row.split(",") for row in self.log]
        return max(int(row[0]) for row in rows if row[3] == "STEP" and row[4].strip() == "1")


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("counts", [(-2,) * 20, (2, -2) * 10])
@pytest.mark.parametrize(("board", "stride"), [("uno", 5), ("mega", 23), ("m1284", 17)])
def test_stops_while_a_command_is_taken(tmp_path, board, stride, counts):
    """The stop's interrupt comes at every place of the step interrupt's longest way."""
    outcome = estops.EstopsOutcome(estops.EstopsPlan(board, 1))
    with AtCommands(board, tmp_path / "edges.csv") as stopper:
        for offset in range(-700, 700, cases(7 * stride, stride)):
            stopper.board.command("permit_on", [])
            stopper.stop_behind_a_step(counts, offset, outcome)
    assert outcome.complaints == []


@pytest.mark.usefixtures("simulator")
def test_an_edge_too_many_is_a_complaint(monkeypatch):
    monkeypatch.setattr(estops, "ESTOP_CYCLES", -1_000_000)
    outcome = estops.run(estops.EstopsPlan("uno", 12))
    assert any("cycles behind it" in text for text in outcome.complaints)


@pytest.mark.usefixtures("simulator")
def test_a_wrong_position_is_a_complaint(monkeypatch):
    monkeypatch.setattr(Simulator, "steps", lambda *_: 123_456_789)
    outcome = estops.run(estops.EstopsPlan("uno", 2))
    assert any("123456789 steps made" in text for text in outcome.complaints)


def test_the_figures_are_said(invoke, monkeypatch):
    said = estops.EstopsOutcome(estops.EstopsPlan("uno", 3), 3, 2, 641, 607, 1234, ["stop 1: lost"])
    monkeypatch.setattr(estops, "run", lambda *_: said)
    done = invoke("robustness", "estops", "--board", "uno", "--count", 3, status=1)
    assert "641 cycles" in done.stdout
    assert "FAIL: stop 1: lost" in done.stdout
