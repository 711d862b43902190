# SPDX-License-Identifier: MIT
"""`pixstep file info`, `check` and `convert`: profiles and motion files, PRN, CSV and CSB."""

from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click

from pixstep import atomic, formats
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import (
    DECODE,
    HZ,
    LINE_NUMBER,
    Facts,
    deliver_facts,
    json_option,
    raw_option,
    say,
    show_json,
)
from pixstep.cli.quantities import PixelsType
from pixstep.errors import FINE, NEGATIVE, REFUSED, RefusedError, UserError
from pixstep.formats import prn
from pixstep.formats.convert import HeaderChanges, Request
from pixstep.formats.convert import convert as converted
from pixstep.formats.describe import describe, table
from pixstep.formats.examine import NAMES, Examined, check_name, examine
from pixstep.formats.findings import LENIENT, STRICT, Finding, shown_path
from pixstep.formats.recognise import KINDS
from pixstep.lines.line import PLAIN, SMOOTH

_VERDICTS = {FINE: "fine", NEGATIVE: "accepted with notes", REFUSED: "refused"}
_lenient_option = click.option(
    "--lenient",
    is_flag=True,
    help="Accept LF, a missing final newline, truncated lines, a wrong name; each with a note.",
)


@command("info")
@click.argument("path", metavar="FILE", type=FILE)
@raw_option
@json_option
def info(path: Path, raw: bool, as_json: bool) -> None:
    """Say what is in a file.

    Its format and why, the header in words, lines, values, steps, line ends, the reading taken and
    the one not taken.
    """
    facts = describe(path, raw=raw)
    if as_json:
        show_json(facts)
        return
    click.secho(shown_path(path), bold=True)
    for label, text in table(facts):
        click.echo(f"  {label:<16} {text}")


@command("check")
@click.argument("path", metavar="FILE", type=FILE)
@_lenient_option
@raw_option
@click.option(
    "--decode", type=DECODE, help="smooth: a smooth motor's PRN is even, above 0, never falling."
)
@json_option
@click.pass_context
def check(
    ctx: click.Context, path: Path, lenient: bool, raw: bool, decode: str | None, as_json: bool
) -> None:
    """List everything wrong with a file.

    Every finding is a line `file:line:column: severity: message`. Exit status 0 fine, 1 accepted
    with notes or warnings, 3 refused.
    """
    smooth = decode == SMOOTH
    examined = _examined(path, lenient, raw, smooth)
    findings = examined.findings.in_order()
    refused = examined.findings.refused
    status = REFUSED if refused else NEGATIVE if findings else FINE
    verdict = _VERDICTS[status]
    helps = refused and not lenient and not _examined(path, True, raw, smooth).findings.refused
    if as_json:
        show_json(_report(examined, findings, verdict))
    else:
        for item in findings:
            place = f"{shown_path(path)}:{item.line}:{item.column}"
            click.echo(f"{place}: {_severity(item)}: {item.message}")
        what = NAMES[examined.kind] if examined.kind else "unknown format"
        hint = " (--lenient accepts it)" if helps else ""
        click.echo(f"{shown_path(path)}: {verdict}: {what}{hint}")
    ctx.exit(status)


class _Options(TypedDict):
    line: int | None
    decode: str | None
    drop_header: bool
    name: str | None
    haps: int | None
    lead_in: int | None
    pixel_hz: Fraction | None
    date: str | None


@command("convert")
@click.argument("source", metavar="IN", type=FILE)
@click.argument("target", metavar="OUT", type=OUTPUT)
@click.option("--to", type=click.Choice(KINDS), help="Format.  [default: by the name of OUT]")
@click.option("--line", type=LINE_NUMBER, metavar="N", help="Only line N of many.")
@click.option(
    "--decode", type=DECODE, help="plain: the numbers of a PRN are counts, as those of a CSV are."
)
@click.option("--drop-header", is_flag=True, help="The header may be lost.")
@click.option("--header", "name", metavar="NAME", help="Profile name, at most 20 characters.")
@click.option("--haps", type=click.IntRange(0, 9999), help="Entries usable in homing.")
@click.option("--lead-in", type=PixelsType(0, 999_999), help="Constant pixels before image.")
@click.option("--pixel-hz", type=HZ, help="Pixel frequency: 30, 29.97 or 30000/1001.")
@click.option("--date", metavar="CTIME", help="As 'Mon Oct 12 15:13:35 2009'.  [default: now]")
@_lenient_option
@raw_option
@json_option
def convert(
    source: Path,
    target: Path,
    to: str | None,
    lenient: bool,
    raw: bool,
    as_json: bool,
    **options: Unpack[_Options],
) -> None:
    """Write a file in another format.

    Nothing is lost and no meaning is changed without being told to; text is written with CR LF.
    Header options change the header of IN or, with --header and --pixel-hz, make one; --haps and
    --lead-in are then 0 unless given.
    """
    kind = _target_kind(target, to)
    read = _read(source, lenient, raw)
    made, notes = _converted(source, read, kind, options)
    data = formats.encode(made, target)
    atomic.write_bytes(target, data)
    say([*read.notes, *(f"{shown_path(source)}: {note}" for note in notes)])
    lines = (
        [made.values]
        if isinstance(made, formats.PrnFile)
        else [block.values for block in made.blocks]
    )
    count = f"{len(lines)} lines, " if len(lines) > 1 else ""
    values = sum(len(values) for values in lines)
    told = f"{shown_path(target)}: {NAMES[kind]}, {count}{values} values, {len(data)} bytes"
    facts = {
        "file": str(target),
        "kind": kind,
        "lines": len(lines),
        "values": values,
        "bytes": len(data),
    }
    deliver_facts(facts, told, target, as_json=as_json)


def _examined(path: Path, lenient: bool, raw: bool, smooth: bool) -> Examined:
    """Read a file and look at its name, too."""
    examined = examine(path, LENIENT if lenient else STRICT, raw=raw)
    check_name(examined)
    if smooth and examined.kind in NAMES and examined.kind != prn.KIND:
        raise UserError(
            f"{shown_path(path)}: --decode smooth is for PRN profiles, this is a "
            f"{NAMES[examined.kind]}: `pixstep line check` checks lines"
        )
    if smooth and not examined.findings.refused:
        prn.check_smooth(examined.required().values, examined.findings)
    return examined


def _report(examined: Examined, findings: list[Finding], verdict: str) -> Facts:
    """Return the outcome of a check for JSON."""
    return {
        "file": str(examined.path),
        "kind": examined.kind,
        "why": examined.why,
        "verdict": verdict,
        "findings": [vars(item) for item in findings],
    }


def _severity(item: Finding) -> str:
    """Return the severity, coloured on a terminal."""
    colour = {"error": "red", "warning": "yellow"}.get(item.severity)
    return click.style(item.severity, fg=colour)


def _target_kind(target: Path, to: str | None) -> str:
    """Return the format of the output; a name that says another one is refused."""
    named = target.suffix.lower().removeprefix(".")
    if to is None and named not in KINDS:
        raise UserError(f"{shown_path(target)}: which format? --to prn, csv or csb")
    if to is not None and named in KINDS and named != to:
        raise UserError(f"{shown_path(target)}: --to {to} contradicts the name")
    return to or named


def _read(source: Path, lenient: bool, raw: bool) -> formats.PrnFile | formats.MotionFile:
    """Read the input; a refusal that --lenient would lift says so."""
    try:
        return formats.read_any(source, lenient=lenient, raw=raw)
    except UserError as error:
        if lenient or examine(source, LENIENT, raw=raw).findings.refused:
            raise
        raise RefusedError(f"{error} (--lenient accepts it)") from None


def _converted(
    source: Path, read: formats.PrnFile | formats.MotionFile, kind: str, options: _Options
) -> tuple[formats.PrnFile | formats.MotionFile, tuple[str, ...]]:
    """Convert; a refusal names the input."""
    hz = options["pixel_hz"]
    hz_text = None if hz is None else formats.hz_text(hz)
    changes = HeaderChanges(
        name=options["name"],
        haps=options["haps"],
        lead_in_px=options["lead_in"],
        pixel_hz=hz_text,
        timestamp=options["date"],
    )
    request = Request(
        kind, options["line"], options["decode"] == PLAIN, options["drop_header"], changes
    )
    rounded: tuple[str, ...] = ()
    if hz_text is not None and Fraction(hz_text) != hz:
        rounded = (f"pixel frequency {hz} Hz is written as {hz_text}",)
    try:
        made, notes = converted(read, request)
        return made, notes + rounded
    except UserError as error:
        if str(error).startswith(shown_path(source)):
            raise
        raise UserError(f"{shown_path(source)}: {error}") from None
