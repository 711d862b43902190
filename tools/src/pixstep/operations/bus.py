# SPDX-License-Identifier: MIT
"""What requests to boards have in common: the port's fields, open buses, boards, stopping."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from pixstep import signals
from pixstep.board import run, scan, settings
from pixstep.board.device import Device, Identity
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import (
    BAUD,
    LAST_UNIT,
    LEAST_BAUD,
    MOST_BAUD,
    PARITIES,
    Port,
)
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.facts import boards_at
from pixstep.operations.kinds import TEXT, Choice, Parsed, Whole
from pixstep.operations.request import Request, option, shared_fields
from pixstep.operations.shared import AXIS
from pixstep.server import remote

ALL = "all"
Units = tuple[int, ...] | str  # addresses, or ALL


def _read_units(text: str) -> Units:
    if text == ALL:
        return ALL
    found: list[int] = []
    for part in text.split(","):
        low, dash, high = part.strip().partition("-")
        if not low.isdecimal() or (dash and not high.isdecimal()):
            raise UserError(f"{text!r}: addresses are wanted, as in 1 or 1,2,5-8, or all")
        first, last = int(low), int(high or low)
        if not 1 <= first <= last <= LAST_UNIT:
            raise UserError(f"{part!r}: addresses are 1 to {LAST_UNIT}")
        found += [unit for unit in range(first, last + 1) if unit not in found]
    return tuple(found)


class _Units(Parsed):
    """Addresses: 1 or 1,2,5-8, or all."""

    def __init__(self) -> None:
        super().__init__("UNITS", _read_units, "int | str | tuple[int, ...]")

    def judge(self, value: Any) -> Units:
        """Return addresses that Python has."""
        several = value if isinstance(value, (tuple, list)) else (value,)
        unit = Whole(1, LAST_UNIT)
        return tuple(unit.read(one) for one in several)


UNITS = _Units()
UNIT = Whole(1, LAST_UNIT)


@shared_fields
class OnPort(Request):
    """A request to a bus with boards."""

    port: str = option(
        TEXT, "Serial port, or a simulator's pseudo terminal.", required=True,
        variable="PIXSTEP_PORT", machine=machine.of_board("port"),
    )  # fmt: skip
    baud: int = option(
        Whole(LEAST_BAUD, MOST_BAUD),
        "Rate of the serial line.",
        default=BAUD,
        machine=machine.of_board("baud"),
    )
    parity: str | None = option(
        Choice(list(PARITIES), any_case=True), "Parity of the serial line.",
        machine=machine.of_board("parity"),
        default_text="E; N on a pseudo terminal, which has no parity",
    )  # fmt: skip
    timeout: float | None = shared.timeout()

    @property
    def bus(self) -> Port:
        """The port and how it is spoken to."""
        return Port(self.port, self.baud, self.parity, self.timeout)


@shared_fields
class ToBoard(OnPort):
    """A request to one board."""

    unit: int = option(UNIT, "Address of the board.", default=1, machine=machine.of_board("unit"))


@shared_fields
class ToBoards(OnPort):
    """A request to several boards."""

    units: Units = option(
        UNITS, "Addresses of boards: 1 or 1,2,5-8, or all, which looks for them.", "--unit",
        default=(1,),
        default_text="1", machine=machine.units,
    )  # fmt: skip


def some_axes(**more: Any) -> Any:
    """Return the field of the axes that are meant: all, if none is named."""
    given = {"many": True, "default_text": "all", "machine": machine.axes}
    return option(AXIS, "Axis of the board; again for more.", "--axis", **{**given, **more})


class StoppedError(BoardError):
    """Motion was stopped because the process was ended; `status` is the exit status."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True)
class Known:
    """A board that has said what it is."""

    board: Device
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
def opened(
    desk: Desk, request: OnPort, first: Callable[[Link], None] = lambda _: None
) -> Iterator[Link]:
    """Yield the open bus; `first` is done with it before anything else.

    A bus that the caller has open already stays open.
    """
    if desk.link is not None:
        first(desk.link)
        yield desk.link
        return
    found = remote.open_bus(request.bus, lambda text: desk.say((text,)), first)
    try:
        yield found
    finally:
        found.close()


@contextlib.contextmanager
def boards(desk: Desk, request: ToBoards) -> Iterator[tuple[Link, list[Known]]]:
    """Yield the open bus and its boards, each with a register map that this tool knows."""
    with opened(desk, request) as found:
        yield found, [known(desk, found, unit) for unit in addresses(desk, found, request.units)]


@contextlib.contextmanager
def one_board(desk: Desk, request: ToBoard) -> Iterator[tuple[Link, Known]]:
    """Yield the open bus and its one board."""
    with opened(desk, request) as found:
        yield found, known(desk, found, request.unit)


def each_board(desk: Desk, request: ToBoards, act: Callable[[Known], None]) -> None:
    """Do something with every board, also after one that does not answer or refuses.

    Raises BoardError for the last that failed; those before it are complained of.
    """
    with opened(desk, request) as found:
        each_of(desk, found, request.units, act)


def each_of(desk: Desk, found: Link, units: Units, act: Callable[[Known], None]) -> None:
    """Do the same on a bus that is open."""
    failures: list[BoardError] = []
    for unit in addresses(desk, found, units):
        try:
            act(known(desk, found, unit))
        except BoardError as error:
            failures.append(error)
    for failure in failures[:-1]:
        desk.complain(failure)
    if failures:
        raise failures[-1]


def known(desk: Desk, found: Link, unit: int) -> Known:
    """Return a board that has said what it is.

    Raises RefusedError for another kind of board than the machine file has there.
    """
    one = found.board(unit)
    who = one.who()
    _compare(desk, found.port, unit, who.board)
    return Known(one, who)


def addresses(desk: Desk, found: Link, units: Units) -> tuple[int, ...]:
    """Return the addresses of a field: those given, or of all boards that are found."""
    return present(desk, found) if isinstance(units, str) else units


def present(
    desk: Desk,
    found: Link,
    wanted: Iterable[int] = scan.UNITS,
    timeout_s: float = scan.TIMEOUT_S,
    where: str = "at any address",
) -> tuple[int, ...]:
    """Look for the boards of the bus; raises BoardError if there is none."""
    with desk.progress("looking for boards") as show, scan.quickly(found.modbus, timeout_s):
        answers = scan.scan(found.modbus, wanted, show)
    units = tuple(answer.unit for answer in answers if not answer.trouble)
    if not units:
        raise BoardError(f"{found.port}: no board answers {where}")
    return units


def units_on(desk: Desk, port: str) -> tuple[int, ...]:
    """Return the addresses that the machine file gives boards on a port."""
    try:
        used = desk.facts.found
    except UserError:  # a mistake in the file keeps nobody from looking
        return ()
    if used is None:
        return ()
    there = used.boards.values()
    return tuple(sorted({board.unit for board in there if board.port in (None, port)}))


@contextlib.contextmanager
def stopping(group: list[run.LinesOfBoard]) -> Iterator[None]:
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


def note_unattended(desk: Desk, board: Device) -> None:
    """Say that a board does not go on for long without requests, if it is set so."""
    limit_ms = settings.read(board)["bus_timeout_ms"]
    if limit_ms:
        desk.say((AskedText(
            "board {unit_number} stops with fault bus_silent when no request comes for {limit:g} s "
            "while an axis is armed or moves: follow it ({wait}, `pixstep board watch`), or let it "
            "run alone (`pixstep board set bus_timeout_ms=0`, at rest)",
            unit_number=board.unit, limit=limit_ms / 1000,
        ),))  # fmt: skip


def note_play(desk: Desk, board: Device, axes: list[int]) -> None:
    """Say which of the lines that were armed did not know the play that they take up."""
    desk.say(
        f"board {board.unit} axis {axis}: how much of the play was taken up was not known, as "
        f"after a reset: the line takes up all of it, and the load may be too far by as much"
        for axis in (run.play_unknown(board, axes) if axes else ())
    )


def axes_text(axes: list[int]) -> str:
    """Return some axes in words."""
    return f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(map(str, axes))}"


def _compare(desk: Desk, port: str, unit: int, kind: str) -> None:
    """Refuse a board of another kind than the machine file that is used says.

    The file says it of the board at this address, and of the one whose motor is meant. A request
    that is for any board only notes it.
    """
    machine_file = desk.facts.used
    if machine_file is None:
        return
    for name in _boards_meant(desk, port, unit):
        if machine_file.boards[name].kind == kind:
            continue
        said = f"{machine_file.path} has boards.{name} as a {machine_file.boards[name].kind}"
        text = f"board {unit} on {port} is a {kind}; {said}"
        if not desk.facts.any_board:
            raise RefusedError(text)
        desk.say((text,))


def _boards_meant(desk: Desk, port: str, unit: int) -> list[str]:
    """Return the file's boards that a connected one must be like, by name.

    A board without a port in the file is on every port. A motor of another board that the caller
    gives the address of says nothing of this one.
    """
    facts = desk.facts
    place = [
        name
        for name, board in facts.machine.boards.items()
        if board.port in (None, port) and board.unit == unit
    ]
    motors = facts.motors if facts.named.any or _by_motor(desk) else []
    others = boards_at(facts.machine, [one for one in facts.named.units if one != unit])
    named = [name for name in map(facts.machine.board_name, motors) if name not in others]
    return list(dict.fromkeys([*place, *named]))


def _by_motor(desk: Desk) -> bool:
    """True if a value of the request comes from a motor of the machine file."""
    fields = desk.facts.fields.items()
    return any(
        desk.by_machine(name) and one.machine and machine.needs_motor(one.machine)
        for name, one in fields
    )
