# SPDX-License-Identifier: MIT
"""Sequences of commands that once broke a promise; replayed first of all."""

from dataclasses import dataclass

from clock import TICK_HZ
from pixstep_dev.robustness.orders.actions import (
    ASK,
    TELL,
    Action,
    BoardOrder,
    ClockCommand,
    Coils,
    Frequency,
    Look,
    QueueBlock,
    Setting,
    StepWait,
    Wait,
)

BOTH = ("uno", "mega")
MEGA = ("mega",)
_WATCH = (Look(), Wait(TICK_HZ // 20), Look())
_BUSY_AGAIN = TICK_HZ // 50
_REFUSED = ((0x7FFF, 0),)
_TOKEN = 77


@dataclass(frozen=True)
class Kept:
    """A sequence, the boards that it is for, and what must be true besides the model's rules.

    `careful`: what a refusal must leave as it was is compared. `faults`: one of them must be
    latched in the end; empty: none.
    """

    name: str
    boards: tuple[str, ...]
    actions: tuple[Action, ...]
    careful: bool = False
    faults: tuple[str, ...] = ()


def _plain(count: int, pixels: int = 1000, mark: int = 1) -> tuple[tuple[int, int], ...]:
    return ((mark, 0), (0, 0), (count, pixels), (2, 0))


def _moving(count: int, more: int) -> tuple[Action, ...]:
    """300 steps/s for a count of 10: a period that the timer can hold whole."""
    return (
        Frequency(30, TELL),
        QueueBlock(0, _plain(count), 0, TELL),
        BoardOrder("arm", 1, None, TELL),
        StepWait(0, TICK_HZ, more),
    )


_ENDS = {
    "coil stop": Coils(8, (1,), TELL),
    "stop": BoardOrder("stop", 1, None, TELL),
    "disarm": BoardOrder("disarm", 1, None, TELL),
    "discard": BoardOrder("discard", 1, None, TELL),
    "coil disarm": Coils(4, (0,), TELL),
}

KEPT = (
    *(
        Kept(f"{name} behind a stop", BOTH, (*_moving(10, 10_000), _ENDS["stop"], end, *_WATCH))
        for name, end in _ENDS.items()
    ),
    *(
        Kept(
            f"{name} twice before the first step",
            BOTH,
            (
                Frequency(10, TELL),
                QueueBlock(0, ((1, 0), (0, 0), (0, 5), (1, 1), (0, 5), (1, 1), (2, 0)), 0, TELL),
                BoardOrder("arm", 1, None, TELL),
                Wait(280_000),
                end,
                Wait(400),
                end,
                *_WATCH,
            ),
        )
        for name, end in (("coil stop", _ENDS["coil stop"]), ("stop", _ENDS["stop"]))
    ),
    Kept(
        "a line queued behind a stop",
        BOTH,
        (
            *_moving(10, 10_000),
            _ENDS["stop"],
            QueueBlock(0, _plain(7), 0, ASK),
            BoardOrder("arm", 1),
            *_WATCH,
            Wait(_BUSY_AGAIN),
        ),
    ),
    Kept(
        "a refused block for an armed axis that waits for no clock",
        BOTH,
        (
            Frequency(30, TELL),
            QueueBlock(0, _plain(10), 0, ASK),
            BoardOrder("arm", 1, None, TELL),
            QueueBlock(0, _REFUSED, 0, TELL),
            *_WATCH,
            Wait(TICK_HZ // 10),
            Look(),
        ),
    ),
    *(
        Kept(
            f"a refused block for one of two axes armed together, {wait} cycles later",
            MEGA,
            (
                Frequency(100, TELL),
                ClockCommand("hz 100/1"),
                QueueBlock(0, _plain(10, mark=0x21), 0, ASK),
                QueueBlock(1, _plain(10, mark=0x21), 0, ASK),
                BoardOrder("arm", 3, None, TELL),
                Wait(wait),
                QueueBlock(1, _REFUSED, 0, TELL),
                *_WATCH,
                Wait(TICK_HZ // 10),
                Look(),
            ),
        )
        for wait in (0, 100_000, 200_000)
    ),
    Kept(
        "a token whose axis was disarmed",
        BOTH,
        (
            Frequency(30, TELL),
            QueueBlock(0, _plain(10), 0, ASK),
            BoardOrder("arm", 1, _TOKEN),
            BoardOrder("disarm", 1),
            Look(),
            BoardOrder("go", 0, _TOKEN),
            *_WATCH,
        ),
    ),
    Kept(
        "a token left over does not stop who runs",
        MEGA,
        (
            Frequency(30, TELL),
            QueueBlock(0, _plain(10), 0, ASK),
            QueueBlock(1, _plain(10), 0, ASK),
            BoardOrder("arm", 1),
            Wait(TICK_HZ // 20),
            BoardOrder("arm", 2, _TOKEN),
            BoardOrder("disarm", 2),
            Look(),
            BoardOrder("go", 0, _TOKEN),
            *_WATCH,
        ),
    ),
    Kept(
        "a refused coil leaves the argument",
        BOTH,
        (BoardOrder("enable", 1, 9), Coils(4, (1,)), BoardOrder("disable", 1), *_WATCH),
        careful=True,
    ),
    Kept(
        "a refused order leaves the order",
        BOTH,
        (
            BoardOrder("enable", 1, 9),
            BoardOrder("arm", 1, 5),
            BoardOrder("store", 0, 0x5AFF),
            BoardOrder("go", 0, 3),
            Setting("enable_settle_ms", 1001),
            QueueBlock(0, _plain(1), 1),
            *_WATCH,
        ),
        careful=True,
    ),
    *(
        Kept(
            f"a clock of {hz} Hz for a line of 100 Hz",
            BOTH,
            (
                Frequency(100, TELL),
                ClockCommand(f"hz {hz}/1"),
                Wait(TICK_HZ // 5),
                QueueBlock(0, _plain(10, 10, mark=0x21), 0, ASK),
                BoardOrder("arm", 1),
                Wait(TICK_HZ // 4),
                *_WATCH,
            ),
            faults=("pixel_clock_missing", "clock_edge_lost", "pixel_clock_off"),
        )
        for hz in (60, 89, 111, 200)
    ),
)
