# SPDX-License-Identifier: MIT
"""How long a step is: MRES, UREV and SREV agree, and the dead bands are not below a step."""

from typing import Final

from pixstep.motor_record.model import limits, speeds
from pixstep.motor_record.model.state import State
from pixstep.motor_record.model.values import Values

STEPS_PER_REVOLUTION: Final = 200
"""What SREV becomes where it is 0 or less."""

LEAST_STEP: Final = 1e-12
"""Below this a step counts as none."""


def keep_dead_bands(v: Values) -> None:
    """Lift RDBD to one step: no move could come nearer."""
    v.rdbd = max(v.rdbd, abs(v.mres))


def step_written(r: State) -> None:
    """Act on MRES."""
    r.v.urev = r.v.mres * r.v.srev
    speeds.all_egu_follow(r.v)
    limits.dial_limits_from_raw(r.v)
    r.resolution_written = True


def revolution_written(r: State) -> None:
    """Act on UREV."""
    speeds.all_egu_follow(r.v)
    step = r.v.mres
    _step_from_revolution(r)
    if r.v.mres != step:
        limits.dial_limits_from_raw(r.v)


def steps_written(r: State) -> None:
    """Act on SREV: the revolution stays, the step changes."""
    v = r.v
    if v.srev <= 0:
        v.srev = STEPS_PER_REVOLUTION
    _step_from_revolution(r)


def _step_from_revolution(r: State) -> None:
    v = r.v
    step = v.urev / v.srev
    if v.mres != step:
        v.mres = step
        r.resolution_written = True


def encoder_step_written(r: State) -> None:
    """Act on ERES: 0 becomes the motor's step."""
    if r.v.eres == 0:
        r.v.eres = r.v.mres
    r.resolution_written = True


def settle(v: Values) -> None:
    """Make the fields agree after a database file: UREV counts, where it is given."""
    if v.srev <= 0:
        v.srev = STEPS_PER_REVOLUTION
    if v.urev != 0:
        v.mres = v.urev / v.srev
    if abs(v.mres) < LEAST_STEP:
        v.mres = 1.0
    v.urev = v.mres * v.srev
