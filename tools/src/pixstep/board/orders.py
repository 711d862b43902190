# SPDX-License-Identifier: MIT
"""Orders that a board must not be given twice: sent once, and if the reply is lost, looked after.

The board carries out what it hears in turn, and the master drops what comes late. So what the board
says of itself afterwards tells whether it has carried out the order.
"""

from collections.abc import Callable, Sequence

from pixstep.board import registers as regs
from pixstep.board.device import STORING, Device
from pixstep.board.errors import IMPOSSIBLE, BoardError, ExceptionReplyError, NoReplyError

_TRIES = 4
_BEGUN = ("armed", "running", "done")
_FAULT = ("fault_code", "fault_argument", "fault_axis", "fault_pixel")


def arm(
    board: Device, axes: list[int], token: int = 0, known: Sequence[tuple[int, int]] | None = None
) -> None:
    """Arm axes. A line that has begun since, or is over already, was armed.

    `known` are the states of the axes and their lines done, from who has just asked for them.
    """
    before = _lines(board, axes) if known is None else list(known)
    _give(lambda: board.command("arm", axes, token), lambda: _lines(board, axes) != before)


def go(board: Device, token: int, edge: int) -> None:
    """Let axes go. A board that has been told so refuses it the second time, and its axes begin."""
    lost = False
    for last in (False, False, False, True):
        try:
            board.go(token, edge)
            return
        except NoReplyError:
            if last:
                raise
            lost = True
        except ExceptionReplyError as error:
            if lost and error.code == IMPOSSIBLE and _has_gone(board):
                return
            raise


def clear_fault(board: Device) -> None:
    """Clear the fault. Another one that has come since stays, and is raised."""
    before = _fault(board)

    def cleared() -> bool:
        now = _fault(board)
        if now[0] and now != before:
            raise BoardError(f"board {board.unit}: {board.fault_text()}")
        return not now[0]

    _give(lambda: board.command("clear_fault", [0]), cleared)


def store(board: Device, serial: int) -> None:
    """Begin to store the settings, the newest record being number `serial`."""
    _give(
        board.store,
        lambda: (
            bool(board.input("settings_state") & STORING)
            or board.input("settings_serial") != serial
        ),
    )


def _give(order: Callable[[], None], is_done: Callable[[], bool]) -> None:
    """Give an order once; again if the reply was lost and nothing has been done."""
    for last in (False,) * (_TRIES - 1) + (True,):
        try:
            order()
            return
        except NoReplyError:
            if is_done():
                return
            if last:
                raise


def _lines(board: Device, axes: list[int]) -> list[tuple[int, int]]:
    """Return of some axes what an order to arm them changes: the state, the lines done."""
    found = board.axes(max(axes) + 1)
    return [(found[axis]["axis_state"], found[axis]["lines_done"]) for axis in axes]


def _has_gone(board: Device) -> bool:
    """Whether a board without a fault has axes that wait for an edge, run or have run."""
    if board.input("fault_code"):
        return False
    found = board.axes(board.input("axis_count"))
    return any(regs.axis_state(axis["axis_state"]) in _BEGUN for axis in found)


def _fault(board: Device) -> tuple[int, ...]:
    state = board.inputs()
    return tuple(state[name] for name in _FAULT)
