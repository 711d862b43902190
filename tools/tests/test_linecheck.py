# SPDX-License-Identifier: MIT
"""The host's line check: each named error, and the oscillation detector with its repairs."""

from fractions import Fraction

import pytest

from clock import TICK_HZ
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.line_check import Limits, check, exit_status, propose_repair
from worked import worked_line


def names(counts, limits=None, **kwargs):
    return [(item.name, item.pixel) for item in check(Line(tuple(counts), **kwargs), limits)]


@pytest.mark.parametrize("backlash", [0, 1, 250, 1000])
def test_worked_example_is_fine(backlash):
    assert check(worked_line(backlash)) == []


@pytest.mark.parametrize(
    ("counts", "error"),
    [
        ([4, 4], None),
        ([4, 12], ("ends_moving", 3)),
        ([4, 3], ("reverses_inside_pixel", 2)),
        ([4, 0], ("zero_while_moving", 2)),
        ([4, -4], ("negative_count", 2)),
        ([40000], ("out_of_range", 1)),
        ([16384], ("out_of_range", 1)),
        ([16383, 16383], ("oscillates", 1)),
    ],
)
def test_named_errors(counts, error):
    found = names(counts)
    assert (error in found) if error else ("oscillates", 1) in found


@pytest.mark.parametrize(
    ("counts", "backlash", "error"),
    [
        ([0, 4, 8, 4, 0], 9, ("backlash_over_speed", 1)),
        ([4, 8, 4], 4, ("backlash_no_room", 1)),
        ([0, 4, 8, 4, 0], 8, None),
    ],
)
def test_backlash(counts, backlash, error):
    assert names(counts, backlash=backlash) == ([error] if error else [])


def test_backlash_on_a_plain_line():
    assert names([0, 5, 0], decode=PLAIN, backlash=1) == [("backlash_plain", 1)]


def test_hazard_of_constant_counts_from_rest():
    (found,) = [f for f in check(Line((10, 10, 10, 10))) if f.name == "oscillates"]
    assert (found.pixel, found.amplitude, found.severity) == (1, 10, "error")
    assert found.repair == [5]


@pytest.mark.parametrize("head", [[5], [2, 7]])
def test_repaired_lines_are_fine(head):
    line = [*head, 10, 10, *reversed(head)]
    assert names(line) == []


def test_small_oscillation_is_a_warning():
    # entered at 1002: the amplitude 2 is no more than max(2, 1 %)
    found = check(Line((501, 1000, 1000, 501)))
    assert [(f.name, f.severity, f.pixel, f.amplitude) for f in found] == [
        ("ripple", "warning", 2, 2)
    ]
    assert exit_status(found) == 1


def test_odd_constant_cannot_be_repaired():
    (found,) = [f for f in check(Line((5, 11, 11))) if f.pixel == 2]
    assert found.repair == [] and "use 10 or 12" in found.message


@pytest.mark.parametrize(
    ("entry", "count", "limit", "repair"),
    [
        (0, 10, None, [5]),
        (0, 10, 6, [2, 7]),
        (0, 1000, None, [500]),
        (20, 10, None, [15]),
        (0, 11, None, []),
    ],
)
def test_repair_reaches_the_count(entry, count, limit, repair):
    assert propose_repair(entry, count, limit) == repair
    speed = entry
    for value in repair:
        if limit:
            assert abs(2 * (value - speed)) <= limit
        speed = 2 * value - speed
    assert speed == (count if repair else entry)


def test_limits():
    limits = Limits(max_speed=20, max_acceleration=16)

    assert ("too_fast", 2) in names([8, 20, 20, 8], limits)
    assert ("acceleration", 1) in names([10, 20, 10], limits)


def test_jerk_warning():
    found = names([4, 12, 41, 41, 12, 4], Limits(jerk_warning=20))
    assert ("jerk", 3) in found


@pytest.mark.parametrize(
    ("counts", "limit", "pixels"),
    [
        ([10, 20, 10], 19, [1, 2, 3, 3]),  # from rest, to constant, from constant, to rest
        ([10, 20, 10], 20, []),
        ([0, 10, 20, 10, 0], 19, [2, 3, 4, 5]),
        ([2, 6, 8, 8, 6, 2], 3, [1, 3, 5, 6]),
    ],
)
def test_jerk_counts_from_rest_and_to_rest(counts, limit, pixels):
    found = check(Line(tuple(counts), backlash=counts[0] == 0), Limits(jerk_warning=limit))
    assert [item.pixel for item in found if item.name == "jerk"] == pixels
    assert len(found) == len(pixels)


@pytest.mark.parametrize(
    ("counts", "limits", "pixels"),
    [
        ([10, 20, 10], Limits(jerk_warning=19), [3]),  # 10, 10, -10, -10
        ([10, 20, 10], Limits(jerk_warning=9), [1, 3]),
        ([20, -20], Limits(jerk_warning=59), [2, 2]),
        ([20, -20], Limits(jerk_warning=1, start_stop=20), []),
    ],
)
def test_the_jerk_of_a_plain_line(counts, limits, pixels):
    found = check(Line(tuple(counts), PLAIN), limits)
    assert [item.pixel for item in found if item.name == "jerk"] == pixels


def test_whole_steps_of_a_plain_line_have_a_jerk_of_their_own():
    limits = Limits(max_acceleration=5, jerk_warning=3)
    assert limits.with_rounding(Line((1,), PLAIN)) == Limits(max_acceleration=7, jerk_warning=7)
    assert limits.with_rounding(Line((1,))) == limits


def test_rate_limit():
    limits = Limits(min_interval_ticks=100, period_ticks=Fraction(TICK_HZ, 30))
    assert ("too_fast", 1) in names([6000], limits, decode=PLAIN)
    assert names([5000], limits, decode=PLAIN) == []


def test_every_place_above_a_limit_is_named():
    # boundary speeds 0 20 20 30 20 0
    found = names([10, 20, 25, 25, 10], Limits(max_acceleration=10, max_speed=25))
    assert found == [
        ("acceleration", 1), ("oscillates", 3), ("too_fast", 3), ("acceleration", 5),
    ]  # fmt: skip


@pytest.mark.parametrize(("length", "end"), [(2, 8), (3, 8), (4, 8), (7, 8)])
def test_the_check_goes_on_behind_equal_counts_that_oscillate(length, end):
    counts = [10] * length
    speed = 0 if length % 2 == 0 else 20
    counts.append((speed + end) // 2)
    assert names(counts) == [("oscillates", 1), ("ends_moving", length + 2)]
    assert names([*counts, 10, 6]) == [("oscillates", 1)]


def test_every_ripple_is_named():
    counts = [501, 1000, 1000, 1002, 1000, 1000, 501]
    assert [item for item in names(counts) if item[0] == "ripple"] == [("ripple", 2), ("ripple", 5)]


@pytest.mark.parametrize(
    ("counts", "found"),
    [
        ([1, -118], [("reversal_too_fast", 2)]),
        ([1, -1], []),
        ([118, 0, -118], []),
        ([1, -118, 118], [("reversal_too_fast", 2), ("reversal_too_fast", 3)]),
    ],
)
def test_reversals_need_time(counts, found):
    limits = Limits(reversal_ticks=4240, period_ticks=Fraction(16_000_000, 100))
    assert names(counts, limits, decode=PLAIN) == found


def test_the_text_of_a_reversal_has_the_times():
    limits = Limits(reversal_ticks=4240, period_ticks=Fraction(16_000_000, 100))
    (found,) = check(Line((5, -100), PLAIN), limits)
    assert found.message.endswith(": from 5 to -100 in 1600.0 ticks, the board needs 4240")


def test_counts_that_no_segment_can_hold_are_refused():
    assert names([70_000], decode=PLAIN) == [("out_of_range", 1)]
    assert names([-70_000], decode=PLAIN) == [("out_of_range", 1)]
    assert names([0, 4, 4], backlash=70_000)[0] == ("backlash_over_speed", 1)
