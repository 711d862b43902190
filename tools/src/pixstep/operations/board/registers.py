# SPDX-License-Identifier: MIT
"""Registers of boards by name: get them, set those that are settings."""

from __future__ import annotations

from typing import NotRequired, TypedDict

from pixstep.board import boards, settings, values
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.board.settings import ChangeData
from pixstep.board.values import SETTING, RegisterReading
from pixstep.errors import UserError
from pixstep.operations import bus
from pixstep.operations.bus import Known, ToBoards
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import TEXT
from pixstep.operations.request import argument, flag, operation
from pixstep.operations.result import Page, Result
from pixstep.simulation import report

STORE_HELP = "Store the settings in the board's EEPROM afterwards."


class Register(TypedDict):
    """A register and its value; only a setting has limits."""

    name: str
    value: int
    unit: str
    words: str
    address: int
    type: str
    meaning: str
    minimum: NotRequired[int]
    maximum: NotRequired[int]
    default: NotRequired[int]


class BoardRegisters(TypedDict):
    """Registers of a board."""

    unit: int
    registers: list[Register]


class Registers(TypedDict):
    """Registers of some boards."""

    boards: list[BoardRegisters]


class ChangedBoard(TypedDict):
    """What changed on a board, and the record that was stored if any was."""

    unit: int
    changed: list[ChangeData]
    record: NotRequired[int]


class SetBoard(ChangedBoard):
    """The same beside what was as wanted already."""

    unchanged: dict[str, int]


class SetBoards(TypedDict):
    """What changed on some boards."""

    boards: list[SetBoard]


@operation("board get")
class Get(ToBoards):
    """Read registers by name, or all of them.

    Settings, what the board measures, and its axes'. NAME may have wild cards ('dir_*'), an axis
    ('axis0.position_steps', without the axis all of them); none at all means everything.
    """

    result = Registers

    names: tuple[str, ...] = argument(TEXT, many=True, required=False, shown="[NAME]...")

    def run(self, desk: Desk) -> Result:
        """Read them from each board."""
        values.select(self.names, max(regs.AXIS_COUNTS))  # an unknown name before the port is open
        with bus.boards(desk, self) as (_found, known):
            for item in known:
                _require(item.board, self.names)
            told = [
                (item, values.read(item.board, values.select(self.names, item.who.axis_count)))
                for item in known
            ]
        rows = [
            {"unit": item.board.unit, "registers": [one.as_json() for one in readings]}
            for item, readings in told
        ]
        return Result({"boards": rows}, lambda page: self._write(page, told))

    def _write(self, page: Page, told: list[tuple[Known, list[RegisterReading]]]) -> None:
        for item, readings in told:
            if len(told) > 1:
                page.tell(f"board {item.board.unit}:")
            if not self.names:
                _write_table(page, readings)
                continue
            for reading in readings:
                page.tell(_text(reading))


@operation("board set")
class Set(ToBoards):
    """Change settings, all of them in one request: all or none.

    pixel_hz=30000/1001 sets its four words, baud=19200 and parity=N what they say. When address,
    rate or parity change, the next commands need the new ones.
    """

    result = SetBoards

    assigned: tuple[str, ...] = argument(TEXT, many=True, shown="NAME=VALUE...")
    store: bool = flag(STORE_HELP)

    def run(self, desk: Desk) -> Result:
        """Set each board."""
        wanted = values.assignments(self.assigned)
        with bus.boards(desk, self) as (found, known):
            if "unit_address" in wanted and len(known) > 1:
                raise UserError("unit_address: several boards cannot have one address")
            rows = desk.rows()
            for item in known:
                row = _set(item.board, wanted, found.world, store=self.store)
                rows.add(row, _set_text(row, several=len(known) > 1))
        return rows.result()


def _require(board: Device, names: tuple[str, ...]) -> None:
    """Refuse a register asked for by its name that says nothing on this board."""
    needed = {
        boards.FEATURE_OF_REGISTERS[name] for name in names if name in boards.FEATURE_OF_REGISTERS
    }
    if needed:
        board.require(*sorted(needed))


def _write_table(page: Page, readings: list[RegisterReading]) -> None:
    """Write values with their meanings."""
    table = report.new_table("name", "value", "in words", "range", "default", "meaning")
    for column in table.columns:
        column.justify = "left"
        column.no_wrap = False
    table.columns[0].no_wrap = True
    for reading in readings:
        register = reading.item.register
        is_setting = reading.item.kind == SETTING
        table.add_row(
            reading.item.name,
            f"{reading.value}{values.unit_text(register)}",
            reading.words,
            values.range_text(register) if is_setting else "",
            str(register.default) if is_setting else "",
            register.meaning,
        )
    page.draw(table, wide=True)


def _text(reading: RegisterReading) -> str:
    """Return a value as `name = value unit (words)`."""
    words = f" ({reading.words})" if reading.words else ""
    unit = values.unit_text(reading.item.register)
    return f"{reading.item.name} = {reading.value}{unit}{words}"


def _set(board: Device, wanted: dict[str, int], world: World, *, store: bool) -> SetBoard:
    """Set one board; return what changed."""
    needed = {
        boards.FEATURE_OF_REGISTERS[name] for name in wanted if name in boards.FEATURE_OF_REGISTERS
    }
    board.require(*sorted(needed | ({"store"} if store else set())))
    old = settings.read(board)
    found = settings.changes(old, wanted)
    unit = board.unit  # before a new one is in force
    settings.write(board, old, found)
    row: SetBoard = {
        "unit": unit,
        "changed": [change.as_json() for change in found],
        "unchanged": {name: old[name] for name in wanted if old[name] == wanted[name]},
    }
    if store:
        row["record"] = settings.store(board, world)
    return row


def _set_text(row: SetBoard, *, several: bool) -> str:
    texts = [change_text(change) for change in row["changed"]]
    texts += [f"{name} is {value} already" for name, value in row["unchanged"].items()]
    if "record" in row:
        texts.append(f"stored as record {row['record']}")
    where = f"board {row['unit']}: " if several else ""
    return "\n".join(where + text for text in texts)


def change_text(row: ChangeData) -> str:
    """Return a change as `name: old -> new unit (words)`."""
    register = values.check(row["name"], row["new"])
    words = regs.words(register, row["new"])
    unit = values.unit_text(register)
    return f"{row['name']}: {row['old']} -> {row['new']}{unit}" + (f" ({words})" if words else "")
