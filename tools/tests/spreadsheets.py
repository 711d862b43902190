# SPDX-License-Identifier: MIT
"""Tables as spreadsheets export them: random, in every dress, with the truth beside."""

import random
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.owndata import ImportRequest

STEPS_PER_MM = 400
HZ = Fraction(1000)
_MARKS = {";": "semicolon", "\t": "tab", "|": "bar", ",": "comma", " ": "blank"}
_MINUS = ("-", "-", "-", "\u2212", "\u2013")
_NAMES = {
    "steps": ("steps", "Steps", "counts", "n_steps", "steps X"),
    "position": ("pos_mm", "Position [mm]", "x (mm)", "pos mm", "Position\n[mm]"),
    "speed": ("v_mm_s", "speed (mm/s)", "Geschwindigkeit v [mm/s]", "velocity [mm/s]"),
}
_INDEX, _TIME = ("pixel", "Pixel", "n", "index"), ("t_ms", "t [ms]", "time (ms)")
_LABEL = ("remark", "Bemerkung", "Größe", "état")
_LABELS = ("ok", "", "gut", "très bien", "a b", "#1")


@dataclass
class Sheet:
    """A table and how it is written; `counts` is the line that it means."""

    counts: tuple[int, ...]
    quantity: str
    rows: list[list[str]]
    names: list[str] | None
    column: int  # of the values, from 1
    separator: str
    decimal: str
    timed: bool
    traits: list[str] = field(default_factory=list)
    data: bytes = b""

    def request(self, decode: str, scale: object, *, told: bool) -> ImportRequest:
        """Return what to ask for: nothing but the motor, or how the table is to be read."""
        if not told:
            return ImportRequest(decode, HZ, scale=scale)
        alone = self.separator == " " and self.column == 1
        return ImportRequest(
            decode, HZ, scale=scale,
            separator="none" if alone else _MARKS[self.separator],
            decimal="comma" if self.decimal == "," else "point",
            column=str(self.column),
            quantity=self.quantity,
            unit={"steps": "steps", "position": "mm", "speed": "mm/s"}[self.quantity],
        )  # fmt: skip


def sheet(rng: random.Random) -> Sheet:
    """Return a sound table."""
    made = _contents(rng)
    made.data = _bytes(rng, made, _lines(rng, made))
    return made


def spoiled(rng: random.Random) -> Sheet:
    """Return a table in which a field, a number or a row is wrong: no line may come of it."""
    made = _contents(rng)
    row = rng.randrange(1 if made.names else 0, len(made.rows) - 1)
    fields, column = made.rows[row], made.column - 1
    kind = rng.choice(("field", "word", "empty", "row", "mark", "more"))
    if not row and kind in ("empty", "row"):  # in front of the numbers empty rows are legal
        kind = "word"
    left = "".join(fields[:column] + fields[column + 1 :])  # empty lines and comments are legal
    if kind == "field" and left and not left.startswith("#"):
        del fields[column]
    elif kind == "mark" and _has_decimals(made, row):
        fields[column] = f"0{'.' if made.decimal == ',' else ','}25"
    elif kind in ("word", "field", "mark"):
        fields[column] = rng.choice(
            ("#N/A", "NaN", "1e999", "--", "4 mm", "1..5", "1,2,3,4", "(4)")
        )
    elif kind == "row":
        made.rows[row] = [""] * len(fields)
    elif kind == "more":
        fields.append("7")
    else:
        fields[column] = ""
    made.traits.append(f"spoiled: {kind} in row {row + 1}")
    made.data = _bytes(rng, made, _lines(rng, made))
    return made


def _has_decimals(made: Sheet, without: int) -> bool:
    """True if a number of the column, but for that in a row, has decimals."""
    rows = made.rows[:without] + made.rows[without + 1 :]
    return any(made.decimal in fields[made.column - 1] for fields in rows)


def _contents(rng: random.Random) -> Sheet:
    """Return a table of random numbers."""
    separator = rng.choice(";;;,,\t\t| ")
    decimal = rng.choice(".,")
    groups = [mark for mark in ".,'\u00a0\u202f " if mark not in (decimal, separator)]
    style = decimal, rng.choice(("", "", *groups)), rng.choice(_MINUS)
    quantity = rng.choice(("steps", "position", "position", "speed"))
    counts = [rng.choice((0, 1, -1, rng.randint(-9, 9), rng.randint(-9000, 9000), 400, -1200))
              for _ in range(rng.randint(3, 12))]  # fmt: skip
    values, counts = _values(rng, quantity, counts)
    digits = 0 if quantity == "steps" else rng.choice((3, 4, 5, None))
    cells = [_written(value, digits, style) for value in values]
    columns, names, column, timed = [cells], [rng.choice(_NAMES[quantity])], 1, False
    if rng.random() < 0.6:
        timed = rng.random() < 0.4
        first = rng.choice((0, 1)) if not timed else 0
        numbers = [Fraction(first + k) for k in range(len(cells))]
        columns.insert(0, [_written(number, 0, (decimal, "", "-")) for number in numbers])
        names.insert(0, rng.choice(_TIME if timed else _INDEX))
        column = 2
    if rng.random() < 0.2 and separator != " ":
        columns.append([rng.choice(_LABELS) for _ in cells])
        names.append(rng.choice(_LABEL))
    # Whole numbers without a header are steps: that is how the file is to be meant.
    plain = quantity == "steps" or any(value.denominator != 1 for value in values)
    headless = plain and rng.random() < 0.2
    rows = [list(fields) for fields in zip(*columns, strict=True)]
    return Sheet(
        tuple(counts), quantity, rows, None if headless else names, column, separator, decimal,
        timed,
    )  # fmt: skip


def _values(
    rng: random.Random, quantity: str, counts: list[int]
) -> tuple[list[Fraction], list[int]]:
    """Return what the column holds, and the line that it means."""
    if quantity == "steps":
        return [Fraction(count) for count in counts], counts
    if quantity == "speed":  # mm/s: 400 steps/mm at 1 kHz are 0.4 steps/px for 1 mm/s
        counts = [count // 10 for count in counts]
        return [Fraction(count * 5, 2) for count in counts], counts
    place = Fraction(rng.choice((0, 0, 1, -2, 1000)))
    values = [place]
    for count in counts:
        place += Fraction(count, STEPS_PER_MM)
        values.append(place)
    return values, counts


def _written(value: Fraction, digits: int | None, style: tuple[str, str, str]) -> str:
    """Return a number as a spreadsheet shows it, exactly: with more than `digits` if need be."""
    decimal, group, minus = style
    least = next(k for k in range(6) if (value * 10**k).denominator == 1)
    text = f"{abs(float(value)):.{least if digits is None else max(digits, least)}f}"
    whole, _, part = text.partition(".")
    if group:
        whole = f"{int(whole):,}".replace(",", group)
    return f"{minus if value < 0 else ''}{whole}{decimal if part else ''}{part}"


def _lines(rng: random.Random, made: Sheet) -> list[str]:
    """Return the lines of a table: quotes, empty fields, empty rows, sep=."""
    mark, width = made.separator, max(map(len, made.rows))
    quoting = rng.choice(("needed", "needed", "all", "words"))
    behind = rng.choice((0, 0, 0, 1, 4)) if mark != " " else 0
    padded = rng.random() < 0.1 and mark in ";,"

    def line(fields: list[str], *, words: bool = False) -> str:
        cells = []
        for cell in fields:
            whole = quoting == "all" or (quoting == "words" and words)
            if whole or mark in cell or "\n" in cell or (mark == " " and not cell):
                cell = f'"{cell}"'
            cells.append(cell)
        return (f" {mark} " if padded else mark).join([*cells, *[""] * behind])

    names = made.names
    if names and mark == " ":
        names = [name.split()[0] if "\n" not in name else "pos_mm" for name in names]
        names = [{"Position": "pos_mm", "x": "x_mm", "pos": "pos_mm", "speed": "v_mm_s",
                  "velocity": "v_mm_s", "Geschwindigkeit": "v_mm_s", "t": "t_ms", "time": "t_ms"}
                 .get(name, name) for name in names]  # fmt: skip
    lines = [line(fields) for fields in made.rows]
    if names and rng.random() < 0.1 and not any("\n" in name for name in names):
        lines.insert(0, "# " + mark.join(names))
    elif names:
        lines.insert(0, line(names, words=True))
    if mark not in " |" and rng.random() < 0.2:
        lines.insert(0, rng.choice((f"sep={mark}", f'"sep={mark}"', f"SEP={mark}")))
    if rng.random() < 0.3:
        empty = mark * (width - 1 + behind) if mark != " " else ""
        lines.extend([empty] * rng.randint(1, 20))
    made.traits += [f"quotes {quoting}", f"{behind} behind"]
    return lines


def _bytes(rng: random.Random, made: Sheet, lines: list[str]) -> bytes:
    """Return the file."""
    end = rng.choice(("\r\n", "\r\n", "\n", "\r"))
    text = end.join(lines) + rng.choice((end, end, "", end * 3))
    encodings = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252", "cp1252"]
    rng.shuffle(encodings)
    for encoding in encodings:
        try:
            data = text.encode(encoding)
        except UnicodeEncodeError:
            continue
        made.traits.append(encoding)
        return b"\xfe\xff" + data if encoding == "utf-16-be" and rng.random() < 0.5 else data
    raise AssertionError(text)
