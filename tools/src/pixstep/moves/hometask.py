# SPDX-License-Identifier: MIT
"""A simulated homing from plan to files on disk: run, judge, write, plot."""

from pathlib import Path

from pixstep import atomic, outfolder
from pixstep.moves import homesim
from pixstep.moves.homejudge import HomeSummary, judge
from pixstep.moves.homesim import HomeJob
from pixstep.progress import Progress, unseen

OUTPUTS = (*homesim.OUTPUTS, "summary.json", "homing.png")


def simulate(
    job: HomeJob,
    out: Path,
    *,
    plot: bool = False,
    progress: Progress = unseen,
) -> HomeSummary:
    """Run and judge a homing; write OUTPUTS to `out` (homing.png only if asked), all or none.

    Raises UserError if a file is in the way that is not as an earlier run left it.
    """
    with outfolder.of_run(out, OUTPUTS) as folder:
        summary = _simulate(job, folder, plot, progress)
    if "plots" in summary:
        summary["plots"] = [str(out / name) for name in summary["plots"]]
    return summary


def _simulate(job: HomeJob, out: Path, plot: bool, progress: Progress) -> HomeSummary:
    done = homesim.run(job, out, progress)
    summary = judge(done)
    if plot and len(done.edges.rising):
        from pixstep.moves import homeplot  # matplotlib takes a second to load

        summary["plots"] = [homeplot.draw(done, out / "homing.png", summary["verdict"]).name]
    atomic.write_json(out / "summary.json", summary)
    return summary
