# SPDX-License-Identifier: MIT
"""A board as `pixstep board watch` draws it: steady columns, colour for what counts."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from rich import box
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from pixstep.board import registers as regs
from pixstep.board.snapshot import Snapshot
from pixstep.board.state import beside_set
from pixstep.operations.board.watch import AXIS_COLUMNS, NONE, Pair, Show

_HEADS = (  # and widths that hold any value, so that nothing jumps
    ("axis", 4), ("state", 7), ("position", 11), ("expected", 11), ("pixel", 10),
    ("queue free", 10), ("ring", 4),
)  # fmt: skip
_ON = {"clock": "green", "fault": "bold red", "estop": "bold red", "permit": "yellow"}
_STATES = {"running": "green", "armed": "cyan", "fault": "red", "refused": "red", "empty": "dim"}
_TROUBLES = ("crc_errors", "exceptions", "rx_overruns", "busy_replies")
_GAP = "   "


def screen() -> TerminalScreen | None:
    """Return a screen if there is a terminal."""
    console = Console(highlight=False)
    return TerminalScreen(console) if console.is_terminal else None


class TerminalScreen:
    """A terminal on which boards are drawn again and again."""

    def __init__(self, console: Console):
        self._console = console

    @contextlib.contextmanager
    def opened(self, port: str) -> Iterator[Show]:
        """Yield what draws the boards of a port in the place of the last ones."""
        with Live(console=self._console, auto_refresh=False, screen=False) as live:

            def show(look: list[Pair]) -> None:
                title = Text(f"{port}   Ctrl-C ends", style="dim")
                live.update(Group(title, *(page(*pair) for pair in look)), refresh=True)

            yield show


def page(now: Snapshot, before: Snapshot | None) -> RenderableType:
    """Return a board as a frame: red at a fault, green while it moves."""
    body: RenderableType
    if now.trouble:
        body, border = Text(now.trouble, style="red"), "red"
    else:
        body, border = Group(*_body(now, before)), _border(now.flags)
    title = Text(f" board {now.who.unit}  {now.who.board} {now.who.firmware} ", style="bold")
    return Panel(body, title=title, title_align="left", border_style=border, box=box.ROUNDED)


def _border(flags: dict[str, bool]) -> str:
    if flags["fault"] or flags["estop"]:
        return "red"
    return "green" if flags["running"] else "dim"


def _body(now: Snapshot, before: Snapshot | None) -> Iterator[RenderableType]:
    """Yield flags, fault, axes, and what else there is."""
    yield _flags(now.flags)
    if now.fault:
        yield Text(f"fault: {now.fault}", style="bold red")
    yield Text()
    yield _axes(now)
    yield Text.assemble(
        ("pixel clock  ", "dim"), _clock(now, before), (f"{_GAP}switches  ", "dim"), now.switches
    )
    if now.clock:
        yield Text.assemble(("measured     ", "dim"), now.clock.text)
    yield Text.assemble(("serial line  ", "dim"), _line(now, before))


def _flags(flags: dict[str, bool]) -> Text:
    """Return the status bits: a filled dot is on."""
    text = Text()
    for name, on in flags.items():
        mark, style = ("●", _ON.get(name, "cyan")) if on else ("○", "dim")
        text.append(f"{mark} {name.replace('_', ' ')}{_GAP}", style=style)
    return text


def _axes(now: Snapshot) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name, width in _HEADS:
        table.add_column(
            name, justify="left" if name == "state" else "right", min_width=width, no_wrap=True
        )
    for number, axis in enumerate(now.shown_axes):
        state = regs.axis_state(now.axes[number]["axis_state"])
        values = (NONE if axis[name] is None else f"{axis[name]:,}" for name in AXIS_COLUMNS)
        table.add_row(str(number), Text(state, style=_STATES.get(state, "")), *values)
    return table


def _clock(now: Snapshot, before: Snapshot | None) -> str:
    rates = now.rates(before)
    rate = f"{rates['pixel_edges']:.2f} Hz, " if rates else ""
    text = f"{rate}{now.inputs['pixel_edges']:,} edges"
    if now.off_hz is not None:
        return f"{text}, {beside_set(now.off_hz, now.set_hz)}: another clock"
    return text


def _line(now: Snapshot, before: Snapshot | None) -> Text:
    """Return how busy the line is, and what went wrong on it."""
    rates = now.rates(before)
    text = Text(f"{now.inputs['frames_ok']:,} requests served")
    if rates:
        text.append(f", {rates['frames_ok']:.1f}/s of {rates['bus_messages']:.1f}/s on the line")
    wrong = [f"{name} {now.inputs[name]}" for name in _TROUBLES if now.inputs[name]]
    text.append(_GAP)
    if wrong:
        text.append(", ".join(wrong), style="yellow")
    else:
        text.append("no errors", style="green")
    return text
