# SPDX-License-Identifier: MIT
"""What can be done to a board, as data: made at random, written down, replayed.

Every request is sent at a chosen cycle. `ask` waits for the reply; `tell` is a broadcast, which
nobody answers and behind which the next frame may follow at once.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

ASK, TELL = "ask", "tell"
Entries = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class BoardOrder:
    """A command register write: a key of registers.COMMANDS for a mask of axes.

    `ahead`: `go` names the clock edge that comes so many behind the newest one; 0: it names none.
    """

    name: str
    mask: int
    argument: int | None = None
    how: str = ASK
    ahead: int = 0


@dataclass(frozen=True)
class Coils:
    """A write of coils from `first` on."""

    first: int
    values: tuple[int, ...]
    how: str = ASK


@dataclass(frozen=True)
class QueueBlock:
    """A block for the queue window; its number is so far from the one that the axis expects."""

    axis: int
    entries: Entries
    off: int = 0
    how: str = ASK


@dataclass(frozen=True)
class Setting:
    """A write of a 16-bit setting."""

    name: str
    value: int
    how: str = ASK


@dataclass(frozen=True)
class Frequency:
    """A write of the board's pixel frequency, in whole Hz; the clock itself is another action."""

    hz: int
    how: str = ASK


@dataclass(frozen=True)
class ClockCommand:
    """A command for the pixel clock: "on", "off", "drop 3", "ppm 1000", "hz 100/1"."""

    text: str


@dataclass(frozen=True)
class PinInput:
    """An input pin driven from outside: ESTOP, HOME, LIMIT_MINUS or LIMIT_PLUS."""

    signal: str
    axis: int
    level: int


@dataclass(frozen=True)
class Supply:
    """The supply is cut and given back ("cycle"), or a reset: "external" or "brownout"."""

    what: str


@dataclass(frozen=True)
class Wait:
    """Let so many cycles pass."""

    cycles: int


@dataclass(frozen=True)
class StepWait:
    """Wait for a STEP edge of an axis, `limit` cycles at most; go on `more` cycles behind it."""

    axis: int
    limit: int
    more: int


@dataclass(frozen=True)
class Look:
    """Read the state of the board and compare it with what was seen."""


Action = (
    BoardOrder
    | Coils
    | QueueBlock
    | Setting
    | Frequency
    | ClockCommand
    | PinInput
    | Supply
    | Wait
    | StepWait
    | Look
)
KINDS: dict[str, Callable[..., Action]] = {
    kind.__name__.lower(): kind
    for kind in (
        BoardOrder,
        Coils,
        QueueBlock,
        Setting,
        Frequency,
        ClockCommand,
        PinInput,
        Supply,
        Wait,
        StepWait,
        Look,
    )
}


def as_json(action: Action) -> dict[str, Any]:
    """Return plain data."""
    return {"do": type(action).__name__.lower(), **asdict(action)}


def from_json(data: dict[str, Any]) -> Action:
    """Return the action of plain data."""
    rest = {name: _tuples(value) for name, value in data.items() if name != "do"}
    return KINDS[data["do"]](**rest)


def _tuples(value: object) -> object:
    return tuple(map(_tuples, value)) if isinstance(value, (list, tuple)) else value


def text(action: Action) -> str:
    """Return an action in a few words."""
    parts = [f"{value}" for value in asdict(action).values() if value is not None]
    return " ".join([type(action).__name__.lower(), *parts])
