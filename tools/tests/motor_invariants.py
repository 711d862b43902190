# SPDX-License-Identifier: MIT
"""What holds of a motor record after every operation, whatever came before."""

from pixstep.motor_record import FIELDS, FieldType, Mip, Msta
from pixstep.motor_record.field import Spmg

WHOLE = {
    FieldType.LONG: (-(2**31), 2**31 - 1),
    FieldType.ULONG: (0, 2**32 - 1),
    FieldType.SHORT: (-(2**15), 2**15 - 1),
    FieldType.USHORT: (0, 2**16 - 1),
    FieldType.UCHAR: (0, 255),
}


def near(one, other, size=0.0):
    """True if two numbers are equal but for the rounding of numbers of this size."""
    return abs(one - other) <= 1e-9 * max(1.0, abs(one), abs(other), size)


def coordinates(bench):
    """User, dial and raw: one equation each."""
    r = bench.record
    sign = -1 if r["DIR"] else 1
    size = abs(r["OFF"])
    if not bench.stepper.status_wanted:  # else OFF may be new, and the position not yet
        assert near(r["RBV"], sign * r["DRBV"] + r["OFF"], size)
    high, low = (r["DHLM"], r["DLLM"]) if sign > 0 else (-r["DLLM"], -r["DHLM"])
    assert near(r["HLM"], high + r["OFF"], size + abs(high))
    assert near(r["LLM"], low + r["OFF"], size + abs(low))
    assert near(r["UREV"], r["MRES"] * r["SREV"])
    assert not (r["UEIP"] and r["URIP"])


def speeds(r):
    """Each speed by both ways, and within its bounds."""
    turn = abs(r["UREV"])
    for egu, turns in (("VELO", "S"), ("BVEL", "SBAK"), ("VBAS", "SBAS"), ("VMAX", "SMAX")):
        assert near(r[egu], turn * r[turns]), egu
    slack = 1e-9 * max(1.0, r["VBAS"], r["VMAX"])
    for name in ("VELO", "BVEL"):
        assert r[name] >= r["VBAS"] - slack, name
        assert r["VMAX"] == 0 or r[name] <= r["VMAX"] + slack, name
    assert r["VMAX"] == 0 or r["VBAS"] <= r["VMAX"] + slack
    assert r["ACCL"] >= 0 and r["BACC"] > 0
    assert 0.0999 < r["FRAC"] < 1.5001 and r["NTMF"] >= 2


def types(r):
    """Every field holds what its type can hold."""
    for name, field in FIELDS.items():
        value = r[name]
        if field.type in WHOLE:
            lowest, highest = WHOLE[field.type]
            assert isinstance(value, int) and lowest <= value <= highest, (name, value)
        elif field.type is FieldType.MENU:
            assert isinstance(value, int) and 0 <= value < len(field.menu), (name, value)
        elif field.type in (FieldType.DOUBLE, FieldType.FLOAT):
            assert abs(value) < 1e300, (name, value)
        else:
            assert isinstance(value, str), (name, value)


def target_within_limits(r, last, commands):
    """No leg that a write begins goes beyond a limit, or farther beyond than where it begins.

    A target outside is taken where the last one was as far outside, or farther. With MRES < 0 a
    near relative move may make its approach from the other side, as the record's does.
    """
    low, high, target = r["DLLM"], r["DHLM"], r["DVAL"]
    ways = [one for one in commands if one.verb in ("MOVE_ABS", "MOVE_REL")]
    if low == high == 0 or not ways:
        return
    assert low <= high
    if not low <= target <= high:
        assert high < target <= last or last <= target < low, (target, last, low, high)
        return
    lowest, highest = min(low, last, r["DRBV"]), max(high, last, r["DRBV"])
    for way in ways:
        if way.verb == "MOVE_REL" and r["MRES"] < 0:
            continue
        here = r["DRBV"] if way.verb == "MOVE_REL" else 0.0
        there = here + way.argument * r["MRES"]
        slack = 1e-9 * max(1.0, abs(there)) + abs(r["MRES"])
        assert lowest - slack <= there <= highest + slack, (there, lowest, highest)


def at_rest_when_done(bench):
    """After a status, DMOV = 1 means that the motor rests, if nothing halts the record's look."""
    r = bench.record
    halted = r["MSTA"] & (Msta.PROBLEM | Msta.PLUS_LS | Msta.MINUS_LS)
    if r["DMOV"] and not halted:
        assert bench.stepper.at_rest
        assert r["RMP"] == bench.stepper.status().position_steps
    assert r["MOVN"] == 0 or not r["DMOV"]


def told(r, known):
    """Clients know the value of every monitored field."""
    for name, value in known.items():
        assert r[name] == value, (name, r[name], value)


def ends(bench, ended):
    """A motion that is over is done for the record as well, unless that is held or in trouble."""
    r = bench.record
    if not ended:
        waits = r["SPMG"] in (Spmg.STOP, Spmg.PAUSE) or bench.stepper.problem
        waits = waits or bench.delay_s is not None
        assert waits or not bench.stepper.at_rest, (r["MIP"], r["DMOV"])
        return
    held = r["SPMG"] in (Spmg.STOP, Spmg.PAUSE) and r["MIP"] == Mip.JOG_REQ  # begins at Go
    assert held or r["MIP"] in (Mip.DONE, Mip.STOP), r["MIP"]
