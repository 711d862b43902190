# SPDX-License-Identifier: MIT
"""`pixstep profile make`: the shortest profile within limits, as PRN and as CSV."""

import time
from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click

from pixstep import atomic, formats
from pixstep.cli.command import OUTPUT, OUTPUT_OR_FOLDER, command, refuse_outputs
from pixstep.cli.options import DECODE, HZ, json_option, say, show_json, teller
from pixstep.cli.quantities import ACCELERATION_TYPE, JERK_TYPE, SPEED_TYPE, PixelsType
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import ACCELERATION, JERK, SPEED, Quantity
from pixstep.profiles import generator, kinematics, make, names, page
from pixstep.profiles.repair import whole_line
from pixstep.profiles.stretches import START


class _Options(TypedDict):
    motor: str | None
    variant: str | None
    csv: Path | None
    decode: str | None
    name: str | None
    haps: int | None
    lead_in: int


@command("make")
@click.option("--top-speed", type=SPEED_TYPE, required=True,
              help="Speed at the end, even: 1000, 1000steps/px or 30000steps/s.")  # fmt: skip
@click.option("--max-acceleration", type=ACCELERATION_TYPE, required=True,
              help="128, 128steps/px2 or 115200steps/s2.")  # fmt: skip
@click.option("--max-jerk", type=JERK_TYPE, required=True,
              help="Change of the acceleration from pixel to pixel: steps/px3 or steps/s3.",
              )  # fmt: skip
@click.option("--pixel-hz", type=HZ, help="Pixel frequency, for figures per second and the name.")
@click.option("--motor", metavar="NAME", help="Motor of the conventional name, as M39.")
@click.option("--variant", metavar="TEXT", help="Variant of the conventional name, as 1.")
@click.option("-o", "--output", type=OUTPUT_OR_FOLDER,
              help="PRN to write, or a folder: AccProf<motor>-<f>Hz-<variant>.PRN in it. "
              "Default: that name in the current folder.")  # fmt: skip
@click.option("--csv", type=OUTPUT, help="Write the CSV profile for fast moves and homing too.")
@click.option("--decode", type=DECODE, help="Motor that the CSV is for.  [default: smooth]")
@click.option("--name", metavar="TEXT", help="Name in the CSV's header, up to 20 characters.")
@click.option("--haps", type=click.IntRange(0, 9999),
              help="HAPs of the CSV: entries used in homing. Default: all.")  # fmt: skip
@click.option("--lead-in", type=PixelsType(0, 999_999), default=0, show_default=True,
              help="LeadIn of the CSV: constant pixels before the image.")  # fmt: skip
@json_option
@click.pass_context
def profile_make(
    ctx: click.Context,
    top_speed: Quantity,
    max_acceleration: Quantity,
    max_jerk: Quantity,
    pixel_hz: Fraction | None,
    output: Path | None,
    as_json: bool,
    **options: Unpack[_Options],
) -> None:
    """Make the shortest acceleration profile within limits of acceleration and jerk.

    All speeds are even, and the jerk limit is kept from rest up to the constant speed after the
    last entry.
    """
    limits = make.ProfileLimits(
        make.legal_speed(top_speed.per_pixel(pixel_hz), pixel_hz),
        _legal(max_acceleration, pixel_hz),
        _legal(max_jerk, pixel_hz),
    )
    path = _prn_path(output, pixel_hz, options["motor"], options["variant"])
    speeds = make.shortest_profile(limits)
    csv = options["csv"]
    parts = _csv_parts(options, csv, speeds, pixel_hz)
    csv_outputs = [("--csv", csv)] if csv else []
    refuse_outputs(ctx, [("-o", path), *csv_outputs])
    with atomic.together():
        formats.write_prn(path, speeds)
        if csv and parts:
            formats.write_csv(csv, *parts)
    figures = _figures(speeds)
    if as_json:
        report = {
            "file": str(path),
            "csv": str(csv) if csv else None,
            "limits": {
                "top_speed_steps_per_px": limits.top_speed,
                "max_acceleration_steps_per_px2": limits.max_acceleration,
                "max_jerk_steps_per_px3": limits.max_jerk,
            },
            "figures": page.figures_json(figures, pixel_hz),
            "speeds": speeds,
        }
        show_json(report)
        return
    _print(path, csv, speeds, limits, pixel_hz)


def _legal(limit: Quantity, hz: Fraction | None) -> int:
    """Return a limit as an even whole number; a note says if that is less than was given."""
    given = limit.per_pixel(hz)
    legal = make.legal_limit(given, limit.order, hz, limit)
    if legal != given:
        unit = units.unit(limit.order)
        say([f"limit {units.number_text(given)} {unit}: changes are even, at most {legal} used"])
    return legal


def _prn_path(
    output: Path | None, hz: Fraction | None, motor: str | None, variant: str | None
) -> Path:
    """Return where the PRN goes: the file given, or the conventional name in the folder given."""
    if output is not None and not output.is_dir():
        if motor or variant:
            raise UserError(f"{output}: a file name is given, --motor and --variant have no use")
        return output
    if motor is None or variant is None or hz is None:
        parts = {"--motor": motor, "--variant": variant, "--pixel-hz": hz}
        missing = ", ".join(option for option, value in parts.items() if value is None)
        raise UserError(f"the conventional name needs {missing}; or give a file name with -o")
    return (output or Path()) / names.conventional(motor, hz, variant)


def _csv_parts(
    options: _Options, csv: Path | None, speeds: list[int], hz: Fraction | None
) -> tuple[list[int], formats.ProfileHeader] | None:
    """Return counts and header of the CSV, None if none is wanted.

    The counts end with one pixel of the top speed, so that it is reached under both decode rules.
    """
    if csv is None:
        _refuse_without_csv(options)
        return None
    if hz is None:
        raise UserError(f"{csv}: the header of a CSV profile needs --pixel-hz")
    name = options["name"] or csv.stem
    if len(name) > 20:
        raise UserError(f"header name {name!r} is longer than 20 characters: give --name")
    top = speeds[-1]
    counts = (
        speeds if options["decode"] == PLAIN else [*generator.acceleration_counts(speeds, top), top]
    )
    haps = len(counts) if options["haps"] is None else options["haps"]
    if haps > len(counts):
        raise UserError(f"--haps {haps}: the CSV profile has {len(counts)} entries")
    frequency = f"{float(hz):.10g}"
    return counts, formats.ProfileHeader(time.ctime(), name, 1, haps, options["lead_in"], frequency)


def _refuse_without_csv(options: _Options) -> None:
    """Refuse options that mean nothing without a CSV."""
    for name, given in (
        ("--decode", options["decode"]),
        ("--name", options["name"]),
        ("--haps", options["haps"]),
        ("--lead-in", options["lead_in"]),
    ):
        if given:
            raise UserError(f"{name} is for the CSV profile: give --csv")


def _figures(speeds: list[int]) -> kinematics.Figures:
    """Return the peaks of the line that the profile makes, and the length of the profile."""
    counts = tuple(generator.acceleration_counts(speeds, speeds[-1]))
    whole = kinematics.figures(Line(whole_line(counts, START)))
    return kinematics.Figures(
        len(counts), sum(counts), whole.peak_speed, whole.peak_acceleration, whole.peak_jerk
    )


def _print(
    path: Path, csv: Path | None, speeds: list[int], limits: make.ProfileLimits, hz: Fraction | None
) -> None:
    """Print the page."""
    tell = teller(path if atomic.is_stdout(path) else csv)
    figures = _figures(speeds)
    length = f" = {float(len(speeds) / hz):.6g} s" if hz else ""
    tell(f"{path}: {len(speeds)} pixels{length}, {figures.steps} steps, even speeds")
    for name, order, value, limit in (
        ("top speed", SPEED, figures.peak_speed, limits.top_speed),
        ("acceleration", ACCELERATION, figures.peak_acceleration, limits.max_acceleration),
        ("jerk", JERK, figures.peak_jerk, limits.max_jerk),
    ):
        tell(f"  {name:<13}{units.both_text(value, order, hz)} (limit {limit})")
    if csv:
        tell(f"{csv}: the same as counts, for fast moves and homing")
