# SPDX-License-Identifier: MIT
"""Arithmetic of a motion program: numbers, P and Q variables, functions; nothing else is run.

sum       product {+|- product}
product   factor {*|/|% factor}
factor    [+|-] number | variable | function(sum) | (sum)
variable  P or Q with a number or (sum)
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field

MOST_NUMBER = 8191  # of a variable
_DEEPEST = 40  # brackets and signs inside of each other
_NUMBER = re.compile(r"[ \t]*((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?![0-9.A-Za-z_]))")
_NAME = re.compile(r"[ \t]*([A-Za-z]+)")
_SUM = re.compile(r"[ \t]*([+-])")
_PRODUCT = re.compile(r"[ \t]*([*/%])")
_INDEX = re.compile(r"([0-9]+)")


@dataclass
class Variables:
    """The P and Q variables of a program; one without a value cannot be read."""

    values: dict[tuple[str, int], float] = field(default_factory=dict)

    def read(self, name: str, number: float) -> float:
        """Return a value. Raises ValueError if it was never given."""
        key = name, _whole(name, number)
        if key not in self.values:
            raise ValueError(f"{name}{key[1]} has no value yet: give it one, {name}{key[1]}=...")
        return self.values[key]

    def write(self, name: str, number: float, value: float) -> None:
        """Give a variable its value."""
        self.values[name, _whole(name, number)] = value


Expression = Callable[[Variables], float]
_Operator = Callable[[float, float], float]


class SyntaxMistakeError(Exception):
    """The text is no expression; `place` is where the reader stopped."""

    def __init__(self, place: int, text: str) -> None:
        super().__init__(text)
        self.place = place


def constant(text: str) -> float:
    """Return a number that a program has. Raises ValueError for one that is too large."""
    value = float(text)
    if math.isinf(value):
        raise ValueError("is too large")
    return value


def value_of(expression: Expression, variables: Variables) -> float:
    """Return the value of an expression. Raises ValueError saying what it cannot do."""
    try:
        value = expression(variables)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise ValueError("the result is too large")
    return value


class ExpressionReader:
    """Reads expressions from a place of a text on; `place` is behind what was read."""

    def __init__(self, text: str, place: int) -> None:
        self.text, self.place = text, place
        self._depth = 0

    def sum(self) -> Expression:
        return self._chain(_SUM, self._product)

    def bracketed(self) -> Expression:
        """Read a sum and the bracket behind it; the one before it has been read."""
        found = self.sum()
        if not self._taken(")"):
            raise SyntaxMistakeError(self.place, "expected )")
        return found

    def variable(self, name: str) -> Expression:
        """Read which variable `name` is: the number behind P or Q."""
        found = _INDEX.match(self.text, self.place)
        if found:
            self.place = found.end()
            number = float(found[1])
            return lambda _: number
        if self._taken("("):
            return self.bracketed()
        raise SyntaxMistakeError(self.place, f"expected the number of a variable, as {name}1")

    def _chain(self, operator: re.Pattern[str], part: Callable[[], Expression]) -> Expression:
        first, rest = part(), []
        while sign := operator.match(self.text, self.place):
            self.place = sign.end()
            rest.append((_OPERATORS[sign[1]], part()))
        return _folded(first, rest) if rest else first

    def _product(self) -> Expression:
        return self._chain(_PRODUCT, self._factor)

    def _factor(self) -> Expression:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise SyntaxMistakeError(self.place, "too many brackets inside of each other")
        found = self._signed()
        self._depth -= 1
        return found

    def _signed(self) -> Expression:
        if sign := _SUM.match(self.text, self.place):
            self.place = sign.end()
            inner = self._factor()
            return inner if sign[1] == "+" else lambda variables: -inner(variables)
        return self._plain()

    def _plain(self) -> Expression:
        if found := _NUMBER.match(self.text, self.place):
            self.place = found.end()
            number = constant(found[1])
            return lambda _: number
        if self._taken("("):
            return self.bracketed()
        found = _NAME.match(self.text, self.place)
        name = found[1].upper() if found else ""
        if found and name in ("P", "Q"):
            self.place = found.end()
            index = self.variable(name)
            return lambda variables: variables.read(name, index(variables))
        if found and name in FUNCTIONS:
            self.place = found.end()
            if not self._taken("("):
                raise SyntaxMistakeError(self.place, f"expected ( after {name}")
            return _called(name, self.bracketed())
        raise SyntaxMistakeError(
            self._next(), f"expected a number, P1, Q1 or a function: {', '.join(FUNCTIONS)}"
        )

    def _taken(self, sign: str) -> bool:
        place = self._next()
        found = self.text[place : place + 1] == sign
        self.place = place + 1 if found else self.place
        return found

    def _next(self) -> int:
        rest = self.text[self.place :]
        return self.place + len(rest) - len(rest.lstrip(" \t"))


def _whole(name: str, number: float) -> int:
    if not (number.is_integer() and 0 <= number <= MOST_NUMBER):
        raise ValueError(f"there is no variable {name}({number:g}): 0 to {MOST_NUMBER}")
    return int(number)


def _folded(first: Expression, rest: list[tuple[_Operator, Expression]]) -> Expression:
    """Return what joins its parts from left to right, however many there are."""

    def value(variables: Variables) -> float:
        found = first(variables)
        for operator, part in rest:
            found = operator(found, part(variables))
        return found

    return value


def _called(name: str, inner: Expression) -> Expression:
    function = FUNCTIONS[name]

    def value(variables: Variables) -> float:
        given = inner(variables)
        try:
            return function(given)
        except ValueError:
            raise ValueError(f"{name}({given:g}) is not a number") from None

    return value


def _divided(left: float, right: float) -> float:
    if right == 0:
        raise ValueError("division by 0")
    return left / right


def _rest(left: float, right: float) -> float:
    if right <= 0:
        raise ValueError(f"rest of a division by {right:g}: expected a number above 0")
    return left % right


_OPERATORS: dict[str, _Operator] = {
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
    "*": lambda left, right: left * right,
    "/": _divided,
    "%": _rest,
}
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ABS": abs,
    "INT": lambda value: float(math.floor(value)),
    "SQRT": math.sqrt,
    "EXP": math.exp,
    "LN": math.log,
    "SIN": lambda degrees: math.sin(math.radians(degrees)),
    "COS": lambda degrees: math.cos(math.radians(degrees)),
    "TAN": lambda degrees: math.tan(math.radians(degrees)),
    "ASIN": lambda value: math.degrees(math.asin(value)),
    "ACOS": lambda value: math.degrees(math.acos(value)),
    "ATAN": lambda value: math.degrees(math.atan(value)),
}
