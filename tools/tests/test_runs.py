# SPDX-License-Identifier: MIT
"""Runs: shortest encoding, split repeats, the queue entries of a line."""

import random

import pytest

from pixstep.api.given import exact_hz
from pixstep.errors import UserError
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import hz_text, parse_hz


def test_round_trip():
    rng = random.Random(1)
    counts = [rng.choice((0, 5, 5, -3)) for _ in range(500)]
    assert runs.decode(runs.encode(counts)) == counts


def test_long_runs_are_split():
    assert runs.encode([7] * 70_000) == [(7, 65_535), (7, 4_465)]


def test_out_of_range():
    with pytest.raises(UserError, match="40000"):
        runs.encode([40_000])


def test_queue_entries():
    smooth = Line((0, 4, 8, 8, 4, 0), backlash=3)
    assert runs.queue_entries(smooth) == [
        (0x31, 0), (3, 8), (0, 1), (4, 1), (8, 2), (4, 1), (0, 1), (2, 0),
    ]  # fmt: skip
    assert runs.queue_entries(Line((5, -5), PLAIN)) == [
        (0x21, 0), (0, 0), (5, 1), (-5, 1), (2, 0),
    ]  # fmt: skip
    assert runs.queue_entries(Line((4, 4), negative=True))[0] == (0x71, 0)
    assert runs.queue_entries(Line((5, -5), PLAIN), 4)[:4] == [(0x221, 0), (0, 0), (4, 0), (5, 1)]


@pytest.mark.parametrize(
    ("text", "exact"),
    [("30", "30/1"), ("29.97", "2997/100"), ("30000/1001", "30000/1001"), ("1e3", "1000/1")],
)
def test_frequencies_are_exact(text, exact):
    assert hz_text(parse_hz(text)) == exact


@pytest.mark.parametrize("text", ["0", "-1", "1/0", "abc", "1e99", "", "29,97", "0.0000000001"])
def test_bad_frequencies(text):
    with pytest.raises(UserError, match="pixel frequency"):
        parse_hz(text)


def test_a_frequency_may_have_as_many_digits_as_the_board_holds():
    assert parse_hz("0.000000001")  # 1/10^9 fits 32 bits


def test_a_frequency_that_is_none_of_pixels_is_not_called_so(invoke):
    ticks = ("ticks", "line.csv", "--decode", "plain", "--pixel-hz", "30", "-o", "t.csv")
    said = invoke(*ticks, "--timer-hz", "0", status=2).stderr
    assert said.startswith("pixstep: --timer-hz: frequency '0': must be above 0 Hz")


@pytest.mark.parametrize(
    ("text", "near"), [("333.3333333333333", "1000/3"), ("29.97002997002997", "30000/1001")]
)
def test_too_many_digits_are_refused_with_the_fraction_that_is_meant(text, near):
    with pytest.raises(UserError, match=f"needs more than 32 bits: write {near}[?]$"):
        parse_hz(text)
    with pytest.raises(UserError, match=f"write {near}[?]$"):
        exact_hz(float(text))
    assert parse_hz(near)
