# SPDX-License-Identifier: MIT
"""The report of a plan: what its time is made of, which moves are slower than programmed."""

import numpy as np
import pytest

from programbench import SHORT_MOVES, path, planned, random_program, setup

NO_LIMIT = 1e9
DWELLING = "INC TS0 TA50 TM200 X100 Y10\nX300\nDWELL70\nTM473 X-500"


@pytest.mark.parametrize("mode", ["lookahead", "mode1"])
def test_a_program_that_nothing_slows_takes_its_moves_its_stops_and_its_dwells(mode):
    report = planned(DWELLING, setup(NO_LIMIT, 2), mode=mode)[1]
    assert report.moves_ms == 200 + 200 + 473
    assert report.stops_ms == 4 * 50 / 2  # two starts, two stops
    assert report.dwells_ms == 70
    assert report.total_ms == pytest.approx(report.programmed_ms) == pytest.approx(1043)
    assert not report.slowed_moves and not report.clipped
    facts = report.as_json()
    assert facts["programmed_ms"] == facts["moves_ms"] + facts["stops_ms"] + facts["dwells_ms"]


def test_a_blend_that_rule_3_shortens_slows_nothing():
    report = planned("INC TS0 TM100 TA50 X1000\nTA300 X3000", setup(NO_LIMIT))[1]
    assert report.clipped == 1 == report.as_json()["clipped_blends"]
    assert [(item["line"], item["asked_ms"], item["why"]) for item in report.slowed] == [
        (2, 100, "acceleration time")
    ]


@pytest.mark.parametrize("mode", ["lookahead", "mode1"])
@pytest.mark.parametrize("seed", range(8))
def test_what_is_told_to_be_slower_is_slower_and_together_it_is_the_difference(seed, mode):
    rng = np.random.default_rng(seed)
    motors = int(rng.integers(1, 4))
    of = setup(10 ** rng.uniform(-2, 0, motors), motors, speed=rng.choice([3.0, NO_LIMIT], motors))
    text, _ = random_program(rng, motors, int(rng.integers(2, 10)))
    report = planned(text, of, mode=mode)[1]
    for item in report.slowed:
        assert f"{item['ms']:.6g}" != f"{item['asked_ms']:.6g}" and item["ms"] > item["asked_ms"]
        assert item["why"] not in ("", "blend clipped")
    slower = sum(item["ms"] - item["asked_ms"] for item in report.slowed)
    assert slower >= 0.9 * (report.total_ms - report.programmed_ms)


def test_a_start_that_takes_longer_than_ta_is_its_moves():
    """TA 1 is 50 for the speed; TM stays, half of the difference is lost at either end."""
    report = planned("INC TS0 TA1 TM100 X5000", setup(1), mode="mode1")[1]
    assert report.total_ms == pytest.approx(150)
    (item,) = report.slowed
    assert (item["asked_ms"], item["ms"]) == (100, pytest.approx(149))
    assert report.total_ms - report.programmed_ms == pytest.approx(49)


def test_the_deviation_from_the_path_is_told():
    report = planned(SHORT_MOVES, setup(1, 2))[1]
    assert 0 < report.off_path <= 0.5
    counts, report = planned("INC TS0 TA9 TM20 X90 Y30\nX20 Y100", setup(0.5, 2, 100, smooth=True))
    assert 0 < report.off_path <= 1 and report.as_json()["off_path_steps"] == report.off_path
    assert counts.sum(axis=0).tolist() == [110, 130]
    assert path("INC TS0 TA9 TM20 X90", setup(1)).du.sum() == 29
