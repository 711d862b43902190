# SPDX-License-Identifier: MIT
"""Arcs as CAM programs have them: numbers of a few decimals, by centre and by radius."""

import math
import re
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from effort import cases
from pixstep.programs.language import ProgramError, read
from pixstep.programs.moves import Program
from programbench import events, planned, setup
from programbench import path as path_of

STEPS = 400  # for a millimetre
TOGETHER = 100  # arcs of a program
WAYS = {1: -1, 2: 1}  # CIRCLE1 is clockwise


def machine(**more):
    """Return two motors with 400 steps/mm."""
    return setup(100, 2, counts_per_unit=STEPS, unit="mm", segment_ms=5, **more)


def random_arc(rng, by_radius):
    """Return what a CAM program knows of an arc: way, begin to centre, radius, signed angle."""
    radius = 10 ** rng.uniform(math.log10(0.2), 1.7)
    angle = rng.choice([math.pi, rng.uniform(0.02, math.tau - 0.02)], p=[0.2, 0.8])
    angle = max(angle, 0.02 / radius)  # no arc is shorter than its decimals
    if by_radius:
        angle = min(angle, math.tau - 0.1)
    circle = int(rng.choice([1, 2]))
    return circle, rng.uniform(0, math.tau), radius, angle * WAYS[circle]


def written(rng, arcs, decimals, by_radius):
    """Return a program of arcs in a row, and for each begin, centre, radius, first angle, angle."""
    rows, place, exact = ["ABS TS0 TA5 F600"], np.zeros(2), []
    for _ in range(arcs):
        circle, first, radius, angle = random_arc(rng, by_radius)
        centre = place - radius * np.array([math.cos(first), math.sin(first)])
        end = centre + radius * np.array([math.cos(first + angle), math.sin(first + angle)])
        exact.append((centre, radius, first, angle))
        shown = np.round(place, decimals)
        if by_radius:
            how = f"R{math.copysign(radius, math.pi * (1 + 1e-12) - abs(angle)):.{decimals}f}"
        else:
            i, j = centre - shown
            how = f"I{i:.{decimals}f} J{j:.{decimals}f}"
        rows.append(f"CIRCLE{circle} X{end[0]:.{decimals}f} Y{end[1]:.{decimals}f} {how}")
        place = end
    return "\n".join(rows), exact


def _off(places, arc):
    """Return how far places lie from an arc: from its circle, and past its ends from these."""
    centre, radius, first, angle = arc
    away = places - centre
    turned = (np.arctan2(away[:, 1], away[:, 0]) - first) * np.sign(angle)
    inside = np.mod(turned, math.tau) <= abs(angle)
    ends = centre + radius * np.array([[math.cos(a), math.sin(a)] for a in (first, first + angle)])
    to_end = np.min([np.hypot(*(places - end).T) for end in ends], axis=0)
    return np.where(inside, np.abs(np.hypot(*away.T) - radius), to_end)


def _corners_off(text, of, exact):
    """Return for each arc how far the middles of its segments lie from the exact one, mm."""
    moves = events(text, of)
    lines = np.array([move.line for move in moves])
    targets = np.array([move.target for move in moves]) / STEPS
    begins = np.vstack([np.zeros(2), targets[:-1]])
    found = []
    for number, arc in enumerate(exact):
        own = np.flatnonzero(lines == number + 2)[1:-1]  # the first and the last have one corner
        middles = (begins[own] + targets[own]) / 2 if len(own) else targets[lines == number + 2]
        found.append(_off(middles, arc).max())
    return np.array(found)


def _end(text):
    """Return where the last line of a program ends, mm."""
    return [float(value) for value in re.findall(r"[XY]([-.0-9]+)", text.splitlines()[-1])]


@pytest.mark.parametrize("decimals", [3, 4])
@pytest.mark.parametrize("by_radius", [False, True])
def test_random_arcs_of_cam_programs_are_planned_within_the_tolerance(decimals, by_radius):
    """4,000 arcs: segments on the exact arc within a step; in the long check all counts are made.

    By R a half circle's centre is known to the root of the rounding alone, so that the bound there
    is what the decimals leave.
    """
    rng = np.random.default_rng(1000 * decimals + by_radius)
    of = machine()
    for number in range(1000 // TOGETHER):
        text, exact = written(rng, TOGETHER, decimals, by_radius)
        if number < cases(1, 1000):
            end = [round(value * STEPS) for value in _end(text)]
            assert planned(text, of)[0].sum(axis=0).tolist() == end
        off = _corners_off(text, of, exact)
        if by_radius:
            half = 0.5 * 10.0**-decimals * (1 + 2 * math.sqrt(2))
            for arc, one in zip(exact, off, strict=True):
                _, radius, _, angle = arc
                # High is the centre's distance from the chord: its square is known to the rounding.
                high = radius * abs(math.cos(angle / 2))
                lost = math.sqrt(high**2 + 2 * radius * half) - high
                assert one <= 1 / STEPS + 2 * lost
        else:
            assert off.max() <= 1 / STEPS


@pytest.mark.parametrize(
    ("text", "length"),
    [
        ("INC CIRCLE1 X7.072 Y7.072 R5", math.pi * 5.00066),  # of the controller's manual
        ("CIRCLE2 X6.518 Y-3.976 I4.868 J0.650\nCIRCLE2 X7.173 Y-5.524 I0.901 J-0.531", None),
    ],
)
def test_the_numbers_of_real_programs(text, length):
    counts, report = planned(f"TA10 TS0 F20\n{text}", machine(feed_ms=1000.0))
    assert report.whole and counts.any()
    assert 0.05 < report.arc_off_steps < 1
    if length:
        steps = np.hypot(*np.diff(np.cumsum(counts, axis=0), axis=0).T).sum()
        assert steps == pytest.approx(length * STEPS, rel=0.01)


def test_the_radius_runs_linearly_from_begin_to_end():
    """A quarter of a turn from radius 10 to 10.1 mm."""
    of = machine(arc_tolerance=25)
    text = "TS0 TA5 F600 CIRCLE2 X-10 Y10.1 I-10 J0"
    path = path_of(text, of)
    places = path.place / STEPS + [10, 0]
    radius, angle = np.hypot(*places.T), np.arctan2(*places.T[::-1])
    inner = (angle > 0.1) & (angle < math.pi / 2 - 0.1)
    assert inner.sum() > 50
    assert np.abs(radius - 10 - 0.1 * angle / (math.pi / 2))[inner].max() < 0.5 / STEPS


def test_more_than_the_tolerance_is_refused_with_what_would_do():
    text = "TS0 TA5 TM90 CIRCLE2 X-5 Y5.004 I-5"
    assert planned(text, machine())[0].any()  # 2 um off either way, a step is 2.5 um
    for wrong, message in (
        (text.replace("5.004", "5.006"), "ends at radius 5.006, 0.003 mm off a circle, and 0.0025"),
        ("TS0 TA5 TM90 CIRCLE2 X10.006 R5", "10.006 apart, 0.003 mm off a circle, and 0.0025 mm"),
    ):
        with pytest.raises(ProgramError, match=message + r".*: arc_tolerance 0.0031?mm takes it"):
            planned(wrong, machine())
        assert planned(wrong, machine(arc_tolerance=1.3))[0].any()


def test_ends_that_are_one_place_but_for_the_noise_of_sums_make_a_whole_circle():
    text = "INC TS0 TA5 F600\nX0.1\nX0.1\nX0.1\nABS CIRCLE2 X0.3 Y0 I-2"
    moves = events(text, machine())
    assert len(moves) > 30


def test_random_arcs_from_rest_to_rest_lie_on_their_circles_within_half_a_step():
    """Of any radius, angle, time and acceleration time; their ends are whole steps."""
    rng, counts = np.random.default_rng(2), set()
    for _ in range(cases(250, 4000)):
        radius = 10 ** rng.uniform(0.7, 4.6)
        angle, first = 10 ** rng.uniform(-2.5, 0.79), rng.uniform(0, math.tau)
        centre = -radius * np.array([math.cos(first), math.sin(first)])
        end = np.round(
            centre + radius * np.array([math.cos(first + angle), math.sin(first + angle)])
        )
        chord = math.hypot(*end)
        if not 2 <= chord <= 2 * radius:
            continue
        high = math.sqrt(radius**2 - chord**2 / 4) * np.array([-end[1], end[0]]) / chord
        centre = min((end / 2 + high, end / 2 - high), key=lambda one: math.dist(one, centre))
        of = setup(1e9, 2, segment_ms=float(rng.choice([5, 50, 255])))
        found = path_of(
            f"INC TS0 TA{rng.choice([1, 5, 50, 400])} TM{10 ** rng.uniform(0, 3.3):.3f}\n"
            f"CIRCLE2 X{end[0]} Y{end[1]} I{centre[0]:.9f} J{centre[1]:.9f}",
            of,
        )
        counts.add(int(found.move.max()) + 1)
        dense = found.divided(np.full(len(found), 20))
        assert np.abs(np.hypot(*(dense.place - centre).T) - radius).max() <= 0.501
    assert {1, 2, 3, 4, 5} <= counts


def test_a_circle_of_very_many_segments_takes_no_memory():
    of = machine()
    program = Program("p.pmc", replace(of, segment_ms=0.001))
    moves = program.events(read("p.pmc", ["INC TS0 TA5 TM8000000 CIRCLE1 X1 R5"]))
    assert len(list(islice(moves, 1000))) == 1000
