# SPDX-License-Identifier: MIT
"""Values of registers in words, out of the meanings that the register table gives."""

import re

from pixstep.board import registers as regs
from pixstep.board.registers import Register

_CHOICE = re.compile(r"(?:^|[:,] )(\d+)(?: to (\d+))? ([^,;]+)")
_PER_AXIS = "four bits an axis"
_AXIS_BITS = 4
_CODES = {
    "fault_code": regs.faults,
    "line_error": regs.line_errors,
    "line_warning": regs.line_errors,
}
_COUNTED = ("bits", "state", "code")


def choices(register: Register) -> dict[int, str]:
    """Return what each value (of a state or code) or each bit stands for; empty if none does."""
    if register.unit not in _COUNTED:
        return {}
    if register.name in _CODES:
        return {code.code: code.name for code in _CODES[register.name]().values()}
    found: dict[int, str] = {}
    for first, last, text in _CHOICE.findall(register.meaning):
        for number in range(int(first), int(last or first) + 1):
            found[number] = re.sub(r"\b(axis) n\b", rf"\1 {number - int(first)}", text).strip()
    if _PER_AXIS in register.meaning:
        return {
            _AXIS_BITS * axis + bit: f"axis {axis} {text}"
            for axis in range(max(regs.AXIS_COUNTS))
            for bit, text in found.items()
        }
    return found


def words(register: Register, value: int) -> str:
    """Return a value in words: its state, its bits joined by commas; empty if it has none."""
    known = choices(register)
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
