# SPDX-License-Identifier: MIT
"""Soft limits in their three coordinates, and what violates them."""

from pixstep.motor_record.model.state import State, Values
from pixstep.motor_record.traffic import Verb


def enabled(v: Values) -> bool:
    """True unless both dial limits are 0."""
    return not v.dhlm == v.dllm == 0.0


def contradict(v: Values) -> bool:
    """True where no position can be within the limits."""
    return v.dllm > v.dhlm


def user_limits_from_dial(v: Values) -> None:
    """Make the user limits agree after a change of OFF, DIR or the dial limits."""
    if v.dir:
        v.hlm, v.llm = v.off - v.dllm, v.off - v.dhlm
    else:
        v.hlm, v.llm = v.dhlm + v.off, v.dllm + v.off


def dial_limits_from_raw(v: Values) -> None:
    """Make dial and user limits agree after a change of MRES."""
    ends = (v.rllm * v.mres, v.rhlm * v.mres)
    v.dllm, v.dhlm = ends if v.mres >= 0 else ends[::-1]
    user_limits_from_dial(v)


def high_dial_limit_changed(r: State) -> None:
    """Tell the driver about DHLM, and make raw and user limits agree."""
    v = r.v
    raw = v.dhlm / v.mres
    _tell(r, high=v.mres >= 0, raw=raw)
    if v.dir:
        v.llm = v.off - v.dhlm
    else:
        v.hlm = v.dhlm + v.off


def low_dial_limit_changed(r: State) -> None:
    """Tell the driver about DLLM, and make raw and user limits agree."""
    v = r.v
    raw = v.dllm / v.mres
    _tell(r, high=v.mres < 0, raw=raw)
    if v.dir:
        v.hlm = v.off - v.dllm
    else:
        v.llm = v.dllm + v.off


def high_user_limit_changed(r: State) -> None:
    """Make dial and raw limits agree with HLM."""
    v = r.v
    if v.dir:
        v.dllm = v.off - v.hlm
        low_dial_limit_changed(r)
    else:
        v.dhlm = v.hlm - v.off
        high_dial_limit_changed(r)


def low_user_limit_changed(r: State) -> None:
    """Make dial and raw limits agree with LLM."""
    v = r.v
    if v.dir:
        v.dhlm = v.off - v.llm
        high_dial_limit_changed(r)
    else:
        v.dllm = v.llm - v.off
        low_dial_limit_changed(r)


def _tell(r: State, *, high: bool, raw: float) -> None:
    if high:
        r.v.rhlm = raw
        r.ask(Verb.SET_HIGH_LIMIT, raw)
    else:
        r.v.rllm = raw
        r.ask(Verb.SET_LOW_LIMIT, raw)


def outside(v: Values, dial: float) -> bool:
    """True for a dial position beyond a limit."""
    return dial > v.dhlm or dial < v.dllm


def coming_back(v: Values) -> bool:
    """True for a target outside that is nearer to the limits than the last one."""
    return v.dhlm < v.dval < v.ldvl or v.ldvl < v.dval < v.dllm


def move_violates(v: Values, *, preferred: bool) -> bool:
    """True if the target violates a limit, or the point beyond it where an approach begins."""
    if not enabled(v):
        return False
    if contradict(v):
        return True
    if coming_back(v):
        return False
    return outside(v, v.dval if preferred else v.dval - v.bdst)


def jog_violates(v: Values, position: float) -> bool:
    """True if less than one second of the jog is left from a user position."""
    if not enabled(v):
        return False
    forwards = v.jogf and position > v.hlm - v.jvel
    backwards = v.jogr and position < v.llm + v.jvel
    return bool(forwards or backwards) or contradict(v)
