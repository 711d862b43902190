# SPDX-License-Identifier: MIT
"""Files of profiles and lines from one format to another."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from pixstep import arguments, formats
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.shown import Facts, Shown, count
from pixstep.api.words import Decode, FileKind
from pixstep.errors import UserError
from pixstep.formats import convert
from pixstep.formats.convert import Conversion, HeaderChanges
from pixstep.formats.files import KINDS
from pixstep.formats.header import MOST_HAPS, MOST_LEAD_IN
from pixstep.lines.line import PLAIN


@dataclass(frozen=True, repr=False)
class Converted(Shown):
    """A file that `convert_file` has written."""

    path: Path
    """The file."""
    kind: str
    """Its format: `"prn"`, `"csv"` or `"csb"`."""
    lines: int
    """Lines or profiles in it."""
    values: int
    """Numbers in it, of all lines."""
    notes: tuple[str, ...]
    """What was tolerated, and what is different from the source."""

    def _headline(self) -> str:
        lines = f"{count(self.lines, 'line')}, " if self.lines > 1 else ""
        return f"{self.path}: {self.kind}, {lines}{count(self.values, 'value')}"

    def _facts(self) -> Facts:
        yield from (("note", note) for note in self.notes)


def convert_file(
    source: str | PathLike[str],
    target: str | PathLike[str],
    *,
    to: FileKind | None = None,
    decode: Decode | None = None,
    number: int | None = None,
    drop_header: bool = False,
    header: str | None = None,
    pixel_hz: Hz | None = None,
    haps: int | None = None,
    lead_in: int | None = None,
    lenient: bool = False,
    raw: bool = False,
) -> Converted:
    """Write a PRN, CSV or CSB file in another format; an existing target is replaced.

    The format is `to`, by default as the target's name says. Nothing is lost and no meaning is
    changed without being told to: `decode="plain"` says that the numbers of a PRN are counts as
    those of a CSV are, `number` takes one line of several, `drop_header` leaves the header out.
    `header` (a name), `pixel_hz`, `haps` and `lead_in` change the header or, the first two
    together, make one. `lenient` accepts what `pixstep file check --lenient` does, `raw` reads
    numbers that look like blocks of lines as one line. Raises UserError naming file, line and
    column.
    """
    place, out = arguments.path("source", source), arguments.path("target", target)
    hz = given.exact_hz(pixel_hz)
    changes = HeaderChanges(
        given.maybe(arguments.text, "header", header),
        given.maybe(arguments.whole, "haps", haps, 0, MOST_HAPS),
        given.maybe(arguments.whole, "lead_in", lead_in, 0, MOST_LEAD_IN),
        None if hz is None else formats.hz_text(hz),
    )
    request = Conversion(
        _kind(out, to),
        given.maybe(arguments.whole, "number", number, 1),
        plain=decode is not None and given.decode(decode, None) == PLAIN,
        drop_header=arguments.flag("drop_header", drop_header),
        changes=changes,
    )
    read = formats.read_any(
        place, lenient=arguments.flag("lenient", lenient), raw=arguments.flag("raw", raw)
    )
    with given.number_for_line():
        written = convert.write(read, place, out, request)
    notes = (*read.notes, *written.notes)
    return Converted(out, request.to, written.lines, written.values, notes)


def _kind(target: Path, to: str | None) -> str:
    """Return the format of the target; a name that says another one is refused."""
    named = target.suffix.lower().removeprefix(".")
    if to is None:
        if named not in KINDS:
            raise UserError(f"target {target}: which format? to prn, csv or csb")
        return named
    kind = arguments.one_of("to", to, KINDS)
    if named in KINDS and named != kind:
        raise UserError(f"target {target}: its name says {named}, to says {kind}")
    return kind
