# SPDX-License-Identifier: MIT
"""The virtual bench on a terminal: what is connected, what moves, and the line that is typed."""

from __future__ import annotations

import contextlib
import os
import select
import sys
from collections.abc import Iterator

from rich import box
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from pixstep.errors import PlainError
from pixstep.operations.board.simulate import GAP, behind_text, wires
from pixstep.simulation.bench_script import Order
from pixstep.simulation.virtual_bench import BenchStatus, VirtualBench

try:
    import termios
    import tty
except ImportError:  # Windows has no terminals of this kind, and no simulator either
    termios = tty = None  # type: ignore[assignment]

_ENTER, _CLEAR, _END, _PRINTABLE = b"\n", b"\x15", b"\x04", range(0x20, 0x7F)
_ERASE = (b"\x7f", b"\x08")
_CHUNK = 4096
_REDRAW_S = 0.1
_STYLES = {  # of what is on, and off
    "5 V": ("green", "red"), "pixel clock": ("green", "yellow"), "ESTOP": ("bold red", "dim"),
    "PERMIT": ("yellow", "dim"),
}  # fmt: skip


class TypedLines:
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


@contextlib.contextmanager
def key_by_key(descriptor: int) -> Iterator[None]:
    """Get keys from a terminal as they are pressed, without its own echo."""
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


class BenchTerminal:
    """Where commands come from, and the screen on which the bench is drawn."""

    def __init__(self, *, as_json: bool):
        self._as_json = as_json
        self._typed: TypedLines | None = None

    def typed(self, *, scripted: bool) -> TypedLines | None:
        """Return where commands come from: a terminal, or a pipe if there is no script."""
        try:
            descriptor = sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):
            return None
        if os.isatty(descriptor):
            self._typed = TypedLines(descriptor, keys=True) if in_foreground(descriptor) else None
        elif not scripted:
            self._typed = TypedLines(descriptor, keys=False)
        return self._typed

    def opened(
        self, bench: VirtualBench, port: str
    ) -> contextlib.AbstractContextManager[_View] | None:
        """Return what draws the bench, the typed line below; None to print it."""
        typed = self._typed
        if typed is None or not typed.keys or self._as_json or not sys.stdout.isatty():
            return None
        return self._drawn(bench, port, typed)

    @contextlib.contextmanager
    def _drawn(self, bench: VirtualBench, port: str, typed: TypedLines) -> Iterator[_View]:
        console = Console(highlight=False)
        with (
            key_by_key(typed.descriptor),
            Live(console=console, auto_refresh=False, screen=False) as live,
        ):
            yield _View(bench, live, typed, port)


class _View:
    """A frame that is drawn again and again, with the line that is typed below."""

    def __init__(self, bench: VirtualBench, live: Live, typed: TypedLines, port: str) -> None:
        self.bench, self.live, self.typed = bench, live, typed
        self.said, self._drawn_s = f"pixstep board ... --port {port}", -_REDRAW_S

    def done(self, order: Order | None) -> None:
        if order:
            self.said = f"{order.text}: done"

    def failed(self, error: PlainError) -> None:
        self.said = str(error)

    def look(self) -> None:
        if self.bench.time_s - self._drawn_s >= _REDRAW_S:
            self._drawn_s = self.bench.time_s
            line = self.typed.line.decode(errors="replace")
            self.live.update(page(self.bench.status(), self.said, line), refresh=True)


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


def _wires(status: BenchStatus) -> Text:
    return Text(GAP).join(
        Text.assemble((f"{name} ", "dim"), (text, _STYLES[name][0 if on else 1]))
        for name, on, text in wires(status)
    )


def _axes(status: BenchStatus) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name, width in (("axis", 4), ("steps", 11), ("edges", 11), ("load", 11)):
        table.add_column(name, justify="right", min_width=width, no_wrap=True)
    table.add_column("closed switches")
    for number, axis in enumerate(status["axes"]):
        figures = (axis["steps"], axis["edges"], axis["load_steps"])
        table.add_row(str(number), *(f"{value:,}" for value in figures), ", ".join(axis["closed"]))
    return table
