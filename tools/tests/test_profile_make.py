# SPDX-License-Identifier: MIT
"""The shortest profile: limits kept, no shorter one exists, lines of it pass every check."""

import json
import math
import random
from fractions import Fraction

import pytest
from click.testing import CliRunner

from clock import TICK_HZ
from effort import cases
from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines import core, exact, line_check
from pixstep.lines.line import Line
from pixstep.lines.units import ACCELERATION, JERK
from pixstep.profiles import generator
from pixstep.profiles.generator import ProfileLimits, shortest_pixels, shortest_profile

RANDOM_LIMITS = cases(300, 2000)


def random_limits(rng: random.Random) -> ProfileLimits:
    """Even limits, every order of magnitude as likely as another."""
    top = 2 * min(8191, int(10 ** rng.uniform(0, 3.92)))
    return ProfileLimits(top, 2 * int(10 ** rng.uniform(0, 3)), 2 * int(10 ** rng.uniform(0, 2.6)))


def line_of(limits: ProfileLimits, constant: int = 3, backlash: int = 0) -> Line:
    speeds = shortest_profile(limits)
    pixels = 2 * len(speeds) + constant + (2 if backlash else 0)
    request = generator.LineRequest(limits.top_speed, pixels, backlash)
    return Line(tuple(generator.generate(speeds, request).counts), backlash=backlash)


def line_limits(limits: ProfileLimits) -> line_check.Limits:
    return line_check.Limits(
        max_speed=limits.top_speed,
        max_acceleration=limits.max_acceleration,
        jerk_warning=limits.max_jerk,
    )


def reached_in(limits: ProfileLimits) -> int:
    """Fewest pixels to the top speed by breadth-first search over all even states."""
    states = {(0, 0)}
    for pixels in range(1, 10_000):
        following = set()
        for speed, acceleration in states:
            low = max(-limits.max_acceleration, acceleration - limits.max_jerk)
            high = min(limits.max_acceleration, acceleration + limits.max_jerk)
            for value in range(low, high + 1, 2):
                if 0 <= speed + value <= limits.top_speed:
                    following.add((speed + value, value))
        if any(s == limits.top_speed and abs(a) <= limits.max_jerk for s, a in following):
            return pixels
        states = following
    raise AssertionError("never reached")


def continuous_bound(limits: ProfileLimits) -> float:
    """Fewest pixels of any real-valued profile.

    Averaged over a pixel, an acceleration that jumps by at most J from pixel to pixel becomes a
    continuous one of slope at most J, a pixel longer, with the same gain; the shortest of those is
    the trapezoid (or triangle) of slope J and height A.
    """
    speed, top, jerk = limits.top_speed, limits.max_acceleration, limits.max_jerk
    if speed * jerk >= top * top:
        return speed / top + top / jerk - 1
    return 2 * math.sqrt(speed / jerk) - 1


def test_limits_far_above_the_speed_take_no_time():
    """One pixel is enough; the work must not grow with limits that are of no use."""
    assert shortest_profile(ProfileLimits(1000, 10**15, 10**15)) == [1000]
    assert shortest_profile(ProfileLimits(1000, 10**15, 400)) == [334, 668, 1000]


def test_no_shorter_profile_exists_in_small_cases():
    for top in range(2, 42, 2):
        for acceleration in (2, 4, 6, 10):
            for jerk in (2, 4, 6):
                limits = ProfileLimits(top, acceleration, jerk)
                assert len(shortest_profile(limits)) == reached_in(limits), limits


def test_random_limits_are_kept_and_the_length_is_near_the_bound():
    rng = random.Random(20)
    worst = 0.0
    for _ in range(RANDOM_LIMITS):
        limits = random_limits(rng)
        speeds = shortest_profile(limits)
        changes = [b - a for a, b in zip([0, *speeds], speeds, strict=False)]
        jerks = [b - a for a, b in zip([0, *changes], [*changes, 0], strict=True)]
        assert all(speed % 2 == 0 for speed in speeds) and speeds[-1] == limits.top_speed
        assert min(changes) > 0 and max(changes) <= limits.max_acceleration, limits
        assert max(map(abs, jerks)) <= limits.max_jerk, limits
        excess = len(speeds) - continuous_bound(limits)
        assert excess >= -1e-9, limits
        worst = max(worst, excess)
    assert worst <= 2


def test_random_limits_make_lines_without_findings():
    rng = random.Random(21)
    for _ in range(RANDOM_LIMITS):
        limits = random_limits(rng)
        backlash = rng.choice((0, 1, limits.top_speed))
        line = line_of(limits, rng.randint(1, 5), backlash)
        assert line_check.check(line, line_limits(limits)) == [], limits


@pytest.mark.usefixtures("plan_program")
def test_the_firmware_takes_the_lines():
    rng = random.Random(22)
    for _ in range(cases(10, 40)):
        limits = random_limits(rng)
        line = line_of(limits, 2, rng.choice((0, limits.top_speed // 2)))
        hz = max(Fraction(1), Fraction(TICK_HZ, 2000 * limits.top_speed))
        table = core.plan(line, hz, tick_hz=TICK_HZ, pixels=True)
        assert table.warnings == ()
        assert table.columns()[:, 2].tolist() == exact.expected_positions(line), limits
        if line.total_steps < 100_000:
            assert len(core.plan(line, hz, tick_hz=TICK_HZ).columns()) == line.total_steps


def test_the_command_makes_what_line_check_accepts(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rng = random.Random(23)
    for number in range(20):
        limits = random_limits(rng)
        name = f"{number}.PRN"
        made = run(
            "make", "--top-speed", limits.top_speed, "--max-acceleration", limits.max_acceleration,
            "--max-jerk", limits.max_jerk, "-o", name, "--force", "--json",
        )  # fmt: skip
        speeds, notes = formats.read_prn(tmp_path / name)
        assert speeds == json.loads(made)["speeds"] and notes == []
        pixels = 2 * shortest_pixels(limits) + 1
        run(
            "make", "--profile", name, "--speed", limits.top_speed, "--pixels", pixels,
            "--pixel-hz", 30, "--jerk-warn", limits.max_jerk, "-o", "line.csv", "--force",
            group="line",
        )  # fmt: skip
        checked = run(
            "check", "line.csv", "--decode", "smooth", "--max-acceleration",
            limits.max_acceleration, "--jerk-warn", limits.max_jerk, group="line",
        )  # fmt: skip
        assert "fine" in checked


def run(*words, group="profile", status=0):
    done = CliRunner().invoke(main, [group, *map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert done.exit_code == status, done.output
    return done.output


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (Fraction(1001), "nearest legal 1000 steps/px and 1002 steps/px$"),
        (Fraction(3001, 3), "nearest legal 1000 steps/px and 1002 steps/px$"),
        (Fraction(1), "nearest legal 2 steps/px$"),
        (Fraction(0), "nearest legal 2 steps/px$"),
        (Fraction(16_383), "above the largest, nearest legal 16382 steps/px$"),
        (Fraction(32_763, 2), "nearest legal 16380 steps/px and 16382 steps/px$"),
    ],
)
def test_illegal_top_speeds(value, message):
    with pytest.raises(UserError, match=message):
        generator.legal_speed(value)


def test_limits_are_rounded_down_to_even():
    assert generator.legal_limit(Fraction(7), ACCELERATION) == 6
    assert generator.legal_limit(Fraction(17, 2), JERK) == 8
    with pytest.raises(UserError, match=r"below 2.*nearest legal 2"):
        generator.legal_limit(Fraction(19, 10), JERK)


def test_refusals_name_legal_values_per_second_too():
    with pytest.raises(UserError, match=r"= 30000 steps/s and 1002 .* 30060 steps/s$"):
        generator.legal_speed(Fraction(30_010, 30), Fraction(30))
    with pytest.raises(UserError, match="nearest legal 2 steps/px2 = 1800 steps/s2"):
        generator.legal_limit(Fraction(1), ACCELERATION, Fraction(30))


def test_conventional_name_and_si_units(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = run(
        "make", "--top-speed", "30000steps/s", "--max-acceleration", "115200 steps/s2",
        "--max-jerk", 40, "--pixel-hz", 30, "--motor", "M39", "--variant", "2",
    )  # fmt: skip
    speeds, _ = formats.read_prn(tmp_path / "AccProfM39-30Hz-2.PRN")
    assert speeds == shortest_profile(ProfileLimits(1000, 128, 40))
    assert "1000 steps/px = 30000 steps/s" in output and "= 99000 steps/s2" in output


def test_name_in_a_folder(tmp_path):
    common = ("--top-speed", 100, "--max-acceleration", 10, "--max-jerk", 4, "-o", tmp_path)
    text = run("make", *common, status=2)
    assert "needs --motor, --variant, --pixel-hz" in text
    assert "its name cannot be a part of a file's name" in run(
        "make", *common, "--motor", "a/b", "--variant", 1, "--pixel-hz", 30, status=2
    )
    assert list(tmp_path.iterdir()) == []
    run("make", *common, "--motor", "M40", "--variant", 1, "--pixel-hz", "29.97")
    assert [path.name for path in tmp_path.iterdir()] == ["AccProfM40-29.97Hz-1.PRN"]


def test_csv_for_fast_moves_and_homing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    common = (
        "make", "--top-speed", 100, "--max-acceleration", 20, "--max-jerk", 8, "--pixel-hz", 30,
        "-o", "a.PRN", "--csv", "a.csv",
    )  # fmt: skip
    run(*common, "--haps", 3, "--lead-in", 2, "--name", "mine")
    read = formats.read_csv(tmp_path / "a.csv")
    speeds, _ = formats.read_prn(tmp_path / "a.PRN")
    assert list(read.values) == [*generator.acceleration_counts(speeds, 100), 100]
    header = read.header
    assert (header.name, header.haps, header.lead_in_px, header.pixel_hz) == ("mine", 3, 2, "30")
    assert "fine" in run("check", "a.csv", "--max-acceleration", 20, "--max-jerk", 8)
    run(*common, "--decode", "plain", "--force")
    assert list(formats.read_csv(tmp_path / "a.csv").values) == speeds


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--haps", 3], "--haps is for the CSV"),
        (["--csv", "a.csv"], "needs --pixel-hz"),
        (["--csv", "a.csv", "--pixel-hz", 30, "--haps", 99], "--haps 99: the CSV profile has"),
        (["--csv", "a.csv", "--pixel-hz", 30, "--name", "x" * 21], "longer than 20"),
        (["--motor", "M39"], "have no use"),
        (["--max-jerk", "1"], "jerk limit 1 steps/px3 is below 2"),
        (["--max-jerk", "40steps/s3"], "needs --pixel-hz"),
        (["--max-jerk", "40steps/px2"], "expected a number of steps/px3 or steps/s3"),
    ],
)
def test_misuse_is_refused_in_one_line(tmp_path, monkeypatch, more, message):
    monkeypatch.chdir(tmp_path)
    common = ["make", "--top-speed", 100, "--max-acceleration", 20, "--max-jerk", 8, "-o", "a.PRN"]
    output = run(*common, *more, status=2)
    assert message in output
    assert list(tmp_path.iterdir()) == []


def test_line_below_the_top_speed_tells_of_its_jerk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run("make", "--top-speed", 1000, "--max-acceleration", 128, "--max-jerk", 40, "-o", "a.PRN")
    common = ("make", "--profile", "a.PRN", "--pixels", 60, "--pixel-hz", 30, "-o", "l.csv")
    output = run(*common, "--speed", 900, "--jerk-warn", 40, group="line", status=1)
    assert "the acceleration changes by 88, above 40" in output
    assert "pixstep profile make --top-speed 900 --max-jerk 40" in output
    assert (tmp_path / "l.csv").exists()
    again = (*common, "--force")
    assert "warning" not in run(*again, "--speed", 1000, "--jerk-warn", 40, group="line")
