# SPDX-License-Identifier: MIT
"""A job is simulated as a whole: rows, edges, what is known from before, what is refused."""

import json
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pyarrow.parquet as parquet
import pytest

import jobbench
import runbench
from pixstep import natives, ops
from pixstep.errors import UserError
from pixstep.jobs.job import Job, id_of
from pixstep.jobs.shapes import Shape
from pixstep.jobs.simulated import cuts, work
from pixstep.jobs.simulated.cuts import Cutter, SimulatedWorld
from pixstep.jobs.simulated.judge import _Part, _turns
from pixstep.jobs.simulated.rows import Edges
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.simulation import verdict
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import AxisEdges
from pixstep.simulation.pixel_clock import ClockFlaws

TOOLS = {"pixstep": "1"}


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Return a folder with a job of five lines, simulated in blocks of two, and the result."""
    folder = tmp_path_factory.mktemp("job")
    runbench.folder_with_job(folder, lines=5)
    return folder, simulate(folder)


def simulate(folder, **more):
    """Simulate the job of a folder."""
    return ops.job_simulate(
        folder / "a.pxjob", **{"out": folder / "print.pxsim", "block": 2, "processes": 1, **more}
    )


def keys(job, **world):
    """Return the keys of a job's blocks."""
    return [cut.key for cut in Cutter(job, SimulatedWorld(lines=2, **world), TOOLS).cuts()]


def with_machine(job, text):
    """Return a job with another copy of the machine file."""
    return Job(job.header, {**job.copies, "machine.toml": text}, job.runs, job.shapes)


@pytest.mark.usefixtures("simulator")
class TestSimulated:
    """On simulated boards."""

    def test_every_motor_and_line_has_a_row(self, simulated):
        folder, done = simulated
        job = Job.read(folder / "a.pxjob")
        assert (done["verdict"], done["failed"], done.status) == ("pass", 0, 0)
        assert (done["blocks"], done["simulated"], done["known"]) == (3, done["different"], 0)
        found = parquet.read_table(done["lines_file"]).to_pylist()
        assert [(row["line"], row["motor"]) for row in found] == [
            (line, motor) for line in range(1, 6) for motor in job.motors
        ]
        for row in found:
            assert row["steps"] == job.line(row["line"])[row["motor"]].total_steps
            assert row["off_steps"] == 0 and row["reason"] == ""
        assert sum(row["steps"] for row in found) == done["steps"]
        scan = [row for row in found if row["motor"] == "M39"]
        assert [row["late_ticks"] for row in scan] == [0] * 5
        assert max(abs(row["load_error_steps"]) for row in scan) <= 1

    def test_edges_are_those_of_the_rows(self, simulated):
        _, done = simulated
        for row in parquet.read_table(done["lines_file"]).to_pylist():
            mine = [("line", "==", row["in_block"]), ("motor", "==", row["motor"])]
            table = parquet.read_table(row["edges"], filters=mine)
            cycles, signs = (table.column(name).to_numpy() for name in ("cycle", "direction"))
            assert Edges(1, row["motor"], cycles, signs).sum() == row["sha256"]
            assert len(cycles) == row["steps"] and np.all(np.diff(cycles) > 0)

    def test_the_document_reads_them(self, simulated, monkeypatch, capsys):
        folder, _ = simulated
        monkeypatch.chdir(folder)
        text = (natives.root() / "docs/JOBS.md").read_text(encoding="utf-8")
        (code,) = re.findall(r"```py\n(.*?)```", text, re.DOTALL)
        exec(compile(code, "JOBS.md", "exec"), {})
        verdict, made, listed = capsys.readouterr().out.split()
        assert verdict == "pass" and made == listed

    def test_what_is_finished_is_not_simulated_again(self, simulated):
        folder, done = simulated
        again = simulate(folder)
        assert (again["simulated"], again["known"]) == (0, done["different"])
        assert again["sha256"] == done["sha256"]
        about = json.loads((folder / "print.pxsim/simulation.json").read_text())
        assert about["verdict"] == "pass" and about["tools"]["pixstep-sim"]

    def test_a_block_without_its_rows_or_edges_is_simulated_again(self, simulated):
        folder, done = simulated
        first, second, third = sorted((folder / "print.pxsim/blocks").iterdir())
        first.write_bytes(b"nonsense")
        edges = folder / "print.pxsim/edges"
        (edges / second.name).unlink()
        whole = (edges / third.name).read_bytes()
        (edges / third.name).write_bytes(whole[: len(whole) // 2])
        again = simulate(folder)
        assert again["simulated"] == 3 and again["sha256"] == done["sha256"]
        assert (edges / third.name).read_bytes() == whole

    def test_a_block_simulated_twice_has_the_same_edges(self, simulated, tmp_path):
        folder, _ = simulated
        job = Job.read(folder / "a.pxjob")
        world = SimulatedWorld(lines=2)
        found = cuts.tools_of(job, world)
        cut = [*Cutter(job, world, found).cuts()][1]
        answer = work.simulate(cuts.pack(job, cut, world, found), str(tmp_path))
        assert answer.refused == ""
        mine, theirs = tmp_path / f"{cut.key}.parquet", folder / "print.pxsim/edges"
        assert parquet.read_table(mine).equals(parquet.read_table(theirs / mine.name))

    def test_other_tools_are_refused(self, simulated, tmp_path):
        job = Job.read(simulated[0] / "a.pxjob")
        world = SimulatedWorld()
        other = {**cuts.tools_of(job, world), "pixstep-sim": "another one"}
        cut = next(Cutter(job, world, other).cuts())
        answer = work.simulate(cuts.pack(job, cut, world, other), str(tmp_path))
        assert f"{cuts.host()} has pixstep-sim " in answer.refused
        assert "instead of another one" in answer.refused and [*tmp_path.iterdir()] == []


class TestChained:
    """A chained line begins a part of a tick after a whole one."""

    LINE = Line((0, 3, *[5] * 12, 2, 0), "plain")
    PERIOD = Fraction(16_000_000, 110)  # and 6/11 of a tick

    def edges(self, phase):
        """Return the steps of a line on the exact grid."""
        whole = [
            when.later(phase).floor() for _, when in exact.exact_instants(self.LINE, self.PERIOD)
        ]
        cycles = np.array(whole, dtype=np.int64) + 1000
        levels = np.tile([1, 0], len(cycles))
        return AxisEdges(np.stack([cycles, cycles + 50], axis=1).reshape(-1), levels)

    @pytest.mark.parametrize("phase", [Fraction(k, 11) for k in range(11)])
    def test_it_is_right_with_its_part_of_a_tick(self, phase):
        found = verdict.judge_axis(
            self.LINE, self.PERIOD, self.edges(phase), tick_hz=16_000_000, phase=phase
        )
        assert found.reasons == [] and found.line_zero_cycle == 1000

    def test_it_is_wrong_without(self):
        edges = self.edges(Fraction(10, 11))
        found = verdict.judge_axis(self.LINE, self.PERIOD, edges, tick_hz=16_000_000)
        assert any("not on the pixel edge" in reason for reason in found.reasons)

    @pytest.mark.parametrize(("hold", "right"), [(400, True), (100, False)])
    def test_a_turn_at_a_seam_keeps_the_hold_time(self, hold, right):
        cycles, levels = np.array([1000, 1050, 9000, 9050]), np.array([1, 0, 1, 0])
        lines = [
            AxisEdges(cycles[:2], levels[:2]),
            AxisEdges(cycles[2:], levels[2:], np.array([1000 + hold]), np.array([1])),
        ]
        of = LineExperiment("mega", {}, Fraction(110))
        parts = [_Part(k, "M39", self.LINE, edges, of, 0, False) for k, edges in enumerate(lines)]
        _turns(parts)
        assert [part.reasons == [] for part in parts] == [True, right]


class TestKeys:
    """Keys of blocks, for which nothing is simulated."""

    def test_equal_blocks_have_one_key(self, tmp_path):
        job = runbench.folder_with_job(tmp_path, lines=9)
        found = keys(job)
        # The first has no line before it; the last is shorter, and so is the line in it.
        assert len(found) == 5 and len({*found[1:4]}) == 1 and len({*found}) == 3

    def test_a_changed_line_changes_its_block_and_the_next_one(self, tmp_path):
        job = runbench.folder_with_job(tmp_path, lines=10)
        runs = [*job.runs]
        at = next(k for k, run in enumerate(runs) if run.line == 4 and run.motor == "M41")
        other = Shape.of((0, 1, -1, *[0] * (job.pixels - 3)), "plain")
        runs[at] = replace(runs[at], shape=other.key)
        shapes = {**{run.shape: job.shapes[run.shape] for run in job.runs}, other.key: other}
        header = job.header.model_copy(update={"id": id_of(runs)})
        changed = keys(Job(header, job.copies, tuple(runs), shapes))
        same = [one == two for one, two in zip(keys(job), changed, strict=True)]
        assert same == [True, False, False, True, True]

    def test_what_decides_nothing_is_in_no_key(self, tmp_path):
        job = runbench.folder_with_job(tmp_path)
        commented = with_machine(job, b"# mine\n" + job.copies["machine.toml"])
        assert keys(commented) == keys(job)

    @pytest.mark.parametrize(
        "world", [{"seed": 2}, {"ppm": 1.0}, {"flaws": ClockFlaws(jitter_us=1)}, {"run_in": False}]
    )
    def test_the_world_is_in_every_key(self, tmp_path, world):
        job = runbench.folder_with_job(tmp_path)
        same = [one == two for one, two in zip(keys(job), keys(job, **world), strict=True)]
        assert same == [world == {"run_in": False}, False]  # the first has no line before it

    def test_settings_and_clock_are_in_every_key(self, tmp_path):
        job = runbench.folder_with_job(tmp_path)
        text = job.copies["machine.toml"].replace(b'sync = "lock"', b'sync = "start"')
        assert not {*keys(with_machine(job, text))} & {*keys(job)}

    def test_a_block_has_few_bytes_a_line(self, tmp_path):
        machine = jobbench.write_machine(tmp_path)
        job = jobbench.large(machine, lines=64)
        found = [
            len(cuts.pack(job, cut, SimulatedWorld(), TOOLS))
            for cut in Cutter(job, SimulatedWorld(), TOOLS).cuts()
        ]
        print(f"a line of 3 motors with 500 pixels: {sum(found) / 64:.0f} bytes to its worker")
        assert sum(found) < 64 * 1500

    def test_long_lines_make_short_blocks(self, tmp_path, monkeypatch):
        monkeypatch.setattr(cuts, "MOST_STEPS", 100_000)
        job = runbench.folder_with_job(tmp_path, lines=9)
        found = [cut.lines for cut in Cutter(job, SimulatedWorld(), TOOLS).cuts()]
        assert sum(found) == 9 and 1 < max(found) < 9


@pytest.mark.usefixtures("simulator")
def test_whoever_is_in_a_hurry_gets_one_line_and_leaves_nothing(tmp_path):
    """Several signals end a simulation as one does."""
    runbench.folder_with_job(tmp_path, lines=40)
    words = ("job", "simulate", "a.pxjob", "--block", "40", "--processes", "1", "--out", "a.pxsim")
    edges = tmp_path / "a.pxsim/edges"
    with subprocess.Popen(
        [sys.executable, "-m", "pixstep", *words], cwd=tmp_path, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        while process.poll() is None and not [*edges.glob(".pixstep-part-*/edges.csv")]:
            time.sleep(0.02)
        for _ in range(3):
            process.send_signal(signal.SIGINT)
            time.sleep(0.01)
        said, complaints = process.communicate()
    assert process.returncode in (130, -signal.SIGINT), complaints  # 130 of a shell, both
    assert said == "" and complaints.count("\n") == 1, complaints
    assert complaints.startswith("pixstep: stopped by Ctrl-C: 0 of 1 blocks are finished")
    assert [*edges.iterdir()] == []


@pytest.mark.usefixtures("simulator")
def test_a_full_disk_is_told_with_its_file():
    with runbench.bus(clock_log="/dev/full") as link:
        link.world.wait(1)
        with pytest.raises(UserError, match="/dev/full: No space left on device"):
            link.simulator.quit()


class TestRefused:
    """What cannot be simulated is said in one line, and nothing is made."""

    def test_a_folder_of_something_else(self, tmp_path):
        runbench.folder_with_job(tmp_path)
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine/text").write_text("mine")
        with pytest.raises(UserError, match="mine: is the folder of no simulation"):
            simulate(tmp_path, out=tmp_path / "mine")

    def test_edges_where_no_folder_can_be(self, tmp_path, simulator):
        del simulator
        runbench.folder_with_job(tmp_path, lines=1)
        with pytest.raises(UserError, match=r"lines 1 to 1: .*a.pxjob: Not a directory"):
            simulate(tmp_path, edges=tmp_path / "a.pxjob")

    def test_a_gated_clock_without_a_gate(self, tmp_path):
        text = jobbench.MACHINE.replace('sync = "lock"', 'sync = "lock"\ngate_edges = 5')
        runbench.folder_with_job(tmp_path, text=text)
        with pytest.raises(UserError, match="its pixel clock is gated, with 5 edges"):
            simulate(tmp_path)
        assert not (tmp_path / "print.pxsim").exists()

    def test_no_scheduler(self, tmp_path):
        runbench.folder_with_job(tmp_path)
        with pytest.raises(UserError, match="scheduler nowhere: "):
            simulate(tmp_path, scheduler="nowhere")
        assert not (tmp_path / "print.pxsim").exists()
