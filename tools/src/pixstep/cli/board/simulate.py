# SPDX-License-Identifier: MIT
"""`pixstep board simulate`: a board to practise on, and hands for its switches, clock, supply."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import click

from pixstep import atomic, signals
from pixstep.board import boards
from pixstep.cli.clockoptions import gate_option
from pixstep.cli.command import FILE, command
from pixstep.cli.failures import complain
from pixstep.cli.options import pixel_hz_option, say, show_json_row
from pixstep.errors import FINE, PlainError, RefusedError, UserError
from pixstep.lazy import lazy
from pixstep.simulation import benchscript, virtualbench
from pixstep.simulation.benchscript import Order
from pixstep.simulation.virtualbench import SLICE_S, VirtualBench

if TYPE_CHECKING:
    import rich.console
    import rich.live

    from pixstep.cli.board import benchview
else:
    rich = lazy("rich")
    benchview = lazy("pixstep.cli.board.benchview")

_KEYS = "typed"
_INPUT = "standard input"
_BEHIND_AGAIN = 1.5  # how much longer a delay must have become to be told again
_REDRAW_S = 0.1


@command("simulate")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@pixel_hz_option
@gate_option
@click.option(
    "--link",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="A name for the port that stays the same: a symbolic link, taken away at the end.",
)
@click.option(
    "--script",
    type=FILE,
    metavar="FILE",
    help="Commands to begin with; - is the standard input.",
)
@click.option("--image", type=FILE, help="Another firmware image (ELF) for the board.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="One line of JSON for each command.")
@click.pass_context
def simulate_command(
    ctx: click.Context,
    board: str,
    pixel_hz: Fraction,
    pixel_gate: tuple[int, float] | None,
    link: Path | None,
    script: Path | None,
    image: Path | None,
    seed: int,
    as_json: bool,
) -> None:
    """Simulate a board, and work its switches, clock and supply.

    Any Modbus client, `pixstep board` first of all, talks to it in real time by the port that it
    prints. Commands are typed, come from --script, or are piped in; docs/CONSOLE.md describes them.
    It ends by `quit` or Ctrl-C; with the exit status of the first command piped in that was not
    done.
    """
    orders = _script(script, boards.load(board))
    options = virtualbench.options(board, pixel_hz, image=image, seed=seed, gate=pixel_gate)
    hands = _Hands(_typed(script))
    with signals.until_ctrl_c(), VirtualBench(options) as bench, _linked(link, bench.port):
        typed = hands.typed
        if typed and typed.keys and not as_json and sys.stdout.isatty():
            with benchview.key_by_key(typed.descriptor):
                _serve_terminal(bench, orders, hands, str(link or bench.port))
        else:
            show = _Rows(bench) if as_json else _Text(bench, str(link or bench.port))
            _serve(bench, orders, hands, show)
    ctx.exit(hands.status)


class _Show(Protocol):
    """Where the bench is shown."""

    def done(self, order: Order | None) -> None:
        """Show what a command has done; None at the start."""

    def failed(self, error: PlainError) -> None:
        """Show why a command that was typed or piped in was not done."""

    def look(self) -> None:
        """Show how it is now."""


def _script(path: Path | None, kind: boards.Board) -> list[Order]:
    """Return all commands of a script; nothing is started if one is wrong."""
    if path is None:
        return []
    stream = path == atomic.STDOUT  # "-"
    name = _INPUT if stream else str(path)
    try:
        text = sys.stdin.read() if stream else path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise RefusedError(f"{name}: not a text of UTF-8") from None
    return benchscript.parse_all(text.splitlines(), kind, name)


def _typed(script: Path | None) -> benchview.Typed | None:
    """Return where further commands come from: a terminal, or a pipe if there is no script."""
    try:
        descriptor = sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None
    if os.isatty(descriptor):
        return (
            benchview.Typed(descriptor, keys=True) if benchview.in_foreground(descriptor) else None
        )
    return None if script else benchview.Typed(descriptor, keys=False)


@contextlib.contextmanager
def _linked(link: Path | None, port: str) -> Iterator[None]:
    """Give the port a second name. Raises UserError if there is something else of that name."""
    if link is None:
        yield
        return
    if link.is_symlink() and not link.exists():
        link.unlink()  # of a bench that was killed
    try:
        link.symlink_to(port)
    except FileExistsError:
        raise UserError(f"{link}: already exists") from None
    except OSError as error:  # which names the port first
        raise UserError(f"{link}: {error.strerror or error}") from None
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            if str(link.readlink()) == port:
                link.unlink()


class _Hands:
    """Does what is typed or piped in; a command that is wrong is told, and the bench goes on."""

    def __init__(self, typed: benchview.Typed | None) -> None:
        self.typed = typed
        self.status = FINE  # of the first command piped in that was not done
        self._lines = 0

    def work(self, bench: VirtualBench, show: _Show) -> None:
        """Do what has come since the last time."""
        for text in list(self.typed.take()) if self.typed else ():
            self._lines += 1
            if not bench.ended:
                self._do(text, bench, show)

    def _do(self, text: str, bench: VirtualBench, show: _Show) -> None:
        keys = self.typed is not None and self.typed.keys
        try:
            place = _KEYS if keys else f"{_INPUT}: line {self._lines}"
            order = benchscript.parse(text, bench.kind, place)
            if order:
                order.obey(bench)
                show.done(order)
        except PlainError as error:
            show.failed(error)
            self.status = self.status or (FINE if keys else error.status)


def _serve(bench: VirtualBench, orders: list[Order], hands: _Hands, show: _Show) -> None:
    """Do what is ordered, first the script, until `quit`. What fails in a script is raised."""
    bench.look = show.look
    show.done(None)
    for order in orders:
        order.obey(bench)
        show.done(order)
        if bench.ended:
            return
    while not bench.ended:
        bench.wait(SLICE_S)
        hands.work(bench, show)


class _Behind:
    """Tells that the bench has fallen behind, not more often than helps."""

    def __init__(self, bench: VirtualBench) -> None:
        self.bench, self.told_s = bench, 0.0

    def more(self) -> bool:
        """True if it has become notably later since this was last true."""
        lost_s = self.bench.lost_s
        if lost_s <= self.told_s * _BEHIND_AGAIN:
            return False
        self.told_s = lost_s
        return True


class _Rows:
    """Rows of JSON."""

    def __init__(self, bench: VirtualBench) -> None:
        self.bench, self._behind = bench, _Behind(bench)

    def done(self, order: Order | None) -> None:
        self._row(order.text if order else "ready")

    def failed(self, error: PlainError) -> None:
        complain(error)

    def look(self) -> None:
        if self._behind.more():
            self._row("behind")

    def _row(self, event: str) -> None:
        show_json_row({"event": event, **self.bench.status()})
        sys.stdout.flush()


class _Text:
    """Plain lines."""

    def __init__(self, bench: VirtualBench, port: str) -> None:
        self.bench, self.port, self._behind = bench, port, _Behind(bench)

    def done(self, order: Order | None) -> None:
        if order is None:
            click.echo(f"{self.bench.name} at {self.port}: pixstep board ... --port {self.port}")
        else:
            click.echo(f"{self.bench.time_s:8.3f} s  {order.text}")
            if order.text == "status":
                click.echo("\n".join(benchview.lines(self.bench.status())))
        sys.stdout.flush()

    def failed(self, error: PlainError) -> None:
        complain(error)

    def look(self) -> None:
        if self._behind.more():
            say((benchview.behind_text(self.bench.lost_s),))


class _View:
    """A frame that is drawn again and again, with the line that is typed below."""

    def __init__(
        self, bench: VirtualBench, live: rich.live.Live, typed: benchview.Typed, port: str
    ) -> None:
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
            self.live.update(benchview.page(self.bench.status(), self.said, line), refresh=True)


def _serve_terminal(bench: VirtualBench, orders: list[Order], hands: _Hands, port: str) -> None:
    console = rich.console.Console(highlight=False)
    assert hands.typed is not None  # the terminal
    with rich.live.Live(console=console, auto_refresh=False, screen=False) as live:
        _serve(bench, orders, hands, _View(bench, live, hands.typed, port))
