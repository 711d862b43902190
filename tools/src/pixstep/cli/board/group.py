# SPDX-License-Identifier: MIT
"""What the commands of `pixstep board` share: the port's options, boards, errors."""

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import click

from pixstep import progress, signals
from pixstep.board import run, scan, settings
from pixstep.board.device import Board, Identity
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import (
    BAUD,
    LAST_UNIT,
    LEAST_BAUD,
    MOST_BAUD,
    PARITIES,
    TIMEOUT_S,
    TIMEOUTS_S,
    Port,
)
from pixstep.cli import machinedefaults
from pixstep.cli.failures import complain
from pixstep.cli.options import say
from pixstep.cli.quantities import TimeType
from pixstep.errors import UserError
from pixstep.server import remote

ALL = "all"
AXIS = click.IntRange(0, 3)
axes_option = click.option(
    "--axis", "axes", type=AXIS, multiple=True, help="Again for more axes.  [default: all]"
)


class StoppedError(BoardError):
    """Motion was stopped because the command was ended; `status` is its exit status."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


Units = tuple[int, ...] | str  # addresses, or ALL


class _Units(click.ParamType[Units, Units]):
    """Addresses: 1 or 1,2,5-8, or all."""

    name = "UNITS"

    def convert(
        self, value: Units, param: click.Parameter | None, ctx: click.Context | None
    ) -> Units:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, tuple) or value == ALL:
            return value
        found: list[int] = []
        for part in value.split(","):
            low, dash, high = part.strip().partition("-")
            if not low.isdecimal() or (dash and not high.isdecimal()):
                self.fail(
                    f"{value!r}: addresses are wanted, as in 1 or 1,2,5-8, or all", param, ctx
                )
            first, last = int(low), int(high or low)
            if not 1 <= first <= last <= LAST_UNIT:
                self.fail(f"{part!r}: addresses are 1 to {LAST_UNIT}", param, ctx)
            found += [unit for unit in range(first, last + 1) if unit not in found]
        return tuple(found)


UNITS = _Units()
unit_option = click.option(
    "--unit", "unit", type=click.IntRange(1, LAST_UNIT), default=1, show_default=True,
    help="Address of the board.",
)  # fmt: skip
units_option = click.option(
    "--unit", "units", type=UNITS, default="1", show_default=True,
    help="Addresses: 1 or 1,2,5-8, or all (looks for them).",
)  # fmt: skip
_PORT_OPTIONS = (
    click.option(
        "--port", required=True, envvar="PIXSTEP_PORT", show_envvar=True,
        help="Serial port, or a simulator's pseudo terminal.",
    ),
    click.option(
        "--baud", type=click.IntRange(LEAST_BAUD, MOST_BAUD), default=BAUD, show_default=True
    ),
    click.option(
        "--parity", type=click.Choice(PARITIES, case_sensitive=False),
        help="[default: E; N on a pseudo terminal, which has no parity]",
    ),
    click.option(
        "--timeout", type=TimeType("s", *TIMEOUTS_S), metavar="TIME",
        envvar="PIXSTEP_TIMEOUT", show_envvar=True,
        help=f"Time to wait for a reply, s.  [default: {TIMEOUT_S}]",
    ),
)  # fmt: skip


def port_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the port; the command gets them as `port`, a Port."""

    @functools.wraps(command)
    def call(
        *arguments: Any,
        port: str,
        baud: int,
        parity: str | None,
        timeout: float | None,
        **others: Any,
    ) -> None:
        command(*arguments, port=Port(port, baud, parity, timeout), **others)

    for option in reversed(_PORT_OPTIONS):
        call = option(call)
    return call


@dataclass(frozen=True)
class Known:
    """A board that has said what it is."""

    board: Board
    who: Identity

    def axes(self, chosen: tuple[int, ...]) -> list[int]:
        """Return the axes chosen, all of them if none is; raises UserError for one too many."""
        for axis in chosen:
            if axis >= self.who.axis_count:
                last = self.who.axis_count - 1
                has = "axis 0 only" if last == 0 else f"axes 0 to {last}"
                raise UserError(
                    f"axis {axis}: board {self.board.unit} ({self.who.board}) has {has}"
                )
        return sorted(set(chosen)) or list(range(self.who.axis_count))


@contextlib.contextmanager
def opened(port: Port, first: Callable[[Link], None] = lambda _: None) -> Iterator[Link]:
    """Yield the open bus; `first` is done with it before anything else."""
    found = remote.open_bus(port, lambda text: say((text,)), first)
    try:
        yield found
    finally:
        found.close()


@contextlib.contextmanager
def boards(port: Port, units: Units) -> Iterator[tuple[Link, list[Known]]]:
    """Yield the open bus and its boards, each with a register map that this tool knows."""
    with opened(port) as found:
        yield found, [_known(found, unit) for unit in _addresses(found, units)]


def each_board(port: Port, units: Units, act: Callable[[Known], None]) -> None:
    """Do something with every board, also behind one that does not answer or refuses.

    Raises BoardError for the last that failed; those before it are told on the error stream.
    """
    with opened(port) as found:
        each_of(found, units, act)


def each_of(found: Link, units: Units, act: Callable[[Known], None]) -> None:
    """Do the same on a bus that is open."""
    failures: list[BoardError] = []
    for unit in _addresses(found, units):
        try:
            act(_known(found, unit))
        except BoardError as error:
            failures.append(error)
    for failure in failures[:-1]:
        complain(failure)
    if failures:
        raise failures[-1]


@contextlib.contextmanager
def one_board(port: Port, unit: int) -> Iterator[tuple[Link, Known]]:
    """Yield the open bus and its one board."""
    with boards(port, (unit,)) as (found, (known,)):
        yield found, known


def _known(found: Link, unit: int) -> Known:
    one = found.board(unit)
    who = one.who()
    machinedefaults.compare_board(click.get_current_context(), found.port, unit, who.board)
    return Known(one, who)


def _addresses(found: Link, units: Units) -> tuple[int, ...]:
    """Return the addresses of an option: those given, or of all boards that are found."""
    return present(found) if isinstance(units, str) else units


def present(
    found: Link,
    addresses: Iterable[int] = scan.UNITS,
    timeout_s: float = scan.TIMEOUT_S,
    where: str = "at any address",
) -> tuple[int, ...]:
    """Look for the boards of the bus; raises BoardError if there is none."""
    with progress.shown("looking for boards") as show, scan.quickly(found.modbus, timeout_s):
        answers = scan.scan(found.modbus, addresses, show)
    units = tuple(answer.unit for answer in answers if not answer.trouble)
    if not units:
        raise BoardError(f"{found.port}: no board answers {where}")
    return units


@contextlib.contextmanager
def stopping(group: list[run.Lines]) -> Iterator[None]:
    """Stop all axes of a group when Ctrl-C, SIGTERM or SIGHUP comes, or this program fails.

    Raises StoppedError saying where the axes are after a signal. Keep this the innermost context.
    """
    try:
        with run.stopped_on_failure(group):
            yield
    except KeyboardInterrupt as error:
        told = "; ".join(error.__notes__)
        raise StoppedError(
            f"stopped by {signals.name(error)}: {told}", signals.status(error)
        ) from None


def note_unattended(board: Board) -> None:
    """Say that a board does not go on for long without requests, if it is set so."""
    limit_ms = settings.read(board)["bus_timeout_ms"]
    if limit_ms:
        say((
            f"board {board.unit} stops with fault bus_silent when no request comes for "
            f"{limit_ms / 1000:g} s while an axis is armed or moves: follow it (--wait, `pixstep "
            f"board watch`), or let it run alone (`pixstep board set bus_timeout_ms=0`, at rest)",
        ))  # fmt: skip


def note_play(board: Board, axes: list[int]) -> None:
    """Say which of the lines that were armed did not know the play that they take up."""
    say(
        f"board {board.unit} axis {axis}: how much of the play was taken up was not known, as "
        f"after a reset: the line takes up all of it, and the load may be too far by as much"
        for axis in (run.play_unknown(board, axes) if axes else ())
    )


def axes_text(axes: list[int]) -> str:
    """Return some axes in words."""
    return f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(map(str, axes))}"
