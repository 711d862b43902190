# SPDX-License-Identifier: MIT
"""A trace is replayed: the same operations on our record, and what differs from what was recorded."""

import json
import lzma
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pixstep.errors import RefusedError
from pixstep.motor_record import Command, MotorRecord, Outcome, PutRefusedError, Verb
from pixstep_trials.motor_traces.stepper import TICK_S, Stepper

SETTLE_TICKS: Final = 3000
QUIET_TICKS: Final = 3
DELAY_TICKS: Final = 0
"""Ticks of the motor that pass while a delay runs: none, it is real time."""

Trace = dict[str, Any]
Step = dict[str, Any]


@dataclass(frozen=True)
class Difference:
    """The first thing in a trace that is not as recorded."""

    step: int
    """Number of the step; -1: before the first."""
    operation: Sequence[Any]
    what: str
    """A field, "commands", "dmov", "ticks" or "settled"."""
    wanted: Any
    found: Any

    def __str__(self) -> str:
        return (
            f"step {self.step} {json.dumps(list(self.operation))}: {self.what}:"
            f" wanted {json.dumps(self.wanted)}, found {json.dumps(self.found)}"
        )


@dataclass
class Bench:
    """One record above one stepper, and what was seen of them since the last look."""

    record: MotorRecord
    stepper: Stepper
    commands: list[Command] = field(default_factory=list)
    dmov: list[int] = field(default_factory=list)
    delays: int = 0
    """Delays that run."""

    def take(self, outcome: Outcome) -> Outcome:
        """Carry out what the record asks for."""
        self.commands.extend(outcome.commands)
        self.dmov.extend(int(post.value) for post in outcome.posts if post.field == "DMOV")
        self.stepper.obey(outcome.commands)
        if outcome.delay_s is not None:
            self.delays += 1
        return outcome

    def put(self, name: str, value: float | str) -> None:
        """Write as a client does. What the record does not take changes nothing."""
        try:
            outcome = self.record.put(name, value)
        except PutRefusedError:
            return
        self.take(outcome)

    def tick(self) -> None:
        """Let 20 ms pass."""
        self._end_delays()
        status = self.stepper.tick()
        if status is not None:
            self.take(self.record.update(status))

    def _end_delays(self) -> None:
        """End the delays that run, if the motor rests: they are over before its next tick."""
        if self.stepper.motion.name != "REST" or self.record["DMOV"]:
            return
        while self.delays:
            self.delays -= 1
            self.take(self.record.delay_over())

    def settle(self) -> tuple[int, bool]:
        """Let time pass until all is at rest. Return the ticks, and whether that came."""
        quiet = 0
        for ticks in range(1, SETTLE_TICKS + 1):
            self.tick()
            quiet = quiet + 1 if self.record["DMOV"] and self.stepper.quiet else 0
            if quiet == QUIET_TICKS:
                return ticks, True
        return SETTLE_TICKS, False


def read(path: Path) -> Iterator[Trace]:
    """Yield the traces of a file of JSON lines, packed by xz where its name says so."""
    opened = lzma.open(path, "rt") if path.suffix == ".xz" else path.open()
    with opened as stream:
        for number, line in enumerate(stream, 1):
            try:
                trace = json.loads(line)
            except ValueError:
                raise RefusedError(f"{path}:{number}: no JSON") from None
            if not isinstance(trace, dict) or not {"initial", "start", "steps"} <= trace.keys():
                raise RefusedError(
                    f"{path}:{number}: no trace: initial, start and steps are wanted"
                )
            yield trace


def replay(trace: Trace) -> Difference | None:
    """Replay one trace; None if all is equal."""
    bench = _begin(trace)
    expected = dict(trace["start"])
    found = _fields(bench, expected, -1, ["start"])
    if found:
        return found
    for number, step in enumerate(trace["steps"]):
        found = _step(bench, number, step) or _seen(bench, number, step, expected)
        if found:
            return found
    return None


def _begin(trace: Trace) -> Bench:
    """Return a record and a motor as they were when the trace began."""
    initial = trace["initial"]
    uses_encoder = bool(trace["start"]["UEIP"])
    fields = {name: value for name, value in initial.items() if name != "UEIP"}
    record = MotorRecord(fields)
    if trace["kind"] == "links":
        record.set_link("RDBL", 0.0)
        record.set_link("DOL", 0.0)
    ratio = initial["MRES"] / initial["ERES"] if "UEIP" in initial else None
    bench = Bench(record, Stepper(ratio=ratio))
    bench.take(record.initialise(bench.stepper.status()))
    _ticks(bench, 2)
    if uses_encoder:
        bench.put("UEIP", "Yes")
        _ticks(bench, 2)
    bench.commands.clear()
    bench.dmov.clear()
    return bench


def _ticks(bench: Bench, count: int) -> None:
    for _ in range(count):
        bench.tick()


def _step(bench: Bench, number: int, step: Step) -> Difference | None:
    """Do one operation. Return what differs about the time that it took."""
    name, *arguments = step["op"]
    if name == "put":
        bench.put(*arguments)
    elif name == "adv":
        _ticks(bench, arguments[0])
    elif name == "sim":
        bench.stepper.turn(*arguments)
    elif name in ("link", "dol"):
        bench.take(bench.record.set_link("RDBL" if name == "link" else "DOL", arguments[0]))
    elif name == "settle":
        ticks, settled = bench.settle()
        if settled != step["settled"]:
            return Difference(number, step["op"], "settled", step["settled"], settled)
        if ticks != step["ticks"]:
            return Difference(number, step["op"], "ticks", step["ticks"], ticks)
    else:
        raise RefusedError(f"step {number}: {name!r} is no operation of a trace")
    return None


def _seen(bench: Bench, number: int, step: Step, expected: dict[str, float]) -> Difference | None:
    """Compare what a step brought about, and note which fields are expected now."""
    operation = step["op"]
    before = int(expected["DMOV"])
    expected.update(step.get("changed", {}))
    commands, bench.commands = bench.commands, []
    dmov, bench.dmov = bench.dmov, []
    wanted = step.get("commands", [])
    if not same_commands(wanted, commands):
        return Difference(number, operation, "commands", wanted, [str(one) for one in commands])
    changes = [_changes(before, step.get("dmov", [])), _changes(before, dmov)]
    if changes[0] != changes[1]:
        return Difference(number, operation, "dmov", *changes)
    return _fields(bench, expected, number, operation)


def _changes(before: int, posts: Sequence[float]) -> list[int]:
    """Return the order of changes: two equal posts that follow each other are one state."""
    changes: list[int] = []
    for post in posts:
        if int(post) != (changes[-1] if changes else before):
            changes.append(int(post))
    return changes


def same_commands(wanted: Sequence[str], found: Sequence[Command]) -> bool:
    """True if commands are equal in name, order and argument."""
    return len(wanted) == len(found) and all(map(_same_command, wanted, found))


def _same_command(wanted: str, found: Command) -> bool:
    name, _, argument = wanted.partition(" ")
    if name != found.verb:
        return False
    if not argument:
        return found.argument is None
    return found.argument is not None and close(float(argument), found.argument)


def close(wanted: float, found: float) -> bool:
    """True if two numbers are equal, as far as ten significant digits tell."""
    return f"{wanted:.10g}" == f"{found:.10g}" or abs(wanted - found) <= 1e-9 * max(
        1.0, abs(wanted)
    )


def _fields(
    bench: Bench, expected: dict[str, float], number: int, operation: Sequence[Any]
) -> Difference | None:
    for name, wanted in expected.items():
        found = bench.record[name]
        if isinstance(found, str) or not close(wanted, found):
            return Difference(number, operation, name, wanted, found)
    return None


__all__ = ["TICK_S", "Bench", "Difference", "Verb", "read", "replay"]
