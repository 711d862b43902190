# SPDX-License-Identifier: MIT
"""The motor record against recordings of the real one, and its foresight of second legs."""

from pathlib import Path

import pytest

from pixstep.motor_record import Mip
from pixstep_trials.motor_traces import replay, verdict
from pixstep_trials.motor_traces.compare import close

DATA = Path(__file__).parent / "data" / "motor_record"
COUNTS = {
    "traces.jsonl.xz": dict.fromkeys(
        ("moves", "backlash", "encoder", "slip", "coordinates", "motion", "limits", "faults"), 40
    ),
    "more.jsonl.xz": dict.fromkeys(("delay", "links", "alarms"), 30),
}


@pytest.mark.parametrize("name", COUNTS)
def test_every_trace_is_equal(name):
    judged = verdict.judge([DATA / name])
    assert judged.total == COUNTS[name]
    assert [str(one) for one in judged.differing] == []


def _same(one, other):
    return len(one) == len(other) and all(
        a.verb == b.verb and (a.argument is None or close(a.argument, b.argument))
        for a, b in zip(one, other, strict=True)
    )


class Watch:
    """Compares each second leg that was foreseen with what the record asks when it is time."""

    def __init__(self, bench):
        self.bench = bench
        self.foreseen = None
        """None: there was no leg, or something came between."""
        self.rest = None
        self.held = 0
        self._take, bench.take = bench.take, self.take

    def take(self, outcome):
        stepper = self.bench.stepper
        undisturbed = (stepper.position, stepper.slip) == self.rest
        self._take(outcome)
        if outcome.commands:
            if self.foreseen is not None and undisturbed and self._is_second(outcome):
                assert _same(self.foreseen, outcome.commands), (self.foreseen, outcome.commands)
                self.held += 1
            self.foreseen = outcome.second_leg
            self.rest = (stepper.target, stepper.slip)
        return outcome

    def _is_second(self, outcome):
        """True for an approach: also where none was foreseen."""
        return bool(self.foreseen) or bool(self.bench.record["MIP"] & (Mip.MOVE_BL | Mip.JOG_BL2))


@pytest.mark.parametrize(
    ("kind", "legs"),
    [("backlash", 273), ("encoder", 104), ("motion", 42)],
    ids=lambda one: str(one),
)
def test_second_legs_come_as_foreseen(kind, legs):
    held = 0
    for trace in replay.read(DATA / "traces.jsonl.xz"):
        if trace["kind"] != kind:
            continue
        bench = replay.begin(trace)
        watch = Watch(bench)
        for step in trace["steps"]:
            if step["op"][0] not in ("adv", "settle"):
                watch.foreseen = None
            replay.operate(bench, step["op"])
        held += watch.held
    assert held == legs
