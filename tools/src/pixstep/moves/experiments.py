# SPDX-License-Identifier: MIT
"""A fast move or a homing on a simulated board, from plan to files on disk."""

from __future__ import annotations

from pathlib import Path

from pixstep import atomic, outfolder
from pixstep.board import boards
from pixstep.board.errors import BoardError
from pixstep.board.handle import Course, Handle
from pixstep.errors import UserError
from pixstep.moves.homing import Homed, home
from pixstep.moves.homing_judge import HomeJob, HomeRun, HomeSummary, judge
from pixstep.moves.legs import INVERTED, shared_limits
from pixstep.moves.move_judge import MoveJob, MoveRun, judge_end
from pixstep.progress import Progress, unseen
from pixstep.simulation import report
from pixstep.simulation.job import LineExperiment, run_job
from pixstep.simulation.judge import judge as judge_lines
from pixstep.simulation.logs import read_edges
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep.simulation.summary import Summary

SETTLE_S = 0.05
MOVE_OUTPUTS = ("edges.csv", "clock.csv", "serial.csv", "pixels.csv", "summary.json", "move.png")
HOMING_LOGS = {"edges": "edges.csv", "switch_log": "switches.csv"}
HOMING_OUTPUTS = (*HOMING_LOGS.values(), "summary.json", "homing.png")


def run_move(job: MoveJob, progress: Progress = unseen, *, out: Path) -> MoveRun:
    """Simulate and judge a move; leave edges, clock, serial (.csv) in `out`.

    The verdict is that of a line, and besides: the board's position register and the simulator's
    own count of the STEP edges must both be the steps asked for.
    """
    result = run_job(
        LineExperiment(job.board, {job.axis: job.move.line()}, job.pixel_hz), out, progress
    )
    judged = judge_lines(result)
    judge_end(job, result, judged.summary)
    return MoveRun(job, result, judged)


def simulate_move(
    job: MoveJob, out: Path, *, plot: bool = False, progress: Progress = unseen
) -> MoveRun:
    """Run a move and write MOVE_OUTPUTS (move.png only if asked) to `out`, all or none.

    Raises UserError if a file is in the way that is not as an earlier run left it.
    """
    with outfolder.of_run(out, MOVE_OUTPUTS) as folder:
        done = run_move(job, progress, out=folder)
        summary = done.judged.summary
        report.write_pixels(folder / "pixels.csv", done.judged.pixels)
        if plot:
            from pixstep.moves import plots  # matplotlib takes a second to load

            plots.draw_move(job, folder / "move.png", done)
        _write(summary, folder, out, "move.png" if plot else "")
    return done


def simulate_homing(
    job: HomeJob, out: Path, *, plot: bool = False, progress: Progress = unseen
) -> HomeSummary:
    """Run and judge a homing; write HOMING_OUTPUTS to `out` (homing.png only if asked).

    All or none. Raises UserError if a file is in the way that is not as an earlier run left it.
    """
    with outfolder.of_run(out, HOMING_OUTPUTS) as folder:
        done = run_homing(job, folder, progress)
        summary = judge(done)
        plot = plot and len(done.edges.rising) > 0
        if plot:
            from pixstep.moves import plots  # matplotlib takes a second to load

            plots.draw_homing(done, folder / "homing.png", summary["verdict"])
        _write(summary, folder, out, "homing.png" if plot else "")
    return summary


def run_homing(job: HomeJob, out: Path, progress: Progress = unseen) -> HomeRun:
    """Run a homing; leave HOMING_LOGS in `out`.

    Raises UserError if the simulator cannot run; what the board does wrong is in the result.
    """
    axis = job.plan.axis
    if axis >= boards.load(job.board).axes:
        raise UserError(f"axis {axis}: the {boards.axes_text(job.board)}")
    done = HomeRun(job)
    with job.simulated(out, HOMING_LOGS, plants={(0, axis): job.plant}) as run:
        try:
            done.homed = _home(job, run, progress)
        except BoardError as error:
            done.error = error
        run.simulator.wait_s(SETTLE_S)
        done.counted_steps = run.simulator.steps(0, axis)
        _, done.load_steps = run.simulator.plant(0, axis)
    done.edges = read_edges(out / "edges.csv").axis(0, axis)
    done.switch_edges = job.home_edges(out / "switches.csv")
    return done


def _home(job: HomeJob, run: SimulatedBoard, progress: Progress) -> Homed:
    """Set the board up, and home as a real board does."""
    axis = job.plan.axis
    settings = {
        "inputs_inverted": INVERTED[job.inverted],
        "home_is_limit": shared_limits(0, axis, job.home_is_limit),
    }
    if job.filter_us is not None:
        settings["input_filter_us"] = job.filter_us
    if settings["home_is_limit"]:
        run.board.require("shared_switch")
    run.set_up(job.pixel_hz, [axis], **settings)
    run.simulator.wait_s(SETTLE_S)  # the filters see the switches

    def make(course: Course) -> Homed:
        # Nobody waits for its begin, which would cost a look at the axis.
        return home(
            run.board, job.plan, job.pixel_hz, course.world, course.progress, lines=run.lines
        )

    return Handle(run.link, [run.lines], make, progress).begin().wait()


def _write(summary: Summary | HomeSummary, folder: Path, out: Path, picture: str) -> None:
    """Write summary.json, which names its picture; the caller's names where it is, in `out`."""
    if picture:
        summary["plots"] = [picture]
    atomic.write_json(folder / "summary.json", summary)
    if picture:
        summary["plots"] = [str(out / picture)]
