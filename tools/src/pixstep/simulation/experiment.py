# SPDX-License-Identifier: MIT
"""One experiment from what is run to files on disk: run, judge, write, draw."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic, natives, outfolder
from pixstep.board import registers as regs
from pixstep.lazy import require_package
from pixstep.lines.units import hz_text
from pixstep.progress import Progress, unseen
from pixstep.simulation import clock_judge, report
from pixstep.simulation.job import LineExperiment, RunResult, run_job
from pixstep.simulation.judge import AxisLoad, Judgement, axis_load, judge

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pixstep.simulation import plots

# What a run may leave in its folder; an earlier run's must not pass for this one's.
OUTPUTS = (
    "edges.csv", "clock.csv", "serial.csv", "plant.csv", "pixels.csv", "summary.json", "run.vcd",
)  # fmt: skip
_TOGETHER = "motion.png"  # of one axis its own, of several all in one
_PLOTS = (_TOGETHER, "edge-error.png", "positions.png", "load.png", "clock.png")


def names() -> list[str]:
    """Return the names of all files that a run may write."""
    prefixes = ("", *(f"axis{axis}-" for axis in range(max(regs.AXIS_COUNTS))))
    return [*OUTPUTS, *(prefix + name for prefix in prefixes for name in _PLOTS)]


def simulate(
    job: LineExperiment, out: Path, *, plots: bool = False, progress: Progress = unseen
) -> Judgement:
    """Run a job and write OUTPUTS (run.vcd and plots only if asked) to `out`, all or none.

    Raises UserError if a file is in the way that is not as an earlier run left it.
    """
    with outfolder.of_run(out, names()) as folder:
        return simulate_into(job, folder, out, plots=plots, progress=progress)


def simulate_into(
    job: LineExperiment,
    folder: Path,
    out: Path,
    *,
    plots: bool = False,
    progress: Progress = unseen,
) -> Judgement:
    """Run a job and leave the files in `folder`; the summary names them by their place in `out`."""
    result, judged, loads = run_and_judge(job, folder, progress)
    if plots:
        drawn = draw_plots(result, judged, loads, folder)
        judged.summary["plots"] = [str(out / path.name) for path in drawn]
    return judged


def require_installed() -> None:
    """Raise UserError if anything is not installed that a run or its verdict needs."""
    natives.program("pixstep-sim")
    require_package("numpy")


def run_and_judge(
    job: LineExperiment, folder: Path, progress: Progress = unseen
) -> tuple[RunResult, Judgement, list[AxisLoad]]:
    """Run a job, leave the files in `folder`; return what it left, its verdict and its loads."""
    require_installed()
    result = run_job(job, folder, progress)
    judged = judge(result)
    loads = follow_loads(result, judged)
    report.write_pixels(folder / "pixels.csv", judged.pixels)
    atomic.write_json(folder / "summary.json", judged.summary)
    return result, judged, loads


def follow_loads(result: RunResult, judged: Judgement) -> list[AxisLoad]:
    """Return the loads of the axes with a plant; note them in the summary and the pixel rows.

    An axis that made no step, or whose edges have no place in time, has none.
    """
    loads = []
    for row in judged.summary["axes"]:
        axis = row["axis"]
        mine = [index for index, pixel in enumerate(judged.pixels) if pixel.axis == axis]
        known = (judged.pixels[index].edge_cycle for index in mine)
        cycles = [cycle for cycle in known if cycle is not None]
        if axis not in result.job.plants or not cycles or len(cycles) < len(mine):
            continue
        line, ideal = result.job.lines[axis], result.job.ideals.get(axis)
        found = axis_load(axis, line, ideal, result.plants[0, axis], cycles)
        row["load"] = found.summary()
        for index, steps in zip(mine, found.load_steps, strict=True):
            judged.pixels[index] = replace(judged.pixels[index], load_steps=int(steps))
        loads.append(found)
    return loads


def draw_plots(
    result: RunResult, judged: Judgement, loads: list[AxisLoad], out: Path
) -> list[Path]:
    """Draw the plots of every axis that moved, and one of several together; return their paths."""
    from pixstep import plotting
    from pixstep.simulation import plots

    job, found = result.job, traces(result, judged)
    prefix = {axis: "" if len(job.lines) == 1 else f"axis{axis}-" for axis in job.lines}
    with plotting.styled():
        paths = [
            plotting.write(make(trace), out / f"{prefix[axis]}{name}.png")
            for axis, trace in found.items()
            for name, make in plots.OF_TRACE.items()
        ]
        if len(found) > 1:
            paths.append(plotting.write(plots.together([*found.values()]), out / _TOGETHER))
    for axis, kept in judged.kept.items() if clock_judge.parts(judged.summary) else ():
        paths.append(plotting.write(clock_figure(job, kept), out / f"{prefix[axis]}clock.png"))
    with plotting.styled():
        for load in loads:
            path = out / f"{prefix[load.axis]}load.png"
            paths.append(plotting.write(load_figure(job, load), path))
    return paths


def clock_figure(job: LineExperiment, kept: clock_judge.ClockKeeping) -> Figure:
    """Return the drawing of how an axis kept to the clock."""
    from pixstep import plotting
    from pixstep.simulation import plots

    with plotting.styled():
        return plots.clock(kept, job, _title(job, kept.axis))


def load_figure(job: LineExperiment, load: AxisLoad) -> Figure:
    """Return the drawing of an axis' load."""
    from pixstep.simulation import plots

    title = f"{_title(job, load.axis)}, plant {job.plants[load.axis]}"
    return plots.load(load, title, job.line_hz, job.scales.get(load.axis))


def traces(result: RunResult, judged: Judgement) -> dict[int, plots.Trace]:
    """Return what there is to draw, by axis: those that moved."""
    from pixstep.simulation import plots

    job = result.job
    return {
        found.axis: plots.Trace(
            line=job.lines[found.axis],
            period=job.period,
            tick_hz=job.tick_hz,
            zero=found.line_zero_cycle,
            edges=result.edges.axis(0, found.axis),
            pixels=[row for row in judged.pixels if row.axis == found.axis],
            title=_title(job, found.axis),
            scale=job.scales.get(found.axis),
            grid=judged.grids[found.axis],
        )
        for found in judged.axes
        if found.line_zero_cycle is not None and found.errors_ticks is not None
    }


def _title(job: LineExperiment, axis: int) -> str:
    from pixstep.plotting import number  # matplotlib takes a second to load

    line = job.lines[axis]
    hz = hz_text(job.line_hz).removesuffix("/1")
    return (
        f"{job.board} axis {axis}, {line.decode} decoding, {line.pixels} pixels at {hz} Hz, "
        f"{number(line.total_steps)} steps, backlash {number(line.backlash)}"
    )
