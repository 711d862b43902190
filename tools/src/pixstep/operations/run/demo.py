# SPDX-License-Identifier: MIT
"""The main job on the worked example: profile, line, plan, simulated board, verdict, drawings."""

from __future__ import annotations

import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import atomic, formats, natives, outfolder
from pixstep.board import boards
from pixstep.errors import FINE, NEGATIVE
from pixstep.lazy import have_package, lazy
from pixstep.lines import core, exact, line_check
from pixstep.lines.line import Line
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FOLDER
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import generator
from pixstep.simulation import experiment, report
from pixstep.simulation.job import Job
from pixstep.simulation.judge import Judgement
from pixstep.simulation.summary import Summary

if TYPE_CHECKING:
    import rich.rule
else:
    rich = lazy("rich")

PROFILE = "AccProfM39-30Hz-1.PRN"
PIXEL_HZ = Fraction(30)
REQUEST = generator.LineRequest(speed=1000, pixels=60, backlash=250)
_BOARD = "mega"
_OWN = ("line.csv", "ticks.csv")  # besides those of the simulated run


@operation("demo")
class Demo(Request):
    """Worked example: profile, line, plan, simulated Mega, verdict, plots, VCD."""

    result = Summary

    out: Path | None = option(
        FOLDER, "Folder for the results; replaces only what an earlier run has left there.",
        default_text="build/demo in a clone, else pixstep-demo",
    )  # fmt: skip
    serial_load: bool = flag("Saturate the serial line while moving.")

    def run(self, desk: Desk) -> Result:
        """Go from profile to verdict."""
        experiment.require_installed()
        started = time.monotonic()
        out = self.out or _default_folder()
        source = natives.example(PROFILE)
        speeds, _ = formats.read_prn(source)
        with outfolder.of_run(out, (*_OWN, *experiment.names())) as folder:
            host = _on_host(folder, source, speeds)
            job = Job(_BOARD, {0: host.line}, PIXEL_HZ, serial_load=self.serial_load, vcd=True)
            with desk.progress("simulating the Mega") as show:
                drawn = have_package("matplotlib")
                judged = experiment.simulate_into(job, folder, out, plots=drawn, progress=show)
        seconds = time.monotonic() - started
        fine = judged.passed and host.checked and host.planned
        return Result(
            judged.summary, lambda page: _write(page, host, judged, out, seconds),
            FINE if fine else NEGATIVE,
        )  # fmt: skip


def _default_folder() -> Path:
    return Path("pixstep-demo") if natives.installed() else natives.root() / "build" / "demo"


@dataclass(frozen=True)
class _Host:
    """The line that was made, and whether its check and its plan are right."""

    line: Line
    checked: bool
    planned: bool


def _on_host(folder: Path, source: Path, speeds: list[int]) -> _Host:
    """Make the line, check it, plan its edges."""
    made = generator.generate(speeds, REQUEST, str(source))
    formats.write_csv(folder / "line.csv", made.counts)
    line = Line(tuple(made.counts), backlash=REQUEST.backlash, name="worked example")
    tick_hz = boards.load(_BOARD).tick_hz
    plan = core.plan(line, PIXEL_HZ, tick_hz=tick_hz)
    atomic.write_text(folder / "ticks.csv", plan.csv)
    table = core.plan(line, PIXEL_HZ, tick_hz=tick_hz, pixels=True).columns()[:, 2]
    return _Host(line, not line_check.check(line), table.tolist() == exact.expected_positions(line))


def _write(page: Page, host: _Host, judged: Judgement, out: Path, seconds: float) -> None:
    """Write the page."""
    checked, planned = (
        "[green]ok[/]" if good else "[red]wrong[/]" for good in (host.checked, host.planned)
    )
    page.draw(rich.rule.Rule("[bold]worked example: profile to checked STEP edges"))
    page.print(
        f"profile  {PROFILE}, speed {REQUEST.speed} steps/pixel, {PIXEL_HZ} Hz, "
        f"backlash {REQUEST.backlash}\n"
        f"line     {host.line.pixels} pixels, {host.line.total_steps} steps; line check {checked}\n"
        f"plan     expected positions of the host library {planned}"
    )
    report.print_page(page, judged.summary)
    report.print_files(page, out)
    if not judged.summary.get("plots"):
        page.print("no drawings: pip install 'pixstep\\[plot]' brings matplotlib")
    page.print(f"[dim]{seconds:.1f} s")
