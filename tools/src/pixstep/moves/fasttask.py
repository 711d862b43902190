# SPDX-License-Identifier: MIT
"""A simulated fast move from plan to files on disk: run, judge, write, plot."""

from pathlib import Path

from pixstep import atomic, outfolder
from pixstep.moves.fastsim import MoveJob, MoveRun, run
from pixstep.progress import Progress, unseen
from pixstep.simulation import report

OUTPUTS = ("edges.csv", "clock.csv", "serial.csv", "pixels.csv", "summary.json", "move.png")


def simulate(
    job: MoveJob,
    out: Path,
    *,
    plot: bool = False,
    progress: Progress = unseen,
) -> MoveRun:
    """Run a move and write OUTPUTS (move.png only if asked) to `out`, all or none.

    Raises UserError if a file is in the way that is not as an earlier run left it.
    """
    with outfolder.of_run(out, OUTPUTS) as folder:
        done = _simulate(job, folder, plot, progress)
    summary = done.judged.summary
    if "plots" in summary:
        summary["plots"] = [str(out / name) for name in summary["plots"]]
    return done


def _simulate(job: MoveJob, out: Path, plot: bool, progress: Progress) -> MoveRun:
    done = run(job, progress, out=out)
    report.write_pixels(out / "pixels.csv", done.judged.pixels)
    if plot:
        from pixstep.moves import fastplot  # matplotlib takes a second to load

        done.judged.summary["plots"] = [fastplot.draw_run(done, out / "move.png").name]
    atomic.write_json(out / "summary.json", done.judged.summary)
    return done
