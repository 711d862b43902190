# SPDX-License-Identifier: MIT
"""All operations by the words that call them, and the schemas of what they give back.

Each is imported when it is used: the texts are the first sentences of their docstrings, so that a
list of commands needs no import.
"""

from __future__ import annotations

import inspect
import types
import typing
from importlib import import_module
from typing import Any, NotRequired, get_args, get_origin, get_type_hints, is_typeddict

from pixstep.operations.request import Request

# fmt: off
OPERATIONS: dict[str, tuple[str, str]] = {
    "line make": ("line.make:LineMake",
        "Make a line: up, constant speed, down, by a profile or by an acceleration."),
    "line check": ("line.check:LineCheck",
        "Check a line of a CSV or CSB file, and the file's form as `file check` does."),
    "line show": ("line.check:LineShow",
        "Show speed, acceleration, jerk and position of a line: a table, with --plot a drawing."),
    "line import": ("line.make:LineImport",
        "Make a line of your own table: what a spreadsheet exports, or what numpy's savetxt "
        "writes."),
    "line compensate": ("line.compensate:LineCompensate",
        "Take up the play at every reversal of a plain line."),
    "profile make": ("profile.make:ProfileMake",
        "Make the shortest acceleration profile within limits of acceleration and jerk."),
    "profile repair": ("profile.make:ProfileRepair",
        "Repair a file for a smooth motor: counts that oscillate, or the speeds of a PRN."),
    "profile check": ("profile.look:ProfileCheck",
        "Check a profile under every reading of its file."),
    "profile show": ("profile.look:ProfileShow",
        "Show speed, acceleration, jerk and position of a profile: a table, with --plot a "
        "drawing."),
    "file info": ("file:FileInfo", "Say what is in a file."),
    "file check": ("file:FileCheck", "List everything wrong with a file."),
    "file convert": ("file:FileConvert", "Write a file in another format."),
    "limits": ("limits:ShowLimits",
        "Show what a board can do: rates, accelerations, shortest lines, reversals."),
    "board scan": ("board.find:BoardScan", "Look for boards at every address of the line."),
    "board info": ("board.find:Info", "Show the identity and state of boards."),
    "board features": ("board.find:ShowFeatures", "Show what boards' images were built with."),
    "board get": ("board.settings:Get", "Read registers by name, or all of them."),
    "board set": ("board.settings:Set",
        "Change settings, all of them in one request: all or none."),
    "board settings export": ("board.settings:Export",
        "Write all settings in force to a TOML file."),
    "board settings import": ("board.settings:Import",
        "Set what a TOML file says, all or nothing; read it back."),
    "board settings store": ("board.settings:Store",
        "Store the settings in force in the board's EEPROM."),
    "board settings defaults": ("board.settings:UseDefaults",
        "Put the default settings into force."),
    "board settings diff": ("board.settings:Diff",
        "Compare with a TOML file, or with the defaults."),
    "board log records": ("board.records:LogRecords",
        "Write per-pixel records as CSV, each as it comes."),
    "board log events": ("board.records:LogEvents", "Print faults and resets with their times."),
    "board watch": ("board.watch:WatchBoards", "Watch boards live; Ctrl-C ends it."),
    "board stop": ("board.commands:Stop", "Stop what moves, at once, and forget what is queued."),
    "board selftest": ("board.bring_up:WiringTest", "Walk through the wiring of a new board."),
    "board simulate": ("board.simulate:Simulate",
        "Simulate a board, and work its switches, clock and supply."),
    "board upload": ("board.lines:BoardUpload",
        "Queue lines, one file an axis; with --arm run them."),
    "board start": ("board.lines:BoardStart",
        "Start loaded lines; several boards begin on one clock edge."),
    "board home": ("board.motion:BoardHome", "Home an axis: its switch's edge becomes position 0."),
    "board measure-play": ("board.motion:MeasurePlay",
        "Measure the play of an axis by its home switch."),
    "board move": ("board.motion:BoardMove", "Move an axis by exactly N steps."),
    "board run": ("program:RunProgram", "Run a motion program while it is planned."),
    "board trajectory": ("trajectory.runs:BoardTrajectory",
        "Run a table of two axes, with or without its play taken up."),
    "flash": ("board.bring_up:Flash",
        "Write the firmware to a board by avrdude through its boot loader, then ask what it is."),
    "serve": ("serve:Serve", "Own a bus, and let other programs reach it: consoles, Python, PLCs."),
    "ioc": ("ioc:Ioc",
        "Serve the motors of a machine file as motor records of EPICS (Channel Access)."),
    "board arm": ("board.commands:Arm", "Arm loaded axes by hand, with a token if wanted."),
    "board disarm": ("board.commands:Disarm", "Disarm axes and discard their queues."),
    "board clear": ("board.commands:Clear", "Clear the latched fault."),
    "board enable": ("board.commands:Enable", "Switch drivers on: their motors hold."),
    "board disable": ("board.commands:Disable", "Switch drivers of axes at rest off."),
    "board permit": ("board.commands:Permit",
        "Switch the permit output, the gate of a laser or spindle."),
    "sim": ("run:Sim",
        "Run lines on a simulated board and judge every edge; one file (CSV, CSB) per axis."),
    "ticks": ("line.check:PlanTicks",
        "Plan the edges of a line of a CSV or CSB with the native build of the firmware's core."),
    "demo": ("run:Demo",
        "Worked example: profile, line, plan, simulated Mega, verdict, plots, VCD."),
    "plan": ("program:PlanProgram",
        "Plan a motion program of blended moves: a line for each motor, all of equal length."),
    "move make": ("motion:MoveMake",
        "Write a move as a plain line: one signed count per pixel, in the fewest pixels possible."),
    "move show": ("motion:MoveShow", "Show a move: how fast in which pixels, how long, where."),
    "move sim": ("motion:MoveSim",
        "Make a move on a simulated board and judge every STEP edge and where it ends."),
    "home sim": ("motion:HomeSim",
        "Home a simulated axis by a CSV or CSB profile, and judge it by the simulator's own log."),
    "trajectory circle": ("trajectory.tables:TrajectoryCircle",
        "Make the table of a circle, counter-clockwise from angle 0, in counts."),
    "trajectory import": ("trajectory.tables:TrajectoryImport",
        "Check a table of your own and write it as 16-byte records."),
    "trajectory export": ("trajectory.tables:TrajectoryExport",
        "Write a table as CSV or Parquet, by the end of the output's name."),
    "trajectory compensate": ("trajectory.tables:TrajectoryCompensate",
        "Write a table with the play of both axes taken up at every reversal."),
    "trajectory show": ("trajectory.runs:TrajectoryShow",
        "Show what is in a table and, with --play, what the load of a modelled machine does."),
    "trajectory sim": ("trajectory.runs:TrajectorySim",
        "Run a table on two axes of a simulated board, and measure the circle that its loads "
        "make."),
    "job make": ("job.make:JobMake",
        "Make a job: a file of the lines of several motors and the configuration that made them."),
    "job show": ("job.show:JobShow",
        "Show what is in a job: lines, motors, times, shapes; with --line one line of it."),
    "job show-config": ("job.show:JobShowConfig",
        "Show what a job was made with: its parameters, the machine file and the profiles in it."),
    "job check": ("job.check:JobCheck",
        "Compare a job with the machine file of today, and with what the boards hold."),
    "job run": ("job.printing:JobRun",
        "Print a job on the boards of the machine file."),
    "job resume": ("job.resume:JobResume",
        "Go on with a run that was paused or broken off."),
    "job status": ("job.resume:JobStatus",
        "Say how far a run has come, by its log alone; no board is asked."),
    "job pause": ("job.resume:JobPause",
        "Ask a run in another console to pause."),
    "job simulate": ("job.simulate:JobSimulate",
        "Simulate a whole job: every board, motor and line, cycle by cycle, on all cores."),
    "job report": ("job.watch:JobReport",
        "Write the report of a run: one HTML file, which needs no network."),
    "watch": ("job.watch:WatchRun",
        "Watch a run of a job: the line that moves, and the time that is left."),
    "job export": ("job.show:JobExport",
        "Write the lines of a job as files again: a CSV for each motor, with all lines or one."),
    "machine new": ("machine_files:MachineNew",
        "Begin a machine file: valid as it is, with a comment for every key."),
    "machine check": ("machine_files:MachineCheck",
        "Check a machine file: every mistake with its line, key and value."),
    "machine show": ("machine_files:MachineShow",
        "Show the machine in force: its file, clock, boards and motors, in steps and pixels."),
}
# fmt: on


def load(words: str) -> type[Request]:
    """Return the operation that some words call."""
    module, _, name = OPERATIONS[words][0].partition(":")
    found: type[Request] = getattr(import_module(f"pixstep.operations.{module}"), name)
    return found


DIALECT = "https://json-schema.org/draft/2020-12/schema"
_PLAIN = {
    int: {"type": "integer"},
    float: {"type": "number"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
    type(None): {"type": "null"},
    Any: {},
    object: {},
}


def all_schemas() -> dict[str, Any]:
    """Return one document: the result of each operation by its words, beside what is shared."""
    shared: dict[str, Any] = {}
    results = {words: _of(load(words).result, shared) for words in sorted(OPERATIONS)}
    return {"$schema": DIALECT, "properties": results, "$defs": dict(sorted(shared.items()))}


def schema(words: str) -> dict[str, Any]:
    """Return the schema of one operation's result."""
    shared: dict[str, Any] = {}
    return {"$schema": DIALECT, **_of(load(words).result, shared), "$defs": shared}


def _of(kind: Any, shared: dict[str, Any]) -> dict[str, Any]:
    if kind in _PLAIN:
        return dict(_PLAIN[kind])
    if is_typeddict(kind):
        return _of_dict(kind, shared)
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return {"anyOf": [_of(one, shared) for one in inner]}
    if origin is typing.Literal:
        return {"enum": list(inner)}
    if origin in (list, tuple) or getattr(origin, "__name__", "") == "Sequence":
        return {"type": "array", "items": _of(inner[0], shared) if inner else {}}
    if origin is dict or getattr(origin, "__name__", "") == "Mapping":
        return {"type": "object", "additionalProperties": _of(inner[1], shared)}
    if kind is dict:
        return {"type": "object"}
    raise TypeError(f"{kind}: no part of a result")


def _of_dict(kind: Any, shared: dict[str, Any]) -> dict[str, Any]:
    name, about = kind.__name__, inspect.getdoc(kind) or ""
    if shared.get(name) and shared[name]["description"] != about:
        raise TypeError(f"{kind}: another type of a result has this name")
    if name not in shared:
        shared[name] = {}  # stands there already where the type has itself inside
        hints = get_type_hints(kind, include_extras=True)
        needed = [key for key, hint in hints.items() if get_origin(hint) is not NotRequired]
        shared[name] = {
            "type": "object",
            "description": about,
            "properties": {key: _of(_bare(hint), shared) for key, hint in hints.items()},
            "required": [key for key in needed if key in kind.__required_keys__],
            "additionalProperties": False,
        }
    return {"$ref": f"#/$defs/{name}"}


def _bare(hint: Any) -> Any:
    return get_args(hint)[0] if get_origin(hint) is NotRequired else hint
