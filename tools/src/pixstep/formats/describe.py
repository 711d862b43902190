# SPDX-License-Identifier: MIT
"""What is in a file, as a table of words and as JSON, and what its numbers mean.

What the numbers and header fields mean depends on the file and on the motor.
"""

import hashlib
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep.formats.files import NAMES, Examined, examine
from pixstep.formats.findings import LENIENT, counted
from pixstep.formats.motion import (
    BARE,
    BLOCKS,
    CSB_KIND,
    CSV_KIND,
    RAW,
    FileBlock,
    MotionFile,
    could_be_blocks,
)
from pixstep.formats.records import PRN_KIND, PrnFile

_STEPS = "steps moved in the pixel"

# kind: meaning for a smooth motor (M39), for a plain one (all others)
VALUES = {
    PRN_KIND: ("speed at the end of the pixel, steps/pixel", f"{_STEPS}, which is its speed"),
    CSV_KIND: (_STEPS, _STEPS),
    CSB_KIND: (_STEPS, _STEPS),
}

FIELDS = {
    "timestamp": "when the file was written",
    "name": "profile name",
    "Lines": "lines in the file",
    "HAPs": "homing acceleration pixels: leading entries usable in homing",
    "LeadIn": "constant-speed pixels before the first image pixel; 0: as configured",
    "Pixel Frequency": "pixel clock, Hz",
    "Backlash": "steps of play that the lines of a smooth motor were made for",
}


class LineFigures(TypedDict):
    """Figures of one line as plain data; the steps of a PRN's depend on the motor."""

    line: int
    values: int
    announced: int
    minimum: int
    maximum: int
    steps: NotRequired[int]
    steps_smooth: NotRequired[int | None]
    steps_plain: NotRequired[int]


def smooth_steps(speeds: tuple[int, ...]) -> int | None:
    """Return the steps that a smooth motor makes along a PRN; None if a speed is odd."""
    if any(speed % 2 for speed in speeds):
        return None
    return sum((start + end) // 2 for start, end in zip((0, *speeds[:-1]), speeds, strict=True))


def line_figures(number: int, block: FileBlock) -> LineFigures:
    """Return the figures of one line: number of values, extremes, steps in both directions."""
    return {
        "line": number,
        "values": len(block.values),
        "announced": block.declared,
        "minimum": min(block.values),
        "maximum": max(block.values),
        "steps": sum(abs(value) for value in block.values),
    }


_LINES_SHOWN = 20

_READINGS = {
    BARE: "no header: every row is a value",
    BLOCKS: "numbered blocks: line number, number of values, values",
    RAW: "raw: every row after the header is a value",
}


class HeaderField(TypedDict):
    """A field of a file's header."""

    value: str | int
    meaning: str


class Meanings(TypedDict):
    """What a file's values are for each kind of motor."""

    smooth: str
    plain: str


class Content(TypedDict):
    """What depends on the kind of a file."""

    line_ends: str | None
    header: dict[str, HeaderField] | None
    reading: str | None
    lines: list[LineFigures]
    other_readings: list[str]


class Description(Content):
    """What is in a file, as plain data."""

    file: str
    kind: str
    why: str
    bytes: int
    sha256: str
    values_mean: Meanings
    notes: list[str]


def describe(path: Path, *, raw: bool = False) -> Description:
    """Return what is in a file that at least a lenient reader takes.

    A CSV or CSB whose rows are no numbered blocks is described by its raw reading. Raises
    UserError for the first error if there is no reading.
    """
    read = examine(path, LENIENT, raw=raw)
    blocks_refused = None
    if read.findings.refused and not raw:
        again = examine(path, LENIENT, raw=True)
        if not again.findings.refused:
            blocks_refused, read = read.findings.in_order()[0].text(path), again
    file = read.required()
    smooth, plain = VALUES[file.kind]
    content = _profile(file) if isinstance(file, PrnFile) else _motion(file, read, blocks_refused)
    return {
        "file": str(path),
        "kind": file.kind,
        "why": read.why,
        "bytes": len(read.data),
        "sha256": hashlib.sha256(read.data).hexdigest(),
        "values_mean": {"smooth": smooth, "plain": plain},
        **content,
        "notes": list(file.notes),
    }


def table(facts: Description) -> list[tuple[str, str]]:
    """Return the description as rows of a label and its text."""
    rows = [
        ("format", f"{NAMES[facts['kind']]}: {facts['why']}"),
        ("size", f"{facts['bytes']} bytes, sha256 {facts['sha256'][:16]}"),
    ]
    if facts["line_ends"]:
        rows.append(("line ends", facts["line_ends"]))
    for name, field in (facts["header"] or {}).items():
        rows.append((name, f"{field['value']} ({field['meaning']})"))
    mean = facts["values_mean"]
    if mean["smooth"] == mean["plain"]:
        rows.append(("values", f"{mean['smooth']}, whatever the motor"))
    else:
        rows += [("smooth motor", mean["smooth"]), ("plain motor", mean["plain"])]
    if facts["reading"]:
        rows.append(("reading", facts["reading"]))
    rows += _line_rows(facts["lines"])
    rows += [("other reading", text) for text in facts["other_readings"]]
    return rows + [("note", note) for note in facts["notes"]]


def _profile(file: PrnFile) -> Content:
    """Return what only a PRN has: one list, whose steps depend on the motor."""
    figures = line_figures(1, FileBlock(file.values, len(file.values)))
    smooth, plain = smooth_steps(file.values), figures.pop("steps")
    figures["steps_smooth"], figures["steps_plain"] = smooth, plain
    return {
        "line_ends": file.ends.words,
        "header": None,
        "reading": None,
        "lines": [figures],
        "other_readings": [],
    }


def _motion(file: MotionFile, read: Examined, blocks_refused: str | None) -> Content:
    """Return what a CSV or CSB has: header, lines and the readings not taken."""
    header: dict[str, HeaderField] | None = None
    if file.header:
        header = {
            name: {"value": value, "meaning": meaning}
            for (name, meaning), value in zip(
                FIELDS.items(), vars(file.header).values(), strict=True
            )
            if value is not None
        }
    return {
        "line_ends": file.ends.words if read.kind == CSV_KIND else None,
        "header": header,
        "reading": _READINGS[file.reading],
        "lines": [line_figures(number, block) for number, block in enumerate(file.blocks, 1)],
        "other_readings": _other_readings(file, read, blocks_refused),
    }


def _other_readings(file: MotionFile, read: Examined, blocks_refused: str | None) -> list[str]:
    """Say what the rows are by the readings that were not taken."""
    if blocks_refused:
        return [f"numbered blocks: refused: {blocks_refused}"]
    if file.reading == BLOCKS:
        rows = tuple(file.rows)
        _, text = _line_row(line_figures(1, FileBlock(rows, len(rows))))
        return [f"raw (--raw): {text}"]
    if file.reading == RAW:
        blocks = examine(read.path, LENIENT, kinds=(CSV_KIND, CSB_KIND))
        if blocks.findings.refused:
            return [f"numbered blocks: refused: {blocks.findings.in_order()[0].text(read.path)}"]
        return [f"numbered blocks: {counted(len(blocks.required_motion().blocks), 'line')}"]
    if could_be_blocks(file.rows):
        return [f"numbered block without its header: line 1 of {file.rows[1]} values"]
    return []


def _line_rows(lines: list[LineFigures]) -> list[tuple[str, str]]:
    """Return a row a line, and for many their sums."""
    rows = [_line_row(line) for line in lines[:_LINES_SHOWN]]
    if len(lines) > _LINES_SHOWN:
        rows.append(("...", f"{len(lines) - _LINES_SHOWN} more lines (--json lists all)"))
    if len(lines) > 1:
        values, steps = (sum(line[key] for line in lines) for key in ("values", "steps"))
        rows.append(("all lines", f"{len(lines)} lines, {values} values, {steps} steps"))
    return rows


def _line_row(line: LineFigures) -> tuple[str, str]:
    """Return the row of one line's figures."""
    count = counted(line["values"], "value")
    if line["values"] < line["announced"]:
        count = f"{line['values']} of {line['announced']} values (truncated)"
    extremes = f"{line['minimum']} to {line['maximum']}"
    if "steps" in line:
        return f"line {line['line']}", f"{count}, {extremes}, {line['steps']} steps"
    smooth = line["steps_smooth"]
    made = "odd speeds, for no smooth motor" if smooth is None else f"{smooth} steps if smooth"
    return "entries", f"{count}, {extremes}; over all {made}, {line['steps_plain']} if plain"
