# SPDX-License-Identifier: MIT
"""`pixstep profile repair`: counts that oscillate, illegal profile speeds."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import click

from pixstep import formats
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import HZ, Facts, json_option, raw_option, say, show_json, teller
from pixstep.cli.quantities import ACCELERATION_TYPE
from pixstep.errors import UserError
from pixstep.lines.units import Quantity
from pixstep.profiles import legal_prn, make, page, readings
from pixstep.profiles.repair import Repair, Wish, repair_counts
from pixstep.profiles.stretches import LINE, START


@command("repair")
@click.argument("file", type=FILE)
@click.option("--max-acceleration", type=ACCELERATION_TYPE,
              help="Largest acceleration of the new ramps, steps/px2 or steps/s2. Default: any.",
              )  # fmt: skip
@click.option("--part", type=click.Choice([LINE, START]),
              help="A line from rest to rest, or an accelerating start that goes on at its last "
              "speed. Default: start after a profile's header, else line.")  # fmt: skip
@click.option("--insert", is_flag=True,
              help="Insert pixels instead of taking them from the constant ones: longer.",
              )  # fmt: skip
@raw_option
@click.option("--lenient", is_flag=True, help="Accept LF and a missing final newline in a PRN.")
@click.option("--pixel-hz", type=HZ, help="Pixel frequency, for a limit per second.")
@click.option("-o", "--output", type=OUTPUT, required=True, help="File to write.")
@json_option
def profile_repair(
    file: Path,
    max_acceleration: Quantity | None,
    part: str | None,
    insert: bool,
    raw: bool,
    lenient: bool,
    pixel_hz: Fraction | None,
    output: Path,
    as_json: bool,
) -> None:
    """Repair a file for a smooth motor: counts that oscillate, or the speeds of a PRN.

    Counts keep their length: ramps take pixels from the stretches of constant speed. A PRN gets
    the nearest speeds that are even, above 0 and never fall.
    """
    read = readings.load(file, raw=raw, lenient=lenient)
    say(read.notes)
    if read.is_prn:
        _refuse_for_prn(file, max_acceleration, part, insert=insert)
        repair, part = legal_prn.repair_speeds(read.values), None
        formats.write_prn(output, list(repair.values))
    else:
        part = part or (START if read.header else LINE)
        repair = _repair(file, read.values, Wish(_limit(max_acceleration, pixel_hz), part, insert))
        header = replace(read.header, lines=1) if read.header else None
        formats.write_csv(output, list(repair.values), header)
    if as_json:
        show_json(_report(file, output, part, read.values, repair))
    else:
        _print(file, output, part, read.values, repair)


def _limit(quantity: Quantity | None, hz: Fraction | None) -> int | None:
    """Return the limit as an even number."""
    if quantity is None:
        return None
    return make.legal_limit(quantity.per_pixel(hz), quantity.order, hz, quantity)


def _refuse_for_prn(file: Path, limit: Quantity | None, part: str | None, *, insert: bool) -> None:
    """Refuse options that mean nothing for the speeds of a PRN."""
    for name, given in (("--max-acceleration", limit), ("--part", part), ("--insert", insert)):
        if given:
            raise UserError(f"{file}: {name} is for counts; `profile make` keeps limits of a PRN")


def _repair(file: Path, counts: tuple[int, ...], wish: Wish) -> Repair:
    """Repair counts; an error names the file."""
    try:
        return repair_counts(counts, wish)
    except UserError as error:
        raise UserError(f"{file}: {error}") from None


def _report(
    file: Path, output: Path, part: str | None, before: tuple[int, ...], repair: Repair
) -> Facts:
    """Return the repair as plain data."""
    return {
        "file": str(file),
        "output": str(output),
        "part": part,
        "changes": page.changes_json(repair.changes),
        "values_before": list(before),
        "values": list(repair.values),
    }


def _print(
    file: Path, output: Path, part: str | None, before: tuple[int, ...], repair: Repair
) -> None:
    """Print what was changed and why."""
    tell = teller(output)
    kinds = {LINE: "a line from rest to rest", START: "an accelerating start", None: "PRN speeds"}
    place = "entry" if part is None else "pixel"
    tell(f"{file}: read as {kinds[part]}")
    for text in page.first_lines([page.change_text(change, place) for change in repair.changes]):
        tell(f"  {text}")
    if not repair.changes:
        tell("  nothing to repair")
    length = f"{len(before)} -> {len(repair.values)}" if len(before) != len(repair.values) else (
        f"{len(before)}"
    )  # fmt: skip
    if part is None:
        tell(f"{output}: {length} entries")
    else:
        tell(f"{output}: {length} pixels, {sum(before)} -> {sum(repair.values)} steps")
