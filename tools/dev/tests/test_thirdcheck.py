# SPDX-License-Identifier: MIT
"""sim/thirdcheck finds one period that is a cycle off, and one that is left out."""

import subprocess
import sys

import pytest

import compare
import thirdcheck
from pixstep import natives
from worked import PRN

STEPS = 100
RISES = [1000 + 533 * step for step in range(STEPS)]
CHANGES = ["ENABLE 1 after 0 steps", "DIR 1 after 7 steps"]
SENT = [(1000 + 20000 * number + 1496 * at, at) for number in range(3) for at in range(5)]


def run(rises=RISES, changes=CHANGES, sent=SENT):
    return compare.Run(list(rises), list(changes), list(sent))


def later_from(rises, step):
    """Lengthen one period by one cycle: every step from that one on comes one cycle later."""
    return [cycle + (at >= step) for at, cycle in enumerate(rises)]


def without(items, index):
    return [item for at, item in enumerate(items) if at != index]


def found(got, want=None, min_steps=STEPS):
    return compare.compare(want or run(), got, min_steps)[0]


def test_the_same_passes():
    problems, summary = compare.compare(run(), run(), STEPS)
    assert problems == []
    assert summary.startswith("99 periods at tolerance 0, edges 0 cycles apart at most, 2 changes")
    assert summary.endswith("2 replies, 10 of their 10 bytes the same")


def test_where_the_run_begins_is_not_a_period():
    """As a start edge that is captured a cycle later: told, not a fault."""
    problems, summary = compare.compare(run(), run(later_from(RISES, 0)), STEPS)
    assert problems == [] and "edges 1 cycles apart" in summary


@pytest.mark.parametrize("step", [1, 50, STEPS - 1])
def test_one_period_a_cycle_longer(step):
    text = f"1 of 99 periods differ, first the one behind step {step}: 534 cycles instead of 533"
    assert found(run(later_from(RISES, step))) == [text]


def test_one_step_a_cycle_late_is_two_periods():
    late = [cycle + (at == 50) for at, cycle in enumerate(RISES)]
    assert found(run(late))[0].startswith("2 of 99 periods differ, first the one behind step 50")


@pytest.mark.parametrize("index", [0, 50, STEPS - 1])
def test_one_step_left_out(index):
    assert found(run(without(RISES, index)))[0] == "99 steps instead of 100"


def test_one_step_too_many_and_too_few_recorded():
    assert found(run([*RISES, RISES[-1] + 533])) == ["101 steps instead of 100"]
    want = run(RISES[:9])
    assert found(run(RISES[:9]), want) == ["the recorded run has 9 steps, not 100 or more"]


def test_other_outputs_change_elsewhere():
    moved = [CHANGES[0], "DIR 1 after 8 steps"]
    assert found(run(changes=moved)) == [f"{', '.join(moved)} instead of {', '.join(CHANGES)}"]


def test_replies():
    other = [(cycle, byte ^ 0xFF) for cycle, byte in SENT]
    assert found(run(sent=other)) == ["reply 1: fffefdfcfb instead of 0001020304"]
    assert found(run(sent=without(SENT, 6))) == ["reply 2: 00020304 instead of 0001020304"]
    assert found(run(sent=[])) == ["reply 1:  instead of 0001020304"]
    # Readings of the moment, behind address and function, are counted and not judged.
    reading = [(cycle, 9 if byte == 3 else byte) for cycle, byte in SENT]
    problems, summary = compare.compare(run(), run(sent=reading), STEPS)
    assert problems == [] and summary.endswith("8 of their 10 bytes the same")


def test_without_yasimavr_it_is_skipped_with_the_reason(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "yasimavr", None)
    monkeypatch.delitem(sys.modules, "yasimavr.lib.core", raising=False)
    assert (
        thirdcheck.main(["--image", "a", "--pins", "b", "--run", "c"]) == thirdcheck.SKIPPED == 77
    )
    assert capsys.readouterr().out.startswith("thirdcheck: skipped, no yasimavr here: ")


@pytest.mark.usefixtures("plan_program", "simulator")
def test_a_recorded_run_changed_by_one_cycle(tmp_path):
    """On a short line, for real: as it is, with one period a cycle longer, with one left out."""
    if thirdcheck.missing():
        pytest.skip(f"no yasimavr: {thirdcheck.missing()}")
    line, folder = tmp_path / "line.csv", tmp_path / "run"
    pixstep(
        "line make --profile", PRN, "--speed 22 --pixels 12 --pixel-hz 30 --backlash 20 -o", line
    )
    pixstep("sim", line, "--board uno --decode smooth --pixel-hz 30 --backlash 20 --out", folder)
    pins = natives.source("firmware/avr/boards/uno.def")
    want, got, _ = thirdcheck.replay(natives.image("uno"), pins, folder)
    steps = len(want.rises)
    assert found(got, want, min_steps=steps) == []
    at = steps // 2
    spoiled = compare.Run(later_from(want.rises, at), want.changes, want.sent)
    assert found(got, spoiled, steps)[0].startswith(f"1 of {steps - 1} periods differ, first the")
    spoiled = compare.Run(without(want.rises, at), want.changes, want.sent)
    assert found(got, spoiled, steps - 1)[0] == f"{steps} steps instead of {steps - 1}"


def pixstep(*words):
    """Run the command; words may hold several, as typed."""
    split = [part for word in words for part in (word.split() if isinstance(word, str) else [word])]
    subprocess.run([sys.executable, "-m", "pixstep", *split], check=True, capture_output=True)
