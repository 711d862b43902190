# SPDX-License-Identifier: MIT
"""Campaigns of jobs that are simulated: a share of each, and that faults at seams are found."""

import contextlib
import multiprocessing
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import pytest

from effort import only_long
from pixstep.jobs.simulated import crews, judge, work
from pixstep_dev.jobs import plant_seam, simulate


class Here:
    """Simulates in this process, so that a test may change what does."""

    width, local = 1, True

    def submit(self, data, edges):
        """Simulate at once."""
        future = Future()
        future.set_result(work.simulate(data, edges))
        return future

    def renew(self):
        """Nobody dies."""

    def look(self, waited_s):
        """Nobody is waited for."""


@pytest.fixture
def here(monkeypatch, simulator):
    """Let blocks be simulated in this process."""
    del simulator
    monkeypatch.setattr(crews, "processes", lambda count: contextlib.nullcontext(Here()))


def test_a_process_that_dies_between_two_blocks_is_told_by_the_next_one():
    with crews.processes(1) as crew:
        broken = crew.submit(b"no block", "")
        assert isinstance(broken.exception(), Exception)
        for process in multiprocessing.active_children():
            process.kill()
        told = broken
        while not isinstance(told.exception(), BrokenProcessPool):
            told = crew.submit(b"no block", "")
        assert isinstance(crew.submit(b"no block", "").exception(), BrokenProcessPool)
        crew.renew()
        assert not isinstance(crew.submit(b"no block", "").exception(), BrokenProcessPool)


@only_long
@pytest.mark.usefixtures("simulator")
def test_the_rows_are_the_same_whoever_dies():
    outcome = simulate.run(simulate.JobSimulatePlan(lines=36, block=6, memory_lines=(100, 400)))
    assert outcome.complaints == []
    assert [one.simulated for one in outcome.passes[:2]] == [6, 6]
    assert len({one.sha256 for one in outcome.passes}) == 1 and len(outcome.passes) == 6
    print(outcome)


@pytest.mark.usefixtures("here")
class TestPlants:
    """Faults at seams."""

    def test_a_wrong_take_up_is_found_at_its_seam(self):
        outcome = plant_seam.run(plant_seam.PlantSeamPlan(times=2, lines=4, firmware=False))
        assert outcome.complaints == []
        for one in outcome.plants:
            assert min(one.in_blocks) == one.line and one.alone == []

    def test_a_lost_part_of_a_tick_is_found_by_blocks_alone(self, tmp_path):
        outcome, job = (
            plant_seam.PlantSeamOutcome(),
            plant_seam.press(tmp_path / "job", 3, "start").job,
        )
        images = {"mega": plant_seam.losing_image(tmp_path)}
        plant_seam.look(outcome, "lost part", 2, job, tmp_path / "sim", Here(), images)
        assert outcome.complaints == []
        assert "ticks" in outcome.plants[0].reason

    def test_a_judge_that_takes_each_play_for_granted_misses_it(self, tmp_path, monkeypatch):
        monkeypatch.setattr(judge, "_positions", lambda *args: None)
        monkeypatch.setattr(judge, "_loads", lambda *args: None)
        right = plant_seam.press(tmp_path / "job", 3, "lock").job
        what = plant_seam.NONE_TAKEN
        job = plant_seam.wrong_take_up(right, 3, what, tmp_path / "planted.pxjob")
        outcome = plant_seam.PlantSeamOutcome()
        plant_seam.look(outcome, what, 3, job, tmp_path / "sim", Here())
        assert outcome.complaints == ["no take-up at line 3: blocks find lines []"]
