# SPDX-License-Identifier: MIT
"""All settings of boards: as a TOML file and back, stored, defaults, compared."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep import atomic
from pixstep.board import settings, values
from pixstep.board.values import SettingsFile
from pixstep.errors import FINE, NEGATIVE, RefusedError, UserError
from pixstep.operations import bus
from pixstep.operations.asked import AskedError
from pixstep.operations.board.registers import STORE_HELP, ChangedBoard, change_text
from pixstep.operations.bus import ToBoard, ToBoards
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, TEXT
from pixstep.operations.request import argument, flag, operation, option
from pixstep.operations.result import Result

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
    """What a board has otherwise than a file or the defaults."""

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
    """Store the settings in force: they outlast power."""

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
