# SPDX-License-Identifier: MIT
"""What README.md shows of docs/TIMING.md: the table of rates and the comparison's picture.

Both are read from the document, which `bench --write` writes: no figure is typed a second time.
What is guaranteed stands in front of each highest clean figure.
"""

import math
import re
from collections.abc import Iterable
from fractions import Fraction

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import PlainError
from pixstep_dev import guaranteed
from pixstep_dev.markdown import table

_TIMING = "docs/TIMING.md"
_HZ = ("30", "100")
_MOTIONS = ("constant", "smooth")
_STEPS = "20"  # a pixel, of the highest clocks
_OURS, _OTHERS = "#1f5f8b", "#9aa5ad"
_WIDTH, _NAME, _BAR = 860, 130, 16
_NOTE = re.compile(r"\((.*)\)")
Row = dict[str, str]


def rates() -> str:
    """Return the table: board, axes at once, rates at two clocks, highest clocks.

    Each cell: what is guaranteed / the highest that ran clean.
    """
    kinds = [f"{motion}, {hz} Hz" for hz in _HZ for motion in _MOTIONS]
    head = ("board", "axes", *kinds, "top clock", "with ramps")
    rows = []
    for board in boards.all_boards():
        for axes in range(1, board.axes + 1):
            cells = [_rate(board.name, axes, motion, hz) for hz in _HZ for motion in _MOTIONS]
            tops = [_clock(board.name, axes, motion) for motion in ("one count", "ramps")]
            rows.append((f"`{board.name}`", str(axes), *cells, *tops))
    return table(head, rows)


def _rate(board: str, axes: int, motion: str, hz: str) -> str:
    """Return what is guaranteed of a motion, and its highest clean rate."""
    promised = guaranteed.rate(board, axes, motion, Fraction(hz))
    return f"{promised:,} / {_number(_rates(board, axes, motion, hz))}"


def _clock(board: str, axes: int, motion: str) -> str:
    """Return the clock that is guaranteed, and the highest clean one."""
    clean = _clocks(board, axes, motion)
    if not clean:
        return "-"
    ours = {"one count": "constant", "ramps": "ramp"}[motion]
    promised = guaranteed.clock(board, axes, ours, int(_STEPS), int(clean))
    return f"{promised:,} / {_number(clean)} Hz"


def _rates(board: str, axes: int, motion: str, hz: str) -> str:
    """Return the highest clean rate of a motion, steps/s on each axis."""
    for row in _rows("Highest clean rate, steps/s on each of the axes at once"):
        if (row["board"], row["axes"], row["motion"], row["pixel clock, Hz"]) == (
            board, str(axes), motion, hz,
        ):  # fmt: skip
            return row["steps/s"]
    raise PlainError(f"{_TIMING}: no rate of {board}, {axes} axes, {motion}, {hz} Hz")


def _clocks(board: str, axes: int, motion: str) -> str:
    """Return the highest clean pixel clock, Hz; "" where none was measured for so many axes."""
    for row in _rows("Highest pixel clock for pixels of few steps"):
        if (row["board"], row["axes"], row["motion"], row["steps a pixel"]) == (
            board, str(axes), motion, _STEPS,
        ):  # fmt: skip
            return row["pixel clock, Hz"]
    return ""


def _number(text: str) -> str:
    return f"{int(text):,}" if text else "-"


def _rows(heading: str, number: int = 0) -> list[Row]:
    """Return the rows of a table that stands under a heading of docs/TIMING.md."""
    text = natives.source(_TIMING).read_text(encoding="utf-8")
    below = text.partition(f"\n### {heading}\n")[2].partition("\n### ")[0]
    tables = [part for part in below.split("\n\n") if part.startswith("|")]
    if len(tables) <= number:
        raise PlainError(f"{_TIMING}: no table {number} under {heading!r}")
    head, _, *rows = [
        [cell.strip() for cell in row.strip("|").split("|")]
        for row in tables[number].strip().splitlines()
    ]
    return [dict(zip(head, row, strict=True)) for row in rows]


def comparison() -> str:
    """Return the picture: highest rate of one axis, and largest error of a ramp, as SVG bars."""
    heading = "Targets, and what others reach"
    ours = {row["figure"]: row["pixstep"] for row in _rows(heading)}
    others = {row["figure"]: row for row in _rows(heading, 1)}
    parts: list[str] = []
    notes = ["pixstep's error: after removing the mean, half a tick"]
    y = 24
    for title, figure, logarithmic in (
        ("Highest clean rate of one axis on an ATmega328P, steps/s (longer is better)",
         "one axis, constant, highest clean rate (uno)", False),
        ("Largest error of a STEP edge in a ramp to 30,000 steps/s, µs (shorter is better; "
         "logarithmic)",
         "ramp 0 to 30k at 100k steps/s2: edge error max / RMS", True),
    ):  # fmt: skip
        peers = {name: text for name, text in others[figure].items()
                 if name not in ("figure", "unit")}  # fmt: skip
        values = [("pixstep", _first(ours[figure]))]
        values += [(name, _first(text)) for name, text in peers.items()]
        parts.append(f'<text x="10" y="{y}" class="title">{title}</text>')
        parts += _bars(y + 12, values, logarithmic)
        y += 12 + len(values) * (_BAR + 6) + 34
        notes += [f"{name}: {found[1]}" for name, text in peers.items()
                  if (found := _NOTE.search(text))]  # fmt: skip
    parts += [f'<text x="10" y="{y - 14}" class="small">{"; ".join(notes)}.</text>']
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {y}" '
            f'width="{_WIDTH}" height="{y}" role="img">',
            "<title>pixstep beside other step generators for AVR</title>",
            "<style>text{font:13px 'DejaVu Sans',Verdana,sans-serif;fill:#1a1a1a}"
            ".title{font-weight:bold}.small{font-size:11px;fill:#444}</style>",
            '<rect width="100%" height="100%" fill="#ffffff"/>',
            *parts,
            "</svg>\n",
        ]
    )


def _first(text: str) -> float:
    """Return the first figure of a cell: "1,508 / 353" is 1508."""
    return float(text.split()[0].replace(",", ""))


def _bars(y: float, values: Iterable[tuple[str, float]], logarithmic: bool) -> list[str]:
    """Return a bar for each value with its name and figure."""
    known = list(values)
    most, least = max(value for _, value in known), min(value for _, value in known)
    room = _WIDTH - _NAME - 90

    def length(value: float) -> float:
        if logarithmic:
            return room * (0.04 + 0.96 * math.log(value / least) / math.log(most / least))
        return room * value / most

    made = []
    for index, (name, value) in enumerate(known):
        top = y + index * (_BAR + 6)
        colour = _OTHERS if index else _OURS
        wide = length(value)
        made.append(
            f'<text x="{_NAME - 8}" y="{top + 13}" text-anchor="end">{name}</text>'
            f'<rect x="{_NAME}" y="{top}" width="{wide:.1f}" height="{_BAR}" fill="{colour}"/>'
            f'<text x="{_NAME + wide + 6:.1f}" y="{top + 13}">{value:,g}</text>'
        )
    return made
