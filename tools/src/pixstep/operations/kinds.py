# SPDX-License-Identifier: MIT
"""The kinds of values that fields of requests have: read from a text, or taken from Python.

A kind knows no option and no command. Millimetres and degrees become steps by the scale of the
motor that is meant, which is asked for only then.
"""

import math
import os
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from pixstep import arguments, atomic
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.units import (
    ACCELERATION,
    DISTANCE,
    JERK,
    SPEED,
    STEP,
    Quantity,
    Scale,
    legal_hz,
    parse_hz,
)

PICTURES = (".png", ".svg", ".pdf")
FindScale = Callable[[], Scale | None]  # raises UserError if motors are to be chosen first


def no_scale() -> None:
    """Return that no motor is known."""


class Kind:
    """What values a field has: `name` in a help, `scaled` if the motor's scale may be needed."""

    name = "TEXT"
    scaled = False

    def read(self, value: Any, scale: FindScale = no_scale) -> Any:
        """Return a value from a text, or one that Python has; raises UserError saying what fits."""
        if not isinstance(value, str):
            return self.judge(value)
        return self.parse_scaled(value, scale) if self.scaled else self.parse(value)

    def parse(self, text: str) -> Any:
        """Return the value of a text."""
        return text

    def parse_scaled(self, text: str, scale: FindScale) -> Any:
        """Return the value of a text that may need the scale of a motor."""
        raise NotImplementedError

    def judge(self, value: Any) -> Any:
        """Return a value that is no text."""
        raise UserError(f"{arguments.shown(value)}: expected a text")

    @property
    def python(self) -> str:
        """What Python gives for it, as an annotation."""
        return "str"


class _Number(Kind):
    """A number within a range; `made` is what it becomes, `word` what a wrong text is not."""

    made: type[int] | type[float] = float
    word = "float"

    def __init__(self, least: float | None = None, most: float | None = None):
        self.least, self.most = least, most

    def parse(self, text: str) -> Any:
        """Return the number of a text."""
        try:
            return self.made(self._within(self.made(text)))
        except ValueError:
            raise UserError(f"{text!r} is not a valid {self.word}.") from None

    def judge(self, value: Any) -> Any:
        """Return a number of Python's or numpy's."""
        exact, whole = arguments.number(value), self.made is int
        if exact is None or (whole and exact.denominator != 1):
            raise UserError(
                f"{arguments.shown(value)}: expected a {'whole number' if whole else 'number'}"
            )
        return self.made(self._within(self.made(exact)))

    def _within(self, value: Any) -> Any:
        high = self.most is None or value <= self.most
        low = self.least is None or value >= self.least
        if math.isfinite(value) and high and low:
            return value
        raise UserError(f"{value} is not in the range {self.range_text()}.")

    def range_text(self) -> str:
        """Return the range in words of mathematics, "" if there is none."""
        if self.least is None and self.most is None:
            return ""
        low = "" if self.least is None else f"{self.least}<="
        return f"x>={self.least}" if self.most is None else f"{low}x<={self.most}"


class Whole(_Number):
    """A whole number within a range."""

    name = "INTEGER"
    python = "int"
    made, word = int, "integer"


class Number(_Number):
    """A number within a range."""

    name = "FLOAT"
    python = "float"


class Flag(Kind):
    """Yes or no."""

    name = "FLAG"
    python = "bool"

    def parse(self, text: str) -> bool:
        """Refuse a text."""
        raise UserError(f"{text!r}: expected True or False")

    def judge(self, value: Any) -> bool:
        """Return a truth value."""
        if not isinstance(value, bool):
            raise UserError(f"{arguments.shown(value)}: expected True or False")
        return value


class Choice(Kind):
    """One of some words."""

    name = "CHOICE"

    def __init__(self, words: Sequence[str], *, any_case: bool = False):
        self.words, self.any_case = tuple(words), any_case

    def parse(self, text: str) -> str:
        """Return the word of a text."""
        for word in self.words:
            if text == word or (self.any_case and text.lower() == word.lower()):
                return word
        raise UserError(f"{text!r} is not one of {', '.join(map(repr, self.words))}")

    def judge(self, value: Any) -> Any:
        """Refuse what is no text."""
        raise UserError(f"{arguments.shown(value)}: expected one of {', '.join(self.words)}")

    @property
    def python(self) -> str:
        """What Python gives for it."""
        return f"Literal[{', '.join(map(repr, self.words))}]"


class Text(Kind):
    """Any text."""


class AnyPath(Kind):
    """A path that may be anything."""

    name = "PATH"
    python = "str | PathLike"

    def parse(self, text: str) -> Path:
        """Return the path of a text."""
        return self.judge(Path(text)) if text else self.judge(text)

    def judge(self, value: Any) -> Path:
        """Return a path of Python's."""
        return arguments.path("path", value)


class InFile(AnyPath):
    """A file that is read."""

    name = "FILE"

    def judge(self, value: Any) -> Path:
        """Return a path of Python's."""
        path = super().judge(value)
        if path.is_dir():
            raise UserError(f"File {os.fspath(path)!r} is a directory.")
        return path


class OutFile(InFile):
    """A file that is written; "-" is the standard output. With `folder` a folder will do."""

    def __init__(self, *, folder: bool = False):
        self.folder = folder
        self.name = "PATH" if folder else InFile.name

    def judge(self, value: Any) -> Path:
        """Return a path of Python's."""
        return arguments.path("path", value) if self.folder else super().judge(value)


class OutPicture(OutFile):
    """A drawing that is written; its name says the format, a stream gets PNG."""

    def judge(self, value: Any) -> Path:
        """Refuse a name that says no format."""
        path = super().judge(value)
        if path.suffix.lower() not in PICTURES and not atomic.is_stream(path):
            raise UserError(f"{path}: a drawing ends with {', '.join(PICTURES)}")
        return path


class OutFolder(AnyPath):
    """A folder for the results of a run."""

    name = "DIRECTORY"

    def judge(self, value: Any) -> Path:
        """Return a path of Python's."""
        path = super().judge(value)
        if path.is_file():
            raise UserError(f"Directory {os.fspath(path)!r} is a file.")
        return path


class Hz(Kind):
    """An exact frequency: 30, 29.97Hz or 30000/1001."""

    name = "HZ"
    python = "float | Fraction | str"

    def parse(self, text: str) -> Fraction:
        """Return the frequency of a text."""
        return parse_hz(text)

    def judge(self, value: Any) -> Fraction:
        """Return a frequency of a number; of a float the digits count that it shows."""
        exact, text = arguments.number(value), arguments.shown(value)
        if exact is None:
            raise UserError(f"pixel frequency {text}: expected Hz as 30, 29.97 or '30000/1001'")
        return legal_hz(exact, text)


class WholeHz(Hz):
    """A frequency of a whole number of Hz: 16000000 or 16 MHz."""

    python = "int | str"

    def parse(self, text: str) -> Any:
        """Return the frequency of a text."""
        return self._whole(parse_hz(text, "frequency"), text)

    def judge(self, value: Any) -> Any:
        """Return the frequency of a number."""
        return self._whole(super().judge(value), arguments.shown(value))

    def _whole(self, hz: Fraction, text: str) -> int:
        if hz.denominator != 1:
            raise UserError(f"{text} is not a whole number of Hz")
        return int(hz)


def _in_steps(quantity: Quantity, scale: FindScale) -> Quantity:
    """Return a quantity in steps; only one in another unit asks for the motor's scale."""
    return quantity if quantity.length == STEP else quantity.in_steps(scale())


class Figure(Kind):
    """A speed, an acceleration or a jerk: 128, 128steps/px2, 115200steps/s2 or 12mm/s."""

    scaled = True
    python = "float | str"

    def __init__(self, order: int):
        self.order = order
        self.name = units.unit(order)

    def parse_scaled(self, text: str, scale: FindScale) -> Quantity:
        """Return the figure of a text, in steps."""
        return _in_steps(units.parse(text, self.order), scale)

    def judge(self, value: Any) -> Quantity:
        """Return a number as one of steps and pixels; a Quantity as it is."""
        if isinstance(value, Quantity):
            return value
        exact = arguments.number(value)
        if exact is None or exact < 0:
            raise UserError(f"{arguments.shown(value)}: expected a number of {self.name}, or a "
                            f"text with a unit")  # fmt: skip
        return Quantity(exact, self.order, False, arguments.shown(value))


class Length(Kind):
    """A distance whose motor is not known yet: 2um, 0.5 steps."""

    name = "LENGTH"
    python = "float | str"

    def parse(self, text: str) -> Quantity:
        """Return the distance of a text."""
        return units.parse(text, DISTANCE)

    def judge(self, value: Any) -> Quantity:
        """Return a number as one of steps."""
        return value if isinstance(value, Quantity) else self.parse(arguments.shown(value))


class Steps(Whole):
    """A distance as a whole number of steps: 250, 3um, 0.5 mm."""

    name = "STEPS"
    scaled = True
    python = "int | str"

    def parse_scaled(self, text: str, scale: FindScale) -> int:
        """Return the steps of a text."""
        found = _in_steps(units.parse(text, DISTANCE, signed=True), scale).whole_steps()
        return int(self._within(found))


class Pixels(Whole):
    """A number of pixels: 4 or 4px."""

    name = "PIXELS"
    python = "int | str"

    def parse(self, text: str) -> int:
        """Return the pixels of a text."""
        return int(self._within(units.parse_pixels(text)))


class Time(Kind):
    """A time: 500us, 1.5s, or a number of the unit `bare`, in which the result is too."""

    name = "TIME"
    python = "float | str"

    def __init__(self, bare: str, least: float, most: float, kind: type[float] = float):
        self.bare, self.least, self.most, self.kind = bare, least, most, kind

    def parse(self, text: str) -> float:
        """Return the time of a text."""
        return self._judged(units.parse_seconds(text, self.bare), text)

    def judge(self, value: Any) -> float:
        """Return the time of a number."""
        exact = arguments.number(value)
        if exact is None:
            raise UserError(f"{arguments.shown(value)}: expected a time in {self.bare}")
        return self._judged(exact * units.parse_seconds("1", self.bare), arguments.shown(value))

    def _judged(self, seconds: Fraction, text: str) -> float:
        value = seconds / units.parse_seconds("1", self.bare)
        low, high = Fraction(str(self.least)), Fraction(str(self.most))  # 0.05 is a twentieth
        if not low <= value <= high:
            raise UserError(f"{text} is not in the range {self.least} to {self.most} {self.bare}")
        if self.kind is int and value.denominator != 1:
            raise UserError(f"{text} is not a whole number of {self.bare}")
        return self.kind(value)


class Parsed(Kind):
    """A text that a function reads; what Python has is taken as it is."""

    def __init__(self, name: str, reader: Callable[[str], Any], python: str):
        self.name, self._reader, self._python = name, reader, python

    def parse(self, text: str) -> Any:
        """Return the value of a text."""
        return self._reader(text)

    def judge(self, value: Any) -> Any:
        """Return the value as it is."""
        return value

    @property
    def python(self) -> str:
        """What Python gives for it."""
        return self._python


TEXT = Text()
FLAG = Flag()
FILE = InFile()
PATH = AnyPath()
OUTPUT = OutFile()
OUTPUT_OR_FOLDER = OutFile(folder=True)
PICTURE = OutPicture()
FOLDER = OutFolder()
HZ = Hz()
SPEED_FIGURE = Figure(SPEED)
ACCELERATION_FIGURE, JERK_FIGURE = Figure(ACCELERATION), Figure(JERK)
