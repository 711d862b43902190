# SPDX-License-Identifier: MIT
"""One simulated board whose every input is in hand, with frames placed at exact cycles."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import PermitOutput, SimOptions, SimulatorError
from pixstep_dev.robustness.orders import actions, state
from pixstep_dev.robustness.orders.state import AxisStepEdges, BoardReading
from pixstep_trials import frames
from pixstep_trials.memory import Memory
from pixstep_trials.probe import BoardProbe

FAST_BAUD, SLOW_BAUD = 250_000, 115_200  # the fastest at which no byte is lost, whatever moves
BITS = 11  # of a byte on the line, even parity
SILENCE_US = 1750  # that a reply waits for, and the simulator behind it
REPLY_S = 0.025  # the reply begins within so long, whatever the board does
IDLE_TICKS = 4096  # a period of an axis at rest
_STRETCH_CYCLES = 8192  # between two looks for a step
_PARKED = 4  # STEP_STATE_PARKED
_IDLE_UNITS = 64  # an idle period in units of the coarse clock
_COUNT_ADDRESS = 0x46  # TCNT0
_EDGES = 0x10000  # their numbers are taken modulo this


@dataclass(frozen=True)
class ActionOutcome:
    """What came of an action: taken, refused, or (None) nobody knows.

    It was carried out no later than `done`.
    """

    taken: bool | None
    done: int
    exception: int = 0


class OrdersWorld:
    """A board under direct command; use as a context manager."""

    def __init__(self, board: str, image: Path | None = None, clock_hz: int = 100) -> None:
        self.name, self.clock_hz = board, clock_hz
        table = boards.load(board)
        self.axes, self.tick_hz = table.axes, table.tick_hz
        self.silence_cycles = table.tick_hz * SILENCE_US // 1_000_000
        self.all_axes = (1 << table.axes) - 1
        self._pins = {(pin.signal, pin.axis): (pin.port, pin.bit) for pin in table.pins}
        self._options = SimOptions([(board, image or natives.image(board))], Fraction(clock_hz))
        self.next_block = [0] * table.axes
        self.clock_touched = False
        self.driven: set[tuple[str, int]] = set()  # pins that are not as they were at first

    def __enter__(self) -> "OrdersWorld":
        self.sim = SimLink(self._options).simulator
        try:
            self.memory = Memory(self.sim, self.name)
            self._raise_rate()
        except BaseException:
            self.sim.kill()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.sim.kill()

    def start(self) -> None:
        """Wait for the board behind a reset, and take it to the rate of this world."""
        self.sim.command(f"baud {SLOW_BAUD} E")
        self.sim.boot()
        self._raise_rate()

    def _raise_rate(self) -> None:
        self.byte_cycles = self.tick_hz * BITS // SLOW_BAUD
        register = regs.register_map().holding("baud_100")
        if not self.ask(frames.write(register.address, [FAST_BAUD // 100])).taken:
            raise SimulatorError(f"{self.name}: no reply behind a reset")
        self.sim.command(f"baud {FAST_BAUD} E")
        self.byte_cycles = self.tick_hz * BITS // FAST_BAUD
        self.next_block = [0] * self.axes

    @property
    def cycle(self) -> int:
        """The cycle reached."""
        return self.sim.cycle

    def ask(self, frame: bytes) -> frames.FrameReply:
        """Send a request and wait for the reply."""
        self.asked = self.cycle
        data = self.sim.transmit(frame, self.sim.cycles(REPLY_S))
        self.told = self.cycle - self.silence_cycles - self.byte_cycles * len(data)
        return frames.parse(data)

    def tell(self, frame: bytes) -> int:
        """Send a frame from this cycle on; return when its last bit has left. No time passes."""
        return int(self.sim.command(f"send {frame.hex()}").split()[1])

    def look(self) -> BoardReading | None:
        """Read the state of the board; None if it does not answer."""
        reply = self.ask(frames.read_inputs(state.FIRST, state.words(self.axes)))
        if not reply.taken:
            return None
        found = state.parse(reply.words, self.axes, self.asked, self.told)
        self.next_block = [axis.next_block for axis in found.axes]
        return found

    def registers(self) -> dict[str, tuple[int, ...]]:
        """Return what only a command or a setting changes: the words written, outputs, settings."""
        wanted = {
            "command": frames.read_holdings(regs.COMMAND_BASE, 4),
            "settings": frames.read_holdings(0, regs.settings()[-1].address + 1),
            "outputs": frames.read_inputs(regs.register_map().input("outputs").address, 1),
        }
        return {name: self.ask(frame).words for name, frame in wanted.items()}

    def edges(self, axis: int) -> AxisStepEdges:
        """Return the STEP edges of an axis so far."""
        return AxisStepEdges(*map(int, self.sim.command(f"last 0 {axis}").split()[1:]))

    def account(self, axis: int) -> int:
        """Return how far an axis's account of time is ahead of this cycle, modulo 2^32.

        The ledger holds the end of the newest period that was loaded. Idle periods loaded since it
        was last brought up to date are counted in. Of a parked axis nobody counts them: they are
        what the coarse clock says, since the place where it stood when the axis was parked.
        """
        loaded = self.memory.read(f"axes[{axis}].ledger.loaded_ticks")
        seen = self.memory.read(f"axes[{axis}].ledger.idle_seen")
        if self.memory.read(f"engine[{axis}].state") == _PARKED:
            idle = (self._coarse_units() - self._parked_base(axis)) % (1 << 22) // _IDLE_UNITS
        else:
            idle = self.memory.read(f"engine[{axis}].idle_count")
        return (loaded + (idle - seen) % (1 << 16) * IDLE_TICKS - self.cycle) % (1 << 32)

    def coarse_overflows(self) -> int:
        """Return where the coarse clock's overflows are counted: its address in RAM."""
        return BoardProbe(self.sim).symbol(0, "clock_overflows").address

    def _coarse_units(self) -> int:
        high = BoardProbe(self.sim).peek(0, self.coarse_overflows(), 4)
        return (
            int.from_bytes(high, "little") << 8 | BoardProbe(self.sim).peek(0, _COUNT_ADDRESS, 1)[0]
        )

    def _parked_base(self, axis: int) -> int:
        found = BoardProbe(self.sim).symbol(0, "parked_bases").address
        return int.from_bytes(BoardProbe(self.sim).peek(0, found + 4 * axis, 4), "little")

    def time_words(self, axis: int) -> list[tuple[int, int, int]]:
        """Return address, size and unit (ticks) of every word that counts an idle axis's time."""
        units = {
            f"engine[{axis}].idle_count": IDLE_TICKS,
            f"axes[{axis}].ledger.idle_seen": IDLE_TICKS,
            f"axes[{axis}].ledger.loaded_ticks": 1,
            f"axes[{axis}].feed.stream.delay_ticks": 1,
        }
        return [
            (self.memory.address(path), self.memory.place(path).size, unit)
            for path, unit in units.items()
        ]

    def add(self, address: int, size: int, amount: int) -> None:
        """Add to a number in RAM, modulo its size."""
        old = int.from_bytes(BoardProbe(self.sim).peek(0, address, size), "little")
        BoardProbe(self.sim).poke(
            0, address, ((old + amount) % (1 << 8 * size)).to_bytes(size, "little")
        )

    def permit(self) -> PermitOutput:
        """Return the permit output's level and edges."""
        return self.sim.permit(0)

    def perform(self, action: actions.Action) -> ActionOutcome:
        """Do something from this cycle on."""
        match action:
            case actions.Wait(cycles):
                self.sim.run(cycles)
            case actions.StepWait():
                self._to_step(action)
            case actions.ClockCommand(text):
                self.sim.command(f"clock {text}")
                self.clock_touched = True
            case actions.PinInput(signal, axis, level):
                self.sim.pin(0, *self._pins[signal, axis], level)
                self.driven.add((signal, axis))
            case actions.Supply(what):
                self._interrupt_supply(what)
            case _:
                return self._request(action)
        return ActionOutcome(True, self.cycle)

    def _request(self, action: actions.Action) -> ActionOutcome:
        broadcast = getattr(action, "how", "") == actions.TELL
        frame = self._frame(action, frames.BROADCAST if broadcast else frames.UNIT)
        if broadcast:
            end = self.tell(frame)
            self._count_block(action)
            self.sim.run(max(0, end - self.cycle))
            return ActionOutcome(None, end)
        reply = self.ask(frame)
        if reply.taken:
            self._count_block(action)
        return ActionOutcome(reply.taken if reply.came else None, self.told, reply.exception)

    def _frame(self, action: actions.Action, unit: int) -> bytes:
        table = regs.register_map()
        match action:
            case actions.BoardOrder(name, mask, argument, _, ahead):
                return frames.order(name, mask, argument, unit, self._edge(ahead))
            case actions.Coils(first, values):
                return frames.coils(first, list(values), unit)
            case actions.QueueBlock(axis, entries, off):
                number = self.next_block[axis] + off
                return frames.block(number, axis, list(entries), unit)
            case actions.Setting(name, value):
                return frames.write(table.holding(name).address, [value], unit)
            case actions.Frequency(hz):
                words = [hz >> 16, hz, 0, 1]
                return frames.write(table.holding("pixel_hz_num").address, words, unit)
        raise TypeError(f"no request: {action}")

    def _edge(self, ahead: int) -> int:
        """Return the number of the clock edge so far ahead, 1 for edge 0, which names none."""
        if not ahead:
            return 0
        return (self.memory.read("clock.edges") + ahead) % _EDGES or 1

    def _count_block(self, action: actions.Action) -> None:
        if isinstance(action, actions.QueueBlock) and action.off == 0:
            self.next_block[action.axis] = self.next_block[action.axis] + 1 & 0xFFFF

    def _to_step(self, action: actions.StepWait) -> None:
        begun, limit = self.edges(action.axis).made, self.cycle + action.limit
        while self.cycle < limit and self.edges(action.axis).made == begun:
            self.sim.run(min(_STRETCH_CYCLES, limit - self.cycle))
        place = self.edges(action.axis).last + action.more
        self.sim.run(max(0, place - self.cycle))

    def _interrupt_supply(self, what: str) -> None:
        if what == "cycle":
            self.sim.supply(0, "cycle")
        else:
            self.sim.reset(0, what)
        self.start()
