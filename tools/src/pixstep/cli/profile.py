# SPDX-License-Identifier: MIT
"""`pixstep profile`: make, check, repair and show acceleration profiles."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Unpack

import click

from pixstep.cli.command import FILE, command
from pixstep.cli.meantfor import motor_decode
from pixstep.cli.options import (
    DECODE,
    HZ,
    Facts,
    json_option,
    plot_option,
    raw_option,
    say,
    show_json,
)
from pixstep.cli.quantities import (
    SPEED_TYPE,
    LimitOptions,
    limit_options,
    scale_if_known,
    scale_of,
    whole_limit,
)
from pixstep.cli.show import drawn_limits, show_drawing, used_frequency
from pixstep.errors import UserError
from pixstep.lines import linecheck, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.operations.result import STATUSES, VERDICTS
from pixstep.profiles import generator, page, readings
from pixstep.profiles.drawing import Drawing

_FORMS = {
    readings.PRN: "PRN speeds",
    readings.BLOCK: "block after the header",
    readings.ROWS: "all rows as values",
}

_REPAIRABLE = {"speed", "oscillates", "reverses_inside_pixel"}


@command("check")
@click.argument("file", type=FILE)
@click.option("--decode", type=DECODE,
              help="What the motor is. Default: by the motor in the name, else both.",
              )  # fmt: skip
@raw_option
@click.option("--lenient", is_flag=True, help="Accept LF and a missing final newline in a PRN.")
@click.option("--pixel-hz", type=HZ, help="Pixel frequency, for limits per second.")
@limit_options
@json_option
@click.pass_context
def profile_check(
    ctx: click.Context,
    file: Path,
    decode: str | None,
    raw: bool,
    lenient: bool,
    as_json: bool,
    pixel_hz: Fraction | None,
    **limits: Unpack[LimitOptions],
) -> None:
    """Check a profile under every reading of its file.

    Exit status 0 fine, 1 warnings or a reading that fails, 3 no reading is sound.
    """
    read = readings.load(file, raw=raw, lenient=lenient)
    say(read.notes)
    hz = used_frequency(ctx, pixel_hz, read.path, read.header)
    bounds = linecheck.Limits(
        max_speed=whole_limit(limits["max_speed"], hz),
        max_acceleration=whole_limit(limits["max_acceleration"], hz),
        jerk_warning=whole_limit(limits["max_jerk"], hz),
    )
    found = readings.check(read, decode or motor_decode(ctx, file), bounds)
    status = readings.exit_status(found)
    if as_json:
        show_json(_check_json(file, found, status))
    else:
        _print_check(file, found, status)
    ctx.exit(STATUSES[status])


@command("show")
@click.argument("file", type=FILE)
@click.option("--decode", type=DECODE,
              help="Default: by the motor in the name, else smooth.")  # fmt: skip
@click.option("--speed", type=SPEED_TYPE, help="Draw the line up to this speed, steps/px.")
@raw_option
@click.option("--lenient", is_flag=True, help="Accept LF and a missing final newline in a PRN.")
@click.option("--pixel-hz", type=HZ, help="Pixel frequency. Default: by the name or the header.")
@limit_options
@plot_option("-o", "--output")
@json_option
@click.pass_context
def profile_show(
    ctx: click.Context,
    file: Path,
    decode: str | None,
    speed: units.Quantity | None,
    raw: bool,
    lenient: bool,
    plot: Path | None,
    as_json: bool,
    pixel_hz: Fraction | None,
    **limits: Unpack[LimitOptions],
) -> None:
    """Show speed, acceleration, jerk and position of a profile: a table, with --plot a drawing."""
    read = readings.load(file, raw=raw, lenient=lenient)
    say(read.notes)
    hz = used_frequency(ctx, pixel_hz, read.path, read.header)
    top = None
    if speed is not None:
        top = units.whole_speed(speed, hz, scale_of(ctx), smooth=decode != PLAIN)
    decode = decode or motor_decode(ctx, file) or SMOOTH
    counts = _counts(read, decode, top)
    line = Line(counts, decode, name=str(file))
    bounds = drawn_limits(limits, hz)
    drawing = Drawing(line, file.name, hz, bounds, scale=scale_if_known(ctx), going_on=True)
    show_drawing(drawing, plot, as_json=as_json)


def _counts(read: readings.ProfileFile, decode: str, speed: int | None) -> tuple[int, ...]:
    """Return the counts that a profile makes, up to `speed` if it is given."""
    values = list(read.values)
    if not read.is_prn:
        if speed is not None:
            raise UserError(f"{read.path}: --speed is for a PRN, a CSV holds counts")
        return read.values
    if decode == PLAIN:
        top = speed or values[-1]
        return (*generator.plain_counts(values, top, str(read.path)), top)
    return tuple(generator.acceleration_counts(values, speed or values[-1], str(read.path)))


def _state(reading: readings.Reading) -> str:
    """Return one word for a reading."""
    if reading.rows.values is None:
        return "unreadable"
    if not reading.sound:
        return "fails"
    return "warnings" if reading.findings else "fine"


def _name(reading: readings.Reading) -> str:
    """Return what a reading takes the file for."""
    if reading.rows.values is None:
        return _FORMS[reading.rows.form]
    size = len(reading.rows.values)
    adopted = "" if reading.rows.adopted else " (not adopted)"
    return f"{_FORMS[reading.rows.form]}, {size}, decoded as {reading.decode}{adopted}"


def _finding_text(item: linecheck.Finding) -> str:
    """Return a finding as a line."""
    where = f"entry {item.pixel}: " if item.pixel else ""
    return f"{where}{item.severity} {item.name}: {item.message}"


def _print_check(path: Path, found: list[readings.Reading], status: int) -> None:
    """Print every reading with its findings, then the verdict."""
    for reading in found:
        click.echo(f"{_name(reading)}: {reading.rows.problem or _state(reading)}")
        items = reading.findings if reading.rows.adopted else ()
        for text in page.first_lines([_finding_text(item) for item in items]):
            click.echo(f"  {text}")
    for text in _advice(found):
        click.echo(text)
    click.echo(f"{path}: {VERDICTS[status]}")


def _advice(found: list[readings.Reading]) -> Iterator[str]:
    """Yield what follows from readings that disagree."""
    adopted = [reading for reading in found if reading.rows.adopted]
    sound = {reading.decode for reading in adopted if reading.sound}
    if len(sound) == 1 and len(adopted) > 1:
        (good,) = sound
        use = "fast moves" if good == PLAIN else "homing and printing"
        yield f"ambiguous: sound only when decoded as {good} ({use})"
    if readings.ambiguous(found):
        yield "ambiguous: the rows fit a block too: line number 1, number of values, values"
    elif not sound and any(reading.sound for reading in found):
        yield "only all rows as values make a profile: --raw reads them so"
    failing = (reading for reading in adopted if reading.decode == SMOOTH and not reading.sound)
    if any(item.name in _REPAIRABLE for reading in failing for item in reading.findings):
        yield "pixstep profile repair proposes values that a smooth motor can follow"


def _check_json(path: Path, found: list[readings.Reading], status: int) -> Facts:
    """Return the readings as plain data."""
    return {
        "file": str(path),
        "verdict": VERDICTS[status],
        "readings": [
            {
                "rows": reading.rows.form,
                "adopted": reading.rows.adopted,
                "decode": reading.decode or None,
                "state": _state(reading),
                "problem": reading.rows.problem or None,
                "findings": linecheck.as_json(list(reading.findings)),
            }
            for reading in found
        ],
        "advice": list(_advice(found)),
    }
