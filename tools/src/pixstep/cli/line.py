# SPDX-License-Identifier: MIT
"""`pixstep line make`, `pixstep line check`, `pixstep ticks`: from a profile to planned edges."""

import functools
import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import click

from pixstep import atomic, formats
from pixstep.board import boards
from pixstep.board.limits import named
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
    PixelsType,
    WholeHzType,
    scale_of,
    whole_limit,
)
from pixstep.errors import RefusedError, UserError
from pixstep.lines import linecheck, planner, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import hz_text
from pixstep.profiles import generator, madefor

MOST_PIXELS = 2_000_000  # what a file can hold


@command("make")
@click.option("--profile", "prn", type=FILE, required=True, help="Acceleration profile, PRN.")
@click.option(
    "--speed",
    type=SPEED_TYPE,
    required=True,
    help="Constant speed: 1000 (steps/pixel, even), 30000steps/s or 12mm/s.",
)
@click.option(
    "--pixels",
    type=PixelsType(most=MOST_PIXELS),
    required=True,
    help="Length of the whole line, pixels.",
)
@pixel_hz_option
@backlash_option
@click.option("--lead-in", type=PixelsType(), default=0, help="Constant pixels before the image.")
@click.option("--decode", type=DECODE, help="What the motor is.  [default: smooth]")
@click.option("--plain", is_flag=True, hidden=True)  # an older spelling of --decode plain
@click.option("--negative/--no-negative", help="Plain lines: negative counts.")
@click.option("--lenient", is_flag=True, help="Accept LF and a missing final newline in the PRN.")
@click.option("--jerk-warn", type=JERK_TYPE, help="Warn of larger acceleration changes.")
@click.option("--header", "name", metavar="NAME", help="Write the 40-column header, named NAME.")
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write.")
@json_option
@click.pass_context
def line_make(ctx, prn, speed, pixels, pixel_hz, backlash, lead_in, output, as_json, **options):
    """Make a line from an acceleration profile: up, constant speed, down.

    Exit status 1 if the line is written but its acceleration changes by more than --jerk-warn.
    """
    plain = options["plain"] or options["decode"] == PLAIN
    if options["plain"] and options["decode"] == SMOOTH:
        raise UserError("--plain and --decode smooth contradict each other")
    speeds, notes = formats.read_prn(prn, lenient=options["lenient"])
    say([*notes, *madefor.notes(prn, None, pixel_hz, refuse=True)])
    speed = units.whole_speed(speed, pixel_hz, scale_of(ctx), smooth=not plain)
    jerk_warn = whole_limit(options["jerk_warn"], pixel_hz, least=0)
    request = generator.LineRequest(speed, pixels, backlash, lead_in, plain)
    made = generator.generate(speeds, request, str(prn))
    sign = -1 if plain and options["negative"] else 1
    counts = [sign * count for count in made.counts]
    formats.write_csv(output, counts, _header(options["name"], lead_in, pixel_hz))
    steps = sum(made.counts) + backlash
    rate = float(speed * pixel_hz)
    facts = {
        "file": str(output),
        "pixels": len(made.counts),
        "accelerating_pixels": made.accelerating_pixels,
        "image_pixel": made.image_pixel,
        "steps": steps,
        "backlash_steps": backlash,
        "speed_steps_s": rate,
        "pixel_hz": hz_text(pixel_hz),
    }
    text = (
        f"{output}: {len(made.counts)} pixels, {made.accelerating_pixels} accelerating, image from "
        f"pixel {made.image_pixel}, {steps} steps with backlash {backlash}, "
        f"{rate:g} steps/s at {float(pixel_hz):g} Hz"
    )
    deliver_facts(facts, text, output, as_json=as_json)
    if jerk_warn is not None and not plain:
        ctx.exit(_warn_of_jerk(made, speed, jerk_warn))


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
    ctx, csv, decode, backlash, raw, lenient, line_number, pixel_hz, board, axes, as_json, **limits
):
    """Check a line of a CSV or CSB file, and the file's form as `file check` does.

    Exit status 0 fine, 1 warnings, 3 refused.
    """
    checked = load_line(
        csv,
        decode,
        backlash,
        raw=raw,
        number=line_number,
        read=functools.partial(_read_strictly, lenient=lenient),
        pixel_hz=pixel_hz,
        refuse_faster=True,
    )
    if axes > boards.load(board).axes:
        raise UserError(f"--axes {axes}: {boards.axes_text(board)}")
    of_board = linecheck.Limits()
    if pixel_hz:
        of_board = named(board, pixel_hz, axes=axes).of(checked)
    bounds = replace(
        of_board,
        max_speed=whole_limit(limits["max_speed"], pixel_hz),
        max_acceleration=whole_limit(limits["max_acceleration"], pixel_hz),
        start_stop=whole_limit(limits["start_stop"], pixel_hz),
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
@backlash_option
@raw_option
@line_option
@clock_option
@click.option("--timer-hz", type=WholeHzType(), help="Ticks a second.  [default: the board's]")
@click.option("--pixels", is_flag=True, help="Pixel edges and expected positions instead.")
@click.option("-o", "--output", type=OUTPUT, required=True, help="CSV file to write.")
@json_option
def ticks(csv, decode, pixel_hz, backlash, board, timer_hz, pixels, output, as_json, **options):
    """Plan the edges of a line of a CSV or CSB with the native build of the firmware's core."""
    chosen = load_line(
        csv,
        decode,
        backlash,
        raw=options["raw"],
        number=options["line_number"],
        pixel_hz=pixel_hz,
    )
    tick_hz = timer_hz or boards.load(board).tick_hz
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


def _warn_of_jerk(made: generator.GeneratedLine, speed: int, limit: int) -> int:
    """Say where the acceleration changes by more than `limit`; return the exit status."""
    found = linecheck.check(Line(tuple(made.counts)), linecheck.Limits(jerk_warning=limit))
    jerks = [item for item in found if item.name == "jerk"]
    rising = [item for item in jerks if item.pixel <= len(made.counts) // 2]
    for item in rising:
        click.echo(f"warning: pixel {item.pixel}: {item.message}, above {limit}", err=True)
    if rising:
        click.echo(
            f"warning: a profile made for this speed keeps the limit: "
            f"pixstep profile make --top-speed {speed} --max-jerk {limit} ...",
            err=True,
        )
    return int(bool(rising))


def _header(name: str | None, lead_in: int, hz: Fraction) -> formats.ProfileHeader | None:
    """Return a header stamped now, if one is wanted."""
    if name is None:
        return None
    if len(name) > 20:
        raise UserError(f"header name {name!r} is longer than 20 characters")
    frequency = f"{float(hz):.10g}"
    return formats.ProfileHeader(time.ctime(), name, 1, 0, lead_in, frequency)
