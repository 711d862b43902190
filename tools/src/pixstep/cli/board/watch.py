# SPDX-License-Identifier: MIT
"""`pixstep board watch`: boards as they are, again and again."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from pixstep import signals
from pixstep.board import clock_hz, settings, snapshot
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import Port
from pixstep.board.snapshot import LINE_COUNTERS, Snapshot
from pixstep.cli.board.group import Known, Units, boards, port_options, units_option
from pixstep.cli.command import command
from pixstep.cli.options import show_json_row
from pixstep.cli.quantities import TimeType
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import rich.console
    import rich.live
    import rich.text

    from pixstep.cli.board import watchview
else:
    rich = lazy("rich")
    watchview = lazy("pixstep.cli.board.watchview")

Pair = tuple[Snapshot, Snapshot | None]


@command("watch")
@port_options
@units_option
@click.option(
    "--interval",
    type=TimeType("s", 0.05, 3600),
    default="0.5s",
    show_default=True,
    help="Time from one look to the next.",
)
@click.option("--count", type=click.IntRange(1), metavar="N", help="End after so many looks.")
@click.option("--once", is_flag=True, help="Look once; the same as --count 1.")
@click.option("--json", "as_json", is_flag=True, help="One line of JSON for each board and look.")
def watch_command(
    port: Port, units: Units, interval: float, count: int | None, once: bool, as_json: bool
) -> None:
    """Watch boards live; Ctrl-C ends it.

    Status, fault, axes, switches, pixel clock, rates. Where nobody watches (no terminal) it prints
    plain lines.
    """
    with boards(port, units) as (found, known), signals.until_ctrl_c():
        looks = _looks(found, known, interval, 1 if once else count)
        if as_json:
            for look in looks:
                for now, before in look:
                    show_json_row(now.as_json(before))
            return
        console = rich.console.Console(highlight=False)
        if console.is_terminal and not once:
            _live(console, looks, found.port)
        else:
            for look in looks:
                for pair in look:
                    for text in _lines(*pair):
                        click.echo(text)


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


def _live(console: rich.console.Console, looks: Iterator[list[Pair]], port: str) -> None:
    """Redraw the terminal at each look."""
    with rich.live.Live(console=console, auto_refresh=False, screen=False) as live:
        for look in looks:
            title = rich.text.Text(f"{port}   Ctrl-C ends", style="dim")
            pages = [watchview.page(*pair) for pair in look]
            live.update(rich.console.Group(title, *pages), refresh=True)


def _lines(now: Snapshot, before: Snapshot | None) -> Iterator[str]:
    """Yield a board as plain lines."""
    unit = now.who.unit
    if now.trouble:
        yield now.trouble
        return
    flags = ", ".join(name for name, on in now.flags.items() if on) or "idle"
    fault = f"; fault {now.fault}" if now.fault else ""
    yield (
        f"board {unit} {now.who.board}: {flags}{fault}; {_clock_text(now, before)}; switches: "
        + (now.switches)
    )
    for number, axis in enumerate(now.shown_axes):
        state = regs.axis_state(now.axes[number]["axis_state"])
        rest = ", ".join(
            f"{name} {watchview.NONE if axis[name] is None else axis[name]}"
            for name in watchview.AXIS_COLUMNS
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
        return f"{text}, {clock_hz.beside(now.off_hz, now.set_hz)}: another clock"
    return f"{text}, {now.clock.text}" if now.clock else text


def _rates_text(now: Snapshot, before: Snapshot | None) -> str:
    """Return the line's counters with how fast they count."""
    rates = now.rates(before)
    names = LINE_COUNTERS
    if not rates:
        return ", ".join(f"{name} {now.inputs[name]}" for name in names)
    return ", ".join(f"{name} {now.inputs[name]} ({rates[name]:.1f}/s)" for name in names)
