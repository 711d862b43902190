# SPDX-License-Identifier: MIT
"""A board to practise on, and hands for its switches, clock, supply."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol, TypedDict

from pixstep import atomic, signals
from pixstep.board import boards
from pixstep.errors import FINE, PlainError, RefusedError, UserError
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.clocks import OfClock, pixel_gate
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, PATH
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result
from pixstep.simulation import bench_script, virtual_bench
from pixstep.simulation.bench_script import Order
from pixstep.simulation.virtual_bench import SLICE_S, BenchStatus, VirtualBench

_KEYS = "typed"
_INPUT = "standard input"
GAP = "   "  # between what stands in a line
_BEHIND_AGAIN = 1.5  # how much longer a delay must have become to be told again


class BenchEvent(BenchStatus):
    """A command that was done, "ready" or "behind", and what could be seen then."""

    event: str


class Bench(TypedDict):
    """What was done to a simulated board."""

    board: str
    events: list[BenchEvent]


class Typed(Protocol):
    """Where commands come from while the board runs."""

    @property
    def keys(self) -> bool:
        """True if they are typed, and not piped in."""

    def take(self) -> Iterator[str]:
        """Yield the lines that are complete; never wait for them."""


class Show(Protocol):
    """Where the bench is shown."""

    def done(self, order: Order | None) -> None:
        """Show what a command has done; None at the start."""

    def failed(self, error: PlainError) -> None:
        """Show why a command that was typed or piped in was not done."""

    def look(self) -> None:
        """Show how it is now."""


class Terminal(Protocol):
    """What the bench has where there is a terminal or a pipe."""

    def typed(self, *, scripted: bool) -> Typed | None:
        """Return where commands come from besides a script."""

    def opened(
        self, bench: VirtualBench, port: str
    ) -> contextlib.AbstractContextManager[Show] | None:
        """Return what draws the bench again and again, the typed line below; None to print it."""


@operation("board simulate")
class Simulate(OfClock):
    """Simulate a board, and work its switches, clock and supply.

    Any Modbus client, `pixstep board` first of all, talks to it in real time by the port that it
    prints. Commands are typed, come from --script, or are piped in; docs/CONSOLE.md describes them.
    It ends by `quit` or Ctrl-C; with the exit status of the first command piped in that was not
    done.
    """

    result = Bench
    json_rows = "command"

    board: str = shared.simulated_board()
    pixel_gate: tuple[int, float] | None = pixel_gate()
    clock_wire: bool = flag(
        "In place of the clock source a wire joins the board's CLOCK_OUT and its clock input.",
        off="--no-clock-wire", machine=machine.clock_wire,
    )  # fmt: skip
    link: Path | None = option(
        PATH, "A name for the port that stays the same: a symbolic link, removed at the end."
    )
    script: Path | None = option(FILE, "Commands to begin with; - is the standard input.")
    image: Path | None = option(FILE, "Another firmware image (ELF) for the board.")
    seed: int = shared.seed()

    def run(self, desk: Desk) -> Result:
        """Simulate until somebody ends it."""
        orders = self._orders()
        options = virtual_bench.options(
            self.board, self.edges_hz, image=self.image, seed=self.seed, gate=self.pixel_gate,
            wired=self.clock_wire,
        )  # fmt: skip
        terminal: Terminal | None = desk.view
        typed = terminal.typed(scripted=self.script is not None) if terminal else None
        hands, rows = _Hands(typed), list[BenchEvent]()
        with (
            signals.until_ctrl_c(), VirtualBench(options) as bench, _linked(self.link, bench.port)
        ):  # fmt: skip
            port = str(self.link or bench.port)
            drawn = terminal.opened(bench, port) if terminal else None
            told = _PlainRows(desk, bench, port, rows)
            with drawn or contextlib.nullcontext(told) as show:
                _serve(bench, orders, hands, show)
        return Result({"board": self.board, "events": rows}, status=hands.status, told=True)

    def _orders(self) -> list[Order]:
        """Return all commands of the script; nothing is started if one is wrong."""
        if self.script is None:
            return []
        stream = self.script == atomic.STDOUT  # "-"
        name = _INPUT if stream else str(self.script)
        try:
            text = sys.stdin.read() if stream else self.script.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise RefusedError(f"{name}: not a text of UTF-8") from None
        return bench_script.parse_all(text.splitlines(), boards.load(self.board), name)


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


def _serve(bench: VirtualBench, orders: list[Order], hands: _Hands, show: Show) -> None:
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


class _Hands:
    """Does what is typed or piped in; a command that is wrong is told, and the bench goes on."""

    def __init__(self, typed: Typed | None) -> None:
        self.typed = typed
        self.status = FINE  # of the first command piped in that was not done
        self._lines = 0

    def work(self, bench: VirtualBench, show: Show) -> None:
        """Do what has come since the last time."""
        for text in list(self.typed.take()) if self.typed else ():
            self._lines += 1
            if not bench.ended:
                self._do(text, bench, show)

    def _do(self, text: str, bench: VirtualBench, show: Show) -> None:
        keys = self.typed is not None and self.typed.keys
        try:
            place = _KEYS if keys else f"{_INPUT}: line {self._lines}"
            order = bench_script.parse(text, bench.kind, place)
            if order:
                order.obey(bench)
                show.done(order)
        except PlainError as error:
            show.failed(error)
            self.status = self.status or (FINE if keys else error.status)


class _PlainRows:
    """Plain lines and rows of data."""

    def __init__(self, desk: Desk, bench: VirtualBench, port: str, rows: list[BenchEvent]) -> None:
        self._desk, self._bench, self._port, self._rows = desk, bench, port, rows
        self._told_s = 0.0  # how far behind the bench was when that was last told

    def done(self, order: Order | None) -> None:
        if order is None:
            name = self._bench.name
            self._desk.tell(f"{name} at {self._port}: pixstep board ... --port {self._port}")
        else:
            self._desk.tell(f"{self._bench.time_s:8.3f} s  {order.text}")
        status = self._row(order.text if order else "ready")
        if order and order.text == "status":
            self._desk.tell("\n".join(_lines(status)))

    def failed(self, error: PlainError) -> None:
        self._desk.complain(error)

    def look(self) -> None:
        """Tell that the bench has fallen behind, not more often than helps."""
        lost_s = self._bench.lost_s
        if lost_s > self._told_s * _BEHIND_AGAIN:
            self._told_s = lost_s
            self._row("behind")
            self._desk.say((behind_text(lost_s),))

    def _row(self, event: str) -> BenchStatus:
        status = self._bench.status()
        row: BenchEvent = {"event": event, **status}
        self._desk.row(row)
        if self._desk.keeps:
            self._rows.append(row)
        return status


def _lines(status: BenchStatus) -> Iterator[str]:
    """Yield the bench as plain lines."""
    yield GAP.join(f"{name} {text}" for name, _, text in wires(status))
    for number, axis in enumerate(status["axes"]):
        yield (
            f"axis {number}: {axis['steps']} steps, {axis['edges']} edges, load at "
            f"{axis['load_steps']}, closed: {', '.join(axis['closed']) or 'none'}"
        )
    if status["lost_s"]:
        yield behind_text(status["lost_s"])


def wires(status: BenchStatus) -> Iterator[tuple[str, bool, str]]:
    """Yield supply, clock, emergency stop and permit output: name, whether it is on, in words."""
    clock, on = status["clock"], status["powered"]
    rate = f"{clock['hz']:g} Hz" + (f" {clock['ppm']:+g} ppm" if clock["ppm"] else "")
    if clock["own"]:
        rate = "by a wire from CLOCK_OUT"
    pressed, permit = status["estop_pressed"], bool(status["permit"])
    yield "5 V", on, "on" if on else "off"
    yield "pixel clock", clock["runs"], rate if clock["runs"] else "stopped"
    yield "ESTOP", pressed, "pressed" if pressed else "released"
    yield "PERMIT", permit, "high" if permit else "low"


def behind_text(lost_s: float) -> str:
    """Return what it means that this machine is too slow."""
    return (
        f"{lost_s:.2f} s behind real time: this machine is too slow or busy; requests to the board "
        f"may time out, its own times stay right"
    )
