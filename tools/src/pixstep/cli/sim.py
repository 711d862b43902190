# SPDX-License-Identifier: MIT
"""`pixstep sim` and `pixstep demo`: lines on a simulated board, judged."""

from __future__ import annotations

import functools
from fractions import Fraction
from pathlib import Path
from typing import Unpack

import click

from pixstep import demo, progress
from pixstep.board import boards, limits, settings
from pixstep.board.port import BAUD
from pixstep.cli import judging, machinedefaults
from pixstep.cli.clockoptions import (
    FlawOptions,
    clock_flaw_options,
    clock_flaws,
    divider_option,
    gate_edges_option,
    sync_option,
)
from pixstep.cli.command import FILE, FOLDER, command
from pixstep.cli.manylines import (
    LineOptions,
    line_axes,
    line_axes_option,
    negative_option,
    per_line,
    read_lines,
)
from pixstep.cli.options import (
    DECODE,
    LINE_NUMBER,
    details_option,
    json_option,
    load_line,
    no_check_option,
    out_option,
    pixel_hz_option,
    plots_option,
    raw_option,
    show_json,
)
from pixstep.cli.quantities import StepsType
from pixstep.cli.results import deliver
from pixstep.errors import FINE, NEGATIVE, UserError
from pixstep.lines.line import Line
from pixstep.simulation import report
from pixstep.simulation.simrun import Job
from pixstep.simulation.simtask import simulate


class _SimOptions(FlawOptions, LineOptions):
    pixel_hz: Fraction
    sync: str
    gate_edges: int
    serial_load: bool
    baud: int
    seed: int
    backlash_policy: str
    image: Path | None
    check: bool
    plant: tuple[str, ...]
    ideal: tuple[Path, ...]
    vcd: bool


def _hundreds(_ctx: click.Context, _option: click.Parameter, baud: int) -> int:
    """Return a rate that the board's setting can hold."""
    if baud % 100:
        raise click.BadParameter(f"{baud}: a multiple of 100 is wanted")
    return baud


@command("sim")
@click.argument("csv", metavar="FILE...", type=FILE, nargs=-1, required=True)
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@click.option("--decode", type=DECODE, multiple=True, required=True, help="Once, or per line.")
@pixel_hz_option
@click.option(
    "--backlash",
    type=StepsType(0),
    multiple=True,
    help="Steps; once, or per line.",
)
@line_axes_option
@clock_flaw_options
@sync_option
@divider_option
@gate_edges_option
@click.option("--serial-load", is_flag=True, help="Saturate the serial line while moving.")
@click.option(
    "--baud",
    type=click.IntRange(9600, 1_000_000),
    default=BAUD,
    show_default=True,
    callback=_hundreds,
    help="Of the serial line, to which the board is set before its lines come.",
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
@out_option
@click.option("--backlash-policy", type=click.Choice(["always", "on_reversal"]), default="always")
@negative_option
@click.option("--image", type=FILE, help="Another firmware image (ELF) for the board.")
@no_check_option
@plots_option
@details_option
@click.option(
    "--plant",
    multiple=True,
    metavar="KNOBS",
    help='Mechanics of the axis, as "play=40" (pixstep-sim --help lists the knobs); once, or per '
    "line. Play starts taken up in the + direction, with taken_up=minus in the other.",
)
@click.option(
    "--ideal",
    type=FILE,
    multiple=True,
    help="CSV that the load should follow: a compensated line's original; per line.",
)
@click.option("--vcd", is_flag=True, help="Write run.vcd for GTKWave into the folder.")
@json_option
@raw_option
@click.option(
    "--line",
    "line_number",
    type=LINE_NUMBER,
    metavar="N",
    multiple=True,
    help="Line N of files of many lines; once, or per line file.",
)
@click.pass_context
def sim(
    ctx: click.Context,
    csv: tuple[Path, ...],
    board: str,
    axis: tuple[int, ...],
    decode: tuple[str, ...],
    backlash: tuple[int, ...],
    out: Path,
    divider: int,
    plot: bool,
    details: bool,
    as_json: bool,
    **options: Unpack[_SimOptions],
) -> None:
    """Run lines on a simulated board and judge every edge; one file (CSV, CSB) per axis.

    Any set of axes: of several files --axis is the first of a row, or given once for each.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse, 3 for a refused line.
    """
    line_hz = options["pixel_hz"] / divider
    lines = read_lines(
        csv, decode, backlash, options, pixel_hz=line_hz, divider=divider,
        refuse_faster=options["check"],
    )  # fmt: skip
    axes = line_axes(axis, len(lines))
    if max(axes) >= boards.load(board).axes:
        raise UserError(f"axis {max(axes)}: the {boards.axes_text(board)}")
    if options["check"]:
        clock = settings.of_clock(options["sync"], divider)
        found = limits.named(board, line_hz, axes=len(lines), clock=clock)
        for line, motor in zip(lines, judging.motor_limits(ctx, lines, line_hz), strict=True):
            judging.check(line, found, motor)
    by_axis = dict(zip(axes, lines, strict=True))
    plants, ideals = _plants(by_axis, options)
    job = Job(
        board=board,
        lines=by_axis,
        pixel_hz=options["pixel_hz"],
        pixel_ppm=options["pixel_ppm"],
        flaws=clock_flaws(options),
        sync=options["sync"],
        gate_edges=options["gate_edges"],
        divider=divider,
        serial_load=options["serial_load"],
        baud=options["baud"],
        seed=options["seed"],
        backlash_policy=options["backlash_policy"],
        image=options["image"],
        vcd=options["vcd"],
        plants=plants,
        ideals=ideals,
        scales=machinedefaults.scales(ctx) if plot else {},
    )
    with progress.shown("simulating") as show:
        judged = simulate(job, out, plots=plot, progress=show)
    page = functools.partial(report.print_page, details=details)
    ctx.exit(deliver(judged.summary, out, page, as_json=as_json))


@command("demo")
@click.option(
    "--out",
    type=FOLDER,
    help="Folder for the results; replaces only what an earlier run has left there.  "
    "[default: build/demo in a clone, else pixstep-demo]",
)
@click.option("--serial-load", is_flag=True, help="Saturate the serial line while moving.")
@json_option
@click.pass_context
def demo_command(ctx: click.Context, out: Path | None, serial_load: bool, as_json: bool) -> None:
    """Worked example: profile, line, plan, simulated Mega, verdict, plots, VCD."""
    console = report.new_console(quiet=as_json)
    done = demo.run(console, out, serial_load=serial_load)
    if as_json:
        show_json(done.summary)
    ctx.exit(FINE if done.passed else NEGATIVE)


def _plants(
    lines: dict[int, Line], options: _SimOptions
) -> tuple[dict[int, str], dict[int, tuple[int, ...]]]:
    """Return the plants and the ideal counts of a job, by axis."""
    plant: tuple[str | None, ...] = options["plant"]
    ideal: tuple[Path | None, ...] = options["ideal"]
    knobs = per_line(plant, len(lines), None, "--plant")
    paths = per_line(ideal, len(lines), None, "--ideal")
    if any(paths) and not any(knobs):
        raise UserError("--ideal says what the load should do: give the axis a --plant too")
    ideals = {}
    for (axis, line), path in zip(lines.items(), paths, strict=True):
        if path:
            ideals[axis] = load_line(path, line.decode, raw=options["raw"]).counts
            if len(ideals[axis]) != line.pixels:
                raise UserError(
                    f"{path}: {len(ideals[axis])} pixels, {line.name} has {line.pixels}"
                )
    plants = {axis: text for axis, text in zip(lines, knobs, strict=True) if text}
    return plants, ideals
