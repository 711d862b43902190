# SPDX-License-Identifier: MIT
"""Decisions where the printer's documents leave a gap, by their numbers in docs/FILES.md.

Q1, Q2, Q4, Q5, Q12 and Q13 concern files alone: test_formats.py.
"""

from fractions import Fraction

import pytest

from bench import Bench
from clock import TICK_HZ
from pixstep.board import registers as regs
from pixstep.errors import UserError
from pixstep.lines import core, exact, line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import MARK_SMOOTH, queue_entries
from pixstep.moves import fast
from pixstep.profiles import generator, readings
from pixstep.profiles.generator import LineRequest, generate
from worked import ACCELERATING, DATA, SAMPLE_CSV, worked_line

SPEEDS = [8, 16, 24, 32]
ONE = Fraction(1)


def names(line, **limits):
    return [item.name for item in line_check.check(line, line_check.Limits(**limits))]


def test_q3_the_decode_rule_travels_with_the_line():
    smooth, plain = Line((4, 4), SMOOTH), Line((4, 4), PLAIN)
    assert queue_entries(smooth)[0][0] & MARK_SMOOTH
    assert not queue_entries(plain)[0][0] & MARK_SMOOTH


def test_q3_a_fast_move_is_plain():
    profile = fast.read(DATA / "AccProf-fast-move.csv")
    assert fast.plan(profile, 5000).line("move").decode == PLAIN


def test_q3_a_profile_is_checked_under_both_rules(tmp_path):
    path = tmp_path / "AccProf.csv"
    path.write_bytes(b"".join(b"%6d\r\n" % value for value in (10, 10, 10)))
    found = readings.check(readings.load(path), None, line_check.Limits())
    by_rule = {reading.decode: reading.sound for reading in found}
    assert by_rule == {PLAIN: True, SMOOTH: False}
    assert readings.exit_status(found) == 1


def test_q3_the_sample_is_ambiguous_by_its_rows():
    found = readings.load(SAMPLE_CSV)
    assert [rows.form for rows in found.rows] == [readings.BLOCK, readings.ROWS]


def test_q6_backlash_travels_with_the_line_and_is_no_setting_of_the_board():
    line = worked_line(250)
    assert queue_entries(line)[1] == (250, 1000)
    assert not any("backlash_steps" in register.name for register in regs.register_map().holdings)


@pytest.mark.parametrize("backlash", [0, 4])
@pytest.mark.parametrize("lead_in", [0, 3])
def test_q7_image_pixel_zero(backlash, lead_in):
    made = generate(SPEEDS, LineRequest(24, 30, backlash, lead_in))
    ramp = made.counts.index(24) - (1 if backlash else 0)
    assert ramp == made.accelerating_pixels == 3
    assert made.image_pixel == (1 if backlash else 0) + 1 + ramp + lead_in
    assert made.counts[made.image_pixel - 1 - lead_in : made.image_pixel] == [24] * (lead_in + 1)


@pytest.mark.parametrize("backlash", [0, 1, 24])
def test_q8_trailing_zero_if_and_only_if_there_is_a_leading_one(backlash):
    counts = generate(SPEEDS, LineRequest(24, 30, backlash)).counts
    assert (counts[0] == 0) == (counts[-1] == 0) == (backlash > 0)


def test_q9_a_leading_zero_without_backlash_is_legal_with_a_warning():
    line = Line((0, 4, 8, 8, 4, 0))
    assert names(line) == ["idle_pixel"]
    assert not line_check.refused(line_check.check(line))
    assert names(Line((0, 4, 8, 8, 8, 4, 0), backlash=4)) == []


@pytest.mark.usefixtures("simulator")
def test_q9_the_board_takes_it_and_warns():
    with Bench("mega") as bench:
        bench.load(Line((0, 4, 8, 8, 4, 0)))
        assert bench.state() == "loaded"
        warning = bench.board.axis(0)["line_warning"]
    assert regs.code_name(regs.line_errors(), warning) == "idle_pixel"


@pytest.mark.parametrize("decode", [SMOOTH, PLAIN])
def test_q10_a_step_lies_at_the_end_of_its_interval(decode):
    line = Line((4, 4), decode)
    instants = [float(tick) for _, tick in exact.exact_instants(line, ONE)]
    assert instants[3] == 1 and instants[7] == 2  # the last of each pixel on its edge
    assert instants[0] > 0


@pytest.mark.usefixtures("plan_program")
def test_q11_plain_steps_are_evenly_spaced_by_the_same_rule():
    line = Line((3, 7), PLAIN)
    period = Fraction(TICK_HZ, 30)
    planned = core.plan(line, Fraction(30), tick_hz=TICK_HZ).columns()[:, 1].tolist()
    first = [period * j / 3 for j in (1, 2, 3)]
    second = [period + period * j / 7 for j in range(1, 8)]
    wanted = first + second
    assert all(abs(tick - place) < 1 for tick, place in zip(planned, wanted, strict=True))
    assert planned[2] == period // 1 and planned[9] == 2 * period // 1


def test_q12_a_negative_backlash_figure_is_refused():
    with pytest.raises(UserError, match="positive figure"):
        generate(SPEEDS, LineRequest(24, 30, -1))


def test_q14_a_speed_below_the_first_entry_is_one_partial_entry():
    assert generator.acceleration_counts([8, 16], 6) == [3]
    with pytest.raises(UserError, match="nearest legal 4 and 6"):
        generator.acceleration_counts([8, 16], 5)


@pytest.mark.parametrize(("backlash", "lead_in"), [(0, 0), (0, 5), (4, 0), (4, 5)])
def test_q15_the_shortest_line(backlash, lead_in):
    ramp = len(generator.acceleration_counts(SPEEDS, 24))
    shortest = 2 * ramp + lead_in + 1 + (2 if backlash else 0)
    made = generate(SPEEDS, LineRequest(24, shortest, backlash, lead_in))
    assert len(made.counts) == shortest
    with pytest.raises(UserError, match=f"at least {shortest}$"):
        generate(SPEEDS, LineRequest(24, shortest - 1, backlash, lead_in))


def test_the_worked_example_is_free_of_findings():
    assert names(worked_line(250)) == []
    assert sum(ACCELERATING) == 4418
