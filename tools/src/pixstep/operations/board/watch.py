# SPDX-License-Identifier: MIT
"""Boards as they are, again and again."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import NotRequired, Protocol, TypedDict

from pixstep import signals
from pixstep.board import registers as regs
from pixstep.board import settings, snapshot
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.snapshot import LINE_COUNTERS, ClockData, Snapshot
from pixstep.board.state import beside_set
from pixstep.operations import bus
from pixstep.operations.bus import Known, ToBoards
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Time, Whole
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result

AXIS_COLUMNS = ("position_steps", "expected_steps", "pixel", "queue_free", "ring_fill")
NONE = "-"  # where there is no value
Pair = tuple[Snapshot, Snapshot | None]
Show = Callable[[list[Pair]], None]


class WatchedBoard(TypedDict):
    """A board at one moment; one that does not answer has only `trouble`."""

    unit: int
    board: str
    time_s: float
    trouble: NotRequired[str]
    status: NotRequired[dict[str, bool]]
    fault: NotRequired[str]
    switches: NotRequired[str]
    pixel_edges: NotRequired[int]
    edge_error_ticks: NotRequired[int]
    pixel_clock: NotRequired[ClockData | None]
    set_hz: NotRequired[float]
    other_clock_hz: NotRequired[float | None]
    counters: NotRequired[dict[str, int]]
    rates_per_s: NotRequired[dict[str, float]]
    axes: NotRequired[list[dict[str, int | str | None]]]


class WatchedBoards(TypedDict):
    """The boards at each look; of endless looks only those of the last one."""

    boards: list[WatchedBoard]


class Screen(Protocol):
    """Where boards are drawn again and again."""

    def opened(self, port: str) -> contextlib.AbstractContextManager[Show]:
        """Yield what draws the boards of a port in the place of the last ones."""


@operation("board watch")
class WatchBoards(ToBoards):
    """Watch boards live; Ctrl-C ends it.

    Status, fault, axes, switches, pixel clock, rates. Where nobody watches (no terminal) it prints
    plain lines.
    """

    result = WatchedBoards
    json_rows = "board and look"

    interval: float = option(
        Time("s", 0.05, 3600), "Time from one look to the next.", default=0.5, default_text="0.5s"
    )
    count: int | None = option(Whole(1), "End after N looks.", shown="N")
    once: bool = flag("Look once, as with --count 1.")

    def run(self, desk: Desk) -> Result:
        """Look until it was often enough, or Ctrl-C comes."""
        count = 1 if self.once else self.count
        kept: list[Pair] = []
        with (
            bus.boards(desk, self) as (found, known),
            signals.until_ctrl_c(),
            self._shown(desk, found.port) as show,
        ):
            for look in _looks(found, known, self.interval, count):
                show(look)
                if not (desk.keeps and count):
                    kept.clear()
                kept += look
        texts = (text for pair in kept for text in _lines(*pair))
        data = {"boards": [now.as_json(before) for now, before in kept]}
        return Result(data, "\n".join(texts), told=True)

    @contextlib.contextmanager
    def _shown(self, desk: Desk, port: str) -> Iterator[Show]:
        """Yield what shows a look: the screen if there is one, else rows and lines."""
        screen: Screen | None = None if self.once else desk.view
        if screen is not None:
            with screen.opened(port) as show:
                yield show
            return

        def tell(look: list[Pair]) -> None:
            for now, before in look:
                desk.row(now.as_json(before))
                for text in _lines(now, before):
                    desk.tell(text)

        yield tell


def _looks(
    found: Link, known: list[Known], interval_s: float, count: int | None
) -> Iterator[list[Pair]]:
    """Yield snapshots of all boards with the ones before them."""
    before: list[Snapshot | None] = [None] * len(known)
    patience_s = _patience_s(known)
    done = 0
    while True:
        now = [_take(item, found.world.now_s()) for item in known]
        yield list(zip(now, before, strict=True))
        before = list(now)
        done += 1
        if done == count:
            return
        _wait(found, known, interval_s, patience_s)


def _patience_s(known: list[Known]) -> float:
    """Return how long every board may go without a request: a third of what stops it."""
    limits_ms = []
    for item in known:
        with contextlib.suppress(BoardError):
            limits_ms.append(settings.read(item.board)["bus_timeout_ms"])
    return min((limit / 3000 for limit in limits_ms if limit), default=math.inf)


def _wait(found: Link, known: list[Known], interval_s: float, patience_s: float) -> None:
    """Wait, with requests in between so that no board takes its host for dead."""
    left_s = interval_s
    while left_s > patience_s:
        found.world.wait(patience_s)
        left_s -= patience_s
        for item in known:
            with contextlib.suppress(BoardError):
                item.board.input("status")
    found.world.wait(left_s)


def _take(known: Known, time_s: float) -> Snapshot:
    """Look at a board; one that does not answer does not end the watching."""
    try:
        return snapshot.take(known.board, known.who, time_s)
    except BoardError as error:
        return Snapshot(known.who, time_s, {}, [], str(error))


def _lines(now: Snapshot, before: Snapshot | None) -> Iterator[str]:
    """Yield a board as plain lines."""
    unit = now.who.unit
    if now.trouble:
        yield now.trouble
        return
    flags = ", ".join(name for name, on in now.flags.items() if on) or "idle"
    fault = f"; fault {now.fault}" if now.fault else ""
    clock = _clock_text(now, before)
    yield f"board {unit} {now.who.board}: {flags}{fault}; {clock}; switches: {now.switches}"
    for number, axis in enumerate(now.shown_axes):
        state = regs.axis_state(now.axes[number]["axis_state"])
        rest = ", ".join(
            f"{name} {NONE if axis[name] is None else axis[name]}" for name in AXIS_COLUMNS
        )
        yield f"board {unit} axis {number}: {state}, {rest}"
    if before is not None:
        yield f"board {unit}: {_rates_text(now, before)}"


def _clock_text(now: Snapshot, before: Snapshot | None) -> str:
    """Return what is known of the pixel clock."""
    text = f"{now.inputs['pixel_edges']} pixel edges"
    rates = now.rates(before)
    text = f"{text}, {rates['pixel_edges']:.2f} Hz" if rates else text
    if now.off_hz is not None:
        return f"{text}, {beside_set(now.off_hz, now.set_hz)}: another clock"
    return f"{text}, {now.clock.text}" if now.clock else text


def _rates_text(now: Snapshot, before: Snapshot | None) -> str:
    """Return the line's counters with how fast they count."""
    rates = now.rates(before)
    names = LINE_COUNTERS
    if not rates:
        return ", ".join(f"{name} {now.inputs[name]}" for name in names)
    return ", ".join(f"{name} {now.inputs[name]} ({rates[name]:.1f}/s)" for name in names)
