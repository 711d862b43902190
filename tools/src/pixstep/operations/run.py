# SPDX-License-Identifier: MIT
"""Lines on a simulated board, judged; the worked example."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from pixstep import atomic, formats, natives, outfolder
from pixstep.board import boards, capability, guarantee, settings
from pixstep.errors import FINE, NEGATIVE, UserError
from pixstep.lazy import have_package, rich
from pixstep.lines import core, exact, line_check
from pixstep.lines.line import Line
from pixstep.operations import judging, reading_lines, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.clocks import FlawFields, OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, FOLDER, TEXT, Choice
from pixstep.operations.reading_lines import per_line
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import generator
from pixstep.simulation import experiment, report
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.judge import Judgement
from pixstep.simulation.summary import Summary

JudgedRun = TypeVar("JudgedRun", bound=report.JudgedSummary)


def simulated_result(
    summary: JudgedRun, out: Path, write: Callable[[Page, JudgedRun], None]
) -> Result:
    """Return the summary of a run as a result; its page ends with the files in `out`."""

    def page(page: Page) -> None:
        write(page, summary)
        report.print_files(page, out)

    return Result(summary, page, report.exit_status(summary["verdict"]))


@operation("sim")
class Sim(OfClock, FlawFields):
    """Run lines on a simulated board and judge every edge; one file (CSV, CSB) per axis.

    Any set of axes: --axis names the first of consecutive axes, or is given once for each file.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse, 3 for a refused line.
    """

    result = Summary

    csv: tuple[Path, ...] = reading_lines.line_files()
    board: str = shared.simulated_board()
    decode: tuple[str, ...] = reading_lines.decodes()
    backlash: tuple[int, ...] = reading_lines.backlashes()
    axis: tuple[int, ...] = reading_lines.axes()
    sync: str = shared.sync()
    gate_edges: int = shared.gate_edges()
    serial_load: bool = flag("Saturate the serial line while moving.")
    baud: int = shared.board_baud(
        "Rate of the serial line; the board is set to it before lines are sent."
    )
    seed: int = shared.seed()
    out: Path = shared.out("run")
    backlash_policy: str = option(
        Choice(["always", "on_reversal"]), "When a line takes its play up.", default="always"
    )
    negative: bool | None = reading_lines.negative()
    image: Path | None = shared.image()
    check: bool = judging.no_check()
    beyond: bool = judging.beyond()
    plot: bool = shared.plots()
    details: bool = shared.details()
    plant: tuple[str, ...] = option(
        TEXT,
        'Mechanics of the axis, as "play=40" (pixstep-sim --help lists the knobs); once, or per '
        "line. Play starts taken up in the + direction, with taken_up=minus in the other.",
        many=True, shown="KNOBS",
    )  # fmt: skip
    ideal: tuple[Path, ...] = option(
        FILE, "CSV that the load should follow: a compensated line's original; per line.", many=True
    )
    vcd: bool = flag("Write run.vcd for GTKWave into the folder.")
    raw: bool = shared.raw()
    line_number: tuple[int, ...] = reading_lines.line_numbers()

    def run(self, desk: Desk) -> Result:
        """Run the lines in the simulator."""
        line_hz = self.line_hz
        lines = reading_lines.read_lines(
            desk, self, pixel_hz=line_hz, divider=self.edges, refuse_faster=self.check
        )
        axes = reading_lines.line_axes(self.axis, len(lines))
        if max(axes) >= boards.load(self.board).axes:
            raise UserError(f"axis {max(axes)}: the {boards.axes_text(self.board)}")
        shared.refuse_baud(self.board, self.baud)
        if self.check:
            self._check(desk, lines, line_hz)
        job = self._job(desk, dict(zip(axes, lines, strict=True)))
        with desk.progress("simulating") as show:
            judged = simulate(job, self.out, plots=self.plot, progress=show)

        def write(page: Page, summary: Summary) -> None:
            report.print_page(page, summary, details=self.details)

        return simulated_result(judged.summary, self.out, write)

    def _check(self, desk: Desk, lines: list[Line], line_hz: Fraction) -> None:
        clock = settings.of_clock(self.sync, self.edges)
        found = capability.named_limits(self.board, line_hz, axes=len(lines), clock=clock)
        motors = judging.motor_limits(desk.facts, lines, line_hz)
        for line, motor in zip(lines, motors, strict=True):
            judging.check(desk, line, found, motor)
        world = guarantee.world(self.board, line_hz, clock, self.baud, self.pixel_ppm)
        judging.together(desk, lines, world, beyond=self.beyond, gated=bool(self.gate_edges))

    def _job(self, desk: Desk, lines: dict[int, Line]) -> LineExperiment:
        plants, ideals = self._plants(desk, lines)
        return LineExperiment(
            board=self.board,
            lines=lines,
            pixel_hz=self.edges_hz,
            pixel_ppm=self.pixel_ppm,
            flaws=self.flaws,
            sync=self.sync,
            gate_edges=self.gate_edges,
            divider=self.edges,
            serial_load=self.serial_load,
            baud=self.baud,
            seed=self.seed,
            backlash_policy=self.backlash_policy,
            image=self.image,
            vcd=self.vcd,
            plants=plants,
            ideals=ideals,
            scales=desk.facts.scales() if self.plot else {},
        )

    def _plants(
        self, desk: Desk, lines: dict[int, Line]
    ) -> tuple[dict[int, str], dict[int, tuple[int, ...]]]:
        """Return the plants and the ideal counts of a job, by axis."""
        plant: tuple[str | None, ...] = self.plant
        ideal: tuple[Path | None, ...] = self.ideal
        knobs = per_line("plant", plant, len(lines), None)
        paths = per_line("ideal", ideal, len(lines), None)
        if any(paths) and not any(knobs):
            raise AskedError("{ideal} says what the load should do: give the axis a {plant} too")
        ideals = {}
        for (axis, line), path in zip(lines.items(), paths, strict=True):
            if path:
                counts = reading_lines.load_line(desk, path, line.decode, raw=self.raw).counts
                if len(counts) != line.pixels:
                    raise UserError(f"{path}: {len(counts)} pixels, {line.name} has {line.pixels}")
                ideals[axis] = counts
        return {axis: text for axis, text in zip(lines, knobs, strict=True) if text}, ideals


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
            job = LineExperiment(
                _BOARD, {0: host.line}, PIXEL_HZ, serial_load=self.serial_load, vcd=True
            )
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
