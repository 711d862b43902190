# SPDX-License-Identifier: MIT
"""The firmware's core, built natively, against the independent reference: the property test."""

import random
from fractions import Fraction
from itertools import cycle, product

import pytest

from clock import TICK_HZ
from effort import cases
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.lines import core
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import check, refused
from pixstep.lines.units import edge_tick, period_ticks
from pixstep_trials.cases import PIXEL_HZ, Bounds, LineCase, case
from plan_judge import judge
from worked import EXPECTED, worked_line

pytestmark = pytest.mark.usefixtures("plan_program")

BACKLASHES = [0, 1, 250, 999, 1000]
CLOCKS = sorted({board.tick_hz for board in boards.all_boards()})


@pytest.mark.parametrize("decode", [SMOOTH, PLAIN])
@pytest.mark.parametrize("tick_hz", CLOCKS)
@pytest.mark.parametrize("seed", range(cases(2, 5)))
def test_random_lines(lines_option, decode, seed, tick_hz):
    rng = random.Random(f"{seed} {decode} plan")
    for _ in range(max(1, lines_option // 5)):
        judge(case(rng, decode, Bounds(min_interval_ticks=100, max_pixels=12, tick_hz=tick_hz)))


@pytest.mark.parametrize("tick_hz", CLOCKS)
@pytest.mark.parametrize(
    ("hz", "backlash"),
    cases(zip(PIXEL_HZ, cycle(BACKLASHES), strict=False), product(PIXEL_HZ, BACKLASHES)),
)
def test_worked_example(hz, backlash, tick_hz):
    judge(LineCase(worked_line(backlash, pixels=34), hz, tick_hz))


@pytest.mark.parametrize("backlash", sorted(EXPECTED))
def test_worked_example_table(backlash):
    rows = core.plan(worked_line(backlash), Fraction(30), tick_hz=TICK_HZ, pixels=True).columns()
    assert rows[:17, 2].tolist() == EXPECTED[backlash]


def test_other_timer_frequency():
    line = Line((4, 12, 16, 12, 4))
    ticks = core.plan(line, Fraction(30), tick_hz=8_000_000).columns()[:, 1].tolist()
    period = period_ticks(Fraction(30), 8_000_000)
    assert ticks[-1] == edge_tick(5, period)


def test_long_constant_line_does_not_drift():
    line = Line((500,) * 130, PLAIN)
    judge(LineCase(line, Fraction(30000, 1001), TICK_HZ))


HAZARDS = [
    ([10, 10, 10], {}, "oscillates"),
    ([4, 3], {}, "reverses_inside_pixel"),
    ([4, 0], {}, "zero_while_moving"),
    ([4, 12], {}, "ends_moving"),
    ([4, -4], {}, "negative_count"),
    ([16384], {}, "out_of_range"),
    ([0, 4, 8, 4, 0], {"backlash": 9}, "backlash_over_speed"),
    ([4, 8, 4], {"backlash": 4}, "backlash_no_room"),
    ([0, 4, 0], {"decode": PLAIN, "backlash": 4}, "backlash_plain"),
]


@pytest.mark.parametrize(("counts", "options", "name"), HAZARDS)
def test_core_and_host_refuse_alike(counts, options, name):
    line = Line(tuple(counts), **options)
    found = check(line)
    assert refused(found) and name in [item.name for item in found]
    with pytest.raises(core.LineRefusedByCoreError, match=f"line refused: {name} at pixel"):
        core.plan(line, Fraction(30), tick_hz=TICK_HZ)


@pytest.mark.parametrize("seed", range(4))
def test_core_and_host_agree_on_random_counts(seed):
    """Counts near the legal ones, so that both outcomes are common."""
    rng = random.Random(seed)
    agreed = {True: 0, False: 0}
    for _ in range(40):
        tested = case(rng, SMOOTH, Bounds(max_pixels=10, min_pixels=3))
        counts = list(tested.line.counts)
        if rng.random() < 0.7:
            counts[rng.randrange(len(counts))] += rng.choice((-2, -1, 1, 2))
        line = Line(tuple(counts), backlash=tested.line.backlash)
        host = refused(check(line))
        try:
            core.plan(line, tested.pixel_hz, tick_hz=tested.tick_hz)
            core_refuses = False
        except core.LineRefusedByCoreError as error:
            core_refuses = True
            assert host, f"{counts}: only the core refuses: {error}"
        assert host == core_refuses, f"{counts}: only the host refuses: {check(line)}"
        agreed[host] += 1
    assert all(agreed.values()), agreed


def test_ripple_is_a_warning_of_both():
    line = Line((501, 1000, 1000, 501))
    assert [item.name for item in check(line)] == ["ripple"]
    warnings = core.plan(line, Fraction(30), tick_hz=TICK_HZ).warnings
    assert len(warnings) == 1 and "warning: ripple at pixel 2" in warnings[0]


def test_a_frequency_that_the_board_cannot_do_is_one_line():
    with pytest.raises(UserError, match="period must be 1024 to 16777215"):
        core.plan(Line((4, 4)), Fraction(1, 100), tick_hz=TICK_HZ)
