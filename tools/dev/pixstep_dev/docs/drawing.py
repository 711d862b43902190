# SPDX-License-Identifier: MIT
"""Wiring drawings as SVG: blocks with named pins in columns, wires between neighbouring columns.

A drawing says what is connected to what; places follow from that. Each wire has an upright lane of
its own in the gap that it crosses, so that no two wires share a line.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from html import escape

from pixstep.errors import PlainError

_ROW = 26  # px from pin to pin
_HEAD = 44  # px of a block above its first pin
_BELOW = 8  # px from block to block: all rows are on one grid
_LANE = 16  # px from lane to lane
_MARGIN = 20
_FOOT = 20  # px of a line of text under the drawing
_CHAR = 7.8  # px of a character of a pin's name
_TITLE_CHAR = 9.2
_SERIES = 52  # px of a resistor in a wire
_LEFT, _RIGHT = "left", "right"

COLOURS = {
    "step": "#1f5fbf",
    "dir": "#2e8b57",
    "enable": "#c76b00",
    "5v": "#d62728",
    "ground": "#222222",
    "motor": "#8b1a1a",
    "coil": "#7b3fa0",
    "signal": "#0f7f8c",
}

_STYLE = (
    "text{font:13px 'DejaVu Sans',Verdana,sans-serif;fill:#1a1a1a}"
    ".title{font-weight:bold;font-size:14px}.small{font-size:12px;fill:#444}"
)

End = tuple[str, str]  # the title of a block and the name of its pin


@dataclass(frozen=True)
class PinBlock:
    """A part with pins: rows of names on its left and right side; an empty name leaves a row."""

    title: str
    subtitle: str = ""
    left: Sequence[str] = ()
    right: Sequence[str] = ()

    @property
    def rows(self) -> int:
        """The rows of the longer side."""
        return max(len(self.left), len(self.right), 1)

    @property
    def height(self) -> float:
        """The height that its rows need."""
        return _HEAD + self.rows * _ROW

    @property
    def width(self) -> float:
        """The width that titles and names need."""
        names = max(
            sum(len(side[row]) for side in (self.left, self.right) if row < len(side))
            for row in range(self.rows)
        )
        heads = max(_TITLE_CHAR * len(self.title), _CHAR * len(self.subtitle)) + 24
        return max(heads, _CHAR * names + 48)


@dataclass(frozen=True)
class DrawnWire:
    """A wire in one gap, and the pins that it joins."""

    kind: str
    ends: Sequence[End]


@dataclass(frozen=True)
class Series:
    """A resistor or a capacitor in the wire that leaves a pin of the gap's left column."""

    label: str
    end: End


@dataclass(frozen=True)
class Across:
    """A part between two wires of one gap, as a pull-up resistor; both ends are on one side."""

    label: str
    first: End
    second: End


Part = Series | Across


@dataclass(frozen=True)
class Gap:
    """What is between two columns: wires, and parts on them from left to right."""

    wires: Sequence[DrawnWire]
    parts: Sequence[Part] = ()


@dataclass(frozen=True)
class WiringDrawing:
    """Columns of blocks, the gaps between them, and lines of text below.

    With `staggered`, the second column is half a row lower: no two wires meet in one row.
    """

    title: str
    columns: Sequence[Sequence[PinBlock]]
    gaps: Sequence[Gap]
    notes: Sequence[str] = ()
    staggered: bool = False


@dataclass
class _Canvas:
    """What is drawn so far, and where the pins have come to be."""

    pins: dict[tuple[int, str, str, str], tuple[float, float]] = field(default_factory=dict)
    out: list[str] = field(default_factory=list)

    def pin(self, gap: int, end: End) -> tuple[float, float]:
        """Return where a pin is that faces a gap."""
        for key in ((gap, *end, _RIGHT), (gap + 1, *end, _LEFT)):
            if key in self.pins:
                return self.pins[key]
        raise PlainError(f"no pin {end[1]!r} of {end[0]!r} faces gap {gap}")

    def is_left(self, gap: int, end: End) -> bool:
        """True if a pin belongs to the column on the gap's left."""
        return (gap, *end, _RIGHT) in self.pins

    def text(self, x: float, y: float, words: str, kind: str = "", anchor: str = "start") -> None:
        """Write a line of text."""
        named = f' class="{kind}"' if kind else ""
        placed = f' text-anchor="{anchor}"' if anchor != "start" else ""
        self.out.append(f'<text x="{x:.1f}" y="{y:.1f}"{named}{placed}>{escape(words)}</text>')

    def line(self, path: str, colour: str, width: float = 2) -> None:
        """Draw a line."""
        self.out.append(
            f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width:g}"/>'
        )

    def dot(self, x: float, y: float, colour: str) -> None:
        """Draw the dot of a junction or of a pin."""
        self.out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.3" fill="{colour}"/>')

    def box(self, x: float, y: float, width: float, height: float, fill: str, more: str) -> None:
        """Draw a rectangle."""
        self.out.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
            f'fill="{fill}" {more}/>'
        )


def svg(drawing: WiringDrawing) -> str:
    """Return the drawing as the text of an SVG file."""
    canvas = _Canvas()
    x, height = float(_MARGIN), 0.0
    starts = []
    for index, column in enumerate(drawing.columns):
        width = max(block.width for block in column)
        y = _MARGIN + 30.0 + (_ROW / 2 if drawing.staggered and index == 1 else 0)
        for block in column:
            _put(canvas, index, block, x, y, width)
            y += block.height + _BELOW
        height = max(height, y)
        x += width
        starts.append(x)
        if index < len(drawing.gaps):
            x += _gap_width(drawing.gaps[index])
    for index, gap in enumerate(drawing.gaps):
        _draw_gap(canvas, index, gap, starts[index])
    for number, note in enumerate(drawing.notes):
        canvas.text(_MARGIN, height + 12 + number * _FOOT, note, "small")
    height += _FOOT * len(drawing.notes) + _MARGIN
    longest = max((len(note) for note in drawing.notes), default=0)
    width = max(x, _CHAR * longest, _TITLE_CHAR * len(drawing.title)) + _MARGIN
    canvas.text(_MARGIN, _MARGIN + 10, drawing.title, "title")
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
            f'width="{width:.0f}" height="{height:.0f}" role="img">',
            f"<title>{escape(drawing.title)}</title>",
            f"<style>{_STYLE}</style>",
            '<rect width="100%" height="100%" fill="#ffffff"/>',
            *canvas.out,
            "</svg>\n",
        ]
    )


def _put(canvas: _Canvas, column: int, block: PinBlock, x: float, y: float, width: float) -> None:
    """Draw a block and note where its pins are."""
    canvas.box(x, y, width, block.height, "#f4f6f8", 'rx="6" stroke="#555" stroke-width="1.4"')
    canvas.text(x + width / 2, y + 19, block.title, "title", "middle")
    if block.subtitle:
        canvas.text(x + width / 2, y + 35, block.subtitle, "small", "middle")
    for side, names, edge in ((_LEFT, block.left, x), (_RIGHT, block.right, x + width)):
        for row, name in enumerate(names):
            if not name:
                continue
            pin_y = y + _HEAD + (row + 0.5) * _ROW - 4
            canvas.pins[column, block.title, name, side] = (edge, pin_y)
            inside, anchor = (edge + 10, "start") if side == _LEFT else (edge - 10, "end")
            canvas.text(inside, pin_y + 4.5, name, "", anchor)
            canvas.dot(edge, pin_y, "#555")


def _gap_width(gap: Gap) -> float:
    """Return what a gap needs: a lane for each wire, more for parts."""
    return _LANE * (len(gap.wires) + 1) + 24 + sum(_part_width(part) for part in gap.parts)


def _part_width(part: Part) -> float:
    return _SERIES if isinstance(part, Series) else 26 + _CHAR * len(part.label)


def _draw_gap(canvas: _Canvas, gap: int, what: Gap, start: float) -> None:
    """Draw the wires of one gap on their lanes, and its parts beside the column that they are at.

    Parts come last: a resistor in a wire covers the wire.
    """
    at_left: list[Part] = []
    at_right: list[Part] = []
    for part in what.parts:
        end = part.end if isinstance(part, Series) else part.first
        (at_left if canvas.is_left(gap, end) else at_right).append(part)
    x = start + 14 + sum(map(_part_width, at_left))
    for number, wire in enumerate(_in_order(canvas, gap, what.wires)):
        _draw_wire(canvas, gap, wire, x + (number + 0.5) * _LANE)
    x += _LANE * len(what.wires)
    wired = {end for wire in what.wires for end in wire.ends}
    for parts, begin in ((at_left, start + 10), (at_right, x + 10)):
        for part in parts:
            _draw_part(canvas, gap, part, begin, wired)
            begin += _part_width(part)


def _in_order(canvas: _Canvas, gap: int, wires: Sequence[DrawnWire]) -> list[DrawnWire]:
    """Return wires so that few cross: those that fall from the bottom on, then those that rise."""

    def turn(wire: DrawnWire) -> tuple[bool, float]:
        left = [canvas.pin(gap, end)[1] for end in wire.ends if canvas.is_left(gap, end)]
        right = [canvas.pin(gap, end)[1] for end in wire.ends if not canvas.is_left(gap, end)]
        falls = not left or not right or max(right) >= max(left)
        return (not falls, -max(right or left) if falls else min(right))

    return sorted(wires, key=turn)


def _draw_wire(canvas: _Canvas, gap: int, wire: DrawnWire, lane: float) -> None:
    """Draw a stub from each pin to the lane, and the lane between the outermost."""
    colour = COLOURS[wire.kind]
    points = [canvas.pin(gap, end) for end in wire.ends]
    rows = [y for _, y in points]
    stubs = "".join(f"M{x:.1f} {y:.1f}H{lane:.1f}" for x, y in points)
    canvas.line(f"{stubs}M{lane:.1f} {min(rows):.1f}V{max(rows):.1f}", colour)
    for y in sorted(set(rows)):
        if len(rows) > 2 and (min(rows) < y < max(rows) or rows.count(y) > 1):
            canvas.dot(lane, y, colour)


def _draw_part(canvas: _Canvas, gap: int, part: Part, x: float, wired: Set[End]) -> None:
    """Draw a part on or between wires; a pin that has no wire gets one as far as the part."""
    if isinstance(part, Series):
        _, y = canvas.pin(gap, part.end)
        if part.label.endswith("F"):
            _plates(canvas, x + 20, y)
        else:
            _symbol(canvas, part.label, x + 6, y - 6, 34, 12)
        canvas.text(x + 23, y - 9, part.label, "small", "middle")
        return
    centre = x + 8
    for end in {part.first, part.second} - wired:
        pin_x, pin_y = canvas.pin(gap, end)
        canvas.line(f"M{pin_x:.1f} {pin_y:.1f}H{centre:.1f}", COLOURS["5v"])
    rows = sorted(canvas.pin(gap, end)[1] for end in (part.first, part.second))
    middle = sum(rows) / 2
    half = min(10.0, (rows[1] - rows[0]) / 2 - 4)
    canvas.line(f"M{centre:.1f} {rows[0]:.1f}V{rows[1]:.1f}", "#444", 1.6)
    for y in rows:
        canvas.dot(centre, y, "#444")
    _symbol(canvas, part.label, centre - 6, middle - half, 12, 2 * half)
    canvas.text(centre + 11, middle + 4.5, part.label, "small")


def _plates(canvas: _Canvas, x: float, y: float) -> None:
    """Draw a capacitor into a wire that runs across."""
    canvas.box(x, y - 8, 6, 16, "#fff", "")
    canvas.line(f"M{x:.1f} {y - 8:.1f}v16m6-16v16", "#444")


def _symbol(canvas: _Canvas, label: str, x: float, y: float, width: float, height: float) -> None:
    """Draw a resistor's box, or a capacitor's two plates if the label is in farads."""
    if not label.endswith("F"):
        canvas.box(x, y, width, height, "#fff", 'stroke="#444" stroke-width="1.6"')
        return
    centre, top = x + width / 2, y + height / 2 - 3
    canvas.box(centre - 8, top, 16, 6, "#fff", "")
    canvas.line(f"M{centre - 8:.1f} {top:.1f}h16m-16 6h16", "#444")
