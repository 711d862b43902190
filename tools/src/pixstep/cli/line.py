# SPDX-License-Identifier: MIT
"""`pixstep line check` and `pixstep ticks`: what a line may do, and its planned edges."""

import functools
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click
from click.core import ParameterSource

from pixstep import atomic, formats
from pixstep.board import boards, settings
from pixstep.board.limits import named
from pixstep.cli import judging
from pixstep.cli.clockoptions import divider_option, sync_option
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import (
    DECODE,
    HZ,
    STATUSES,
    VERDICTS,
    backlash_option,
    clock_option,
    deliver_facts,
    json_option,
    line_option,
    load_line,
    pixel_hz_option,
    raw_option,
    say,
    show_json,
)
from pixstep.cli.quantities import (
    ACCELERATION_TYPE,
    JERK_TYPE,
    SPEED_TYPE,
    WholeHzType,
    whole_limit,
)
from pixstep.errors import RefusedError, UserError
from pixstep.lines import linecheck, planner
from pixstep.lines.units import Quantity


class _CheckOptions(TypedDict):
    lenient: bool
    min_interval: int | None
    max_speed: Quantity | None
    max_acceleration: Quantity | None
    start_stop: Quantity | None
    jerk_warn: Quantity | None
    sync: str


class _TicksOptions(TypedDict):
    raw: bool
    line_number: int | None
    timer_hz: int | None


@command("check")
@click.argument("csv", metavar="FILE", type=FILE)
@click.option("--decode", type=DECODE, required=True)
@backlash_option
@raw_option
@click.option(
    "--lenient", is_flag=True, help="Accept LF and a missing final newline, as `file check` does."
)
@line_option
@click.option("--pixel-hz", type=HZ, help="Check the board's step rate and reversals too.")
@divider_option
@sync_option
@clock_option
@click.option(
    "--axes",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Axes that move together with it, itself included: the more, the slower.",
)
@click.option(
    "--min-interval", type=click.IntRange(1, 65_535), help="Ticks. [default: the board's]"
)
@click.option("--max-speed", type=SPEED_TYPE, help="steps/px or steps/s")
@click.option("--max-acceleration", type=ACCELERATION_TYPE, help="steps/px2 or steps/s2")
@click.option(
    "--start-stop",
    type=SPEED_TYPE,
    help="steps/px or steps/s; up to here a plain line may start, stop and turn without a ramp.",
)
@click.option("--jerk-warn", type=JERK_TYPE, help="Warn of larger acceleration changes.")
@json_option
@click.pass_context
def line_check(
    ctx: click.Context,
    csv: Path,
    decode: str,
    backlash: int,
    raw: bool,
    line_number: int | None,
    pixel_hz: Fraction | None,
    divider: int,
    board: str,
    axes: int,
    as_json: bool,
    **limits: Unpack[_CheckOptions],
) -> None:
    """Check a line of a CSV or CSB file, and the file's form as `file check` does.

    With a pixel frequency by the limits of the board too, and by those of the machine file's motor.
    What is refused here `sim` and `board upload` refuse too, unless they are given --no-check.
    Exit status 0 fine, 1 warnings, 3 refused.
    """
    pixel_hz = pixel_hz and pixel_hz / divider
    checked = load_line(
        csv,
        decode,
        backlash,
        raw=raw,
        number=line_number,
        read=functools.partial(_read_strictly, lenient=limits["lenient"]),
        pixel_hz=pixel_hz,
        refuse_faster=True,
        divider=divider,
    )
    if axes > boards.load(board).axes:
        raise UserError(f"--axes {axes}: {boards.axes_text(board)}")
    of_board = linecheck.Limits()
    if pixel_hz:
        clock = settings.of_clock(limits["sync"], divider)
        of_board = named(board, pixel_hz, axes=axes, clock=clock).of(checked)
        if ctx.get_parameter_source("board") == ParameterSource.DEFAULT:
            say([f"{csv}: checked by what the {boards.load(board).label} can do (--board)"])
    motor = judging.of_quantities(
        checked, pixel_hz, limits["max_speed"], limits["max_acceleration"], limits["start_stop"]
    )
    if ctx.get_parameter_source("max_acceleration") == ParameterSource.DEFAULT_MAP:
        motor = motor.with_rounding(checked)  # it is the machine file's
    bounds = replace(
        of_board.lower(motor),
        jerk_warning=whole_limit(limits["jerk_warn"], pixel_hz, least=0),
        min_interval_ticks=limits["min_interval"] or of_board.min_interval_ticks,
    )
    found = linecheck.check(checked, bounds)
    status = linecheck.exit_status(found)
    verdict = VERDICTS[status]
    if as_json:
        report = {
            "file": str(csv),
            "line": line_number or 1,
            "decode": decode,
            "backlash": backlash,
            "board": board if pixel_hz else None,
            "verdict": verdict,
            "pixels": checked.pixels,
            "steps": checked.total_steps,
            "line_speed": checked.line_speed if status < 2 else None,
            "findings": linecheck.as_json(found),
        }
        show_json(report)
    else:
        for pixels, item in _gathered(found):
            click.echo(f"{csv}: {pixels}: {item.severity} {item.name}: {item.message}")
        click.echo(f"{csv}: {verdict}: {checked.pixels} pixels, {checked.total_steps} steps")
    ctx.exit(STATUSES[status])


@command("ticks")
@click.argument("csv", metavar="FILE", type=FILE)
@click.option("--decode", type=DECODE, required=True)
@pixel_hz_option
@divider_option
@backlash_option
@raw_option
@line_option
@clock_option
@click.option("--timer-hz", type=WholeHzType(), help="Ticks a second.  [default: the board's]")
@click.option("--pixels", is_flag=True, help="Pixel edges and expected positions instead.")
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write.")
@json_option
def ticks(
    csv: Path,
    decode: str,
    pixel_hz: Fraction,
    divider: int,
    backlash: int,
    board: str,
    pixels: bool,
    output: Path,
    as_json: bool,
    **options: Unpack[_TicksOptions],
) -> None:
    """Plan the edges of a line of a CSV or CSB with the native build of the firmware's core."""
    pixel_hz /= divider
    chosen = load_line(
        csv,
        decode,
        backlash,
        raw=options["raw"],
        number=options["line_number"],
        pixel_hz=pixel_hz,
        divider=divider,
    )
    tick_hz = options["timer_hz"] or boards.load(board).tick_hz
    limits = named(board, pixel_hz, tick_hz).of_core()
    planned = planner.plan(chosen, pixel_hz, tick_hz=tick_hz, pixels=pixels, limits=limits)
    say(planned.warnings)
    atomic.write_text(output, planned.csv)
    rows = planned.csv.count("\n") - 1
    what = "pixel edges" if pixels else "steps"
    facts = {"file": str(output), "of": what, "rows": rows, "tick_hz": tick_hz}
    deliver_facts(facts, f"{output}: {rows} {what}", output, as_json=as_json)


def _read_strictly(path: Path, *, raw: bool, lenient: bool) -> formats.MotionFile:
    """Read a file as `file check` does; a refusal that --lenient would lift says so."""
    try:
        return formats.read_motion(path, raw=raw, lenient=lenient, strict=not lenient)
    except RefusedError as error:
        if lenient or not _reads_leniently(path, raw=raw):
            raise
        raise RefusedError(f"{error} (--lenient accepts it)") from None


def _reads_leniently(path: Path, *, raw: bool) -> bool:
    try:
        formats.read_motion(path, raw=raw, lenient=True)
    except UserError:
        return False
    return True


def _gathered(found: list[linecheck.Finding]) -> list[tuple[str, linecheck.Finding]]:
    """Return the findings with their pixels in words: one for neighbours that say the same."""
    runs: list[list[linecheck.Finding]] = []
    for item in found:
        last = runs[-1][-1] if runs else linecheck.Finding("", "", 0, "")
        if replace(last, pixel=item.pixel) == item and item.pixel == last.pixel + 1:
            runs[-1].append(item)
        else:
            runs.append([item])
    return [(_pixels_text(run[0].pixel, run[-1].pixel), run[0]) for run in runs]


def _pixels_text(first: int, last: int) -> str:
    return f"pixel {first}" if first == last else f"pixels {first} to {last}"
