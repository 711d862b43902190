# SPDX-License-Identifier: MIT
"""pixstep: line files to exact step edges on a motor board, planned, checked and simulated.

The names below are the interface for programs and notebooks, `import pixstep as px`; docs/API.md
describes each. A name loads what it needs when it is first used, so that the import costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from pixstep.api.bus import AxisState, Board, Bus, connect
    from pixstep.api.clocks import ClockErrors, ClockFigures, PixelClock
    from pixstep.api.machines import Machine, Motor
    from pixstep.api.motions import (
        CheckResult,
        MotionLine,
        Profile,
        import_line,
        line,
        make_line,
        make_profile,
        read_line,
        read_profile,
    )
    from pixstep.api.programs import MotionProgram, ProgramPlan, read_program
    from pixstep.api.records import AxisRecords
    from pixstep.api.runs import AxisRun, Run, RunFailedError, simulate
    from pixstep.api.ticks import Ticks
    from pixstep.board.errors import BoardError
    from pixstep.errors import PlainError, RefusedError, UserError
    from pixstep.lines.linecheck import Finding, Limits

__all__ = [
    "AxisRecords",
    "AxisRun",
    "AxisState",
    "Board",
    "BoardError",
    "Bus",
    "CheckResult",
    "ClockErrors",
    "ClockFigures",
    "Finding",
    "Limits",
    "Machine",
    "MotionLine",
    "MotionProgram",
    "Motor",
    "PixelClock",
    "PlainError",
    "Profile",
    "ProgramPlan",
    "RefusedError",
    "Run",
    "RunFailedError",
    "Ticks",
    "UserError",
    "connect",
    "import_line",
    "line",
    "make_line",
    "make_profile",
    "read_line",
    "read_profile",
    "read_program",
    "simulate",
]

_MODULES = {
    "api.bus": ("AxisState", "Board", "Bus", "connect"),
    "api.clocks": ("ClockErrors", "ClockFigures", "PixelClock"),
    "api.machines": ("Machine", "Motor"),
    "api.motions": (
        "CheckResult", "MotionLine", "Profile", "import_line", "line", "make_line",
        "make_profile", "read_line", "read_profile",
    ),
    "api.records": ("AxisRecords",),
    "api.programs": ("MotionProgram", "ProgramPlan", "read_program"),
    "api.runs": ("AxisRun", "Run", "RunFailedError", "simulate"),
    "api.ticks": ("Ticks",),
    "board.errors": ("BoardError",),
    "errors": ("PlainError", "RefusedError", "UserError"),
    "lines.linecheck": ("Finding", "Limits"),
}  # fmt: skip
_PLACES = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name of the interface when it is first asked for."""
    if name == "ops":
        return import_module(f"{__name__}.ops")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
