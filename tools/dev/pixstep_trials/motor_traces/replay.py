# SPDX-License-Identifier: MIT
"""A trace is replayed: the same operations on our record, and what differs from the recording."""

import json
import lzma
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from pixstep.errors import RefusedError
from pixstep.motor_record import FIELDS, LinkName, MotorRecord
from pixstep_trials.motor_traces.bench import TraceBench
from pixstep_trials.motor_traces.compare import Difference, changes, close, same_commands
from pixstep_trials.motor_traces.stepper import KNOBS, Stepper

Trace = dict[str, Any]
Step = dict[str, Any]

KEYS: Final = {"kind", "initial", "start", "steps"}
LINKS: Final[dict[str, LinkName]] = {"link": "RDBL", "dol": "DOL"}


def read(path: Path) -> Iterator[Trace]:
    """Yield the traces of a file of JSON lines, packed by xz where its name says so."""
    number = 0
    for number, line in enumerate(_lines(path), 1):
        try:
            trace = json.loads(line)
        except ValueError:
            raise RefusedError(f"{path}:{number}: no JSON") from None
        if not isinstance(trace, dict) or not trace.keys() >= KEYS:
            raise RefusedError(f"{path}:{number}: a trace has {', '.join(sorted(KEYS))}")
        yield trace
    if not number:
        raise RefusedError(f"{path}: there is no trace in it")


def _lines(path: Path) -> Iterator[str]:
    """Yield the lines of a text, packed or not."""
    try:
        with lzma.open(path, "rt") if path.suffix == ".xz" else path.open() as stream:
            yield from stream
    except (lzma.LZMAError, EOFError):
        raise RefusedError(f"{path}: not packed by xz, or cut off") from None
    except UnicodeDecodeError:
        raise RefusedError(f"{path}: no text in UTF-8") from None


def replay(trace: Trace) -> Difference | None:
    """Replay one trace; None if all is equal. RefusedError: something in it is unknown."""
    bench = begin(trace)
    expected = dict(trace["start"])
    found = _fields(bench, expected, -1, ["start"])
    for number, step in enumerate(trace["steps"]):
        if found is not None:
            break
        found = _step(bench, number, step, expected)
    return found


def begin(trace: Trace) -> TraceBench:
    """Return a record and a motor as they were when the trace began."""
    initial = trace["initial"]
    record = MotorRecord({name: value for name, value in initial.items() if name != "UEIP"})
    if trace["kind"] == "links":
        record.set_link("RDBL", 0.0)
        record.set_link("DOL", 0.0)
    ratio = initial["MRES"] / initial["ERES"] if "UEIP" in initial else None
    bench = TraceBench(record, Stepper(ratio=ratio))
    bench.take(record.initialise(bench.stepper.status()))
    bench.ticks(2)
    if "UEIP" in initial:
        bench.put_as_recorded("UEIP", initial["UEIP"])
        bench.ticks(2)
    bench.forget()
    return bench


def operate(bench: TraceBench, operation: Sequence[Any]) -> tuple[int, bool] | None:
    """Do one operation; of "settle" return the ticks and whether all came to rest."""
    name, *arguments = operation
    if name == "settle":
        return bench.settle()
    if name == "put" and arguments[0] in FIELDS:
        bench.put_as_recorded(*arguments)
    elif name == "adv":
        bench.ticks(arguments[0])
    elif name == "sim" and arguments[0] in KNOBS:
        bench.stepper.turn(*arguments)
    elif name in LINKS:
        bench.record.set_link(LINKS[name], arguments[0])
    else:
        raise RefusedError(f"{json.dumps(list(operation))} is no operation of a trace")
    return None


def _step(
    bench: TraceBench, number: int, step: Step, expected: dict[str, float]
) -> Difference | None:
    """Do one step. Return what differs, and note in `expected` the fields as recorded."""
    operation = step["op"]
    before = int(expected["DMOV"])
    expected.update(step.get("changed", {}))
    runs, begun = bench.delay_s is not None, bench.delays
    settled = operate(bench, operation)
    waited = runs or bench.delays > begun
    bench.end_zero_delay()
    commands, dmov = bench.commands, bench.dmov
    bench.forget()
    wanted = step.get("commands", [])
    if not (same_commands(wanted, commands) or same_commands(wanted, commands + bench.late)):
        return Difference(number, operation, "commands", wanted, [str(one) for one in commands])
    posts = [changes(before, step.get("dmov", [])), changes(before, dmov)]
    if posts[0] != posts[1]:
        return Difference(number, operation, "dmov", *posts)
    if settled is not None:
        late = _time(number, step, settled, waited=waited)
        if late is not None:
            return late
    return _fields(bench, expected, number, operation)


def _time(number: int, step: Step, settled: tuple[int, bool], *, waited: bool) -> Difference | None:
    """Compare how long a settling took. After a delay, which is real time, ticks say nothing."""
    wanted = (step["ticks"], step["settled"])
    if wanted[1] != settled[1]:
        return Difference(number, step["op"], "settled", wanted[1], settled[1])
    if wanted[0] != settled[0] and not waited:
        return Difference(number, step["op"], "ticks", wanted[0], settled[0])
    return None


def _fields(
    bench: TraceBench, expected: dict[str, float], number: int, operation: Sequence[Any]
) -> Difference | None:
    for name, wanted in expected.items():
        if name not in FIELDS:
            return Difference(number, operation, name, wanted, "no such field")
        found = bench.record[name]
        if isinstance(found, str) or not close(wanted, found):
            return Difference(number, operation, name, wanted, found)
    return None
