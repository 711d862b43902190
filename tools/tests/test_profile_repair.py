# SPDX-License-Identifier: MIT
"""Repairs: the fixes of oscillating counts, random oscillating lines, nearest legal profiles."""

import itertools
import json
import math
import random

import pytest
from click.testing import CliRunner

from effort import cases
from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.profiles import generator, ramps
from pixstep.profiles.generator import MAX_SPEED
from pixstep.profiles.repair import LINE, START, Wish, repair_counts, repair_speeds, whole_line
from worked import ACCELERATING, MPOS, worked_line

TEN = (10, 10, 10, 10)
RANDOM_LINES = cases(200, 1000)


def values(counts, limit=None, part=LINE, *, insert=False):
    return repair_counts(tuple(counts), Wish(limit, part, insert)).values


def findings(counts, limit=None, part=LINE):
    line = Line(whole_line(tuple(counts), part))
    return line_check.without_idle_pixel(
        line_check.check(line, line_check.Limits(max_acceleration=limit))
    )


@pytest.mark.parametrize(
    ("limit", "part", "insert", "repaired"),
    [
        (None, START, False, (5, 10, 10, 10)),
        (6, START, False, (2, 7, 10, 10)),
        (None, START, True, (5, 10, 10, 10, 10)),
        (6, START, True, (2, 7, 10, 10, 10, 10)),
        (None, LINE, False, (5, 10, 10, 5)),
        (None, LINE, True, (5, 10, 10, 10, 10, 5)),
        (4, LINE, True, (1, 4, 8, 10, 10, 10, 10, 8, 4, 1)),
    ],
)
def test_constant_counts_from_rest(limit, part, insert, repaired):
    assert values(TEN, limit, part, insert=insert) == repaired
    assert findings(repaired, limit, part) == []


def test_changes_say_what_and_why():
    first, last = repair_counts(TEN, Wish()).changes
    assert (first.pixel, first.before, first.after) == (1, (10,), (5,))
    assert first.reason == "4 pixels of 10 entered at speed 0 would swing between 20 and 0"
    assert (last.pixel, last.before, last.after) == (4, (10,), (5,))
    assert last.reason == "the line would end at speed 10, not at rest"


def test_a_good_line_stays_as_it_is():
    for backlash in (0, 250):
        counts = worked_line(backlash).counts
        assert repair_counts(counts, Wish(128)).values == counts
        assert repair_counts(counts, Wish()).changes == ()
    excerpt = tuple(formats.read_csv(MPOS).values)
    assert repair_counts(excerpt, Wish(128, START)).changes == ()


@pytest.mark.parametrize("pixel", range(len(ACCELERATING)))
@pytest.mark.parametrize("edit", [-1, 1, 3])
def test_a_hand_edit_costs_no_more_than_the_edit(pixel, edit):
    counts = list(worked_line(0).counts)
    counts[pixel] += edit
    assert findings(counts) != []
    repaired = values(counts)
    assert findings(repaired) == [] and len(repaired) == len(counts)
    assert sum(abs(a - b) for a, b in zip(counts, repaired, strict=True)) <= abs(edit)


def test_odd_constant_speed_is_lowered():
    counts = [948 if count == 948 else count + (count == 1000) for count in worked_line(0).counts]
    assert max(counts) == 1001
    assert values(counts) == worked_line(0).counts
    assert values([1, 1, 1, 1]) == (1, 2, 2, 1)


def test_an_accidental_pair_in_a_ramp_is_no_stretch():
    repaired = values([5, 10, 10, 10, 13, 13, 10, 10, 10, 5])
    assert findings(repaired) == [] and len(repaired) == 10
    assert repaired[:3] == (5, 10, 10) and repaired[-3:] == (10, 10, 5)


def test_rest_inside_a_line_stays():
    assert values([0, 6, 6, 6, 0, 0, 8, 8, 8, 0]) == (0, 3, 6, 3, 0, 0, 4, 8, 4, 0)


@pytest.mark.parametrize(
    ("counts", "limit", "message"),
    [
        ([10, 10], None, "one must be left: insert makes"),
        ([10] * 6, 2, "within 2 steps/px2 takes 10 of its 6 pixels"),
        ([10, -10], None, "pixel 2: count -10 is outside"),
        ([16_384, 4], None, "pixel 1: count 16384 is outside"),
        ([4, 3], None, "too short to move"),
    ],
)
def test_what_cannot_be_repaired(counts, limit, message):
    with pytest.raises(UserError, match=message):
        values(counts, limit)


def oscillating(rng: random.Random) -> list[int]:
    """A line that a smooth motor does not follow: constant heads, sampled curves, edits."""
    kind = rng.randrange(3)
    if kind == 0:
        return [rng.randint(1, 900)] * rng.randint(3, 40)
    if kind == 1:
        top, ramp, hold = rng.randint(4, 3000), rng.randint(3, 20), rng.randint(2, 30)
        rise = [round(top * math.sin(math.pi * (k + 0.5) / (2 * ramp)) ** 2) for k in range(ramp)]
        return [*rise, *[top] * hold, *rise[::-1]]
    counts = list(worked_line(rng.choice((0, 250))).counts)
    for _ in range(rng.randint(1, 4)):
        pixel = rng.randrange(1, len(counts) - 1)
        counts[pixel] = max(1, counts[pixel] + rng.choice((-3, -1, 1, 2)))
    return counts


def test_random_oscillating_lines_pass_the_check_after_repair():
    rng = random.Random(30)
    repaired_lines = 0
    for _ in range(RANDOM_LINES):
        counts = oscillating(rng)
        if not findings(counts):
            continue
        limit = rng.choice((None, 2 * max(1, max(counts) // 3), 512))
        repaired = repair_counts(tuple(counts), Wish(limit, insert=True))
        assert findings(repaired.values, limit) == [], counts
        repaired_lines += 1
    assert repaired_lines > 0.8 * RANDOM_LINES


def test_random_lines_keep_their_length():
    rng = random.Random(31)
    for _ in range(RANDOM_LINES):
        counts = oscillating(rng)
        repaired = values(counts)
        assert findings(repaired) == [] and len(repaired) == len(counts), counts
        started = values(counts, part=START)
        assert findings(started, part=START) == [] and len(started) == len(counts), counts


def test_changes_lead_from_the_old_counts_to_the_new():
    rng = random.Random(32)
    for _ in range(300):
        counts = oscillating(rng)
        repair = repair_counts(tuple(counts), Wish(insert=rng.random() < 0.5))
        rebuilt, done = [], 0
        for change in repair.changes:
            rebuilt += counts[done : change.pixel - 1]
            done = change.pixel - 1 + len(change.before)
            assert tuple(counts[change.pixel - 1 : done]) == change.before
            rebuilt += change.after
        assert tuple(rebuilt + counts[done:]) == repair.values


def test_ramps_change_as_little_as_any_search_finds():
    rng = random.Random(33)
    for _ in range(60):
        counts = tuple(rng.randint(1, 9) for _ in range(rng.randint(1, 4)))
        begin, end = (2 * rng.randint(0, 5) for _ in range(2))
        ramp = ramps.Ramp(counts, begin, end)
        inner = itertools.product(range(0, 21, 2), repeat=len(counts) - 1)
        best = min(cost(counts, (begin, *speeds, end)) for speeds in inner)
        assert cost(counts, (begin, *ramps.plan(ramp))) <= best + 1, ramp


def cost(counts, speeds):
    """Steps changed by the boundary speeds."""
    means = ((a + b) // 2 for a, b in itertools.pairwise(speeds))
    return sum(abs(mean - count) for mean, count in zip(means, counts, strict=True))


def nearest_by_search(speeds):
    """Least sum of changes over all legal profiles."""
    legal = range(2, max(speeds) + 3, 2)
    choices = itertools.combinations_with_replacement(legal, len(speeds))
    return min(sum(abs(a - b) for a, b in zip(c, speeds, strict=True)) for c in choices)


def test_nearest_legal_prn():
    repair = repair_speeds((8, 15, 24, 20, 32))
    assert repair.values == (8, 14, 20, 20, 32)
    assert [(c.pixel, c.before, c.after) for c in repair.changes] == [
        (2, (15,), (14,)), (3, (24,), (20,)),
    ]  # fmt: skip
    assert repair_speeds((0, 1, 99_999_999)).values == (2, 2, MAX_SPEED)


def test_no_legal_prn_is_nearer():
    rng = random.Random(34)
    for _ in range(200):
        speeds = tuple(rng.randint(0, 14) for _ in range(rng.randint(1, 5)))
        made = repair_speeds(speeds).values
        assert all(value % 2 == 0 and value > 0 for value in made) and list(made) == sorted(made)
        changed = sum(abs(a - b) for a, b in zip(made, speeds, strict=True))
        assert changed == nearest_by_search(speeds), speeds
        counts = generator.acceleration_counts(list(made), made[-1])
        assert findings(counts, part=START) == []


def run(*words, status=0):
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert done.exit_code == status, done.output
    return done.output


def test_command_repairs_a_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    formats.write_csv(tmp_path / "ten.csv", list(TEN))
    output = run("profile", "repair", "ten.csv", "-o", "fixed.csv")
    assert "pixel 1: 10 -> 5: 4 pixels of 10 entered at speed 0 would swing" in output
    assert "4 pixels, 40 -> 30 steps" in output
    assert formats.read_csv(tmp_path / "fixed.csv").values == (5, 10, 10, 5)
    assert "fine" in run("line", "check", "fixed.csv", "--decode", "smooth")
    report = json.loads(
        run("profile", "repair", "ten.csv", "--part", "start", "--max-acceleration", 7,
            "-o", "start.csv", "--json")
    )  # fmt: skip
    assert report["values"] == [2, 7, 10, 10] and report["part"] == "start"
    assert report["changes"][0]["before"] == [10, 10]


def test_a_long_list_of_changes_is_cut_short(tmp_path):
    formats.write_csv(tmp_path / "a.csv", [501, 1000, 1000, 501, 0] * 20)
    output = run("profile", "repair", tmp_path / "a.csv", "-o", tmp_path / "b.csv")
    assert "and 20 more; --json lists them all" in output and output.count("\n") == 23


def test_command_keeps_the_header_of_a_profile(tmp_path):
    header = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "mine", 1, 3, 2, "30")
    formats.write_csv(tmp_path / "a.csv", list(TEN), header)
    output = run("profile", "repair", tmp_path / "a.csv", "--insert", "-o", tmp_path / "b.csv")
    assert "an accelerating start" in output and "before pixel 1: 5 inserted" in output
    read = formats.read_csv(tmp_path / "b.csv")
    assert read.values == (5, 10, 10, 10, 10) and read.header == header


def test_command_repairs_a_prn(tmp_path):
    formats.write_prn(tmp_path / "a.PRN", [8, 15, 24, 20, 32])
    output = run("profile", "repair", tmp_path / "a.PRN", "-o", tmp_path / "b.PRN")
    assert "entry 2: 15 -> 14: odd: every boundary speed is even" in output
    assert formats.read_prn(tmp_path / "b.PRN")[0] == [8, 14, 20, 20, 32]
    assert "fine" in run("profile", "check", tmp_path / "b.PRN", "--decode", "smooth")


def test_command_refuses_in_one_line(tmp_path):
    formats.write_csv(tmp_path / "a.csv", [10, 10])
    formats.write_prn(tmp_path / "a.PRN", [8])
    out = tmp_path / "out"
    text = run("profile", "repair", tmp_path / "a.csv", "-o", out, status=2)
    assert text.count("\n") == 1 and "a.csv: pixel 1" in text
    text = run("profile", "repair", tmp_path / "a.PRN", "--insert", "-o", out, status=2)
    assert "--insert is for counts" in text
    assert not out.exists()
