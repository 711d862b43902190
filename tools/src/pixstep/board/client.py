# SPDX-License-Identifier: MIT
"""A board over Modbus: names instead of addresses, lines instead of register blocks.

Uploading repeats a block whose reply was lost (the board drops the copy), waits while the queue
is full, and streams lines longer than the queue: call `Upload.push` again while the line runs.
"""

from dataclasses import dataclass
from fractions import Fraction

from pymodbus.client import ModbusSerialClient
from pymodbus.exceptions import ModbusException
from pymodbus.pdu import ModbusPDU

from pixstep.board import registers as regs

_ILLEGAL_VALUE = 3
_BUSY = 6
_EXCEPTIONS = {
    1: "illegal function",
    2: "illegal address",
    3: "illegal value",
    4: "device failure",
    5: "acknowledge",
    6: "busy",
}


class BoardError(Exception):
    """The board did not do as asked: no reply, an exception answer, a refused line, a fault."""

    def __init__(self, message: str, code: int | None = None) -> None:
        super().__init__(message)
        self.code = code


class LineRefusedByBoardError(BoardError):
    """The board refused a line while it was queued; `name` and `pixel` say what and where."""

    def __init__(self, axis: int, name: str, pixel: int, text: str) -> None:
        super().__init__(f"axis {axis}: line refused: {name} at pixel {pixel}: {text}")
        self.axis, self.name, self.pixel = axis, name, pixel


@dataclass(frozen=True)
class Record:
    """One per-pixel record of the board."""

    pixel: int
    expected_steps: int
    actual_steps: int
    edge_error_ticks: int


TRIP_NONE, TRIP_CLOSED, TRIP_OPENED, TRIP_ALREADY = range(4)


@dataclass(frozen=True)
class Trip:
    """How the last seek line ended: the edge of a home switch, as the hardware captured it.

    `code` is TRIP_CLOSED or TRIP_OPENED; TRIP_NONE if the line went to its end or still runs,
    TRIP_ALREADY if the switch was as sought from the start: no edge then. `position_steps` is the
    axis' position at the edge (the steps whose STEP edge lies at or before it), `ticks` when it was
    since the board's timers started, modulo 2^32.
    """

    code: int
    axis: int
    position_steps: int
    ticks: int


@dataclass(frozen=True)
class Switches:
    """The filtered switches of one axis; True is tripped."""

    home: bool
    limit_minus: bool
    limit_plus: bool


class Board:
    """One board on the line; `unit` is its Modbus address."""

    def __init__(self, modbus: ModbusSerialClient, unit: int = 1) -> None:
        self.modbus = modbus
        self.unit = unit
        self.map = regs.register_map()
        self._record_capacity = 0

    def read_inputs(self, address: int, count: int) -> list[int]:
        """Return `count` (1..125) input registers."""
        reply = self._ask("read", self.modbus.read_input_registers, address, count=count)
        return list(reply.registers)

    def read_holdings(self, address: int, count: int) -> list[int]:
        """Return `count` (1..125) holding registers."""
        reply = self._ask("read", self.modbus.read_holding_registers, address, count=count)
        return list(reply.registers)

    def write(self, address: int, words: list[int]) -> None:
        """Write holding registers in one all-or-nothing request."""
        self._ask("write", self.modbus.write_registers, address, words)

    def identify(self) -> ModbusPDU:
        """Return the answer to FC17, report server id."""
        return self._ask("identify", self.modbus.report_device_id)

    def input(self, name: str) -> int:
        """Return a board-wide input register by name."""
        register = self.map.input(name)
        return register.decode(self.read_inputs(register.address, register.words))

    def inputs(self) -> dict[str, int]:
        """Return all board-wide input registers by name."""
        return _decode(self.map.inputs, lambda first, count: self.read_inputs(first, count))

    def axis(self, axis: int) -> dict[str, int]:
        """Return the input registers of one axis by name."""
        base = regs.AXIS_BASE + regs.AXIS_STRIDE * axis
        return _decode(
            self.map.axis_inputs, lambda first, count: self.read_inputs(base + first, count)
        )

    def records(self, axis: int) -> list[Record]:
        """Return the newest per-pixel records of an axis, oldest first."""
        words = self.read_inputs(
            regs.RECORD_BASE + regs.RECORD_STRIDE * axis,
            regs.RECORD_HEAD + self.record_capacity() * regs.RECORD_REGISTERS,
        )
        return _parse_records(words)

    def record_capacity(self) -> int:
        """Return how many per-pixel records the board keeps for each axis (asked once)."""
        if not self._record_capacity:
            self._record_capacity = min(self.input("record_capacity"), regs.MAX_RECORDS)
        return self._record_capacity

    def axes(self, count: int) -> list[dict[str, int]]:
        """Return the input registers of the first `count` axes by name, in one request."""
        words = self.read_inputs(regs.AXIS_BASE, regs.AXIS_STRIDE * count)
        return [
            _decode(
                self.map.axis_inputs,
                lambda first, number, base=regs.AXIS_STRIDE * axis: words[
                    base + first : base + first + number
                ],
            )
            for axis in range(count)
        ]

    def write_setting(self, name: str, value: int) -> None:
        """Write one 16-bit holding register by name."""
        self.write(self.map.holding(name).address, [value & 0xFFFF])

    def set_pixel_hz(self, hz: Fraction) -> None:
        """Set the exact pixel frequency: numerator and denominator in one request."""
        words = [hz.numerator >> 16, hz.numerator & 0xFFFF]
        words += [hz.denominator >> 16, hz.denominator & 0xFFFF]
        self.write(self.map.holding("pixel_hz_num").address, words)

    def command(self, name: str, axes: list[int]) -> None:
        """Give a command (a key of registers.COMMANDS) to some axes at once."""
        mask = sum(1 << axis for axis in axes)
        self.write(regs.COMMAND_BASE, [mask, regs.COMMANDS[name]])

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

    def fault_name(self) -> str:
        """Return the name of the board's fault, empty if there is none."""
        code = self.input("fault_code")
        return regs.code_name(regs.faults(), code) if code else ""

    def fault_text(self) -> str:
        """Return the board's fault and its cure in two sentences, empty if there is none."""
        return regs.fault_text(self.inputs())

    def refusal(self, axis: int) -> LineRefusedByBoardError:
        """Return the refusal of an axis in state refused."""
        state = self.axis(axis)
        codes = regs.line_errors()
        code = state["line_error"]
        text = codes[code].text if code in codes else "unknown"
        name = regs.code_name(codes, code)
        return LineRefusedByBoardError(axis, name, state["line_error_pixel"], text)

    def _ask(self, what: str, method, *arguments, **options):
        """Do one request; raise BoardError for no reply or an exception answer."""
        try:
            reply = method(*arguments, device_id=self.unit, **options)
        except ModbusException:
            raise BoardError(f"board {self.unit}: no reply to {what}") from None
        if reply.isError():
            code = getattr(reply, "exception_code", 0)
            where = f" at 0x{arguments[0]:04X}" if arguments else ""
            text = _EXCEPTIONS.get(code, "unknown exception")
            raise BoardError(
                f"board {self.unit}: {what}{where} answered with exception {code}, {text}", code
            )
        return reply


class Upload:
    """The blocks of one line on their way into an axis' queue.

    `state` is what `Board.axis` says of it, if that has just been asked.
    """

    def __init__(
        self,
        board: Board,
        axis: int,
        entries: list[tuple[int, int]],
        state: dict[str, int] | None = None,
    ) -> None:
        self.board, self.axis = board, axis
        self._left = list(entries)
        state = state or board.axis(axis)
        self._block = state["next_block"]
        self._free: int | None = state["queue_free"]  # None: to be asked for again
        self._open = 0  # entries of a block that may have been taken: its answer never came
        self.last: tuple[int, list[tuple[int, int]]] | None = None

    @property
    def block(self) -> int:
        """Number of the block that is sent next."""
        return self._block

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        return not self._left

    def push(self) -> int:
        """Send blocks until all are accepted or one filled the queue; return entries accepted.

        What the board takes out of the queue meanwhile waits for the next call: fast pixels would
        otherwise keep this one busy to the end of the line. Raises LineRefusedByBoardError if the
        board refuses the line, BoardError if it does not answer: call again to go on.
        """
        before = len(self._left)
        while self._left:
            if self._open:
                # The same block with the same entries, or the board would drop others as a copy.
                free, size = None, self._open
            else:
                free = self._room()
                size = min(free, len(self._left), regs.MAX_ENTRIES)
            if size == 0 or not self._send(self._left[:size]):
                break
            del self._left[:size]
            if size == free:
                break
        return before - len(self._left)

    def _room(self) -> int:
        """Return the free entries of the queue, as last known or asked for."""
        known, self._free = self._free, None
        return self.board.axis(self.axis)["queue_free"] if known is None else known

    def _send(self, entries: list[tuple[int, int]]) -> bool:
        """Send one block; False if the board is busy (queue full)."""
        self._open = len(entries)
        try:
            self.board.write_block(self.axis, self._block, entries)
            self._open = 0
        except BoardError as error:
            if error.code is not None:
                self._open = 0
            if error.code == _BUSY:
                return False
            state = self.board.axis(self.axis)
            if error.code == _ILLEGAL_VALUE and regs.AXIS_STATES[state["axis_state"]] == "refused":
                raise self.board.refusal(self.axis) from None
            raise
        self.last = (self._block, entries)
        self._block = (self._block + 1) & 0xFFFF
        return True


def _decode(registers: tuple[regs.Register, ...], read) -> dict[str, int]:
    """Read registers in one request per gapless stretch and decode them by name."""
    values = {}
    for group in _stretches(registers):
        first = group[0].address
        words = read(first, group[-1].address + group[-1].words - first)
        for register in group:
            start = register.address - first
            values[register.name] = register.decode(words[start : start + register.words])
    return values


def _stretches(registers: tuple[regs.Register, ...]) -> list[list[regs.Register]]:
    """Group registers, sorted by address, into gapless stretches of at most 125 words."""
    groups: list[list[regs.Register]] = []
    for register in sorted(registers, key=lambda item: item.address):
        last = groups[-1] if groups else None
        end = register.address + register.words
        if (
            last
            and register.address == last[-1].address + last[-1].words
            and end - last[0].address <= 125
        ):
            last.append(register)
        else:
            groups.append([register])
    return groups


def _parse_records(words: list[int]) -> list[Record]:
    """Decode the record block; each record holds only the low 16 bits of its pixel."""
    newest = words[0] << 16 | words[1]
    records = []
    for index in range(min(words[2], regs.MAX_RECORDS)):
        start = regs.RECORD_HEAD + index * regs.RECORD_REGISTERS
        low, *rest = words[start : start + regs.RECORD_REGISTERS]
        pixel = newest - ((newest - low) & 0xFFFF)
        error = rest[4] - 0x10000 if rest[4] & 0x8000 else rest[4]
        records.append(Record(pixel, _signed32(rest[0:2]), _signed32(rest[2:4]), error))
    return records


def _signed32(words: list[int]) -> int:
    value = words[0] << 16 | words[1]
    return value - (1 << 32) if value >> 31 else value
