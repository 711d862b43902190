# SPDX-License-Identifier: MIT
"""Registers of boards by name: get them, set those that are settings.

All settings at once: as a TOML file and back, stored, defaults, compared.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep import atomic
from pixstep.board import boards, settings, values
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.board.settings import ChangeData
from pixstep.board.values import SETTING, RegisterReading, SettingsFile
from pixstep.errors import FINE, NEGATIVE, RefusedError, UserError
from pixstep.operations import bus
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import Known, ToBoard, ToBoards
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, TEXT
from pixstep.operations.request import argument, flag, operation, option
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


_ADDRESS, _BOARD = "unit_address", "board"


class ExportedSettings(TypedDict):
    """A file of settings that was written; `settings` is how many."""

    file: str
    unit: int
    board: str
    settings: int


class ImportedSettings(TypedDict):
    """What a file changed on some boards, or would change if nothing was `written`."""

    file: str
    written: bool
    boards: list[ChangedBoard]


class StoredBoard(TypedDict):
    """The record that was stored on a board."""

    unit: int
    record: int


class StoredBoards(TypedDict):
    """What was stored on some boards."""

    boards: list[StoredBoard]


class DefaultSettings(TypedDict):
    """A board whose default settings are in force, and the record if one was stored."""

    unit: int
    record: NotRequired[int]


class DifferentSetting(TypedDict):
    """A setting that a board has otherwise."""

    name: str
    other: int
    board: int


class SettingsDifference(TypedDict):
    """The settings in which a board differs from a file, or from the defaults."""

    unit: int
    other: str
    different: list[DifferentSetting]


@operation("board settings export")
class Export(ToBoard):
    """Write all settings in force to a TOML file.

    Each with what it means; "-" writes to the terminal.
    """

    result = ExportedSettings

    file: Path = argument(OUTPUT)

    def run(self, desk: Desk) -> Result:
        """Read the settings and write them."""
        with bus.one_board(desk, self) as (_found, known):
            found = settings.read(known.board)
        values.write_file(self.file, known.who, found)
        facts = {
            "file": str(self.file), "unit": self.unit, "board": known.who.board,
            "settings": len(found),
        }  # fmt: skip
        text = f"{self.file}: {len(found)} settings of board {self.unit} ({known.who.board})"
        return Result(facts, "" if atomic.is_stdout(self.file) else text)


@operation("board settings import")
class Import(ToBoards):
    """Set what a TOML file says, all or nothing; read it back.

    The file may hold only some settings; those that it leaves out stay as they are. One that says
    of which board it is goes onto no other; an exported one that was cut off is refused.
    """

    result = ImportedSettings

    file: Path = argument(FILE)
    skip: tuple[str, ...] = option(
        TEXT,
        "Leave this setting as it is; board: take the file of another board; again for more.",
        many=True, shown="NAME",
    )  # fmt: skip
    store: bool = flag(STORE_HELP)
    dry_run: bool = flag("Only show what would change.")

    def run(self, desk: Desk) -> Result:
        """Set each board, once all of them may be."""
        read = values.read_file(self.file)
        wanted = self._wanted(read)
        with bus.boards(desk, self) as (found, known):
            if _ADDRESS in wanted and len(known) > 1:
                raise AskedError(
                    "{path}: several boards cannot have one address: add {skip} {address}",
                    path=self.file, address=_ADDRESS,
                )  # fmt: skip
            for item in known if _BOARD not in self.skip else ():
                read.refuse_other(item.who)
            for item in known if self.store and not self.dry_run else ():
                item.board.require("store")
            rows = desk.rows(beside={"file": str(self.file), "written": not self.dry_run})
            for item in known:
                old = settings.read(item.board)
                change = settings.changes(old, wanted)
                row: ChangedBoard = {
                    "unit": item.board.unit,
                    "changed": [one.as_json() for one in change],
                }
                if not self.dry_run:
                    with _of_file(self.file):
                        settings.write(item.board, old, change)
                    if self.store:
                        row["record"] = settings.store(item.board, found.world)
                rows.add(row, self._text(row))
        return rows.result()

    def _wanted(self, read: SettingsFile) -> dict[str, int]:
        """Return what the file asks for, without what is to be left out."""
        for name in self.skip:
            if name not in (_BOARD, *settings.defaults()):
                raise AskedError("{skip} {name}: there is no such setting", name=name)
        return {name: value for name, value in read.settings.items() if name not in self.skip}

    def _text(self, row: ChangedBoard) -> str:
        done = "would change" if self.dry_run else "changed"
        count = len(row["changed"])
        texts = [f"board {row['unit']}: {count} setting{'' if count == 1 else 's'} {done}"]
        texts += [f"  {change_text(change)}" for change in row["changed"]]
        if "record" in row:
            texts.append(f"  stored as record {row['record']}")
        return "\n".join(texts)


@contextlib.contextmanager
def _of_file(file: Path) -> Iterator[None]:
    """Say of which file the values are that do not go together."""
    try:
        yield
    except UserError as error:
        raise RefusedError(f"{file}: {error}") from None


@operation("board settings store")
class Store(ToBoards):
    """Store the settings in force in the board's EEPROM."""

    result = StoredBoards

    def run(self, desk: Desk) -> Result:
        """Store those of each board."""
        with bus.boards(desk, self) as (found, known):
            rows = desk.rows()
            for item in known:
                unit, serial = item.board.unit, settings.store(item.board, found.world)
                rows.add(
                    {"unit": unit, "record": serial}, f"board {unit}: stored as record {serial}"
                )
        return rows.result()


@operation("board settings defaults")
class UseDefaults(ToBoards):
    """Put the default settings into force.

    Address 1, 115200 baud, even parity, 30 Hz and so on.
    """

    result = DefaultSettings

    store: bool = flag("Store them too; else the stored ones return at reset.")

    def run(self, desk: Desk) -> Result:
        """Set one board."""
        with bus.boards(desk, self) as (found, known):
            if len(known) > 1:
                raise UserError("one board at a time: by default all have address 1")
            board = known[0].board
            if self.store:
                board.require("store")
            settings.use_defaults(board)
            facts: DefaultSettings = {"unit": board.unit}
            text = f"default settings are in force; the board is now unit {board.unit}"
            if self.store:
                facts["record"] = settings.store(board, found.world)
                text += f"\nstored as record {facts['record']}"
        return Result(facts, text)


@operation("board settings diff")
class Diff(ToBoard):
    """Compare with a TOML file, or with the defaults.

    Exit status 0 if they are equal, 1 if not.
    """

    result = SettingsDifference

    file: Path | None = argument(FILE, required=False)

    def run(self, desk: Desk) -> Result:
        """Read the settings and compare them."""
        wanted = values.read_file(self.file).settings if self.file else settings.defaults()
        with bus.one_board(desk, self) as (_found, known):
            there = settings.read(known.board)
        found = settings.changes(wanted, {name: there[name] for name in wanted})
        other = str(self.file) if self.file else "the defaults"
        rows = [{"name": one.name, "other": one.old, "board": one.new} for one in found]
        data = {"unit": self.unit, "other": other, "different": rows}
        if not found:
            return Result(data, f"board {self.unit}: no difference to {other}", FINE)
        changes = (change_text(one.as_json()) for one in found)
        return Result(data, "\n".join([f"{other} -> board {self.unit}", *changes]), NEGATIVE)
