# SPDX-License-Identifier: MIT
"""The register map, the faults and the line errors, of the firmware's own tables.

`read_by_name` reads registers, those that adjoin in one request.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import UserError

AXIS_BASE = 0x20  # per-axis input registers
AXIS_STRIDE = 0x10
FIRST_WARNING = 32  # line errors from here on are warnings: the line is taken
RECORD_BASE = 0x100  # per-pixel records
RECORD_STRIDE = 0x80
RECORD_REGISTERS = 6
RECORD_HEAD = 4
MAX_RECORDS = 20  # of any board; each says its own in record_capacity
QUEUE_WINDOW = 0x1000
MAX_ENTRIES = 60
MAX_PACKED = 120  # bytes in a block: the board checks them in one go, in 2 ms at most
ROOM_BASE = 0xA0  # free bytes of each axis' queue
COMMAND_BASE = 0x100
EVENT_BASE = 0x300  # event log: number of events, then the entries
EVENT_WORDS = 8
MAP_VERSION = 6
PACKED_MAP_VERSION = 4  # boards from this map on take packed blocks
STORE_KEY = 0x5AFE  # argument of store and default_settings
BOARD_IDS = {board.id: board.name for board in boards.all_boards()}
AXIS_COUNTS = tuple(sorted({board.axes for board in boards.all_boards()}))
STATUS_MEASURED = 7  # bit of input register `status`: a lock to the pixel clock can begin
STATUS_STOPPING = 8  # bit of input register `status` for axis 0; the next axes follow
STATUS_PLAY = 12  # axis 0 began its newest line with backlash without knowing its play; and so on
STATUS_BITS = {  # of input register `status`
    "clock": 0,
    "armed": 1,
    "running": 2,
    "fault": 3,
    "estop": 4,
    "permit": 5,
    "listen_only": 6,
}
SYNCS = {"free": 0, "start": 1, "lock": 2}  # of setting `sync`
OUTPUT_PERMIT = 8  # bit of input register `outputs`; bit n is the driver of axis n
# Discrete inputs: the bits of `status`, then those of `inputs`. Coils, n an axis:
DISCRETE_INPUTS = 16
COIL_DRIVER, COIL_ARMED, COIL_STOP, COIL_CLEAR, COIL_PERMIT = 0, 4, 8, 12, 13

COMMANDS = {
    "arm": 1,
    "disarm": 2,
    "stop": 3,
    "clear_fault": 4,
    "discard": 5,
    "enable": 6,
    "disable": 7,
    "zero": 8,
    "permit_on": 9,
    "permit_off": 10,
    "store": 11,
    "default_settings": 12,
    "go": 13,
    "mark": 14,
}
MAX_EVENTS = 256  # of any board's event log; each says its own in event_capacity
_WORDS = {"u16": 1, "i16": 1, "u32": 2, "i32": 2}


@dataclass(frozen=True)
class RegisterEntry:
    """One register: where, what, its unit and meaning; limits only for a holding register.

    `values` has what each value (of a state or code) or each bit stands for, if any does.
    """

    address: int
    name: str
    type: str
    unit: str
    meaning: str
    minimum: int | None = None
    maximum: int | None = None
    default: int | None = None
    values: Mapping[int, str] = field(default_factory=dict, compare=False)

    @property
    def words(self) -> int:
        """Number of 16-bit registers it takes."""
        return _WORDS[self.type]

    def decode(self, words: list[int]) -> int:
        """Return the value of its words, high word first."""
        value = 0
        for word in words:
            value = value << 16 | word
        bits = 16 * self.words
        if self.type.startswith("i") and value >> (bits - 1):
            value -= 1 << bits
        return value


@dataclass(frozen=True)
class Code:
    """A line error or warning: its number, name and text, and what a user does about it."""

    code: int
    name: str
    text: str
    cure: str


@dataclass(frozen=True)
class Fault:
    """A fault of the board, in sentences for who stands at the machine.

    `argument` says what the argument register holds, empty: nothing. `position` is what is still
    known of where the motors are.
    """

    code: int
    name: str
    text: str
    argument: str
    position: str
    cause: str
    cure: str


@dataclass(frozen=True)
class RegisterMap:
    """The whole map; axis registers hold offsets inside an axis' block."""

    inputs: tuple[RegisterEntry, ...]
    axis_inputs: tuple[RegisterEntry, ...]
    holdings: tuple[RegisterEntry, ...]

    def input(self, name: str) -> RegisterEntry:
        """Return a board-wide input register by name."""
        return _named(self.inputs, name)

    def axis_input(self, name: str) -> RegisterEntry:
        """Return a per-axis input register by name."""
        return _named(self.axis_inputs, name)

    def holding(self, name: str) -> RegisterEntry:
        """Return a holding register by name."""
        return _named(self.holdings, name)


@cache
def register_map() -> RegisterMap:
    """Return the register map."""
    groups = natives.tables()["registers"]
    return RegisterMap(
        tuple(map(_register, groups["inputs"])),
        tuple(map(_register, groups["axis_inputs"])),
        tuple(map(_register, groups["holdings"])),
    )


@cache
def faults() -> dict[int, Fault]:
    """Return the faults by code."""
    return {row["code"]: Fault(**row) for row in natives.tables()["faults"]}


@cache
def line_errors() -> dict[int, Code]:
    """Return the line errors and warnings by code."""
    return {row["code"]: Code(**row) for row in natives.tables()["line_errors"]}


def flags(status: int) -> dict[str, bool]:
    """Return the bits of input register `status` by name."""
    return {name: bool(status >> bit & 1) for name, bit in STATUS_BITS.items()}


def is_measured(status: int) -> bool:
    """Return whether a board has measured its pixel clock, by its input register `status`."""
    return bool(status >> STATUS_MEASURED & 1)


def axis_state(code: int) -> str:
    """Return the name of an axis' state, or its number if this tool does not know it."""
    return AXIS_STATES[code] if code < len(AXIS_STATES) else f"state {code}"


def fault_text(state: Mapping[str, int], beside: str = "") -> str:
    """Return the fault of a board's input registers and its cure, empty if there is none.

    `beside` is what else is known of it.
    """
    code, argument = state["fault_code"], state["fault_argument"]
    if not code:
        return ""
    where = f"on axis {state['fault_axis']} at pixel {state['fault_pixel']}"
    fault = faults().get(code)
    if fault is None:
        return f"fault code {code} {where}, argument {argument}"
    known = [f"{fault.argument}: {argument}"] if fault.argument else []
    known += [beside] if beside else []
    told = f" ({'; '.join(known)})" if known else ""
    return f"fault {fault.name} {where}: {fault.text}{told}. {fault.cure}"


def settings() -> tuple[RegisterEntry, ...]:
    """Return the holding registers that are settings, in the order of their addresses."""
    found = (item for item in register_map().holdings if item.address < COMMAND_BASE)
    return tuple(sorted(found, key=lambda item: item.address))


def version_text(version: int) -> str:
    """Return a firmware version as major.minor."""
    return f"{version >> 8}.{version & 0xFF}"


def words(register: RegisterEntry, value: int) -> str:
    """Return a value in words: its state, its bits joined by commas; empty if it has none."""
    known = register.values
    if not known:
        return _special(register, value)
    if register.unit == "bits":
        bits = [known.get(bit, f"bit {bit}") for bit in range(16) if value >> bit & 1]
        return ", ".join(bits) or "none"
    return known.get(value, f"unknown {register.unit} {value}")


def _special(register: RegisterEntry, value: int) -> str:
    """Return the words of the few registers that are coded in their own way."""
    if register.name == "firmware_version":
        return version_text(value)
    if register.name == "board_id":
        return BOARD_IDS.get(value, "unknown")
    if register.name == "baud_100":
        return f"{100 * value} baud"
    return ""


def code_name(codes: Mapping[int, Code | Fault], code: int) -> str:
    """Return the name of a code, or its number if this tool does not know it."""
    return codes[code].name if code in codes else f"code {code}"


def _register(row: dict[str, Any]) -> RegisterEntry:
    values = {int(value): text for value, text in row.get("values", {}).items()}
    return RegisterEntry(**row | {"values": values})


def _named(registers: tuple[RegisterEntry, ...], name: str) -> RegisterEntry:
    for register in registers:
        if register.name == name:
            return register
    raise UserError(f"the register map has no register {name!r}")


AXIS_STATES = tuple(register_map().axis_input("axis_state").values.values())
MOVING_STATES = ("armed", "running")  # of an axis that moves, or is about to


MOST_WORDS = 125  # of one request
ReadWords = Callable[[int, int], list[int]]  # first address and number of words


class PlacedRegister(NamedTuple):
    """A register of a board under the name and at the address that it has there."""

    name: str
    address: int
    register: RegisterEntry

    @property
    def end(self) -> int:
        """The address behind it."""
        return self.address + self.register.words


def places(registers: Iterable[RegisterEntry]) -> list[PlacedRegister]:
    """Return registers under their own names, where the map has them."""
    return [PlacedRegister(item.name, item.address, item) for item in registers]


def read_by_name(wanted: Iterable[PlacedRegister], read: ReadWords) -> dict[str, int]:
    """Read registers of one area in one request per gapless stretch; return them by name."""
    found = {}
    for stretch in _stretches(wanted):
        first = stretch[0].address
        words = read(first, stretch[-1].end - first)
        for place in stretch:
            mine = words[place.address - first : place.end - first]
            found[place.name] = place.register.decode(mine)
    return found


def _stretches(wanted: Iterable[PlacedRegister]) -> list[list[PlacedRegister]]:
    """Group registers into gapless stretches, each fit for one request."""
    groups: list[list[PlacedRegister]] = []
    for place in sorted(wanted, key=lambda item: item.address):
        last = groups[-1] if groups else []
        fits = last and place.address == last[-1].end
        if fits and place.end - last[0].address <= MOST_WORDS:
            last.append(place)
        else:
            groups.append([place])
    return groups
