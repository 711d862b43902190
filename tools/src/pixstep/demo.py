# SPDX-License-Identifier: MIT
"""The main job on the worked example: profile, line, plan, simulated board, verdict, drawings."""

from __future__ import annotations

import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic, extras, formats, natives, outfolder, progress
from pixstep.board import boards
from pixstep.lazy import lazy
from pixstep.lines import exact, linecheck, planner
from pixstep.lines.line import Line
from pixstep.profiles import generator
from pixstep.simulation import report, simtask
from pixstep.simulation.judge import Judgement
from pixstep.simulation.simrun import Job
from pixstep.simulation.summary import Summary

if TYPE_CHECKING:
    import rich.console
else:
    rich = lazy("rich")

PROFILE = "AccProfM39-30Hz-1.PRN"
PIXEL_HZ = Fraction(30)
_BOARD = "mega"
_OWN = ("line.csv", "ticks.csv")  # besides those of the simulated run
REQUEST = generator.LineRequest(speed=1000, pixels=60, backlash=250)


@dataclass(frozen=True)
class Demo:
    """What came out: whether all of it is right, and the summary of the run."""

    passed: bool
    summary: Summary


def run(
    console: rich.console.Console, out: Path | None = None, *, serial_load: bool = False
) -> Demo:
    """Run the worked example into `out`, print what came out and return it."""
    simtask.require_all()
    started = time.monotonic()
    out = out or _default_folder()
    source = natives.example(PROFILE)
    speeds, _ = formats.read_prn(source)
    with outfolder.of_run(out, (*_OWN, *simtask.names())) as folder:
        line, judged, host_right = _run(folder, out, source, speeds, serial_load=serial_load)
    _print(console, judged.summary, line, host_right, started, out)
    return Demo(judged.passed and all(host_right), judged.summary)


def _default_folder() -> Path:
    return Path("pixstep-demo") if natives.installed() else natives.root() / "build" / "demo"


def _run(
    folder: Path, out: Path, source: Path, speeds: list[int], *, serial_load: bool
) -> tuple[Line, Judgement, tuple[bool, bool]]:
    """Go from profile to verdict; tell too whether line check and plan of the host are right."""
    made = generator.generate(speeds, REQUEST, str(source))
    formats.write_csv(folder / "line.csv", made.counts)
    line = Line(tuple(made.counts), backlash=REQUEST.backlash, name="worked example")
    findings = linecheck.check(line)
    tick_hz = boards.load(_BOARD).tick_hz
    plan = planner.plan(line, PIXEL_HZ, tick_hz=tick_hz)
    atomic.write_text(folder / "ticks.csv", plan.csv)
    table = planner.plan(line, PIXEL_HZ, tick_hz=tick_hz, pixels=True).columns()[:, 2]
    planned_right = table.tolist() == exact.expected_positions(line)
    job = Job(_BOARD, {0: line}, PIXEL_HZ, serial_load=serial_load, vcd=True)
    with progress.shown("simulating the Mega") as show:
        drawn = extras.have("matplotlib")
        judged = simtask.simulate_into(job, folder, out, plots=drawn, progress=show)
    return line, judged, (not findings, planned_right)


def _print(
    console: rich.console.Console,
    summary: Summary,
    line: Line,
    host_right: tuple[bool, bool],
    started: float,
    out: Path,
) -> None:
    """Print the page."""
    checked, planned = ("[green]ok[/]" if good else "[red]wrong[/]" for good in host_right)
    console.rule("[bold]worked example: profile to checked STEP edges")
    console.print(
        f"profile  {PROFILE}, speed {REQUEST.speed} steps/pixel, {PIXEL_HZ} Hz, "
        f"backlash {REQUEST.backlash}\n"
        f"line     {line.pixels} pixels, {line.total_steps} steps; line check {checked}\n"
        f"plan     expected positions of the host library {planned}"
    )
    report.print_page(console, summary)
    report.print_files(console, out)
    if not summary.get("plots"):
        console.print("no drawings: pip install 'pixstep\\[plot]' brings matplotlib")
    console.print(f"[dim]{time.monotonic() - started:.1f} s")
