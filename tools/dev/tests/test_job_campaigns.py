# SPDX-License-Identifier: MIT
"""Campaigns of print jobs: a share of each, and that they find what they look for."""

from dataclasses import replace

import pytest

from pixstep.jobs import comparison, resuming, runner, shapes
from pixstep.jobs.comparison import Rule
from pixstep.jobs.resuming import Fate, LineInFlight
from pixstep_dev.jobs import compare, disagree, kill, late, machine_changes, power, seams


@pytest.mark.usefixtures("simulator")
class TestCampaigns:
    """On simulated boards."""

    def test_a_killed_host_loses_no_line(self):
        outcome = kill.run(kill.KillPlan(times=2, lines=4, seed=5))
        assert outcome.complaints == [] and outcome.killed == 2

    def test_a_late_line_is_never_silent(self):
        outcome = late.run(late.LatePlan(times=5, lines=3, seed=2))
        assert outcome.complaints == [] and sum(outcome.ends.values()) == 5
        assert outcome.ends["named fault"] and outcome.ends["in time"]

    def test_a_lost_board_is_named_and_homed(self):
        outcome = power.run(power.PowerPlan(times=1, lines=3))
        assert outcome.complaints == [] and 0 < outcome.slowest_s <= 1
        assert 1 <= outcome.most_unknown <= 2 and outcome.chains == 2

    @pytest.mark.parametrize(
        ("sync", "jitter_us", "apart_ticks"), [("lock", 0, 1), ("lock", 5, 2), ("start", 5, 0)]
    )
    def test_no_seam_shows(self, sync, jitter_us, apart_ticks):
        outcome = seams.run(seams.SeamsPlan(lines=4, jitter_us=jitter_us, sync=sync))
        assert outcome.complaints == [] and outcome.gap_px == 0
        assert outcome.load_pixels == 84 and outcome.load_steps == 0
        assert outcome.apart_ticks <= apart_ticks

    def test_boards_that_disagree_move_nothing(self):
        outcome = disagree.run(disagree.DisagreePlan(times=2, lines=5, seed=3))
        assert outcome.complaints == [] and outcome.chains == 4
        assert (outcome.together, outcome.homed) == (1, 1)

    def test_the_disagreements_find_a_resume_that_believes_one_board(self, monkeypatch):
        def believes(job, told, stations):
            found = judge(job, told, stations)
            return resuming.ResumeVerdict([replace(one, trusted=True) for one in found.boards])

        judge = resuming.judge
        monkeypatch.setattr(resuming, "judge", believes)
        outcome = disagree.run(disagree.DisagreePlan(times=1, lines=5, seed=3))
        assert any("something moved" in text for text in outcome.complaints)

    def test_a_machine_that_has_changed_is_as_the_model_says(self):
        outcome = compare.run(compare.JobComparePlan(pairs=25))
        assert outcome.complaints == [] and (outcome.pairs + outcome.refused) == 25
        assert outcome.alone == len(machine_changes.CHANGES) and outcome.edges == compare.EDGES

    def test_the_comparisons_find_rules_that_are_others(self, monkeypatch):
        monkeypatch.setitem(
            comparison.RULES, ("clock", "pixel"), Rule(comparison.AMBER, "x", key=True)
        )
        monkeypatch.setitem(comparison.RULES, ("motors", "*", "axis"), Rule(comparison.RED, "x"))
        outcome = compare.run(compare.JobComparePlan(pairs=0))
        named = {text.partition(":")[0] for text in outcome.complaints}
        assert named == {"pixel clock", "axis"}

    def test_the_comparisons_find_play_that_is_the_machines(self, monkeypatch):
        line = shapes.Shape.line

        def of_machine(shape, **more):
            found = line(shape, **more)
            return replace(found, backlash=100) if found.backlash else found

        monkeypatch.setattr(shapes.Shape, "line", of_machine)
        outcome = compare.run(compare.JobComparePlan(pairs=0))
        assert any("in all, not 17086" in text for text in outcome.complaints)

    def test_the_kills_find_a_resume_that_guesses(self, monkeypatch):
        def guesses(job, number, found):
            return LineInFlight(number, Fate.LEFT, "not printed")

        monkeypatch.setattr(resuming, "_line", guesses)
        outcome = kill.run(kill.KillPlan(times=4, lines=4, seed=7))
        assert any("not listed: printed 2 times" in text for text in outcome.complaints)

    def test_the_late_lines_find_a_runner_that_looks_away(self, monkeypatch):
        monkeypatch.setattr(runner.Chain, "_require_one_line", looks_away)
        outcome = late.run(late.LatePlan(times=5, lines=3, seed=2))
        assert outcome.complaints


def looks_away(chain, stations):
    """Take the first axis for all."""
    axis = stations[0].axes()[0]
    return chain.first + axis.counted - 1
