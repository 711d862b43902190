# SPDX-License-Identifier: MIT
"""The table of the motor record's fields, and how values of clients become theirs."""

import typing

import pytest

from motor_bench import motor
from pixstep.motor_record import FIELDS, MONITOR_ORDER, NOT_SERVED, MotorRecord, PutRefusedError
from pixstep.motor_record.field import FieldType
from pixstep.motor_record.model.state import Values

# The record's own fields by its database definition (R7-4), but those that NOT_SERVED names.
RECORD = {
    *("VERS", "OFF", "FOFF", "FOF", "VOF", "DIR", "SET", "SSET", "SUSE", "VELO", "VBAS", "VMAX"),
    *("S", "SBAS", "SMAX", "ACCL", "ACCS", "ACCU", "BDST", "BVEL", "SBAK", "BACC", "FRAC", "OUT"),
    *("CARD", "RDBL", "DOL", "OMSL", "RLNK", "SREV", "UREV", "MRES", "ERES", "RRES", "UEIP"),
    *("URIP", "PREC", "EGU", "RHLM", "RLLM", "HLM", "LLM", "DHLM", "DLLM", "HOPR", "LOPR", "HLS"),
    *("LLS", "RHLS", "RLLS", "HIHI", "LOLO", "HIGH", "LOW", "HHSV", "LLSV", "HSV", "LSV", "HLSV"),
    *("RDBD", "SPDB", "RCNT", "RTRY", "MISS", "SPMG", "LSPG", "STOP", "HOMF", "HOMR", "JOGF"),
    *("JOGR", "TWF", "TWR", "TWV", "VAL", "LVAL", "DVAL", "LDVL", "RVAL", "LRVL", "RLV", "LRLV"),
    *("RBV", "DRBV", "DIFF", "RDIF", "CDIR", "RRBV", "RMP", "REP", "RVEL", "DMOV", "MOVN"),
    *("MSTA", "LVIO", "TDIR", "ATHM", "PP", "MIP", "DLY", "PCOF", "ICOF", "DCOF", "CNEN", "INIT"),
    *("PREM", "POST", "STOO", "DINP", "RINP", "JVEL", "JAR", "LOCK", "NTM", "NTMF", "HVEL"),
    *("STUP", "RMOD", "ADEL", "MDEL", "ALST", "MLST", "SYNC", "IGSET", "RSTM"),
}
OF_EVERY_RECORD = {"DESC", "STAT", "SEVR", "UDF", "PROC", "DISP", "DISA", "DISV"}
PYTHON = {FieldType.DOUBLE: float, FieldType.FLOAT: float, FieldType.STRING: str}
PYTHON[FieldType.LINK] = str


def test_all_fields_are_served_or_said_not_to_be():
    assert FIELDS.keys() == RECORD | OF_EVERY_RECORD
    assert not FIELDS.keys() & NOT_SERVED.keys()
    assert all(NOT_SERVED.values())


def test_the_values_are_those_of_the_table():
    hints = typing.get_type_hints(Values)
    assert list(hints) == [field.attribute for field in FIELDS.values()]
    for field in FIELDS.values():
        assert hints[field.attribute] is PYTHON.get(field.type, int), field.name
        assert isinstance(getattr(Values(), field.attribute), hints[field.attribute]), field.name


def test_every_field_says_what_it_is():
    for name, field in FIELDS.items():
        assert name == field.name and field.meaning
        assert bool(field.menu) == (field.type is FieldType.MENU)
        assert field.limits is None or set(field.limits) <= FIELDS.keys()


def test_control_limits():
    limits = {name: field.limits for name, field in FIELDS.items() if field.limits}
    assert limits == {
        "VAL": ("LLM", "HLM"),
        "RBV": ("LLM", "HLM"),
        "DVAL": ("DLLM", "DHLM"),
        "DRBV": ("DLLM", "DHLM"),
        "RVAL": ("RLLM", "RHLM"),
        "RRBV": ("RLLM", "RHLM"),
        "VELO": ("VBAS", "VMAX"),
    }


def test_units_and_menus_are_those_that_clients_know():
    assert {FIELDS[name].unit for name in ("VELO", "VBAS", "VMAX", "BVEL", "JVEL")} == {"EGU/sec"}
    assert {FIELDS[name].unit for name in ("ACCL", "BACC")} == {"sec"}
    assert FIELDS["FOFF"].menu == ("Variable", "Frozen")
    assert FIELDS["SET"].menu == ("Use", "Set")
    assert FIELDS["SPMG"].menu == ("Stop", "Pause", "Move", "Go")


def test_only_monitored_fields_are_posted_and_dmov_after_positions():
    assert set(MONITOR_ORDER) == {name for name, field in FIELDS.items() if field.monitored}
    assert len(MONITOR_ORDER) == len(set(MONITOR_ORDER))
    place = {name: number for number, name in enumerate(MONITOR_ORDER)}
    assert place["RBV"] < place["VAL"] < place["MIP"] < place["MOVN"] < place["DMOV"]


@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if not field.writable])
def test_what_only_the_record_writes_is_refused(name):
    with pytest.raises(PutRefusedError, match=f"{name}: 1 is refused: only the record writes it"):
        motor().record.put(name, 1)
    with pytest.raises(PutRefusedError):
        MotorRecord({name: 1})


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("NONE", 1, "the motor record has no such field"),
        ("RES", 1, "the motor record has no such field"),
        ("VAL", "far", "a number is wanted"),
        ("VAL", "nan", "a number of at most 1e\\+100 is wanted"),
        ("VAL", float("inf"), "a number of at most 1e\\+100 is wanted"),
        ("SPMG", "Run", "a number, or one of Stop, Pause, Move, Go is wanted"),
        ("SPMG", 4, "0 to 3"),
        ("SPMG", -1, "0 to 3"),
        ("RVAL", 3e9, "-2147483648 to 2147483647"),
        ("JOGF", 40000, "-32768 to 32767"),
        ("NTMF", -1, "0 to 65535"),
        ("FRAC", 1e60, "at most 3.4e38"),
        ("EGU", "a unit of much length", "at most 15 bytes"),
    ],
)
def test_a_value_that_is_none_is_refused_and_nothing_changes(name, value, reason):
    record = motor().record
    before = {field: record[field] for field in FIELDS}
    with pytest.raises(PutRefusedError, match=reason) as refused:
        record.put(name, value)
    assert (refused.value.field, refused.value.value) == (name, value)
    assert before == {field: record[field] for field in FIELDS}


@pytest.mark.parametrize(
    ("name", "value", "kept"),
    [
        ("SPMG", "Go", 3),
        ("SPMG", "2", 2),
        ("ACCU", "Accs", 1),
        ("ACCU", "Use ACCL", 0),
        ("RTRY", 2.9, 2),
        ("RTRY", "-3.9", -3),
        ("TWV", "1e-3", 0.001),
        ("EGU", 5, "5"),
        ("EGU", "µm", "µm"),
        ("DESC", "x" * 40, "x" * 40),
    ],
)
def test_a_value_becomes_the_fields_own(name, value, kept):
    bench = motor()
    bench.put(name, value)
    assert bench.record[name] == kept
