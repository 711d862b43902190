# SPDX-License-Identifier: MIT
"""Lines made by a speed and an acceleration: clock edges of a pixel, exact lengths, refusals."""

import json
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import pytest

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines import line_check, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import ACCELERATION, JERK, SPEED
from pixstep.profiles import accelerate
from pixstep.profiles.generator import LineRequest

HZ = Fraction(1000)


def wanted(speed="40000steps/s", acceleration="200000steps/s2", jerk=None, **more):
    return accelerate.WantedLine(
        units.parse(speed, SPEED),
        units.parse(acceleration, ACCELERATION),
        jerk and units.parse(jerk, JERK),
        more.pop("clock_hz", HZ),
        **more,
    )


@pytest.mark.parametrize(
    ("acceleration", "edges"),
    [("2000000steps/s2", 1), ("1999999steps/s2", 2), ("500000steps/s2", 2), ("200000steps/s2", 4),
     ("125000steps/s2", 4), ("124999steps/s2", 5), ("1954steps/s2", 32), ("1953steps/s2", 33),
     ("2steps/px2", 1)],
)  # fmt: skip
def test_the_fewest_clock_edges_that_allow_an_acceleration(acceleration, edges):
    """The even rule: no less than 2 f^2."""
    assert accelerate.choose_divider(wanted("2000steps/s", acceleration)) == edges


def test_a_jerk_and_a_speed_ask_for_more_edges():
    assert accelerate.choose_divider(wanted(jerk="2000000000steps/s3")) == 4
    assert accelerate.choose_divider(wanted(jerk="1000000steps/s3")) == 13
    # 12.5 steps per clock edge: even in pixels of 4, 8, 12.
    assert accelerate.choose_divider(wanted("12500steps/s", "100000steps/s2")) == 8
    assert accelerate.choose_divider(wanted(plain=True)) == 3


@pytest.mark.parametrize(
    ("speed", "acceleration", "says"),
    [("40000steps/s", "1steps/s2", "no pixel of 1 to 1000 edges"),
     ("40000steps/s", "0", "above 0"),
     ("1.23456789steps/s", "200000steps/s2", "has them in even steps per pixel")],
)  # fmt: skip
def test_what_no_divider_allows(speed, acceleration, says):
    with pytest.raises(UserError, match=says):
        accelerate.choose_divider(wanted(speed, acceleration))


def test_a_jerk_that_no_divider_allows_is_named():
    with pytest.raises(UserError, match="jerk 0: above 0 is expected"):
        accelerate.choose_divider(wanted(jerk="0"))
    with pytest.raises(UserError, match="jerk 1steps/s3 and speed 40000steps/s: no pixel"):
        accelerate.choose_divider(wanted(jerk="1steps/s3"))


def test_little_of_the_acceleration_is_said():
    text = accelerate.note(wanted(), 4)
    assert text == "uses 62.5 % of the acceleration 200000steps/s2: divider 9 uses more"
    assert accelerate.note(wanted(), 10) == ""


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("backlash", [0, 6])
@pytest.mark.parametrize("steps", [500, 1000, 8000, 8002, 12_346, 100_000])
def test_a_line_has_exactly_its_length(plain, backlash, steps):
    if plain and backlash:
        return
    request = LineRequest(0, 0, backlash, 2, plain)
    what = wanted(plain=plain)
    made, speed = accelerate.line_of_length(what, 160, 4, steps, request)
    assert sum(made.counts) == steps and max(made.counts) <= speed <= 160
    line = Line(tuple(made.counts), PLAIN if plain else SMOOTH, backlash)
    most = what.limit(what.acceleration, 4)
    found = line_check.check(line, line_check.Limits(max_speed=160))
    assert not line_check.refused(found), found
    ends = line.counts if plain else line.speeds
    assert max(abs(after - before) for before, after in pairwise((0, *ends, 0))) <= most
    lead = made.counts[made.image_pixel - 3 : made.image_pixel]
    assert lead == [speed] * 3  # two pixels of the lead-in, one of the image


@pytest.mark.parametrize(
    ("steps", "jerk", "says"),
    [(8001, None, "nearest 8000 and 8002"), (4, None, "too short for a line, at least"),
     (8002, "4000000000steps/s3", "nearest [0-9]+ and [0-9]+")],
)  # fmt: skip
def test_lengths_that_cannot_be(steps, jerk, says):
    with pytest.raises(UserError, match=says):
        accelerate.line_of_length(wanted(jerk=jerk), 160, 4, steps, LineRequest(0, 0, 0, 2))


MAKE = ("line", "make", "--clock-hz", "1000", "-o", "l.csv", "--speed", "40000steps/s")
BY_ACCELERATION = (*MAKE, "--max-acceleration", "200000steps/s2")


def test_the_file_has_the_frequency_of_its_pixels(tmp_path, invoke):
    made = json.loads(invoke(*BY_ACCELERATION, "--pixels", "210", "--json").stdout)
    assert (made["divider"], made["pixel_hz"], made["pixels"]) == (4, "250/1", 210)
    assert formats.read_motion(Path("l.csv")).header.frequency == 250
    said = invoke(*BY_ACCELERATION, "--pixels", "210", "--divider", "3", "--force", status=2).stderr
    assert "is below 2" in said  # 1.8 steps/px2
    assert said.endswith("; --divider 4 has pixels that allow it\n")
    invoke(*MAKE, "--max-acceleration", "400000steps/s2", "--pixels", "300", "--force")
    assert formats.read_motion(Path("l.csv")).header.frequency == Fraction("333.3333333")
    check = ("line", "check", "l.csv", "--decode", "smooth", "--clock-hz", "1000")
    assert "made for" not in invoke(*check, "--divider", "3").stderr
    assert "--divider 3, not 2" in invoke(*check, "--divider", "2", status=3).stderr


@pytest.mark.parametrize(
    ("more", "says"),
    [((), "a line needs --profile or --max-acceleration"),
     (("--profile", "p.PRN", "--max-acceleration", "9"), "made by one of them"),
     (("--max-acceleration", "200000steps/s2"), "a line needs --pixels or --length"),
     (("--max-acceleration", "9", "--pixels", "9", "--length", "9"), "a line has one of them"),
     (("--profile", "p.PRN", "--length", "9"), "--length: only with --max-acceleration"),
     (("--profile", "p.PRN", "--pixels", "9", "--max-jerk", "9"), "--max-jerk: only with"),
     (("--max-acceleration", "9", "--pixels", "9", "--divider", "0"), "1<=x<=1000")],
)  # fmt: skip
def test_options_that_do_not_go_together(tmp_path, invoke, more, says):
    Path("p.PRN").write_bytes(b"       8\r\n      16\r\n")
    said = invoke(*MAKE, *more, status=2).stderr
    assert says in said and not Path("l.csv").exists()


@pytest.mark.parametrize("name", ["a\nb", " blank", "m\xfcller", "x" * 21])
def test_a_header_that_cannot_be_is_misuse(tmp_path, invoke, name):
    more = ("--pixels", "210", "--header", name)
    assert not Path("l.csv").exists() and invoke(*BY_ACCELERATION, *more, status=2).stderr


def test_what_turns_a_smooth_line_round_is_said(tmp_path, invoke):
    said = invoke(*BY_ACCELERATION, "--pixels", "210", "--negative").stderr
    assert "note: counts of a smooth line have no sign: --negative for `sim` and `board up" in said
    assert "-" not in Path("l.csv").read_text()


TURN = ("line", "make", "--decode", "plain", "--pixel-hz", 100, "--speed", 40, "--turn")


def test_a_line_that_turns(pixstep, invoke, tmp_path):
    words = (*TURN, "--max-acceleration", 10, "-o", "a.csv", "--force", "--json")
    data = json.loads(invoke(*words, "--pixels", 41).stdout)
    counts = formats.read_csv(tmp_path / "a.csv").values
    assert len(counts) == 41 == data["pixels"] and sum(counts) == 0
    assert counts[:4] == (10, 20, 30, 40) and counts[20] == 0
    assert counts[:20] == tuple(-count for count in counts[:20:-1])
    assert data["steps"] == 2 * sum(counts[:20])
    pixstep(*words, "--pixels", 42)
    assert formats.read_csv(tmp_path / "a.csv").values[20:22] == (0, 0)
    pixstep(*words, "--length", 1000)
    counts = formats.read_csv(tmp_path / "a.csv").values
    assert sum(count for count in counts if count > 0) == 1000 and sum(counts) == 0


def test_advice_and_refusals_of_a_line_that_turns(pixstep, tmp_path):
    """Equal accelerations from the first pixel on: a slower first pixel would be better."""
    told = pixstep(*TURN, "--max-acceleration", 10, "--pixels", 41, "-o", "a.csv")
    assert "its first pixel accelerates by 10 steps/px2, as hard as any other" in told
    formats.write_prn(tmp_path / "slow.PRN", [3, 10, 25, 40])
    told = pixstep(*TURN, "--profile", "slow.PRN", "--pixels", 41, "-o", "b.csv")
    assert "first pixel accelerates" not in told
    smooth = [word if word != "plain" else "smooth" for word in TURN]
    told = pixstep(*smooth, "--max-acceleration", 10, "--pixels", 41, "-o", "c.csv", status=2)
    assert "--turn: only a plain line turns" in told
    told = pixstep(*TURN, "--max-acceleration", 10, "--pixels", 2, "-o", "c.csv", status=2)
    assert "--turn: --pixels 3 at least" in told


def test_a_plain_line_without_a_ramp_is_constant(pixstep, tmp_path):
    words = ("line", "make", "--speed", 200, "--pixel-hz", 30, "--machine", "none")
    told = pixstep(*words, "--decode", "plain", "--pixels", 50, "-o", "a.csv")
    assert "50 pixels, 0 accelerating, image from pixel 1, 10000 steps" in told
    assert list(formats.read_csv(tmp_path / "a.csv").values) == [200] * 50
    for more, why in (
        (("--pixels", 50), "a line needs --profile or --max-acceleration"),
        (("--decode", "plain", "--length", 500), "--length, --max-jerk: only with"),
        (("--decode", "plain", "--pixels", 5, "--lead-in", 5), "need at least 6"),
    ):
        assert why in pixstep(*words, *more, "-o", "b.csv", status=2)


def test_a_file_of_many_lines(pixstep, tmp_path):
    words = ("line", "make", "--decode", "smooth", "--pixel-hz", 100, "--speed", 40,
             "--max-acceleration", 10, "--pixels", 20, "--backlash", 8)  # fmt: skip
    pixstep(*words, "-o", "one.csv")
    pixstep(*words, "--lines", 3, "-o", "many.csv")
    one, many = (formats.read_motion(tmp_path / name) for name in ("one.csv", "many.csv"))
    assert [block.values for block in many.blocks] == [one.values] * 3
    assert many.header.lines == 3 and many.header.backlash == 8 and many.header.name == "many"
    told = pixstep("line", "check", "many.csv", "--decode", "smooth", "--line", 2)
    assert "many.csv: fine" in told
    assert "x<=99999" in pixstep(*words, "--lines", 100_000, "-o", "x.csv", status=2)
