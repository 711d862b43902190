# SPDX-License-Identifier: MIT
"""Campaigns of print jobs: a share of each, and that they find what they look for."""

import pytest

from pixstep.jobs import resuming, runner
from pixstep.jobs.resuming import Fate, Line
from pixstep_dev.jobs import kill, late, power, seams


@pytest.mark.usefixtures("simulator")
class TestCampaigns:
    """On simulated boards."""

    def test_a_killed_host_loses_no_line(self):
        outcome = kill.run(kill.Plan(times=2, lines=4, seed=5))
        assert outcome.complaints == [] and outcome.killed == 2

    def test_a_late_line_is_never_silent(self):
        outcome = late.run(late.Plan(times=5, lines=3, seed=2))
        assert outcome.complaints == [] and sum(outcome.ends.values()) == 5
        assert outcome.ends["named fault"] and outcome.ends["in time"]

    def test_a_lost_board_is_named_and_homed(self):
        outcome = power.run(power.Plan(times=1, lines=3))
        assert outcome.complaints == [] and 0 < outcome.slowest_s <= 1
        assert 1 <= outcome.most_unknown <= 2 and outcome.chains == 2

    @pytest.mark.parametrize(
        ("sync", "jitter_us", "apart_ticks"), [("lock", 0, 1), ("lock", 5, 2), ("start", 5, 0)]
    )
    def test_no_seam_shows(self, sync, jitter_us, apart_ticks):
        outcome = seams.run(seams.Plan(lines=4, jitter_us=jitter_us, sync=sync))
        assert outcome.complaints == [] and outcome.gap_px == 0
        assert outcome.load_pixels == 84 and outcome.load_steps == 0
        assert outcome.apart_ticks <= apart_ticks

    def test_the_kills_find_a_resume_that_guesses(self, monkeypatch):
        def guesses(job, number, found):
            return Line(number, Fate.LEFT, "not printed")

        monkeypatch.setattr(resuming, "_line", guesses)
        outcome = kill.run(kill.Plan(times=4, lines=4, seed=7))
        assert any("not listed: printed 2 times" in text for text in outcome.complaints)

    def test_the_late_lines_find_a_runner_that_looks_away(self, monkeypatch):
        monkeypatch.setattr(runner.Chain, "_require_one_line", looks_away)
        outcome = late.run(late.Plan(times=5, lines=3, seed=2))
        assert outcome.complaints


def looks_away(chain, stations):
    """Take the first axis for all."""
    axis = stations[0].axes()[0]
    return chain.first + axis.counted - 1
