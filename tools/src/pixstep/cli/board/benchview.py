# SPDX-License-Identifier: MIT
"""The virtual bench on a terminal: what is connected, what moves, and the line that is typed."""

import os
import select
from collections.abc import Iterator
from contextlib import contextmanager

from rich import box
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from pixstep.simulation.virtualbench import BenchStatus

try:
    import termios
    import tty
except ImportError:  # Windows has no terminals of this kind, and no simulator either
    termios = tty = None  # type: ignore[assignment]

_ENTER, _CLEAR, _END, _PRINTABLE = b"\n", b"\x15", b"\x04", range(0x20, 0x7F)
_ERASE = (b"\x7f", b"\x08")
_CHUNK = 4096
_GAP = "   "


class Typed:
    """Lines from a file descriptor, taken as they come; never waits for them."""

    def __init__(self, descriptor: int, *, keys: bool) -> None:
        self.descriptor, self.keys = descriptor, keys
        self.line = b""  # typed so far
        self._open = True

    def take(self) -> Iterator[str]:
        """Yield the lines that are complete."""
        while self._open and select.select([self.descriptor], [], [], 0)[0]:
            data = os.read(self.descriptor, _CHUNK)
            self._open = bool(data)
            for place in range(len(data)):
                yield from self._take(data[place : place + 1])
        if not self._open and self.line:
            yield from self._take(_ENTER)

    def _take(self, key: bytes) -> Iterator[str]:
        if key == _ENTER:
            text, self.line = self.line.decode(errors="replace"), b""
            yield text
        elif not self.keys:
            self.line += key
        elif key == _END and not self.line:
            yield "quit"
        else:
            self._edit(key)

    def _edit(self, key: bytes) -> None:
        if key in _ERASE:
            self.line = self.line[:-1]
        elif key == _CLEAR:
            self.line = b""
        elif key[0] in _PRINTABLE:
            self.line += key


@contextmanager
def key_by_key(descriptor: int) -> Iterator[None]:
    """Get keys from a terminal as they are pressed, without its own echo."""
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def in_foreground(descriptor: int) -> bool:
    """True if a terminal's keys come to this program: a job behind `&` would be stopped by them."""
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return False


def page(status: BenchStatus, said: str, typed: str | None) -> RenderableType:
    """Return the bench as a frame; `said` is what the last command had to say."""
    rows: list[RenderableType] = [_wires(status), Text(), _axes(status)]
    if status["lost_s"]:
        rows.append(Text(behind_text(status["lost_s"]), style="yellow"))
    rows.append(Text(said))
    if typed is not None:
        rows.append(Text.assemble(("> ", "bold"), typed, ("_", "blink")))
    title = Text(f" {status['board']}  {status['port']}  {status['time_s']:.1f} s ", style="bold")
    border = "red" if status["estop_pressed"] or not status["powered"] else "dim"
    return Panel(
        Group(*rows), title=title, title_align="left", border_style=border, box=box.ROUNDED
    )


def lines(status: BenchStatus) -> Iterator[str]:
    """Yield the same as plain lines."""
    yield _wires(status).plain
    for number, axis in enumerate(status["axes"]):
        yield (
            f"axis {number}: {axis['steps']} steps, {axis['edges']} edges, load at "
            f"{axis['load_steps']}, closed: {', '.join(axis['closed']) or 'none'}"
        )
    if status["lost_s"]:
        yield behind_text(status["lost_s"])


def behind_text(lost_s: float) -> str:
    """Return what it means that this machine is too slow."""
    return (
        f"{lost_s:.2f} s behind real time: this machine is too slow or busy; requests to the board "
        f"may time out, its own times stay right"
    )


def _wires(status: BenchStatus) -> Text:
    clock = status["clock"]
    rate = f"{clock['hz']:g} Hz" + (f" {clock['ppm']:+g} ppm" if clock["ppm"] else "")
    return Text(_GAP).join((
        _state("5 V", status["powered"], "on", "off", "green", "red"),
        _state("pixel clock", clock["runs"], rate, "stopped", "green", "yellow"),
        _state("ESTOP", status["estop_pressed"], "pressed", "released", "bold red", "dim"),
        _state("PERMIT", bool(status["permit"]), "high", "low", "yellow", "dim"),
    ))  # fmt: skip


def _state(name: str, on: bool, yes: str, no: str, style: str, other: str) -> Text:
    return Text.assemble((f"{name} ", "dim"), (yes if on else no, style if on else other))


def _axes(status: BenchStatus) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name, width in (("axis", 4), ("steps", 11), ("edges", 11), ("load", 11)):
        table.add_column(name, justify="right", min_width=width, no_wrap=True)
    table.add_column("closed switches")
    for number, axis in enumerate(status["axes"]):
        figures = (axis["steps"], axis["edges"], axis["load_steps"])
        table.add_row(str(number), *(f"{value:,}" for value in figures), ", ".join(axis["closed"]))
    return table
