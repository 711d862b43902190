# SPDX-License-Identifier: MIT
"""Lines that run together are refused by name and pixel if a board may not have the time."""

import json
import re
import time
from fractions import Fraction
from itertools import pairwise

import pytest

from pixstep.board import boards, capability, guarantee
from pixstep.errors import RefusedError
from pixstep.lines.line import PLAIN, SMOOTH, Line


def ramps(steps, backlash=7, held=60):
    """Return a line with backlash up to so many steps a pixel by two in each."""
    speeds = [*range(0, steps, 2), *[steps] * held, *range(steps, -1, -2)]
    counts = tuple((a + b) // 2 for a, b in pairwise(speeds))
    return Line((0, *counts), SMOOTH, backlash=backlash, name="ramps")


def world(board, hz, sync=1):
    return guarantee.LineConditions(board, Fraction(hz), sync)


def test_slow_lines_are_followed():
    assert guarantee.refusal([ramps(14)] * 4, world("mega", 100, 2)) == ""


def test_a_refusal_names_the_line_its_pixel_and_what_fits():
    lines = [ramps(14)] * 4
    text = guarantee.refusal(lines, world("mega", 2500))
    found = re.fullmatch(
        r"ramps: beyond_guarantee at pixel (\d+): the Arduino Mega 2560 may be too late with this "
        r"line of 4 together at 2500 Hz; it follows (\S+) Hz with these counts.*",
        text,
    )
    assert found, text
    assert 1 <= int(found[1]) <= 80
    slower = guarantee.LineConditions("mega", Fraction(found[2]) * Fraction(99, 100))
    assert guarantee.follows(lines, slower)
    with pytest.raises(RefusedError, match="beyond_guarantee"):
        guarantee.refuse(lines, world("mega", 2500))


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
@pytest.mark.parametrize("motion", guarantee.MOTIONS)
@pytest.mark.parametrize("hz", [30, 200, 1000])
def test_a_rate_is_followed_and_no_constant_line_beyond_it(board, motion, hz):
    axes, here = boards.load(board).axes, world(board, hz)
    able = capability.of(board, Fraction(hz), axes=axes)
    most = able.top_speed("plain" if motion == "constant" else "smooth")
    steps = guarantee.rate(motion, axes, here, most)
    assert 0 < steps <= most or motion == "smooth"
    if steps:
        assert guarantee.follows([guarantee.line_at(motion, steps, here.pixel_hz)] * axes, here)
    beyond = steps + 2 + steps // 16
    if beyond <= most and motion == "constant":
        line = guarantee.line_at(motion, beyond, here.pixel_hz)
        assert not guarantee.follows([line] * axes, here)


def test_a_million_pixels_of_four_axes_take_seconds():
    line = Line((20,) * 1_000_000, PLAIN)
    started_s = time.process_time()
    assert guarantee.follows([line] * 4, world("mega", 500))
    assert time.process_time() - started_s < 5


def written(path, line):
    """Write the line as a file; return its path as a text."""
    path.write_bytes(b"".join(f"{count:6d}\r\n".encode() for count in line.counts))
    return str(path)


def test_limits_and_line_check_agree(pixstep, tmp_path):
    told = json.loads(pixstep("limits", "--board", "mega", "--pixel-hz", "1000", "--json"))
    row = next(one for one in told["guaranteed"] if one["motion"] == "constant")
    assert row["max_rate_steps_s"] == 1000 * row["max_speed_steps_px"]
    words = ("--decode", "plain", "--board", "mega", "--pixel-hz", "1000")
    steps = row["max_speed_steps_px"]
    for count, status in ((steps, 0), (steps + 2 + steps // 16, 3)):
        line = Line((count,) * 48, PLAIN)
        files = [written(tmp_path / f"{name}.csv", line) for name in "abcd"]
        checked = pixstep("line", "check", *files, *words, "--json", status=status)
        first = json.loads(checked)
        lines = [first, *first["beside"]]
        names = [one["name"] for each in lines for one in each["findings"]]
        assert names == ([] if status == 0 else [guarantee.NAME])
        out = str(tmp_path / "run")
        run = pixstep("sim", *files, *words, "--out", out, status=status)
        assert (guarantee.NAME in run) == (status == 3)


def test_of_pixels_of_several_edges_nothing_is_promised(pixstep):
    words = ("limits", "--board", "mega", "--clock-hz", "400", "--divider", "4")
    assert json.loads(pixstep(*words, "--json"))["guaranteed"] == []
    text = pixstep(*words)
    assert "Guaranteed: nothing" in text and "seen at 30 Hz" in text


def test_beyond_says_so(pixstep, tmp_path):
    file = written(tmp_path / "a.csv", ramps(14))
    words = ("--decode", "smooth", "--backlash", "7", "--board", "mega", "--pixel-hz", "2500")
    told = json.loads(
        pixstep("line", "check", file, "--axes", "4", "--beyond", *words, "--json", status=1)
    )
    assert told["verdict"] == "warnings"
    assert [one["name"] for one in told["findings"]] == [guarantee.NAME]
