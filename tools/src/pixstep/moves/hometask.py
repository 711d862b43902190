# SPDX-License-Identifier: MIT
"""A simulated homing from plan to files on disk: run, judge, write, plot."""

from collections.abc import Callable
from pathlib import Path

from pixstep import atomic
from pixstep.moves import homesim
from pixstep.moves.homejudge import judge
from pixstep.moves.homesim import HomeJob

OUTPUTS = (*homesim.OUTPUTS, "summary.json", "homing.png")


def simulate(
    job: HomeJob,
    out: Path,
    *,
    plot: bool = False,
    progress: Callable[[float], None] = lambda _: None,
) -> dict:
    """Run and judge a homing; write OUTPUTS to `out` (homing.png only if asked)."""
    for name in OUTPUTS:
        (out / name).unlink(missing_ok=True)
    done = homesim.run(job, out, progress)
    summary = judge(done)
    if plot and len(done.edges.rising):
        from pixstep.moves import homeplot  # matplotlib takes a second to load

        summary["plots"] = [str(homeplot.draw(done, out / "homing.png", summary["verdict"]))]
    atomic.write_json(out / "summary.json", summary)
    return summary
