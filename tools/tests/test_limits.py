# SPDX-License-Identifier: MIT
"""`pixstep limits`: its rules are those of the board, its measured rates those of TIMING.md."""

import json
import re
from fractions import Fraction

import pytest

from pixstep import natives
from pixstep.board import boards, capability
from pixstep.errors import UserError
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import period_ticks

_ROW = re.compile(r"\| (\w+) \| (\d) \| (constant|smooth|ramp) ?[a-z ]*\| (\d+) \| (\d+) \|")


def limits(pixstep, *words) -> dict:
    return json.loads(pixstep("limits", *words, "--json"))


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
@pytest.mark.parametrize("hz", [Fraction(30), Fraction(10013, 100), Fraction(5000)])
def test_the_highest_speeds_are_accepted_and_the_next_ones_are_not(board, hz):
    able = capability.of(board, hz)
    period = period_ticks(hz, able.board.tick_hz)
    for kind, step in ((PLAIN, 1), (SMOOTH, 2)):
        bounds = line_check.Limits(
            min_interval_ticks=able.interval_ticks(kind), period_ticks=Fraction(int(period))
        )
        top = able.top_speed(kind)
        for speed, refused in ((top, False), (top + step, True)):
            counts = (speed // 2, speed, speed // 2) if kind == SMOOTH else (speed,)
            found = line_check.check(Line(counts, kind), bounds)
            assert line_check.refused(found) is refused, (kind, speed)


def test_reversals_as_the_firmware_counts_them():
    mega, uno = (capability.of(name, Fraction(10013, 100)) for name in ("mega", "uno"))
    assert (mega.reversal_ticks, uno.reversal_ticks) == (6240, 2240)
    assert mega.direct_reversal_speed == 25 and mega.rest_px == 1
    fast = capability.of("mega", Fraction(15000))
    assert fast.direct_reversal_speed == 0 and fast.rest_px == 6
    assert capability.of("mega", Fraction(30), 100).reversal_ticks == 2 * (1600 + 2800)


def test_least_figures_follow_from_even_speeds(pixstep):
    told = limits(pixstep, "--board", "mega", "--axes", "2", "--pixel-hz", "200")
    rows = {row["kind"]: row for row in told["lines"]}
    assert rows["smooth"]["least_acceleration_steps_s2"] == 2 * 200**2
    assert rows["plain"]["least_acceleration_steps_s2"] == 200**2
    assert rows["smooth"]["least_speed_steps_s"] == 400
    assert (told["schema"], told["axes"], told["machine"]) == (1, 2, None)
    assert told["pixel_hz_most"] == 15625


def test_the_shortest_line_keeps_the_limits(pixstep):
    words = ("--board", "mega", "--pixel-hz", "30", "--max-speed", "3000steps/s")
    told = limits(pixstep, *words, "--max-acceleration", "20", "--max-jerk", "8")["shortest_line"]
    assert told["speed_steps_px"] == 100 and told["pixels"] == 2 * told["accelerating_px"] + 1
    assert told["accelerating_px"] == 7
    alone = limits(pixstep, "--board", "uno", "--pixel-hz", "30")["shortest_line"]
    assert (alone["pixels"], alone["pixels_with_backlash"]) == (3, 5)


def test_misuse_is_one_line(invoke):
    words = ("limits", "--pixel-hz", "30", "--board", "mega")
    assert "mega has 4 axes: 0 to 3" in invoke(*words, "--axes", "5", status=2).stderr
    far = invoke("limits", "--board", "uno", "--pixel-hz", "20kHz", status=2).stderr
    assert "the period must be 1024 to 16777215 ticks" in far
    with pytest.raises(UserError, match="unknown board"):
        capability.of("due", Fraction(30))


@pytest.mark.parametrize(
    ("hz", "seen"), [("20Hz", [30, 100]), ("100.13Hz", [100, 200]), ("1.5kHz", [1000, 2000])]
)
def test_the_page_fits_a_terminal(pixstep, hz, seen):
    page = pixstep("limits", "--board", "mega", "--pixel-hz", hz, "--driver-us", "0.1ms")
    assert "2 f^2" in page and "drivers of 100 us" in page
    assert [int(found) for found in re.findall(r"seen, (\d+) Hz", page)] == seen
    assert all(len(line) <= 80 for line in page.splitlines() if "│" in line or "──" in line)


def test_measured_rates_are_those_of_the_table():
    """A rate may be lower than its table's, which is as old as its last bench, but not by much."""
    text = (natives.root() / "docs" / "TIMING.md").read_text(encoding="utf-8")
    part = text[text.index("### Highest clean rate") :]
    table = {row[:4]: int(row[4]) for row in _ROW.findall(part[: part.index("\n### ", 5)])}
    ours = {
        (row.board, str(row.axes), row.motion, str(row.pixel_hz)): row.steps_s
        for row in capability.all_measured()
    }
    assert ours.keys() == table.keys() and len(ours) == 126
    for key, rate in ours.items():
        assert 0.94 * table[key] <= rate <= table[key], key
