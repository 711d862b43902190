# SPDX-License-Identifier: MIT
"""CSV and CSB: counts of one or many lines, bare or in numbered blocks after a header.

Both formats hold the same rows of integers. Three readings of them: `bare`, without a header,
every row is a value; `blocks`, after a header, rows are line number, number of values, values, and
again for the next line; `raw`, after a header, every row is a value of one line.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pixstep.errors import UserError
from pixstep.formats.findings import Findings, counted, shown_path
from pixstep.formats.header import ProfileHeader, place_in_csb
from pixstep.formats.records import REGULAR, LineEnds

CSV_KIND = "csv"
CSB_KIND = "csb"

BARE = "bare"
BLOCKS = "blocks"
RAW = "raw"

RowPlace = Callable[[int], tuple[int, int]]


@dataclass(frozen=True)
class Block:
    """One line: its values (steps in each pixel), the number that the file announces."""

    values: tuple[int, ...]
    declared: int

    @property
    def truncated(self) -> bool:
        """True if the file ends before the announced number of values."""
        return len(self.values) < self.declared


@dataclass(frozen=True)
class MotionFile:
    """What a CSV or CSB holds, all that is needed to write the same bytes, what was tolerated."""

    blocks: tuple[Block, ...]  # line 1, 2, ...
    header: ProfileHeader | None = None
    reading: str = BARE
    kind: str = CSV_KIND
    ends: LineEnds = REGULAR
    notes: tuple[str, ...] = ()
    path: str = "file"

    @property
    def values(self) -> tuple[int, ...]:
        """The values of the only line; UserError if the file holds several."""
        return self.line().values

    @property
    def rows(self) -> list[int]:
        """Every integer of the data in the order of the file."""
        if self.reading != BLOCKS:
            return list(self.blocks[0].values)
        rows: list[int] = []
        for number, block in enumerate(self.blocks, 1):
            rows += (number, block.declared, *block.values)
        return rows

    def line(self, number: int | None = None) -> Block:
        """Return a line by its number from 1; None stands for the only one there is."""
        count = len(self.blocks)
        line, column = self.header.lines_place if self.header else (1, 1)
        if self.kind == CSB_KIND and self.header:
            line, column = place_in_csb(line, column)
        where = f"{shown_path(self.path)}:{line}:{column}"
        if number is None and count > 1:
            raise UserError(f"{where}: holds {count} lines: choose one by --line 1..{count}")
        if not 1 <= (number or 1) <= count:
            raise UserError(f"{where}: holds {counted(count, 'line')}, there is no line {number}")
        return self.blocks[(number or 1) - 1]


def of_lines(lines: Sequence[Sequence[int]], header: ProfileHeader | None = None) -> MotionFile:
    """Return a file of lines, counts per pixel; more than one need a header."""
    if header is None and len(lines) != 1:
        raise UserError(f"{len(lines)} lines need a header: without one a file holds one line")
    blocks = tuple(Block(tuple(values), len(values)) for values in lines)
    if header is None:
        return MotionFile(blocks)
    return MotionFile(blocks, replace(header, lines=len(lines)), BLOCKS)


def make_file(
    rows: list[int],
    header: ProfileHeader | None,
    *,
    raw: bool,
    place: RowPlace,
    findings: Findings,
) -> MotionFile | None:
    """Return the lines that rows stand for; None if they are refused. `place`: row to position."""
    if not rows:
        findings.error("no_values", *place(0), "no values")
        return None
    if header is None or raw:
        reading = RAW if header else BARE
        blocks: tuple[Block, ...] = (Block(tuple(rows), len(rows)),)
    else:
        reading = BLOCKS
        blocks = _blocks(rows, header, place, findings)
    if header and blocks:
        _check_haps(header, blocks, findings)
    return MotionFile(blocks, header, reading) if blocks else None


def could_be_blocks(rows: Sequence[int]) -> bool:
    """True if rows without a header begin as a numbered block of just their length would."""
    return len(rows) > 2 and rows[0] == 1 and rows[1] == len(rows) - 2


def _blocks(
    rows: list[int], header: ProfileHeader, place: RowPlace, findings: Findings
) -> tuple[Block, ...]:
    """Split rows into numbered blocks; a refused one ends the reading and gives none."""
    blocks: list[Block] = []
    start = 0
    while start < len(rows) and len(blocks) < header.lines:
        block = _block(rows, start, len(blocks) + 1, place, findings)
        if block is None:
            return ()
        blocks.append(block)
        start += 2 + len(block.values)
    if start < len(rows):
        _surplus(len(rows) - start, header, blocks[-1], place(start), findings)
    elif len(blocks) < header.lines:
        missing = f"truncated, {len(blocks)} of {header.lines} lines"
        tolerated = findings.rules.truncated
        findings.quirk("truncated", tolerated, header.lines_place, (missing, missing))
    return tuple(blocks)


def _block(
    rows: list[int], start: int, number: int, place: RowPlace, findings: Findings
) -> Block | None:
    """Return the block that begins at a row, or None if it is refused."""
    if rows[start] != number:
        message = f"line number {rows[start]}, {number} expected (--raw takes every row as a value)"
        findings.error("line_number", *place(start), message)
        return None
    if start + 1 == len(rows):
        message = f"truncated: line number {number} without its number of values"
        findings.error("truncated", *place(start), message)
        return None
    declared = rows[start + 1]
    if declared < 1:
        message = f"number of values {declared}, at least 1 expected"
        findings.error("value_count", *place(start + 1), message)
        return None
    values = rows[start + 2 : start + 2 + declared]
    if len(values) < declared:
        text = f"truncated, {len(values)} of {declared} values"
        hint = f"{text} of line {number} (--raw takes every row as a value)"
        tolerated = findings.rules.truncated and bool(values)
        findings.quirk("truncated", tolerated, place(start + 1), (f"{text} of line {number}", hint))
        if not values:
            return None
    return Block(tuple(values), declared)


def _surplus(
    rows_left: int, header: ProfileHeader, last: Block, where: tuple[int, int], findings: Findings
) -> None:
    """Refuse rows after the last announced line."""
    message = (
        f"{counted(rows_left, 'row')} more than the {counted(last.declared, 'value')} announced "
        f"for line {header.lines}, the last by the header"
    )
    findings.error("surplus", *where, message)


def _check_haps(header: ProfileHeader, blocks: tuple[Block, ...], findings: Findings) -> None:
    """Warn if more entries are usable in homing than there are."""
    fewest = min(len(block.values) for block in blocks)
    if header.haps > fewest:
        message = f"HAPs {header.haps} are more than the {counted(fewest, 'value')} of a line"
        findings.warning("haps", *header.haps_place, message)
