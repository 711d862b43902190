# SPDX-License-Identifier: MIT
"""What the columns of a table hold: by their names, by their numbers, or as the user says.

A name is pos_mm, v [mm/min], Speed (um/px), t_ms, pixel. A unit that is not known must never be
passed over, because the numbers would then be taken as steps. So whatever stands where a unit
belongs and is none is kept as `unclear`.
"""

import re
from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.formats.findings import counted
from pixstep.lines import units
from pixstep.owndata.table import TextTable

POSITION, SPEED, STEPS = "position", "speed", "steps"
QUANTITIES = (POSITION, SPEED, STEPS)
TIME, INDEX = "time", "index"

_BRACKETS = re.compile(r"[\[({<]([^\[\](){}<>]*)[\])}>]?")
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")
_WORD = re.compile(r"/|°|[^\s_/,:;.|°]+")
_PER = re.compile(r"\s*(?:/|\bper\b)\s*")
_QUANTITY_WORDS = {
    POSITION: re.compile(r"(?:pos(?:n|ition)?|coord(?:inate)?|place(?:ment)?)s?[xyz]?\d*"),
    SPEED: re.compile(r"(?:speeds?|(?<!tra)(?<!le)vel(?:ocity|ocities)?)[xyz]?\d*"),
    STEPS: re.compile(r"(?:steps|counts?)[xyz]?\d*"),
    TIME: re.compile(r"time(?:stamp)?s?\d*"),
}
_LETTERS = {
    POSITION: re.compile(r"[xyz]\d*"),
    SPEED: re.compile(r"v[xyz]?\d*"),
    TIME: re.compile(r"t\d*"),
}
_INDEX_WORDS = re.compile(r"pixels?|index|n|i|k|px|nr|no|edges?")
_INDEX_MORE = re.compile(r"number|num|of|the")
_NO_UNIT = re.compile(  # what often stands beside a quantity
    r"[xyz]\d*|m\d+|(?:axis|motor|stage|load|encoder)\d*|set|cmd|target|ref|nominal|act|actual|"
    r"measured|mean|avg|max|raw|abs|absolute|rel|relative|edges?|table|line|profile|data|values?"
)
_FOREIGN_UNITS = re.compile(  # wherever they stand; other words in front of a quantity are names
    r"rp[smh]|m?rad(?:ians?)?|mils?|thou|inch(?:es)?|ft|feet|foot|yards?|microns?|k?met(?:er|re)s?|"
    r"km|km/?h|k[mp]h|mph|ips|mmps|umps|[cpfs]ps|[kmg]?hz|percent|pct|%"
)
_IN_FRONT = ("steps", "step", "in", "m", "s")  # in front of a quantity these are no units
_PIXELS = ("px", "pixel", "pixels")
_SECONDS = {"sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us"}


@dataclass(frozen=True)
class ColumnMeaning:
    """What a name says; None where it does not. `unclear` is in the place of a unit and is none."""

    quantity: str | None = None
    unit: str | None = None
    unclear: str | None = None


def meaning_of(name: str) -> ColumnMeaning:
    """Return what a name says."""
    plain = name.replace("\u00b5", "u").replace("\u03bc", "u")
    inside = [text.strip().lower() for text in _BRACKETS.findall(plain)]
    words = _words(_BRACKETS.sub(" ", plain))
    timed = _quantity(words)[0] == TIME
    unit, stem = _take_unit(words, timed=timed)
    quantity, behind = _quantity(stem)
    unclear = None
    if inside:
        unit, unclear = _of_brackets(inside, unit if stem else None, timed=timed)
        quantity = quantity if stem else _quantity(words)[0]
    elif unit is None:
        unclear = _unclear(quantity, behind) or _foreign(quantity, stem)
    elif more := [word for word in stem if _is_part_of_unit(word)]:
        unclear = " ".join([*more, unit])
    if quantity in (None, INDEX) and unit is not None:  # pixel_mm is no number of a row
        quantity = _by_unit(unit)
    elif unit is not None and (unit in units.SECOND_UNITS) != (quantity == TIME):
        unclear = unclear or unit
    return ColumnMeaning(quantity, unit, unclear)


def is_name(text: str) -> bool:
    """True if a comment above a single column names it; False if it is only a remark."""
    return (
        len(text.split()) == 1 or "[" in text or "(" in text or meaning_of(text) != ColumnMeaning()
    )


def _words(text: str) -> list[str]:
    """Return the words of a name: PosMm, pos_mm and "Pos, mm" have the same."""
    return [word.lower() for word in _WORD.findall(_CAMEL.sub("_", text))]


def _quantity(words: list[str]) -> tuple[str | None, list[str]]:
    """Return the quantity that is named, and what is behind its name."""
    for quantity, pattern in _QUANTITY_WORDS.items():
        for k, word in enumerate(words):
            if found := pattern.search(word):
                return quantity, [word[found.end() :], *words[k + 1 :]]
    for quantity, pattern in _LETTERS.items():
        if words and pattern.fullmatch(words[0]):
            return quantity, words[1:]
    if any(map(_INDEX_WORDS.fullmatch, words)) and all(map(_is_of_index, words)):
        return INDEX, []
    return None, words


def _is_of_index(word: str) -> bool:
    return bool(_INDEX_WORDS.fullmatch(word) or _INDEX_MORE.fullmatch(word))


def _take_unit(words: list[str], *, timed: bool) -> tuple[str | None, list[str]]:
    """Return the unit at the end of a name, None without one, and the words that are left."""
    end = len(words)
    while end and _says_no_unit(words[end - 1]):
        end -= 1
    for size in (1,) if timed else (3, 2, 1):
        start = end - size
        unit = _unit_of(words[start:end], timed=timed) if start >= 0 else None
        if unit is None or (end < len(words) and unit in (_IN_FRONT if not start else ("in",))):
            continue
        while start and words[start - 1] == "/":  # x / mm
            start -= 1
        return unit, words[:start] + words[end:]
    return None, words


def _says_no_unit(word: str) -> bool:
    named = (_QUANTITY_WORDS[key].fullmatch(word) for key in (POSITION, SPEED, TIME))
    return bool(_NO_UNIT.fullmatch(word)) or any(named)


def _unit_of(words: list[str], *, timed: bool) -> str | None:
    """Return the unit that words are: mm; mm per s; mm s."""
    if len(words) == 1:
        return _known(words[0], timed=timed)
    length, time = words[0], words[-1]
    divided = words[1] in ("/", "per") if len(words) == 3 else length != "in"  # v in px
    if divided and length in units.LENGTH_UNITS and time in (*_PIXELS, *units.SECOND_UNITS):
        return f"{length}/{time}"
    return None


def _known(text: str, *, timed: bool) -> str | None:
    """Return a unit of a time, or of anything, as `--unit` takes it; None for no unit."""
    text = _PER.sub("/", text)
    if timed:
        text = _SECONDS.get(text, text)
    if text in units.SECOND_UNITS or (not timed and units.is_unit(text)):
        return text
    return None


def _of_brackets(
    inside: list[str], beside: str | None, *, timed: bool
) -> tuple[str | None, str | None]:
    """Return the unit in brackets, or what is there instead; there may be one unit only."""
    said = inside if len(inside) == 1 else [text for text in inside if not _NO_UNIT.fullmatch(text)]
    unit = _known(said[0], timed=timed) if len(said) == 1 else None
    if unit is None or beside not in (None, unit):
        return None, " ".join([*([beside] if beside else []), *(said or inside)])
    return unit, None


def _unclear(quantity: str | None, behind: list[str]) -> str | None:
    """Return what is where the unit of a quantity belongs, None if that is nothing."""
    if quantity is None:  # "phi in mrad"
        behind = behind[-1:] if behind[-2:-1] == ["in"] else []
    left = [word for word in behind if word and not word.isdigit()]
    return " ".join(left) if not all(map(_says_no_unit, left)) else None


def _foreign(quantity: str | None, words: list[str]) -> str | None:
    """Return the unit of a quantity that stands in front of its name and is not known here."""
    found = [word for word in words if _FOREIGN_UNITS.fullmatch(word)]
    return found[0] if quantity is not None and found else None


def _is_part_of_unit(word: str) -> bool:
    """True for a word that beside a unit makes another one of it: mm/rev, mm/s/s."""
    known = (*units.LENGTH_UNITS, *units.SECOND_UNITS, "per")
    return word in known and word not in ("in", "m", "steps", "step")


def _by_unit(unit: str) -> str | None:
    """Return what a unit alone says: a time, a speed, steps; a length may be either."""
    if unit in units.SECOND_UNITS:
        return TIME
    if "/" in unit:
        return SPEED
    return STEPS if unit.startswith("step") else None


class ChoiceError(RefusedError):
    """Several columns could be meant, and nothing says which."""


@dataclass(frozen=True)
class Column:
    """A column: what it holds, in which unit; None where its name does not say.

    `unclear` is what its name has in the place of a unit, if that is none.
    """

    number: int
    quantity: str | None
    unit: str | None
    unclear: str | None = None


@dataclass(frozen=True)
class KnownColumn(Column):
    """A column of which both are known."""

    quantity: str
    unit: str


def of_table(table: TextTable) -> list[Column]:
    """Return what the names of all columns say."""
    named = [meaning_of(name) for name in table.names or [""] * table.width]
    return [Column(number, **vars(said)) for number, said in enumerate(named)]


def choose(table: TextTable, known: list[Column], wanted: str | None) -> Column:
    """Return the column to import.

    `wanted` is a name or a number from 1. Raises ChoiceError if several columns could be meant.
    """
    if wanted is not None:
        return known[_asked_for(table, wanted)]
    left = [
        item
        for item in known
        if item.quantity not in (TIME, INDEX)
        and (item.quantity is not None or table.has_number(item.number))
    ]
    if len(left) > 1 and not (table.names and table.names[left[0].number]):
        left = left[1:] if _counts_up(table, left[0].number) else left
    if len(left) != 1:
        names = table.names or [str(k + 1) for k in range(table.width)]
        held = f"{counted(table.width, 'column')} ({', '.join(names)})"
        said = "choose one by {column}" if left else "no numbers to import"
        place = f"{table.path}:{table.rows[0][0]}: {held}"
        raise ChoiceError(AskedText("{place}: " + said, place=place))
    return left[0]


def _asked_for(table: TextTable, wanted: str) -> int:
    """Return a column by its name or its number from 1."""
    if table.names and wanted in table.names:
        refuse_twins(table, table.names.index(wanted))
        return table.names.index(wanted)
    if wanted.isascii() and wanted.isdigit() and 1 <= int(wanted) <= table.width:
        return int(wanted) - 1
    has = ", ".join(table.names) if table.names else f"1 to {table.width}"
    raise UserError(f"{table.path}: there is no column {wanted!r}: {has}")


def refuse_twins(table: TextTable, column: int) -> None:
    """Refuse a column that was found by its name if others have the same name."""
    names = table.names or ()
    twins = [str(k) for k, name in enumerate(names, 1) if name == names[column]]
    if len(twins) > 1:
        raise ChoiceError(AskedText(
            "{place}: columns {twins} are all named {name!r}: rename them, or choose by {column} N",
            place=f"{table.path}:{table.rows[0][0]}", twins=", ".join(twins), name=names[column],
        ))  # fmt: skip


def _counts_up(table: TextTable, column: int) -> bool:
    """True for 0 1 2 ... or 1 2 3 ..."""
    values = table.numbers(column)
    return (
        values is not None
        and values[0] in (0, 1)
        and values == [values[0] + k for k in range(len(values))]
    )


def factor_of(unit: str, quantity: str, scale: units.Scale | None, hz: Fraction | None) -> Fraction:
    """Return steps (a pixel, for speeds) for 1 of a unit: steps, mm, um/px, mm/s."""
    order = units.SPEED if quantity == SPEED and "/" in unit else units.DISTANCE
    given = units.parse(f"1 {unit}", order).in_steps(scale)
    return given.per_pixel(hz) if order == units.SPEED else given.value
