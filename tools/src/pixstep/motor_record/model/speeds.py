# SPDX-License-Identifier: MIT
"""Speeds and accelerations: the two ways to write each, and their ranges.

How long a step is: MRES, UREV and SREV agree, and the dead bands are not below a step.
"""

from dataclasses import dataclass
from typing import Final

from pixstep.motor_record.model import limits
from pixstep.motor_record.model.readback import share, within
from pixstep.motor_record.model.state import State, Values

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
    all_egu_follow(r.v)
    limits.dial_limits_from_raw(r.v)
    r.resolution_written = True


def revolution_written(r: State) -> None:
    """Act on UREV."""
    all_egu_follow(r.v)
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


def settle_resolution(v: Values) -> None:
    """Make the fields agree after a database file: UREV counts, where it is given."""
    if v.srev <= 0:
        v.srev = STEPS_PER_REVOLUTION
    if v.urev != 0:
        v.mres = v.urev / v.srev
    if abs(v.mres) < LEAST_STEP:
        v.mres = 1.0
    v.urev = v.mres * v.srev


LEAST_TIME_S: Final = 0.1
"""What an acceleration time of 0 or less becomes."""


@dataclass(frozen=True)
class Pair:
    """One speed by its two fields: EGU/s, and revolutions/s."""

    egu: str
    turns: str


SLEW: Final = Pair("velo", "s")
BACKLASH: Final = Pair("bvel", "sbak")
LOWEST: Final = Pair("vbas", "sbas")
HIGHEST: Final = Pair("vmax", "smax")


def _get(v: Values, attribute: str) -> float:
    value: float = getattr(v, attribute)
    return value


def turns_follow(v: Values, pair: Pair) -> None:
    """Make the speed in revolutions agree with the one in EGU."""
    if v.urev != 0:
        setattr(v, pair.turns, _get(v, pair.egu) / abs(v.urev))


def egu_follows(v: Values, pair: Pair) -> None:
    """Make the speed in EGU agree with the one in revolutions."""
    setattr(v, pair.egu, abs(v.urev) * _get(v, pair.turns))


def all_egu_follow(v: Values) -> None:
    """Keep the speeds in revolutions as the revolution changes."""
    for pair in (SLEW, LOWEST, BACKLASH, HIGHEST):
        egu_follows(v, pair)


def into_range(v: Values, attribute: str) -> None:
    """Bring one speed in EGU/s between VBAS and VMAX."""
    setattr(v, attribute, within(_get(v, attribute), v.vbas, v.vmax))


def egu_written(v: Values, pair: Pair) -> None:
    """Act on a speed written in EGU/s."""
    into_range(v, pair.egu)
    turns_follow(v, pair)


def turns_written(v: Values, pair: Pair) -> None:
    """Act on a speed written in revolutions/s."""
    setattr(v, pair.turns, within(_get(v, pair.turns), v.sbas, v.smax))
    egu_follows(v, pair)


def lowest_written(v: Values, *, in_turns: bool) -> None:
    """Act on VBAS or SBAS: VMAX is lifted to it."""
    _bound_written(v, LOWEST, in_turns)
    if v.vmax != 0 and v.vbas > v.vmax:
        v.vmax, v.smax = v.vbas, v.sbas
    recheck(v)
    acceleration_follows(v)


def highest_written(v: Values, *, in_turns: bool) -> None:
    """Act on VMAX or SMAX: VBAS is lowered to it."""
    _bound_written(v, HIGHEST, in_turns)
    if v.vmax != 0 and v.vmax < v.vbas:
        v.vbas, v.sbas = v.vmax, v.smax
    recheck(v)


def _bound_written(v: Values, pair: Pair, in_turns: bool) -> None:
    written = pair.turns if in_turns else pair.egu
    setattr(v, written, max(_get(v, written), 0.0))
    if in_turns:
        egu_follows(v, pair)
    else:
        turns_follow(v, pair)


def recheck(v: Values) -> None:
    """Bring all speeds between the new bounds."""
    egu_written(v, SLEW)
    egu_written(v, BACKLASH)
    into_range(v, "jvel")
    into_range(v, "hvel")


# --- accelerations -----------------------------------------------------------------------------


def gain(v: Values, speed: float) -> float:
    """Return how much faster than VBAS a speed is, or the speed if it is not."""
    return speed - v.vbas if speed > v.vbas else speed


def acceleration_follows(v: Values) -> None:
    """Make the other one of ACCL and ACCS agree after a change of VELO or VBAS."""
    if v.accu:
        time_follows(v)
    else:
        rate_follows(v)


def rate_follows(v: Values) -> None:
    """Make ACCS agree with ACCL."""
    v.accs = share(gain(v, v.velo), v.accl)


def time_follows(v: Values) -> None:
    """Make ACCL agree with ACCS."""
    if v.accs > 0:
        v.accl = gain(v, v.velo) / v.accs


def time_written(v: Values) -> None:
    """Act on ACCL."""
    if v.accl <= 0:
        v.accl = LEAST_TIME_S
    rate_follows(v)


def rate_written(v: Values) -> None:
    """Act on ACCS: 0 or less is not taken."""
    if v.accs <= 0:
        rate_follows(v)
    else:
        time_follows(v)


# --- at the start ------------------------------------------------------------------------------


def settle(v: Values) -> None:
    """Make both ways agree after a database file: what is given in revolutions counts."""
    _settle_highest(v)
    _settle_lowest(v)
    for pair in (SLEW, BACKLASH):
        if _get(v, pair.turns) != 0:
            turns_written(v, pair)
        else:
            egu_written(v, pair)
    v.accl = v.accl if v.accl > 0 else LEAST_TIME_S
    v.bacc = v.bacc if v.bacc > 0 else LEAST_TIME_S
    _settle_rate(v)
    v.jvel = within(v.jvel, v.vbas, v.vmax) if v.jvel != 0 else v.velo
    v.jar = v.jar if v.jar != 0 else share(v.velo, v.accl)
    v.hvel = within(v.hvel, v.vbas, v.vmax) if v.hvel != 0 else v.vbas


def _settle_highest(v: Values) -> None:
    if v.smax > 0:
        egu_follows(v, HIGHEST)
    elif v.vmax > 0:
        turns_follow(v, HIGHEST)
    else:
        v.smax = v.vmax = 0.0


def _settle_lowest(v: Values) -> None:
    if v.sbas != 0:
        v.sbas = within(v.sbas, 0.0, v.smax)
        egu_follows(v, LOWEST)
    else:
        v.vbas = within(v.vbas, 0.0, v.vmax)
        turns_follow(v, LOWEST)


def _settle_rate(v: Values) -> None:
    if v.accs > 0:
        time_follows(v)
    else:
        rate_follows(v)
