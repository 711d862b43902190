# SPDX-License-Identifier: MIT
"""Files of traces as somebody gives them to the replay: changed, damaged, or something else."""

import copy
import json
import lzma
from pathlib import Path

import pytest

from pixstep.errors import RefusedError
from pixstep_trials.motor_traces import replay, verdict

DATA = Path(__file__).parent / "data" / "motor_record"


@pytest.fixture(scope="module")
def trace():
    """The first recording with commands in its first step."""
    traces = replay.read(DATA / "traces.jsonl.xz")
    return next(one for one in traces if one["steps"][0].get("commands"))


def judged(tmp_path, trace, **changed):
    path = tmp_path / "one.jsonl"
    path.write_text(json.dumps(trace | changed) + "\n")
    return verdict.judge([path])


def first_step(trace, **changed):
    steps = copy.deepcopy(trace["steps"])
    steps[0] |= changed
    return steps


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"commands": []}, "commands"),
        ({"commands": ["MOVE_ABS 1.00001", "GO"]}, "commands"),
        ({"dmov": [0, 1]}, "dmov"),
        ({"changed": {"VAL": 1e6}}, "VAL"),
    ],
)
def test_each_difference_is_found_and_named(tmp_path, trace, changed, what):
    outcome = judged(tmp_path, trace, steps=first_step(trace, **changed))
    assert [one.difference.what for one in outcome.differing] == [what]
    assert outcome.differing[0].line == 1 and outcome.differing[0].difference.step == 0
    assert list(outcome.lines())[1].startswith("all ")
    assert outcome.to_dict()["kinds"][trace["kind"]] == {"equal": 0, "of": 1}


def test_a_change_in_the_ninth_digit_of_an_argument_is_found(tmp_path, trace):
    wanted = list(trace["steps"][0]["commands"])
    name, number = wanted[0].split()
    wanted[0] = f"{name} {float(number) * (1 + 3e-9)!r}"
    outcome = judged(tmp_path, trace, steps=first_step(trace, commands=wanted))
    assert [one.difference.what for one in outcome.differing] == ["commands"]


def test_a_settling_that_took_another_time_is_found(tmp_path, trace):
    steps = copy.deepcopy(trace["steps"])
    settle = next(step for step in steps if step["op"] == ["settle"])
    settle["ticks"] += 1
    outcome = judged(tmp_path, trace, steps=steps)
    assert [one.difference.what for one in outcome.differing] == ["ticks"]


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"steps": [{"op": ["fly", 1]}]}, r'\["fly", 1\] is no operation of a trace'),
        ({"steps": [{"op": ["put", "VAL"]}]}, "no trace: "),
        ({"steps": [{"op": ["sim", "wind", 1]}]}, r'\["sim", "wind", 1\] is no operation'),
        ({"steps": "none"}, "no trace: "),
        ({"start": 5}, "no trace: "),
        ({"initial": {"NEWS": 1}}, "NEWS: 1 is refused"),
    ],
)
def test_what_is_no_trace_is_refused_with_its_place(tmp_path, trace, changed, reason):
    with pytest.raises(RefusedError, match=f"one.jsonl:1: {reason}"):
        judged(tmp_path, trace, **changed)


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.jsonl", b"", "there is no trace in it"),
        ("a.jsonl", b"\xff\xfe\n", "no text in UTF-8"),
        ("a.jsonl", b"{", "1: no JSON"),
        ("a.jsonl", b"[1]", "1: a trace has initial, kind, start, steps"),
        ("a.jsonl.xz", b"no archive", "not packed by xz, or cut off"),
        ("a.jsonl.xz", lzma.compress(b"{}" * 10_000)[:-20], "not packed by xz, or cut off"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, name, content, reason):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RefusedError, match=f"{name}:.*{reason}"):
        verdict.judge([path])
