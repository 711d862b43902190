# SPDX-License-Identifier: MIT
"""The settings of a board: all of them at once, all-or-nothing writes, the stored copy."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TypedDict

from pixstep.board import boards, orders, registers, values
from pixstep.board import registers as regs
from pixstep.board.device import STORING, Device
from pixstep.board.errors import BoardError, ExceptionReplyError, NoReplyError
from pixstep.board.link import World
from pixstep.board.port import PARITIES
from pixstep.board.registers import RegisterEntry
from pixstep.errors import UserError
from pixstep.lines.units import refuse_period

STORED, DIFFERS = 1, 2  # bits of settings_state
_STORE_LIMIT_S = 5.0
_MOVES = 3  # times that a change of the address or rate is sent
_POLL_S = 0.02
_PARITY_LETTERS = {value: letter for letter, value in PARITIES.items()}
_LINE = ("baud_100", "parity")
_ADDRESS = "unit_address"


class ChangeData(TypedDict):
    """A change as plain data."""

    name: str
    old: int
    new: int
    unit: str


@dataclass(frozen=True)
class Change:
    """One setting, before and after."""

    register: RegisterEntry
    old: int
    new: int

    @property
    def name(self) -> str:
        """Name of the setting."""
        return self.register.name

    def as_json(self) -> ChangeData:
        """Return plain data."""
        return {"name": self.name, "old": self.old, "new": self.new, "unit": self.register.unit}


def read(board: Device) -> dict[str, int]:
    """Return all settings by name, read in one request."""
    return registers.read_by_name(registers.places(regs.settings()), board.read_holdings)


def defaults() -> dict[str, int]:
    """Return the settings of a board that has none stored."""
    return {item.name: item.default or 0 for item in regs.settings()}


def changes(old: dict[str, int], new: dict[str, int]) -> list[Change]:
    """Return what differs, in the order of the register map; `new` may hold only some."""
    return [
        Change(item, old[item.name], new[item.name])
        for item in regs.settings()
        if item.name in new and old[item.name] != new[item.name]
    ]


def write(board: Device, old: dict[str, int], wanted: list[Change]) -> None:
    """Make changes in one all-or-nothing request, and read them back.

    The settings in between are written as they were. When address, rate or parity change, the
    client follows. Raises UserError for a pixel frequency that the board cannot carry, BoardError
    also if the board reads back something else.
    """
    if not wanted:
        return
    new = old | {change.name: change.new for change in wanted}
    refuse_period(values.hz_of(new), board.tick_hz())
    refuse_period(values.hz_of(new) / divider_of(new), board.tick_hz(), locked=locks(new))
    first, end = _span([change.register for change in wanted])
    words: list[int] = []
    for item in regs.settings():
        if first <= item.address < end:
            words += [
                new[item.name] >> 16 * (item.words - 1 - index) & 0xFFFF
                for index in range(item.words)
            ]
    changed = {change.name for change in wanted}
    if changed.intersection((_ADDRESS, *_LINE)):
        _move(board, partial(board.write_settings, first, words), old, new)
    else:
        board.write_settings(first, words)
    found = _read_back(board, changed)
    for change in wanted:
        if found[change.name] != change.new:
            raise BoardError(
                f"board {board.unit}: {change.name} reads back {found[change.name]}, "
                f"not {change.new}"
            )


def _read_back(board: Device, changed: set[str]) -> dict[str, int]:
    """Read the settings after a change; say so if the board has taken it and is lost since."""
    try:
        return read(board)
    except NoReplyError:
        if not changed.intersection((_ADDRESS, *_LINE)):
            raise
        place = board.modbus.place or "the line"
        raise BoardError(
            f"board {board.unit}: it has taken the change and does not answer any more on {place}; "
            f"unless they are stored, a reset brings the settings before back"
        ) from None


def follow(board: Device, old: Mapping[str, int], new: Mapping[str, int]) -> None:
    """Let the client talk to the board as its new settings say."""
    board.unit = new[_ADDRESS]
    if any(old[name] != new[name] for name in _LINE):
        board.modbus.follow(100 * new["baud_100"], _PARITY_LETTERS[new["parity"]])


def use_defaults(board: Device) -> None:
    """Put the defaults into force and follow them on the line."""
    _move(board, board.default_settings, read(board), defaults())


def _move(
    board: Device, order: Callable[[], None], old: Mapping[str, int], new: Mapping[str, int]
) -> None:
    """Give an order after which the board may answer at another address or rate, and follow it.

    If the reply is lost, the board is looked for: first where it was, since only this board answers
    there, then where it should be. A board that is still where it was has not heard the order.
    Raises UserError for an address where a board answers already.
    """
    if new[_ADDRESS] != old[_ADDRESS]:
        _refuse_taken(board, new[_ADDRESS])
    for last in (False,) * (_MOVES - 1) + (True,):
        try:
            with board.once():
                order()
        except NoReplyError:
            if not _is_there(board):
                follow(board, old, new)
                if _is_there(board):
                    return
                follow(board, new, old)
            if last:
                raise
        else:
            follow(board, old, new)
            return


def _refuse_taken(board: Device, unit: int) -> None:
    """Raise UserError if another board has an address: neither could be asked any more."""
    try:
        with board.once():
            Device(board.modbus, unit).read_inputs(0, 1)
    except NoReplyError:
        return
    except ExceptionReplyError:
        pass
    raise UserError(
        f"board {board.unit}: {_ADDRESS} = {unit}: another board answers at this address already"
    )


def _is_there(board: Device) -> bool:
    """Whether the board answers at the address and rate at which the client asks."""
    try:
        return board.setting(_ADDRESS) == board.unit
    except NoReplyError:
        return False


def store(board: Device, world: World) -> int:
    """Store the settings in the board's EEPROM; return the number of the record.

    Raises MissingFeatureError, and nothing is sent, for a board that cannot.
    """
    board.require("store")
    before = board.input("settings_serial")
    orders.store(board, before)
    end = world.now_s() + _STORE_LIMIT_S
    while board.input("settings_state") & STORING:
        if world.now_s() > end:
            raise BoardError(f"board {board.unit}: storing takes longer than {_STORE_LIMIT_S} s")
        world.wait(_POLL_S)
    serial = board.input("settings_serial")
    if serial == before or board.input("settings_state") & DIFFERS:
        raise BoardError(f"board {board.unit}: the settings were not stored (record {serial})")
    return serial


def divider(board: Device) -> int:
    """Return how many edges of the clock a pixel has on the board."""
    return divider_of(read(board))


def divider_of(known: dict[str, int]) -> int:
    """Return the same of its settings; a board that has no such setting has one edge."""
    return known.get("divider", 1)


def pixel_hz(board: Device, clock: Fraction | None = None, divider: int | None = None) -> Fraction:
    """Return the exact frequency of the board's pixels; of those of another clock or divider."""
    known = read(board)
    return (clock or values.hz_of(known)) / (divider or divider_of(known))


def locks(known: Mapping[str, int]) -> bool:
    """True if a board with these settings locks lines to its pixel clock."""
    return known.get("sync") == regs.SYNCS["lock"]


def gate_of(known: Mapping[str, int]) -> int:
    """Return how many edges behind a burst's first one lines begin; 0: the clock is not gated."""
    return known.get(boards.GATE_SETTING, 0)


def of_clock(
    sync: str | None,
    divider: int | None,
    gate_edges: int | None = None,
    clock_out_hz: int | None = None,
) -> dict[str, int]:
    """Return the settings that say what lines are to the pixel clock; without what is None."""
    given = {
        "sync": None if sync is None else regs.SYNCS[sync],
        "divider": divider,
        boards.GATE_SETTING: gate_edges,
        boards.CLOCK_OUT_SETTING: clock_out_hz,
    }
    return {name: value for name, value in given.items() if value is not None}


def set_clock(
    board: Device,
    clock: Fraction | None,
    sync: str | None = None,
    divider: int | None = None,
    gate_edges: int | None = None,
    clock_out_hz: int | None = None,
) -> None:
    """Set the pixel clock of a board as far as it is given and differs, in one request.

    Raises UserError for a gate whose line zero is too near, MissingFeatureError for a board that
    knows of no gate or makes no clock itself; nothing is written then.
    """
    if gate_edges:
        board.require(boards.GATE_FEATURE)
    if clock_out_hz:
        board.require(boards.CLOCK_OUT_FEATURE)
    old = read(board)
    wanted = old | of_clock(sync, divider, gate_edges, clock_out_hz)
    if clock is not None and values.hz_of(old) != clock:
        wanted |= {"pixel_hz_num": clock.numerator, "pixel_hz_den": clock.denominator}
    if gate_edges:
        boards.refuse_gate(gate_edges, values.hz_of(wanted), board.tick_hz(), locked=locks(wanted))
    write(board, old, changes(old, wanted))


def _span(table: Sequence[regs.RegisterEntry]) -> tuple[int, int]:
    """Return the first address of registers and the one behind the last."""
    return table[0].address, table[-1].address + table[-1].words
