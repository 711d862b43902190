# SPDX-License-Identifier: MIT
"""CSV: counts right-aligned in 6 columns, a minus sign legal, bare or after the header."""

import re
from dataclasses import replace
from itertools import islice
from pathlib import Path

from pixstep.formats.findings import Findings
from pixstep.formats.header import HEADER_LINES, HEADER_WIDTH, check_header, parse_header
from pixstep.formats.motion import MotionFile, make_file
from pixstep.formats.numbers import CSV_COLUMNS, number_texts, read_numbers
from pixstep.formats.records import check_line_ends, find_line_ends, join_records, split_records

_WORD = re.compile(rb"[A-Za-z]{3}")


def has_header(data: bytes) -> bool:
    """True if the first record is a header line, whole or damaged: 40 columns, or words."""
    first = next(split_records(data), b"")
    return len(first) == HEADER_WIDTH or bool(_WORD.search(first))


def parse_csv(data: bytes, findings: Findings, *, raw: bool = False) -> MotionFile | None:
    """Read a CSV; the result is right only if nothing is refused."""
    check_line_ends(data, findings)
    rows = split_records(data)
    header, first, before = None, 1, len(findings.found)
    if has_header(data):
        header = parse_header(list(islice(rows, HEADER_LINES)), findings)
        first += HEADER_LINES
    values = read_numbers(rows, CSV_COLUMNS, findings, first)
    if findings.refused_since(before):
        return None

    def place(row: int) -> tuple[int, int]:
        if not values:
            return HEADER_LINES, HEADER_WIDTH + 1
        return first + row, CSV_COLUMNS.column(values[row])

    made = make_file(values, header, raw=raw, place=place, findings=findings)
    return made and replace(made, ends=find_line_ends(data))


def encode_csv(file: MotionFile, path: Path | str) -> bytes:
    """Return the bytes of a CSV. Raises UserError for a value or a header that does not fit."""
    rows = []
    if file.header:
        check_header(file.header, path)
        rows = file.header.rows
    texts = number_texts(file.rows, CSV_COLUMNS, path, len(rows) + 1)
    return join_records([*rows, *texts], file.ends)
