# SPDX-License-Identifier: MIT
"""Reversals of plain lines on the host: transitions within the limits, errors, the line check."""

import itertools
import random
import re
from itertools import pairwise

import pytest

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.line_check import Limits, check
from pixstep.reversals.compensate import (
    MotionLimits,
    TakeUpRequest,
    Window,
    compensate,
    directions,
    strokes,
)
from strokes_line import LIMITS, PLAY, four_reversals

LINES = 60


def allowed(before, after, limits):
    """The rule of neighbouring counts, written out on its own."""
    if max(abs(before), abs(after)) <= limits.start_stop:
        return True
    return before * after >= 0 and abs(after - before) <= limits.max_acceleration


def random_stroke(rng, limits, direction, top):
    """Counts from start/stop speed up to a wavy plateau and down again."""
    counts = [rng.randint(1, limits.start_stop)]
    for _ in range(rng.randint(0, 12)):
        change = rng.randint(-limits.max_acceleration // 2, limits.max_acceleration)
        counts.append(min(top, max(1, counts[-1] + change)))
    while counts[-1] > limits.start_stop:
        counts.append(max(1, counts[-1] - rng.randint(1, limits.max_acceleration)))
    return [direction * count for count in counts]


def random_line(rng):
    """A plain line within random limits, some strokes short, some with rests between them."""
    limits = MotionLimits(rng.randint(1, 30), rng.randint(1, 12), rng.choice((80, 300)))
    direction = rng.choice((-1, 1))
    counts = [0] * rng.choice((0, 0, 3))
    for _ in range(rng.randint(2, 7)):
        counts += random_stroke(rng, limits, direction, limits.max_speed)
        counts += [0] * rng.choice((0, 0, 0, 1, 5))
        direction = -direction
    return counts + [0] * 80, limits


@pytest.fixture(params=range(LINES))
def case(request):
    """A random line with limits and play, and the random numbers to go on with."""
    rng = random.Random(1000 + request.param)
    counts, limits = random_line(rng)
    return counts, limits, rng.choice((1, 7, 40, 150)), rng


def assert_sound(counts, made, request):
    """Everything that must hold of any compensated line."""
    limits = request.limits
    for before, after in pairwise((0, *made.counts, 0)):
        assert allowed(before, after, limits), (before, after)
    assert max(map(abs, made.counts)) <= limits.max_speed
    inside, offset = set(), 0
    for item in made.transitions:
        window = range(item.pixel - 1, item.last_pixel)
        assert not inside & set(window)
        inside |= set(window)
        extra = [item.direction * (made.counts[k] - counts[k]) for k in window]
        assert min(extra) >= 0 and max(extra) == item.peak_extra
        assert sum(extra) == item.steps
        offset += item.direction * item.steps
        side = 0 if item.direction == made.taken_up else item.direction * request.play
        assert offset + item.direction * item.missing == side
        assert made.offsets[item.last_pixel - 1] == offset
    outside = set(range(len(counts))) - inside
    assert all(made.counts[k] == counts[k] for k in outside)


def test_the_random_lines_are_what_they_claim(case):
    counts, limits, _, _ = case
    assert all(allowed(a, b, limits) for a, b in pairwise((0, *counts, 0)))
    assert len(strokes(counts)) >= 2


def test_auto_transitions(case):
    counts, limits, play, rng = case
    request = TakeUpRequest(play, limits, None, rng.choice(("first", "+", "-", "unknown")))
    made = compensate(counts, request)
    assert_sound(counts, made, request)
    for item in made.transitions:
        if item.missing:  # only where the next reversal leaves no more room
            starts = [stroke.start + 1 for stroke in strokes(counts)]
            assert item.last_pixel + 1 in starts


def test_fixed_transitions_or_the_smallest_that_works(case):
    counts, limits, play, rng = case
    pixels = rng.choice((1, 2, 4, 8, 16, 32))
    request = TakeUpRequest(play, limits, pixels)
    try:
        made = compensate(counts, request)
    except UserError as error:
        pixel, smallest = map(int, re.search(r"pixel (\d+):.* is (\d+)$", str(error)).groups())
        assert smallest > pixels
        assert pixel - 1 in [stroke.start for stroke in strokes(counts)[1:]]
        request = TakeUpRequest(play, limits, smallest)
        assert_sound(counts, compensate(counts, request), request)
        with pytest.raises(UserError, match=f" is {smallest}$"):
            compensate(counts, TakeUpRequest(play, limits, smallest - 1))
    else:
        assert_sound(counts, made, request)
        assert all(item.window_px <= pixels for item in made.transitions)


def all_sequences(window, top):
    """Every sequence within the limits that is nowhere below the ideal."""
    for counts in itertools.product(*(range(count, top + 1) for count in window.ideal)):
        chain = (window.before, *counts, window.behind)
        if all(allowed(a, b, window.limits) for a, b in pairwise(chain)):
            yield counts


def late(extra):
    """How long the steps are waited for: each counts the pixels before it."""
    return sum(index * steps for index, steps in enumerate(extra))


@pytest.mark.parametrize("seed", range(40))
def test_take_up_against_every_possible_sequence(seed):
    rng = random.Random(seed)
    top = 7
    while True:
        limits = MotionLimits(rng.randint(1, 3), rng.randint(1, 3), top)
        window = Window(
            tuple(rng.randint(0, 4) for _ in range(4)), rng.randint(-3, 3), rng.randint(-3, 3),
            limits,
        )  # fmt: skip
        chain = (window.before, *window.ideal, window.behind)
        if all(allowed(a, b, limits) for a, b in pairwise(chain)):
            break
    sums = {}
    for counts in all_sequences(window, top):
        extra = [a - b for a, b in zip(counts, window.ideal, strict=True)]
        sums.setdefault(sum(extra), []).append((max(extra), late(extra)))
    assert window.room() == max(sums)
    for steps in range(max(sums) + 3):
        made = window.take_up(steps)
        if steps > max(sums):
            assert made is None
            continue
        chain = (window.before, *made, window.behind)
        assert all(allowed(a, b, limits) for a, b in pairwise(chain))
        extra = [a - b for a, b in zip(made, window.ideal, strict=True)]
        assert min(extra) >= 0 and sum(extra) == steps
        assert (max(extra), late(extra)) == min(
            sums[steps]
        )  # none takes less speed, nor is earlier


def test_zero_pixels_belong_to_the_motion_that_follows():
    assert directions([0, 0, 3, 0, 0, -2, -1, 0]) == [1, 1, 1, -1, -1, -1, -1, -1]
    assert directions([0, 0]) == [0, 0]


def test_play_taken_up_at_rest_moves_no_load():
    counts = [4, 10, 4] + [0] * 20 + [-4, -10, -4, 0]
    made = compensate(counts, TakeUpRequest(PLAY, LIMITS))
    (item,) = made.transitions
    assert (item.pixel, item.steps, item.worst_error, item.worst_pixel) == (4, PLAY, 0, None)
    assert made.counts[3 + item.window_px :] == tuple(counts[3 + item.window_px :])
    assert set(made.load_errors) == {0}


def test_second_reversal_inside_a_transition_goes_on_from_the_offset():
    counts = [4, 12, 4, -4, -12, -12, -4, 4, 12, *[20] * 8, 12, 4]
    request = TakeUpRequest(PLAY, LIMITS, 6)
    made = compensate(counts, request)
    assert_sound(counts, made, request)
    first, second = made.transitions
    assert first.missing > 0 and first.steps > 0 and not made.complete
    assert second.steps == first.steps and second.missing == 0  # not the whole play
    jumps = [abs(b - a) for a, b in pairwise((0, *made.counts, 0))]
    assert max(jumps) <= LIMITS.max_acceleration


def test_unbroken_in_the_stroke_though_the_transition_is_longer():
    made = compensate(four_reversals(), TakeUpRequest(PLAY, LIMITS, 1000))
    assert made.complete and [item.window_px for item in made.transitions] == [24] * 4


@pytest.mark.parametrize(
    ("initial", "steps"),
    [("first", [-40, 40]), ("+", [-40, 40]), ("-", [40, -40, 40]), ("unknown", [40, -40, 40])],
)
def test_initial_direction(initial, steps):
    counts = [4, *[10] * 9, 4, -4, *[-10] * 9, -4, 4, *[10] * 9, 4]
    made = compensate(counts, TakeUpRequest(PLAY, LIMITS, None, initial))
    assert [item.direction * item.steps for item in made.transitions] == steps
    down = compensate([-count for count in counts], TakeUpRequest(PLAY, LIMITS, None, "+"))
    assert [item.direction * item.steps for item in down.transitions] == [-40, 40, -40]
    assert down.load_errors[-1] == 0


def test_too_short_an_end_of_the_line():
    with pytest.raises(UserError, match=r"pixel 4: .* 3 pixels up to the end of the line"):
        compensate([4, 10, 4, -4, -10, -4], TakeUpRequest(PLAY, LIMITS))


@pytest.mark.parametrize(
    ("counts", "text"),
    [
        ([4, 15, 4], "pixel 2: acceleration before any compensation"),
        ([4, 5, -4], "pixel 3: reversal_without_ramp before"),
        ([4, 14, 24, 34], "pixel 4: acceleration before"),  # the stop at the end
    ],
)
def test_a_line_that_breaks_the_limits_itself(counts, text):
    with pytest.raises(UserError, match=f"^mine: {text}"):
        compensate(counts, TakeUpRequest(PLAY, LIMITS), "mine")


def test_nothing_to_do():
    assert compensate([0, 0], TakeUpRequest(PLAY, LIMITS)).counts == (0, 0)
    made = compensate([4, 10, 4], TakeUpRequest(PLAY, LIMITS))
    assert made.counts == (4, 10, 4) and made.transitions == () and made.worst_outside == 0


def plain_names(counts, **limits):
    found = check(Line(tuple(counts), PLAIN), Limits(**limits))
    return [(item.name, item.pixel) for item in found]


def test_line_check_of_reversals():
    assert plain_names([5, -5], start_stop=5) == []
    assert plain_names([5, -6], start_stop=5) == [("reversal_without_ramp", 2)]
    assert plain_names([6, -5], start_stop=5) == [("reversal_without_ramp", 2)]
    assert plain_names([60, 0, -60], start_stop=5) == []
    assert plain_names([60, -60]) == []


def test_line_check_of_plain_accelerations():
    rules = {"start_stop": 5, "max_acceleration": 4}
    assert plain_names([5, -5, 5, 9, 5], **rules) == []
    assert plain_names([6], **rules) == [("acceleration", 1), ("acceleration", 1)]
    assert plain_names([5, 10, 6, 2], **rules) == [("acceleration", 2)]
    assert plain_names([5, 6, 7], **rules) == [("acceleration", 3)]  # the stop at the end
    assert plain_names([4, 5], max_acceleration=4) == [("acceleration", 2)]
