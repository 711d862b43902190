# SPDX-License-Identifier: MIT
"""Sequences of commands that once broke a promise, on the real images."""

import pytest

import orders_kept
from effort import TRIED_BOARDS
from pixstep_dev.robustness.orders import actions
from pixstep_dev.robustness.orders.actions import TELL, BoardOrder, PinInput, Wait
from pixstep_dev.robustness.orders.guard import Guard
from pixstep_dev.robustness.orders.world import OrdersWorld

pytestmark = pytest.mark.usefixtures("simulator")
CASES = [
    pytest.param(board, kept, id=f"{board}: {kept.name}")
    for kept in orders_kept.KEPT
    for board in kept.boards
]


@pytest.mark.parametrize(("board", "kept"), CASES)
def test_kept(board, kept):
    with OrdersWorld(board) as world:
        guard = Guard(world)
        guard.careful = kept.careful
        for action in kept.actions:
            guard.do(action)
        fault = guard.state.fault_name
        guard.recover()
    assert guard.complaints == []
    assert fault in (kept.faults or ("none",))


@pytest.mark.parametrize("board", TRIED_BOARDS)
def test_permit_has_no_pulse_beside_a_stop(board):
    """Switching PERMIT on is carried out at every place of the emergency stop's interrupt."""
    with OrdersWorld(board) as world:
        guard = Guard(world)
        for wait in range(0, 3000, 15):
            guard.do(BoardOrder("permit_on", 0))
            guard.do(BoardOrder("permit_on", 0, None, TELL))
            guard.do(Wait(wait))
            guard.do(PinInput("ESTOP", 0, 0))
            guard.do(Wait(8000))
            guard.do(actions.Look())
            guard.recover()
    assert guard.complaints == []


def test_actions_survive_json():
    for kept in orders_kept.KEPT:
        for action in kept.actions:
            assert actions.from_json(actions.as_json(action)) == action
