# SPDX-License-Identifier: MIT
"""What a client's write does by itself, before the record looks at all its wishes."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from pixstep.motor_record.catalogue import FIELDS
from pixstep.motor_record.field import PutRefusedError, StatusUpdate, Value
from pixstep.motor_record.model import limits, moving, readback, speeds
from pixstep.motor_record.model.readback import shows, within
from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Mip, Msta, Verb

TARGETS: Final = frozenset({"VAL", "DVAL", "RVAL", "RLV", "TWF", "TWR"})
"""A write of one of these makes DMOV 0 at once, whatever comes of it."""

LEAST_NTMF: Final = 2
LEAST_FRAC: Final = FIELDS["FRAC"].taken(0.1)
MOST_FRAC: Final = FIELDS["FRAC"].taken(1.5)


def refuse(v: Values, name: str, value: Value) -> None:
    """Raise PutRefusedError for a write that the record does not take in its present state."""
    if v.disp and name != "DISP":
        raise PutRefusedError(name, value, "DISP is 1: the record takes no writes")
    if name in ("HOMF", "HOMR") and v.mip & Mip.HOME:
        raise PutRefusedError(name, value, "the motor looks for the home switch already")
    if name == "STUP" and v.stup != StatusUpdate.OFF:
        raise PutRefusedError(name, value, "a status is awaited already")
    if name in ("MRES", "UREV") and abs(float(value)) < speeds.LEAST_STEP:
        raise PutRefusedError(name, value, f"at least {speeds.LEAST_STEP:g} is wanted")


def act(r: State, name: str) -> bool:
    """Do what the write of a field does by itself. False if the record is not to process."""
    action = ACTIONS.get(name)
    if action is not None:
        action(r)
    return FIELDS[name].processes and not (name == "STUP" and r.v.stup != StatusUpdate.ON)


# --- coordinates -------------------------------------------------------------------------------


def _direction(r: State) -> None:
    v = r.v
    if v.foff:
        v.val = readback.user(v, v.dval)
    else:
        v.off = v.val - v.dval * readback.direction(v)
    v.rbv = readback.user(v, v.drbv)
    limits.user_limits_from_dial(v)


def _offset(r: State) -> None:
    v = r.v
    v.val = readback.user(v, v.dval)
    v.lval = readback.user(v, v.ldvl)
    v.rbv = readback.user(v, v.drbv)
    limits.user_limits_from_dial(v)


def _use_encoder(r: State) -> None:
    v = r.v
    if not v.ueip:
        return
    if shows(v, Msta.EA_PRESENT):
        v.urip = 0
    else:
        v.ueip = 0
        r.resolution_written = True


def _use_link(r: State) -> None:
    v = r.v
    if v.urip and v.ueip:
        v.ueip = 0
        r.resolution_written = True


# --- buttons -----------------------------------------------------------------------------------


def _jog(r: State, button: str, switch: str) -> None:
    v = r.v
    if not getattr(v, button):
        v.mip &= ~Mip.JOG_REQ
    elif v.mip == Mip.DONE and not getattr(v, switch):
        v.mip |= Mip.JOG_REQ


def _jog_speed(r: State) -> None:
    speeds.into_range(r.v, "jvel")
    if r.v.mip & Mip.JOGGING:
        moving.change_jog(r)


def _jog_acceleration(r: State) -> None:
    if r.v.jar <= 0:
        r.v.jar = r.v.jvel / speeds.LEAST_TIME_S


def _status_update(r: State) -> None:
    if r.v.stup != StatusUpdate.ON:
        r.v.stup = StatusUpdate.OFF


def _closed_loop(r: State) -> None:
    if shows(r.v, Msta.GAIN_SUPPORT):
        r.ask(Verb.ENABLE_TORQUE if r.v.cnen else Verb.DISABL_TORQUE, float(r.v.cnen))


def _gain(r: State, attribute: str, verb: Verb) -> None:
    if shows(r.v, Msta.GAIN_SUPPORT):
        gain = within(getattr(r.v, attribute), 0.0, 1.0)
        setattr(r.v, attribute, gain)
        r.ask(verb, gain)


# --- settings ----------------------------------------------------------------------------------


def _set(attribute: str, value: int) -> Callable[[State], None]:
    return lambda r: setattr(r.v, attribute, value)


def _fraction(r: State) -> None:
    r.v.frac = min(max(r.v.frac, float(LEAST_FRAC)), float(MOST_FRAC))


def _far_factor(r: State) -> None:
    r.v.ntmf = max(r.v.ntmf, LEAST_NTMF)


def _backlash_time(r: State) -> None:
    if r.v.bacc <= 0:
        r.v.bacc = speeds.LEAST_TIME_S


def _on_values(action: Callable[[Values], None]) -> Callable[[State], None]:
    return lambda r: action(r.v)


def _slew(r: State, *, in_turns: bool) -> None:
    (speeds.turns_written if in_turns else speeds.egu_written)(r.v, speeds.SLEW)
    speeds.acceleration_follows(r.v)


ACTIONS: Final[Mapping[str, Callable[[State], None]]] = {
    "VAL": _set("udf", 0),
    "DIR": _direction,
    "OFF": _offset,
    "SSET": _set("set", 1),
    "SUSE": _set("set", 0),
    "FOF": _set("foff", 1),
    "VOF": _set("foff", 0),
    "MRES": speeds.step_written,
    "UREV": speeds.revolution_written,
    "SREV": speeds.steps_written,
    "ERES": speeds.encoder_step_written,
    "UEIP": _use_encoder,
    "URIP": _use_link,
    "HLM": limits.high_user_limit_changed,
    "LLM": limits.low_user_limit_changed,
    "DHLM": limits.high_dial_limit_changed,
    "DLLM": limits.low_dial_limit_changed,
    "VELO": partial(_slew, in_turns=False),
    "S": partial(_slew, in_turns=True),
    "BVEL": _on_values(partial(speeds.egu_written, pair=speeds.BACKLASH)),
    "SBAK": _on_values(partial(speeds.turns_written, pair=speeds.BACKLASH)),
    "VBAS": _on_values(partial(speeds.lowest_written, in_turns=False)),
    "SBAS": _on_values(partial(speeds.lowest_written, in_turns=True)),
    "VMAX": _on_values(partial(speeds.highest_written, in_turns=False)),
    "SMAX": _on_values(partial(speeds.highest_written, in_turns=True)),
    "HVEL": _on_values(partial(speeds.into_range, attribute="hvel")),
    "ACCL": _on_values(speeds.time_written),
    "ACCS": _on_values(speeds.rate_written),
    "BACC": _backlash_time,
    "JVEL": _jog_speed,
    "JAR": _jog_acceleration,
    "JOGF": partial(_jog, button="jogf", switch="hls"),
    "JOGR": partial(_jog, button="jogr", switch="lls"),
    "STUP": _status_update,
    "CNEN": _closed_loop,
    "PCOF": partial(_gain, attribute="pcof", verb=Verb.SET_PGAIN),
    "ICOF": partial(_gain, attribute="icof", verb=Verb.SET_IGAIN),
    "DCOF": partial(_gain, attribute="dcof", verb=Verb.SET_DGAIN),
    "FRAC": _fraction,
    "NTMF": _far_factor,
    "RDBD": _on_values(speeds.keep_dead_bands),
    "BDST": _on_values(speeds.keep_dead_bands),
}
