# SPDX-License-Identifier: MIT
"""A board over Modbus: names instead of addresses."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import (
    BUSY,
    IMPOSSIBLE,
    BoardError,
    BusyError,
    ExceptionReplyError,
    LineRefusedByBoardError,
    MapVersionError,
)
from pixstep.board.registers import places, read_by_name
from pixstep.board.state import (
    CLOCK_FAULTS,
    Event,
    NewestRecords,
    ReadBlock,
    Record,
    Switches,
    Trip,
    beside_set,
    fault_hz,
    parse_events,
    read_records,
    read_records_short,
    set_hz,
)
from pixstep.board.wire import Wire

if TYPE_CHECKING:
    from pixstep.board.modbus import Client


@dataclass(frozen=True)
class Identity:
    """What a board says of itself first."""

    unit: int
    map_version: int
    firmware_version: int
    board_id: int
    axis_count: int

    @property
    def board(self) -> str:
        """Its name, as in firmware/avr/boards."""
        return regs.BOARD_IDS.get(self.board_id, f"board {self.board_id}")

    @property
    def firmware(self) -> str:
        """Version as major.minor."""
        return regs.version_text(self.firmware_version)


STORING = 4  # bit of settings_state
_ONCE = frozenset({"arm", "go", "clear_fault", "store"})  # board/orders.py repeats them
_URGENT = "stop"
_CURES = {  # what keeps settings from being changed, by the state of an axis
    "loading": "has a part of a line queued (`pixstep board disarm` forgets it)",
    "loaded": "has a line loaded (`pixstep board disarm` forgets it)",
    "armed": "is armed (`pixstep board disarm` takes it back)",
    "running": "is running (`pixstep board stop` stops it)",
    "refused": "has a refused line queued (`pixstep board disarm` forgets it)",
    "fault": "has stopped with a fault (`pixstep board clear` clears it)",
}


class Device(Wire):
    """One board on the bus; `unit` is its Modbus address."""

    def __init__(self, modbus: Client, unit: int = 1) -> None:
        super().__init__(modbus, unit)
        self.map = regs.register_map()
        self._record_capacity = 0
        self._identity: Identity | None = None
        self._features: frozenset[str] | None = None
        self._packs: bool | None = None

    def input(self, name: str) -> int:
        """Return a board-wide input register by name."""
        register = self.map.input(name)
        return register.decode(self.read_inputs(register.address, register.words))

    def setting(self, name: str) -> int:
        """Return a holding register by name."""
        register = self.map.holding(name)
        return register.decode(self.read_holdings(register.address, register.words))

    def features(self) -> frozenset[str]:
        """Return the names of what the board's image was built with (asked once)."""
        if self._features is None:
            words = (self.input(name) for name in (boards.FEATURES, boards.FEATURES_HIGH))
            self._features = boards.feature_names(*words)
        return self._features

    def has(self, feature: str) -> bool:
        """Return whether the board's image was built with a feature."""
        return feature in self.features()

    def require(self, *wanted: str) -> None:
        """Raise MissingFeatureError for the first of some features that the board has not."""
        for feature in wanted:
            if not self.has(feature):
                raise boards.missing_feature(self.unit, feature)

    def require_no_reset(self, axis: int) -> None:
        """Raise BoardError if the board was reset since it took a line of an axis.

        A block of the line has counted up its number, which nothing but a reset sets to 0.
        """
        if self.axis(axis)["next_block"] == 0:
            raise self.reset_error(axis)

    def reset_error(self, axis: int) -> BoardError:
        """Return that the board was reset during a line of an axis."""
        cause = regs.words(self.map.input("reset_cause"), self.input("reset_cause"))
        return BoardError(
            f"board {self.unit}: it was reset ({cause}) during the line of axis {axis}: lines are "
            f"lost, positions count from 0 again"
        )

    def pixel_period_s(self) -> float:
        """Return the pixel period that the board measures, in seconds."""
        return self.input("pixel_period_ticks") / self.tick_hz()

    def tick_hz(self) -> int:
        """Return the board's timer ticks a second; of an unknown board the slowest there is."""
        found = self._identity or self.who()
        known = [board.tick_hz for board in boards.all_boards()]
        mine = [board.tick_hz for board in boards.all_boards() if board.id == found.board_id]
        return min(mine or known)

    def clock_hz(self) -> Fraction:
        """Return the exact frequency of the pixel clock's edges that the board is set to."""
        return set_hz(self.setting("pixel_hz_num"), self.setting("pixel_hz_den"))

    def inputs(self) -> dict[str, int]:
        """Return all board-wide input registers by name."""
        return read_by_name(places(self.map.inputs), self.read_inputs)

    def inputs_from(self, first: str, last: str) -> dict[str, int]:
        """Return the board-wide input registers from one to another, read in one request."""
        low, high = self.map.input(first).address, self.map.input(last).address
        wanted = [item for item in self.map.inputs if low <= item.address <= high]
        return read_by_name(places(wanted), self.read_inputs)

    def packs(self) -> bool:
        """Return whether the board takes packed blocks (asked once)."""
        if self._packs is None:
            self._packs = self.input("map_version") >= regs.PACKED_MAP_VERSION
        return self._packs

    def room(self, first: int = 0, count: int = 1) -> list[int]:
        """Return the free bytes in the queues of `count` axes from `first` on, in one request."""
        return self.read_inputs(regs.ROOM_BASE + first, count)

    def axis(self, axis: int) -> dict[str, int]:
        """Return the input registers of one axis by name."""
        base = regs.AXIS_BASE + regs.AXIS_STRIDE * axis
        return read_by_name(
            places(self.map.axis_inputs),
            lambda first, count: self.read_inputs(base + first, count),
        )

    def records(self, axis: int) -> list[Record]:
        """Return the newest per-pixel records of an axis, oldest first."""
        return self.record_block(axis).records

    def record_block(self, axis: int) -> NewestRecords:
        """Return the same, and how many the line has made so far."""
        return read_records(
            self._block_reader(axis), self.record_capacity(), self.modbus.most_words
        )

    def short_record_block(self, axis: int) -> NewestRecords | None:
        """Return the same by short requests alone; None if too much is made between them."""
        return read_records_short(
            self._block_reader(axis), self.record_capacity(), self.modbus.most_words
        )

    def _block_reader(self, axis: int) -> ReadBlock:
        """Return what reads the block of an axis' records."""
        base = regs.RECORD_BASE + regs.RECORD_STRIDE * axis

        def read(first: int, count: int, more: bool) -> list[int]:
            self.modbus.more_follows = more
            try:
                return self.read_inputs(base + first, count)
            finally:
                self.modbus.more_follows = False

        return read

    def record_capacity(self) -> int:
        """Return how many per-pixel records the board keeps for each axis (asked once)."""
        if not self._record_capacity:
            self._record_capacity = min(self.input("record_capacity"), regs.MAX_RECORDS)
        return self._record_capacity

    def axes(self, count: int) -> list[dict[str, int]]:
        """Return the input registers of the first `count` axes by name, in one request."""
        words = self.read_inputs(regs.AXIS_BASE, regs.AXIS_STRIDE * count)
        blocks = (words[regs.AXIS_STRIDE * axis :] for axis in range(count))
        return [
            read_by_name(places(self.map.axis_inputs), partial(_part, block)) for block in blocks
        ]

    def moving(self) -> bool:
        """Return True while an axis is armed or runs, and no fault is latched: a short request.

        It is longer than that for the room in the queues, lest their replies be mistaken.
        """
        status = regs.flags(self.inputs_from("status", "fault_pixel")["status"])
        return (status["armed"] or status["running"]) and not status["fault"]

    def write_setting(self, name: str, value: int) -> None:
        """Write one 16-bit holding register by name."""
        self.write_settings(self.map.holding(name).address, [value & 0xFFFF])

    def set_pixel_hz(self, hz: Fraction) -> None:
        """Set the exact pixel frequency: numerator and denominator in one request."""
        words = [hz.numerator >> 16, hz.numerator & 0xFFFF]
        words += [hz.denominator >> 16, hz.denominator & 0xFFFF]
        self.write_settings(self.map.holding("pixel_hz_num").address, words)

    def write_settings(self, address: int, words: list[int]) -> None:
        """Write settings in one request; raises BusyError with the reason if the board is busy."""
        with self._busy_explained(BUSY):
            self.write(address, words)

    def command(self, name: str, axes: list[int], argument: int = 0) -> None:
        """Give a command (a key of registers.COMMANDS) to some axes at once.

        `argument` is a token for arm and go, the key for store and default_settings. An order that
        must not be given twice is sent once, and NoReplyError does not say that it was not heard:
        orders.py has those that find out. A stop goes out at once.
        """
        self._order(name, _command_words(name, axes, argument))

    def go(self, token: int, edge: int) -> None:
        """Let the axes start that were armed with this token.

        Lines that wait for the pixel clock begin on the edge of this number (1..65535), by the
        board's own count (register clock_edge).
        """
        self._order("go", [*_command_words("go", [0], token), edge])

    def _order(self, name: str, words: list[int]) -> None:
        with self.once() if name in _ONCE else contextlib.nullcontext():
            self.write(regs.COMMAND_BASE, words, urgent=name == _URGENT)

    def mark(self) -> None:
        """Make every board on the bus note its newest clock edge; a broadcast: nobody replies.

        Nothing may follow on the bus for 20 ms.
        """
        self.broadcast(regs.COMMAND_BASE, _command_words("mark", [0], 0))

    def stop_all(self) -> None:
        """Stop every axis of every board on the bus; a broadcast: nobody replies.

        A board refuses a command for axes that it has not, so the axes that only larger boards
        have get a frame of their own: each axis is stopped by exactly one.
        """
        first = 0
        for end in sorted(set(regs.AXIS_COUNTS)):
            axes = list(range(first, end))
            self.broadcast(regs.COMMAND_BASE, _command_words("stop", axes, 0))
            first = end

    def permit(self, on: bool) -> None:
        """Switch the permit output, the gate of a laser or spindle."""
        self.command("permit_on" if on else "permit_off", [0])

    def store(self) -> None:
        """Begin to store the settings; done when bit 2 of settings_state is 0 again."""
        with self._busy_explained(IMPOSSIBLE):
            self.command("store", [0], regs.STORE_KEY)

    def default_settings(self) -> None:
        """Put the default settings into force; what is stored stays."""
        with self._busy_explained(IMPOSSIBLE):
            self.command("default_settings", [0], regs.STORE_KEY)

    @contextlib.contextmanager
    def _busy_explained(self, code: int) -> Iterator[None]:
        """Raise BusyError with what keeps settings from being changed for an exception `code`."""
        try:
            yield
        except ExceptionReplyError as error:
            if error.code != code:
                raise
            raise BusyError(self.unit, code, self._occupation()) from None

    def _occupation(self) -> str:
        """Return in words what keeps settings from being changed, and what ends that."""
        state = self.inputs()
        if state["settings_state"] & STORING:
            return "its settings are being stored: try again"
        for axis, found in enumerate(self.axes(state["axis_count"])):
            name = regs.axis_state(found["axis_state"])
            if name in _CURES:
                return f"axis {axis} {_CURES[name]}"
        return "a line is queued, or an axis is not at rest yet: try again"

    def who(self) -> Identity:
        """Return what the board is; raises MapVersionError if its map is not this tool's."""
        words = self.read_inputs(0, 4)
        found = Identity(self.unit, *words)
        if found.map_version != regs.MAP_VERSION:
            raise MapVersionError(
                f"board {self.unit} has register map {found.map_version} (firmware "
                f"{found.firmware}), this tool knows map {regs.MAP_VERSION}: flash the board with "
                f"this tool's firmware (`pixstep flash`), or use the tool that came with it"
            )
        if found.axis_count not in regs.AXIS_COUNTS:
            raise BoardError(
                f"board {self.unit} says that it has {found.axis_count} axes: no board has"
            )
        self._identity = found
        return found

    def events(self) -> tuple[int, list[Event]]:
        """Return how many events there were since reset, and those still kept, oldest first."""
        capacity = min(self.input("event_capacity"), regs.MAX_EVENTS)
        if not capacity:
            return 0, []
        words: list[int] = []
        most = self.modbus.most_words // regs.EVENT_WORDS * regs.EVENT_WORDS
        (total,) = self.read_inputs(regs.EVENT_BASE, 1)
        for first in range(0, capacity * regs.EVENT_WORDS, most):
            count = min(most, capacity * regs.EVENT_WORDS - first)
            words += self.read_inputs(regs.EVENT_BASE + 1 + first, count)
        return total, parse_events(words, min(total, capacity))

    def switches(self, axis: int) -> Switches:
        """Return the home and limit switches of an axis."""
        bits = self.input("inputs") >> 4 * axis
        return Switches(bool(bits & 1), bool(bits & 2), bool(bits & 4))

    def trip(self) -> Trip:
        """Return how the last seek line ended."""
        state = self.inputs()
        return Trip(
            *(state[f"trip_{name}"] for name in ("code", "axis", "position_steps", "ticks"))
        )

    def zero(self, axis: int) -> None:
        """Make the captured edge the position 0 of an axis at rest."""
        self.command("zero", [axis])

    def write_block(self, axis: int, block: int, entries: list[tuple[int, int]]) -> None:
        """Write one block of 1..60 queue entries."""
        words = [block & 0xFFFF, axis]
        for first, second in entries:
            words += [first & 0xFFFF, second & 0xFFFF]
        self.write(regs.QUEUE_WINDOW, words)

    def write_packed(self, axis: int, block: int, data: bytes) -> None:
        """Write one block of 1..242 bytes of packed entries."""
        even = data + bytes(len(data) % 2)
        words = [int.from_bytes(even[at : at + 2]) for at in range(0, len(even), 2)]
        self.write(regs.QUEUE_WINDOW, [block & 0xFFFF, len(data) << 8 | axis, *words])

    def fault_name(self) -> str:
        """Return the name of the board's fault, empty if there is none."""
        code = self.input("fault_code")
        return regs.code_name(regs.faults(), code) if code else ""

    def fault_text(self) -> str:
        """Return the board's fault and its cure in two sentences, empty if there is none."""
        return self.fault()[1]

    def fault(self) -> tuple[str, str]:
        """Return the name of the board's fault, and it in words; both empty if there is none."""
        state = self.inputs()
        name = regs.code_name(regs.faults(), state["fault_code"])
        beside = ""
        if name in CLOCK_FAULTS:
            measured = fault_hz(name, state["fault_argument"], self.tick_hz())
            beside = beside_set(measured, float(self.clock_hz()))
        text = regs.fault_text(state, beside)
        return name if text else "", text

    def fault_advice(self) -> str:
        """Return the same, and how to go on then; empty if there is no fault."""
        text = self.fault_text()
        return f"{text} Then `pixstep board clear`." if text else ""

    def refusal(self, axis: int) -> LineRefusedByBoardError:
        """Return the last refusal of an axis."""
        state = self.axis(axis)
        codes = regs.line_errors()
        code = state["line_error"]
        text = codes[code].text if code in codes else "unknown"
        name = regs.code_name(codes, code)
        return LineRefusedByBoardError(axis, name, state["line_error_pixel"], text)


def _part(words: list[int], first: int, count: int) -> list[int]:
    """Return some of the words that were read at once."""
    return words[first : first + count]


def _command_words(name: str, axes: list[int], argument: int) -> list[int]:
    """Return mask and command, and the argument if there is one."""
    words = [sum(1 << axis for axis in axes), regs.COMMANDS[name]]
    return [*words, argument] if argument else words
