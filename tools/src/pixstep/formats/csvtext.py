# SPDX-License-Identifier: MIT
"""CSV: counts right-aligned in 6 columns, a minus sign legal, bare or after the header."""

import re
from dataclasses import replace
from itertools import islice

from pixstep.formats import header as head
from pixstep.formats import motion, numbers, records
from pixstep.formats.findings import Findings
from pixstep.formats.motion import MotionFile

_WORD = re.compile(rb"[A-Za-z]{3}")


def has_header(data: bytes) -> bool:
    """True if the first record is a header line, whole or damaged: 40 columns, or words."""
    first = next(records.records(data), b"")
    return len(first) == head.WIDTH or bool(_WORD.search(first))


def parse_csv(data: bytes, findings: Findings, *, raw: bool = False) -> MotionFile | None:
    """Read a CSV; the result is right only if nothing is refused."""
    records.check_line_ends(data, findings)
    rows = records.records(data)
    header, first, before = None, 1, len(findings.found)
    if has_header(data):
        header = head.parse_header(list(islice(rows, head.LINES)), findings)
        first += head.LINES
    values = numbers.scan(rows, numbers.CSV, findings, first)
    if findings.refused_since(before):
        return None

    def place(row: int) -> tuple[int, int]:
        if not values:
            return head.LINES, head.WIDTH + 1
        return first + row, numbers.CSV.column(values[row])

    made = motion.make_file(values, header, raw=raw, place=place, findings=findings)
    return made and replace(made, ends=records.line_ends(data))


def encode_csv(file: MotionFile, path: object) -> bytes:
    """Return the bytes of a CSV. Raises UserError for a value or a header that does not fit."""
    rows = []
    if file.header:
        head.check_header(file.header, path)
        rows = file.header.rows
    texts = numbers.texts(file.rows, numbers.CSV, path, len(rows) + 1)
    return records.join([*rows, *texts], file.ends)
