# SPDX-License-Identifier: MIT
"""Numbers as spreadsheets write them: 0.5, 0,5, 1.234,5, 1 234.5, 1'234.5, a minus of U+2212.

Which mark divides the decimals is said from outside: 1.000 is 1 or 1000, and nothing in it tells.
"""

import re
from collections.abc import Sequence
from fractions import Fraction

POINT, COMMA = "point", "comma"
DECIMALS = {POINT: ".", COMMA: ","}

_MOST_DIGITS = 60
# What else is written for a minus.
MINUS = str.maketrans(dict.fromkeys("\u2212\u2010\u2011\u2013\ufe63\uff0d", "-"))
_GROUPS = " '\u2019\u00a0\u2009\u202f"  # marks of thousands that divide nothing else
_PLAIN = r"[+-]?(?:[0-9]+{0}?[0-9]*|{0}[0-9]+)(?:[eE][+-]?[0-9]{{1,2}})?"
_GROUPED = r"[+-]?[1-9][0-9]{{0,2}}([{1}{2}])[0-9]{{3}}(?:\1[0-9]{{3}})*({0}[0-9]*)?"


class Style:
    """How the numbers of a table are written."""

    def __init__(self, decimal: str) -> None:
        """`decimal` is a key of DECIMALS; the other mark may divide thousands."""
        self.decimal = decimal
        self.mark = DECIMALS[decimal]
        self.other = "," if self.mark == "." else "."
        mark, other = re.escape(self.mark), re.escape(self.other)
        self._plain = re.compile(_PLAIN.format(mark))
        self._grouped = re.compile(_GROUPED.format(mark, other, _GROUPS))

    def is_number(self, text: str) -> bool:
        """True for a number."""
        text = text.translate(MINUS)
        fits = len(text) <= _MOST_DIGITS
        return fits and bool(self._plain.fullmatch(text) or self._grouped.fullmatch(text))

    def number(self, text: str) -> Fraction | None:
        """Return the number, exactly as it is written; None if it is none."""
        if len(text) > _MOST_DIGITS:
            return None
        text = text.translate(MINUS)
        if self._plain.fullmatch(text):
            return Fraction(text.replace(",", ".") if self.mark == "," else text)
        found = self._grouped.fullmatch(text)
        if found is None:
            return None
        return Fraction(text.replace(found[1], "").replace(",", "."))

    def grouped(self, text: str) -> bool:
        """True for a number with marks of thousands."""
        return bool(self._grouped.fullmatch(text.translate(MINUS)))

    def doubtful(self, texts: Sequence[str]) -> int | None:
        """Return the index of a number that looks out of place beside the others of its column.

        With marks of thousands every number from 1000 on has them; and one whose only mark would
        mean decimals in the other style has decimals too where others have.
        """
        grouped = [self.grouped(text) for text in texts]
        if not any(grouped):
            return None
        decimals = any(self.mark in text for text in texts)
        both = any(self.mark in text and self.other in text for text in texts)
        for index, text in enumerate(texts):
            number = self.number(text)
            if number is not None and abs(number) >= 1000 and not grouped[index]:
                return index
            bare = grouped[index] and self.other in text and self.mark not in text
            if bare and decimals and not both:
                return index
        return None
