# SPDX-License-Identifier: MIT
"""pixstep: line files to exact step edges on a motor board, planned, checked and simulated.

The names below are the interface for programs and notebooks, `import pixstep as px`; docs/API.md
describes each. A name loads what it needs when it is first used, so that the import costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from pixstep.version import __version__ as __version__

if TYPE_CHECKING:
    from pixstep.api.bus import Board, Bus, connect
    from pixstep.api.clocks import ClockErrors, ClockFigures, PixelClock
    from pixstep.api.files import Converted, convert_file
    from pixstep.api.machines import Machine, Motor
    from pixstep.api.making import line_from_positions, make_line, make_profile
    from pixstep.api.motion import AxisProgress, AxisRecords, AxisState, Motion
    from pixstep.api.motions import (
        CheckResult,
        MotionLine,
        Profile,
        import_line,
        line,
        read_line,
        read_profile,
    )
    from pixstep.api.moving import HomeResult, MoveResult, SeekResult
    from pixstep.api.programs import MotionProgram, ProgramPlan, read_program
    from pixstep.api.runs import AxisRun, Run, RunFailedError, simulate
    from pixstep.api.shown import LineRefusedError, Ticks
    from pixstep.api.virtual import VirtualBoard, VirtualBus, simulated_board, simulated_bus
    from pixstep.board.errors import (
        BoardError,
        BusyError,
        FaultError,
        LineLostError,
        LineRefusedByBoardError,
        MissingFeatureError,
        MotionStoppedError,
        MotionTimeoutError,
        NoReplyError,
        NotPossibleError,
    )
    from pixstep.errors import PlainError, RefusedError, UserError
    from pixstep.lines.line_check import Finding, Limits
    from pixstep.moves.homing import HomingError
    from pixstep.simulation.simulator import SimulatorError

__all__ = [
    "AxisProgress",
    "AxisRecords",
    "AxisRun",
    "AxisState",
    "Board",
    "BoardError",
    "Bus",
    "BusyError",
    "CheckResult",
    "ClockErrors",
    "ClockFigures",
    "Converted",
    "FaultError",
    "Finding",
    "HomeResult",
    "HomingError",
    "Limits",
    "LineLostError",
    "LineRefusedByBoardError",
    "LineRefusedError",
    "Machine",
    "MissingFeatureError",
    "Motion",
    "MotionLine",
    "MotionProgram",
    "MotionStoppedError",
    "MotionTimeoutError",
    "Motor",
    "MoveResult",
    "NoReplyError",
    "NotPossibleError",
    "PixelClock",
    "PlainError",
    "Profile",
    "ProgramPlan",
    "RefusedError",
    "Run",
    "RunFailedError",
    "SeekResult",
    "SimulatorError",
    "Ticks",
    "UserError",
    "VirtualBoard",
    "VirtualBus",
    "connect",
    "convert_file",
    "import_line",
    "line",
    "line_from_positions",
    "make_line",
    "make_profile",
    "read_line",
    "read_profile",
    "read_program",
    "simulate",
    "simulated_board",
    "simulated_bus",
]

_MODULES = {
    "api.bus": ("Board", "Bus", "connect"),
    "api.clocks": ("ClockErrors", "ClockFigures", "PixelClock"),
    "api.shown": ("LineRefusedError", "Ticks"),
    "api.files": ("Converted", "convert_file"),
    "api.machines": ("Machine", "Motor"),
    "api.making": ("line_from_positions", "make_line", "make_profile"),
    "api.motion": ("AxisProgress", "AxisRecords", "AxisState", "Motion"),
    "api.motions": (
        "CheckResult", "MotionLine", "Profile", "import_line", "line", "read_line",
        "read_profile",
    ),
    "api.moving": ("HomeResult", "MoveResult", "SeekResult"),
    "api.programs": ("MotionProgram", "ProgramPlan", "read_program"),
    "api.runs": ("AxisRun", "Run", "RunFailedError", "simulate"),
    "api.virtual": ("VirtualBoard", "VirtualBus", "simulated_board", "simulated_bus"),
    "board.errors": (
        "BoardError", "BusyError", "FaultError", "LineLostError", "LineRefusedByBoardError",
        "MissingFeatureError", "MotionStoppedError", "MotionTimeoutError", "NoReplyError",
        "NotPossibleError",
    ),
    "errors": ("PlainError", "RefusedError", "UserError"),
    "lines.line_check": ("Finding", "Limits"),
    "moves.homing": ("HomingError",),
    "simulation.simulator": ("SimulatorError",),
}  # fmt: skip
_PLACES = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name of the interface when it is first asked for."""
    if name in ("fly", "ops"):
        return import_module(f"{__name__}.{name}")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the interface, and nothing that it is made with."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
