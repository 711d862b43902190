# SPDX-License-Identifier: MIT
"""Values of registers in words, out of the meanings that the register table gives."""

from pixstep.board import registers as regs
from pixstep.board.registers import Register


def words(register: Register, value: int) -> str:
    """Return a value in words: its state, its bits joined by commas; empty if it has none."""
    known = register.values
    if not known:
        return _special(register, value)
    if register.unit == "bits":
        bits = [known.get(bit, f"bit {bit}") for bit in range(16) if value >> bit & 1]
        return ", ".join(bits) or "none"
    return known.get(value, f"unknown {register.unit} {value}")


def _special(register: Register, value: int) -> str:
    """Return the words of the few registers that are coded in their own way."""
    if register.name == "firmware_version":
        return regs.version_text(value)
    if register.name == "board_id":
        return regs.BOARD_IDS.get(value, "unknown")
    if register.name == "baud_100":
        return f"{100 * value} baud"
    return ""
