# SPDX-License-Identifier: MIT
"""All that the page of `pixstep watch --web` is told, as plain data: a verdict, boards, a run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from pixstep.board import registers as regs
from pixstep.board.snapshot import Snapshot, measured_hz
from pixstep.board.state import CLOCK_FAULTS, beside_set, fault_hz
from pixstep.operations.live.eye import AxisName, Eye, Seen

if TYPE_CHECKING:
    from pixstep.operations.live.job_run import LiveRun

STALE_S = 3.0  # figures of this age are old
_GREEN, _BLUE, _AMBER, _RED, _GREY = "green", "blue", "amber", "red", "grey"
_TROUBLES = ("crc_errors", "exceptions", "rx_overruns", "busy_replies")

Data = dict[str, Any]
Said = tuple[str, str, str]  # a colour, a sentence, and what else there is to say


class LiveView:
    """What browsers are told: of the boards that some eyes look at, and of a run of a job."""

    def __init__(
        self, eyes: Sequence[Eye], run: LiveRun | None, place: str, *, stops: bool
    ) -> None:
        self.eyes, self._run, self._place, self._stops = eyes, run, place, stops

    def first(self) -> Data:
        """Return what has been seen so far."""
        past = {
            f"{_key(eye, seen)} {axis}": trail.as_json()
            for eye, seen in self._boards() for axis, trail in [*seen.trails.items()]
        }  # fmt: skip
        return {"past": {"place": self._place, "stops": self._stops, "trails": past}}

    def now(self) -> Data:
        """Return how it is now, and what the line that moves is to be."""
        alarms = list(self._alarms())
        verdict = next((one for one in alarms if one[0] == _RED), None) or self._verdict()
        look = {
            "verdict": _words(verdict),
            "notes": [_words(one) for one in alarms if one != verdict],
            "boards": [_board(eye, seen) for eye, seen in self._boards()],
            "run": self._run.as_json() if self._run else None,
        }
        plan = self._run.plan(self.eyes) if self._run else None
        return ({"plan": plan} if plan else {}) | {"look": look}

    def stop(self) -> str:
        """Stop all boards; return in words what was done."""
        return "; ".join(eye.stop() for eye in self.eyes)

    def _boards(self) -> Iterator[tuple[Eye, Seen]]:
        for eye in self.eyes:
            for seen in eye.seen.values():
                yield eye, seen

    def _verdict(self) -> Said:
        """Return how the run is, else how the axes are."""
        if self._run is None:
            return self._axes_verdict()
        colour, text = self._run.verdict
        title, _, more = text.partition("; ")
        return colour, title, more

    def _axes_verdict(self) -> Said:
        known = [seen.now for _, seen in self._boards() if seen.now and not seen.trouble]
        if not known:
            return _GREY, "Looking for boards", ""
        states = [regs.axis_state(axis["axis_state"]) for now in known for axis in now.axes]
        axes = f"{len(states)} axis" if len(states) == 1 else f"{len(states)} axes"
        if moving := states.count("running"):
            return _BLUE, f"Moving: {moving} of {axes}", ""
        if armed := states.count("armed"):
            return _BLUE, f"Armed, waiting for the start: {armed} of {axes}", ""
        return _GREEN, f"At rest: {axes}, no fault", ""

    def _alarms(self) -> Iterator[Said]:
        """Yield what is wrong with boards; of a run that needs none of them it is amber."""
        for eye, seen in self._boards():
            lost = _AMBER if eye.spot.served and seen.now is None else _RED
            if seen.trouble:
                yield lost, f"No figures of board {seen.unit}", seen.trouble
            elif seen.now and seen.age_s > STALE_S:
                yield _RED, f"No figures of board {seen.unit} for {seen.age_s:.0f} s", ""
            elif seen.now:
                yield from _alarms_of(seen.unit, seen.now)


def _words(said: Said) -> Data:
    colour, text, more = said
    return {"colour": colour, "text": text, "more": more}


def _alarms_of(unit: int, now: Snapshot) -> Iterator[Said]:
    """Yield what is wrong with a board that answers."""
    if now.inputs["fault_code"]:
        title, _, more = _fault(now).partition(": ")
        yield _RED, f"Board {unit}: {title}", more
    if now.flags["estop"]:
        yield _RED, f"Board {unit}: the emergency stop is pressed", ""
    if now.off_hz is not None:
        beside = beside_set(now.off_hz, now.set_hz)
        yield _AMBER, f"Board {unit}: another pixel clock: {beside}", ""
    if now.flags["listen_only"]:
        yield _AMBER, f"Board {unit}: listens only", ""


def _fault(now: Snapshot) -> str:
    name = regs.code_name(regs.faults(), now.inputs["fault_code"])
    beside = ""
    if name in CLOCK_FAULTS and now.clock:
        argument = now.inputs["fault_argument"]
        beside = beside_set(fault_hz(name, argument, now.clock.tick_hz), now.set_hz)
    return regs.fault_text(now.inputs, beside)


def _key(eye: Eye, seen: Seen) -> str:
    return f"{eye.spot.port.name} {seen.unit}"


def _board(eye: Eye, seen: Seen) -> Data:
    """Return a board as it was seen last, and how long ago."""
    found: Data = {
        "key": _key(eye, seen), "unit": seen.unit, "port": eye.spot.port.name,
        "age_s": round(seen.age_s, 1), "trouble": seen.trouble, "axes": [],
        "stale": bool(seen.trouble) or seen.age_s > STALE_S,
    }  # fmt: skip
    now = seen.now
    if now is None:
        return found
    rates = now.rates(seen.before)
    wrong = [f"{now.inputs[name]} {name.replace('_', ' ')}" for name in _TROUBLES
             if now.inputs[name]]  # fmt: skip
    names = eye.spot.names
    return found | {
        "kind": now.who.board, "firmware": now.who.firmware, "time_s": round(now.time_s, 3),
        "flags": now.flags, "switches": now.switches, "clock": _clock(now, rates),
        "fault": regs.code_name(regs.faults(), now.inputs["fault_code"])
        if now.inputs["fault_code"] else "",
        "bus": {"per_s": rates.get("bus_messages"), "wrong": ", ".join(wrong)},
        "axes": [_axis(seen, axis, names.get((seen.unit, axis))) for axis in range(len(now.axes))],
    }  # fmt: skip


def _clock(now: Snapshot, rates: dict[str, float]) -> Data:
    """Return the pixel clock: by its measured period, else as its edges were counted."""
    found = None
    if now.flags["clock"]:
        tick_hz = now.clock.tick_hz if now.clock else 1
        found = measured_hz(now.clock, now.inputs, tick_hz) if now.clock else now.off_hz
        found = rates.get("pixel_edges") if found is None else found
    clock = now.clock.as_json() if now.clock and now.off_hz is None else None
    return {"measured_hz": found, "set_hz": now.set_hz, "edges": now.inputs["pixel_edges"],
            **({"figures": clock} if clock else {})}  # fmt: skip


def _axis(seen: Seen, axis: int, name: AxisName | None) -> Data:
    assert seen.now is not None
    found, shown = seen.now.axes[axis], seen.now.shown_axes[axis]
    trail = seen.trails.get(axis)
    name = name or AxisName("")
    return {
        "axis": axis, "motor": name.motor, "unit": name.unit, "scale": name.steps_per_unit,
        "state": regs.axis_state(found["axis_state"]), "position": found["position_steps"],
        "expected": shown["expected_steps"], "pixel": found["pixel"],
        "lines_done": found["lines_done"], "line": trail.line if trail else 0,
        "speed": trail.speed if trail else None,
    }  # fmt: skip
