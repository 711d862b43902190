# SPDX-License-Identifier: MIT
"""A motor record above the ideal stepper, for tests of single behaviours."""

from pixstep.motor_record import MotorRecord
from pixstep_trials.motor_traces.bench import TraceBench
from pixstep_trials.motor_traces.stepper import Stepper

FIELDS = {
    "MRES": 0.01,
    "VELO": 1,
    "ACCL": 0.2,
    "DHLM": 50,
    "DLLM": -50,
    "JVEL": 1,
    "JAR": 5,
    "HVEL": 0.5,
    "TWV": 0.5,
    "RTRY": 0,
}


def motor(stepper=None, links=None, **fields):
    """Return a record that has begun, above a stepper that rests."""
    record = MotorRecord(FIELDS | fields)
    for name, value in (links or {}).items():
        record.set_link(name, value)
    bench = TraceBench(record, stepper or Stepper())
    bench.take(record.initialise(bench.stepper.status()))
    bench.forget()
    return bench


def commands(bench):
    """Return what was asked since the last look, as texts, and begin a new look."""
    asked = [str(command) for command in bench.commands]
    bench.forget()
    return asked


def posted(outcome, *names):
    """Return the posts of these fields, in order; of all fields if none is named."""
    return [(post.field, post.value) for post in outcome.posts if not names or post.field in names]


def settled(bench):
    """Let all come to rest; it must."""
    assert bench.settle()[1]
    return bench
