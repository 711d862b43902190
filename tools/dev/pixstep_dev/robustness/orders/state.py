# SPDX-License-Identifier: MIT
"""What a board says of itself in one reply, and what the simulator has seen of it."""

from dataclasses import dataclass
from typing import NamedTuple

from pixstep.board import registers as regs

FIRST = 0x0004  # `status`; the axes' registers follow those of the board without a gap
MOVING = frozenset(("armed", "running"))


class AxisStepEdges(NamedTuple):
    """STEP edges of an axis: rising ones, the same signed, cycles of the last two (0: none)."""

    made: int
    steps: int
    last: int
    before: int


@dataclass(frozen=True)
class AxisRegisters:
    """The registers of an axis that commands change."""

    state: str
    queue_free: int
    next_block: int
    line_error: int
    line_error_pixel: int
    position: int
    lines_done: int
    underruns: int


@dataclass(frozen=True)
class BoardReading:
    """One reading: when the request began and its reply had come, and what it said."""

    asked: int
    told: int
    status: int
    fault: int
    argument: int
    fault_axis: int
    fault_mask: int
    reset_cause: int
    axes: tuple[AxisRegisters, ...]

    @property
    def fault_name(self) -> str:
        """Name of the latched fault, "none" without one."""
        return regs.code_name(regs.faults(), self.fault) if self.fault else "none"

    def flag(self, name: str) -> bool:
        """Return a bit of `status`."""
        return bool(self.status >> regs.STATUS_BITS[name] & 1)

    def summary(self) -> str:
        """Return the fault and the axes in a few words."""
        axes = ", ".join(f"{axis.state} at {axis.position}" for axis in self.axes)
        return f"fault {self.fault_name}; {axes}"


def words(axes: int) -> int:
    """Return how many registers one reading takes."""
    return regs.AXIS_BASE + regs.AXIS_STRIDE * axes - FIRST


def parse(found: tuple[int, ...], axes: int, asked: int, told: int) -> BoardReading:
    """Return the reading of these words."""

    def one(address: int) -> int:
        return found[address - FIRST]

    starts = range(regs.AXIS_BASE - FIRST, words(axes), regs.AXIS_STRIDE)
    blocks = tuple(_axis(found[start : start + regs.AXIS_STRIDE]) for start in starts)
    return BoardReading(
        asked, told, one(0x04), one(0x05), one(0x06), one(0x07), one(0x0A), one(0x0B), blocks
    )


def _axis(block: tuple[int, ...]) -> AxisRegisters:
    position = block[6] << 16 | block[7]
    return AxisRegisters(
        state=regs.AXIS_STATES[block[0]],
        queue_free=block[1],
        next_block=block[2],
        line_error=block[3],
        line_error_pixel=block[4] << 16 | block[5],
        position=position - (1 << 32) if position >> 31 else position,
        lines_done=block[0xC],
        underruns=block[0xD],
    )
