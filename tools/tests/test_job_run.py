# SPDX-License-Identifier: MIT
"""A job is printed: chained without a gap, paused, resumed; the log says what is done."""

import pyarrow.parquet as parquet
import pytest

import runbench
from pixstep import ops
from pixstep.errors import RefusedError
from pixstep.jobs.run_folder import RunFolder


@pytest.fixture
def folder(tmp_path, simulator):
    """Return a folder with a machine and a job of four short lines."""
    del simulator
    runbench.folder_with_job(tmp_path)
    return tmp_path


def kinds(folder):
    """Return what the log has, as kind and line."""
    events = RunFolder.of(folder / "a.pxrun").events()
    return [(one["event"], one.get("line")) for one in events]


def test_a_job_is_printed_and_every_line_is_logged(folder):
    job = runbench.Job.read(folder / "a.pxjob")
    with runbench.bus() as link:
        done = runbench.run(folder, link)
        made = link.simulator.count(0, 0)
        ended = [link.simulator.steps(0, axis) for axis in (0, 2)]
        assert link.board().setting("bus_timeout_ms") == 3000  # put back
    assert (done["state"], done["printed"], done.status) == ("finished", 4, 0)
    steps = sum(job.line(n)["M39"].total_steps for n in range(1, 5))
    assert made == steps
    assert ended == [job.expected(4, "M39")[-1], job.expected(4, "M41")[-1]]
    assert done["rests"] == 0 and 0 < done["reserve_px"] < job.pixels
    (begun, *_) = RunFolder.of(folder / "a.pxrun").events()
    tag = begun["boards"]["main"]["tag"]
    assert tag >= 1000 * 2 * job.pixels / 30 and tag % 1000  # a dead host's boards end two lines
    found = kinds(folder)
    assert found[:4] == [("begin", None), ("chain", 1), ("queued", 1), ("queued", 2)]
    for line in (1, 2, 3, 4):
        assert found.index(("queued", line)) < found.index(("done", line))
    for line in (3, 4):  # one line ahead, no more
        assert found.index(("done", line - 2)) < found.index(("queued", line))
    assert found[-1] == ("finished", 4)


def test_a_pause_ends_the_line_behind_and_resume_goes_on(folder):
    with runbench.bus() as link:
        path = RunFolder(folder / "a.pxrun")
        runbench.Hook(link.simulator, 60, path.ask_pause)
        done = runbench.run(folder, link)
        assert done["state"] == "paused" and 2 <= done["printed"] < 4
        assert not path.pause_asked
        status = ops.job_status(folder / "a.pxrun")
        assert status["state"] == "paused" and status["printed"] == done["printed"]
        with pytest.raises(RefusedError, match="nobody runs it"):
            ops.job_pause(folder / "a.pxrun")
        with pytest.raises(RefusedError, match="has a run already"):
            runbench.run(folder, link)
        done = runbench.resume(folder, link)
        assert (done["state"], done["printed"]) == ("finished", 4)
        job = runbench.Job.read(folder / "a.pxjob")
        steps = sum(job.line(n)["M39"].total_steps for n in range(1, 5))
        assert link.simulator.count(0, 0) == steps
    assert not [one for one in kinds(folder) if one[0] == "moved"]


def test_records_are_kept_a_file_a_line(folder):
    job = runbench.Job.read(folder / "a.pxjob")
    with runbench.bus() as link:
        runbench.run(folder, link, records=True)
    parts = sorted((folder / "a.pxrun/parts").iterdir())
    assert [one.name for one in parts] == [f"line-{n:06}.parquet" for n in (1, 2, 3, 4)]
    for number, path in enumerate(parts, 1):
        rows = parquet.read_table(path).to_pylist()
        assert {row["motor"] for row in rows} == set(job.motors)
        assert len(rows) > job.pixels  # of three motors, as many as were read in time
        for row in rows:
            start = job.runs_of(number)[row["motor"]].start_steps
            at = job.expected(number, row["motor"])[row["pixel"] - 1] - start
            assert row["expected_steps"] == row["actual_steps"] == at


@pytest.mark.parametrize("sync", ["lock", "start"])
def test_on_a_gated_clock_each_line_has_a_burst(tmp_path, simulator, sync):
    del simulator
    text = runbench.jobbench.MACHINE.replace('sync = "lock"', f'sync = "{sync}"\ngate_edges = 8')
    job = runbench.folder_with_job(tmp_path, lines=3, text=text)
    with runbench.bus() as link:
        link.simulator.clock(f"gate {job.pixels + 12} 400000")
        done = runbench.run(tmp_path, link)
        made = link.simulator.count(0, 0)
    assert (done["state"], done["printed"]) == ("finished", 3)
    assert made == sum(job.line(n)["M39"].total_steps for n in (1, 2, 3))
    assert [one for one in kinds(tmp_path) if one[0] == "chain"] == [("chain", 1)]


def test_a_gate_that_others_have_left_on_a_board_is_taken_away(tmp_path, simulator):
    """A board of an earlier machine waits for bursts of its clock, and this clock has none."""
    del simulator
    runbench.folder_with_job(tmp_path)
    with runbench.bus() as link:
        ops.board_set(["gate_edges=90"], link=link)
        assert runbench.run(tmp_path, link)["state"] == "finished"
        assert link.board().setting("gate_edges") == 0
