# SPDX-License-Identifier: MIT
"""`pixstep line make`: a line from an acceleration profile, or from a speed and an acceleration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click

from pixstep import formats
from pixstep.cli import meantfor
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.machinedefaults import by_machine, in_force
from pixstep.cli.options import (
    DECODE,
    backlash_option,
    deliver_facts,
    json_option,
    pixel_hz_option,
    say,
)
from pixstep.cli.quantities import (
    ACCELERATION_TYPE,
    JERK_TYPE,
    SPEED_TYPE,
    PixelsType,
    StepsType,
    scale_of,
    whole_limit,
)
from pixstep.errors import UserError
from pixstep.lines import linecheck, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.rational import hz_text
from pixstep.profiles import accelerate, generator, madefor
from pixstep.profiles.generator import MOST_PIXELS
from pixstep.profiles.madefor import MOST_EDGES


class _Options(TypedDict):
    prn: Path | None
    max_acceleration: units.Quantity | None
    max_jerk: units.Quantity | None
    pixels: int | None
    length: int | None
    divider: int | None
    decode: str | None
    plain: bool
    negative: bool
    lenient: bool
    jerk_warn: units.Quantity | None
    name: str | None


@command("make")
@click.option("--profile", "prn", type=FILE, help="Acceleration profile, PRN.")
@click.option(
    "--max-acceleration",
    type=ACCELERATION_TYPE,
    help="Instead of a profile: steps/px2, steps/s2 or mm/s2.",
)
@click.option("--max-jerk", type=JERK_TYPE, help="With --max-acceleration: steps/px3 or steps/s3.")
@click.option(
    "--speed",
    type=SPEED_TYPE,
    required=True,
    help="Constant speed: 1000 (steps/pixel, even), 30000steps/s or 12mm/s.",
)
@click.option(
    "--pixels", type=PixelsType(most=MOST_PIXELS), help="Length of the whole line, pixels."
)
@click.option(
    "--length",
    type=StepsType(1),
    help="With --max-acceleration: length of the whole line, steps or 20mm; a short one is slower.",
)
@pixel_hz_option
@click.option(
    "--divider",
    type=click.IntRange(1, MOST_EDGES),
    metavar="M",
    help="Clock edges of a pixel.  [default: 1; with --max-acceleration the fewest that allow it]",
)
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
def line_make(
    ctx: click.Context,
    speed: units.Quantity,
    pixel_hz: Fraction,
    backlash: int,
    lead_in: int,
    output: Path,
    as_json: bool,
    **options: Unpack[_Options],
) -> None:
    """Make a line: up, constant speed, down, by a profile or by an acceleration.

    A pixel has as many edges of the pixel clock as the acceleration needs, or as --divider says; a
    file with more than one gets a header with the frequency of its pixels. Exit status 1 if the
    line is written but its acceleration changes by more than --jerk-warn.
    """
    plain = options["plain"] or options["decode"] == PLAIN
    if options["plain"] and options["decode"] == SMOOTH:
        raise UserError("--plain and --decode smooth contradict each other")
    asked = _Asked(ctx, options, speed, pixel_hz, plain)
    request = generator.LineRequest(0, options["pixels"] or 0, backlash, lead_in, plain)
    acceleration, profile = asked.acceleration(), options["prn"]
    if acceleration is not None:
        line = _of_acceleration(asked, acceleration, request)
    elif profile is not None:
        line = _of_profile(asked, profile, request)
    else:
        raise UserError("a line needs --profile or --max-acceleration")
    made, line_hz = line.made, pixel_hz / line.divider
    jerk_warn = whole_limit(options["jerk_warn"], line_hz, least=0)
    if asked.given("negative") and options["negative"] and not plain:
        say(["counts of a smooth line have no sign: --negative for `sim` and `board upload`"])
    sign = -1 if plain and options["negative"] else 1
    counts = [sign * count for count in made.counts]
    if options["name"] is None:
        header = madefor.of_pixels(output, lead_in, line_hz, line.divider)
    else:
        header = madefor.header(options["name"], lead_in, line_hz)
    formats.write_csv(output, counts, header)
    facts = _facts(output, line, pixel_hz, backlash)
    text = _text(facts, pixel_hz) + _use_text(ctx, line.divider)
    deliver_facts(facts, text, output, as_json=as_json)
    if jerk_warn is not None and not plain:
        ctx.exit(_warn_of_jerk(made, line.speed, jerk_warn))


class _Facts(TypedDict):
    file: str
    pixels: int
    accelerating_pixels: int
    image_pixel: int
    steps: int
    backlash_steps: int
    speed_steps_s: float
    pixel_hz: str
    divider: int


@dataclass(frozen=True)
class _Made:
    """A line, its speed in steps/pixel, the clock edges of its pixels."""

    made: generator.GeneratedLine
    speed: int
    divider: int


@dataclass(frozen=True)
class _Asked:
    """What the command line says, and the machine file where it does not."""

    ctx: click.Context
    options: _Options
    speed: units.Quantity
    clock_hz: Fraction
    plain: bool

    def given(self, name: str) -> bool:
        """True if an option is on the command line, not only in the machine file."""
        return self.ctx.params[name] is not None and not by_machine(self.ctx, name)

    def acceleration(self) -> units.Quantity | None:
        """Return the acceleration that the line is made by; None if a profile makes it."""
        if self.given("prn") and self.given("max_acceleration"):
            raise UserError("--profile and --max-acceleration: a line is made by one of them")
        if self.options["prn"] is None or self.given("max_acceleration"):
            return self.options["max_acceleration"]
        return None

    def length(self) -> int | None:
        """Return the line's length in steps; None if it is one in pixels."""
        if self.given("pixels") and self.given("length"):
            raise UserError("--pixels and --length: a line has one of them")
        if self.options["pixels"] is None and self.options["length"] is None:
            raise UserError("a line needs --pixels or --length")
        return self.options["length"]


def _of_profile(asked: _Asked, profile: Path, request: generator.LineRequest) -> _Made:
    """Make a line by a profile, whose speeds are per pixel."""
    if asked.length() is not None:
        raise UserError("--length: only with --max-acceleration; by a profile --pixels says it")
    if asked.given("max_jerk"):
        raise UserError("--max-jerk: only with --max-acceleration; a profile has its own")
    divider = asked.options["divider"] or 1
    line_hz = asked.clock_hz / divider
    speeds, notes = formats.read_prn(profile, lenient=asked.options["lenient"])
    say([*notes, *meantfor.motor_notes(profile, None)])
    say(madefor.notes(profile, None, line_hz, refuse=True))
    speed = units.whole_speed(asked.speed, line_hz, scale_of(asked.ctx), smooth=not asked.plain)
    made = generator.generate(speeds, replace(request, speed=speed), str(profile))
    return _Made(made, speed, divider)


def _of_acceleration(
    asked: _Asked, acceleration: units.Quantity, request: generator.LineRequest
) -> _Made:
    """Make the shortest ramps within an acceleration, in pixels that allow it."""
    scale = scale_of(asked.ctx)
    jerk = asked.options["max_jerk"]
    wanted = accelerate.Wanted(
        asked.speed.in_steps(scale), acceleration, jerk, asked.clock_hz, asked.plain
    )
    length = asked.length()
    divider = asked.options["divider"] or accelerate.choose_divider(wanted)
    line_hz = asked.clock_hz / divider
    top = units.whole_speed(asked.speed, line_hz, scale, smooth=not asked.plain)
    used = accelerate.note(wanted, divider)
    if length is not None:
        made, speed = accelerate.line_of_length(wanted, top, divider, length, request)
    else:
        speeds = accelerate.speeds(wanted, top, divider)
        made, speed = generator.generate(speeds, replace(request, speed=top)), top
    say([used] if used else [])
    if speed < top:
        second = units.both_text(speed, units.SPEED, line_hz, scale)
        say([f"the length allows a speed of {second}"])
    return _Made(made, speed, divider)


def _facts(output: Path, line: _Made, clock_hz: Fraction, backlash: int) -> _Facts:
    made, line_hz = line.made, clock_hz / line.divider
    return {
        "file": str(output),
        "pixels": len(made.counts),
        "accelerating_pixels": made.accelerating_pixels,
        "image_pixel": made.image_pixel,
        "steps": sum(made.counts) + backlash,
        "backlash_steps": backlash,
        "speed_steps_s": float(line.speed * line_hz),
        "pixel_hz": hz_text(clock_hz),
        "divider": line.divider,
    }


def _text(facts: _Facts, clock_hz: Fraction) -> str:
    return (
        f"{facts['file']}: {facts['pixels']} pixels, {facts['accelerating_pixels']} accelerating, "
        f"image from pixel {facts['image_pixel']}, {facts['steps']} steps with backlash "
        f"{facts['backlash_steps']}, {facts['speed_steps_s']:g} steps/s at {float(clock_hz):g} Hz"
    )


def _use_text(ctx: click.Context, edges: int) -> str:
    """Return where a line of several clock edges a pixel has to be told of them."""
    if edges == 1:
        return ""
    text = f", {edges} clock edges a pixel"
    machine = in_force(ctx)
    if machine is None:
        return f"{text}: --divider {edges} where it is used"
    if machine.clock.divider == edges:
        return f"{text}, as {machine.path} has it"
    return (
        f"{text}: --divider {edges} where it is used, or divider = {edges} in the table [clock] of "
        f"{machine.path}"
    )


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
