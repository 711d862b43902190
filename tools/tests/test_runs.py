# SPDX-License-Identifier: MIT
"""Runs: shortest encoding, split repeats, the queue entries of a line."""

import random

import pytest

from pixstep.errors import UserError
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.rational import hz_text, parse_hz


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
    ("text", "exact"), [("30", "30/1"), ("29.97", "2997/100"), ("30000/1001", "30000/1001")]
)
def test_frequencies_are_exact(text, exact):
    assert hz_text(parse_hz(text)) == exact


@pytest.mark.parametrize("text", ["0", "-1", "1/0", "abc", "1e3", "", "29,97", "0.000000001"])
def test_bad_frequencies(text):
    if text == "0.000000001":
        assert parse_hz(text)  # 1/10^9 fits 32 bits
        return
    with pytest.raises(UserError, match="pixel frequency"):
        parse_hz(text)
