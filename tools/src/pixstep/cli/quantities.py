# SPDX-License-Identifier: MIT
"""Options that take figures with units: distances, speeds, pixels, times.

Millimetres and degrees become steps by the motor of the command line (see `machinedefaults`).
"""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Generic, TypedDict, TypeVar

import click

from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.rational import parse_hz
from pixstep.lines.units import ACCELERATION, DISTANCE, JERK, SPEED, STEP, Quantity, Scale

_SCALE = "pixstep.scale"
Value = TypeVar("Value", covariant=True)
Decorated = TypeVar("Decorated", bound=Callable[..., Any])  # a command's function


class LimitOptions(TypedDict):
    """What the options of `limit_options` give."""

    max_speed: Quantity | None
    max_acceleration: Quantity | None
    max_jerk: Quantity | None


class FiniteRange(click.FloatRange):
    """A number between two others: "nan" is neither too small nor too large, but no number."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse the text; a bad one is a usage error."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a number.", param, ctx)
        return number


def set_scale(ctx: click.Context, scale: Callable[[], Scale | None]) -> None:
    """Keep what finds the scale by which the options of a command turn lengths into steps."""
    ctx.meta[_SCALE] = scale


def scale_of(ctx: click.Context | None) -> Scale | None:
    """Return the scale of the command's motor, if it has one."""
    find = ctx.meta.get(_SCALE) if ctx else None
    return find() if find else None


def scale_if_known(ctx: click.Context | None) -> Scale | None:
    """Return the scale for what is only shown in units of length too; None if nothing says it.

    A machine file with several motors needs none of them chosen for that.
    """
    try:
        return scale_of(ctx)
    except UserError:
        return None


def _in_steps(quantity: Quantity, ctx: click.Context | None) -> Quantity:
    """Return a quantity in steps; only one in another unit asks for the motor's scale."""
    return quantity if quantity.length == STEP else quantity.in_steps(scale_of(ctx))


class _Parsed(click.ParamType[Value, Any], Generic[Value]):
    """A text that a function parses; a bad one is a usage error."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Value:
        """Parse the text; what is no text was parsed before, as that of a machine file."""
        try:
            return self._parse(value, ctx) if isinstance(value, str) else self._judge(value)
        except UserError as error:
            return self.fail(str(error), param, ctx)

    def _parse(self, text: str, ctx: click.Context | None) -> Value:
        raise NotImplementedError

    def _judge(self, value: Any) -> Value:
        """Return a value that was parsed before. Raises UserError if it cannot be."""
        parsed: Value = value
        return parsed


def _within(value: int, least: int | None, most: int | None) -> int:
    """Return a value. Raises UserError, in click's own words, if it is out of its range."""
    if (least is not None and value < least) or (most is not None and value > most):
        low = "" if least is None else f"{least}<="
        wanted = f"x>={least}" if most is None else f"{low}x<={most}"
        raise UserError(f"{value} is not in the range {wanted}.")
    return value


class _QuantityType(_Parsed[Quantity]):
    """A figure such as 128, 128steps/px2, 115200steps/s2 or 12mm/s."""

    def __init__(self, order: int):
        self.order = order
        self.name = units.unit(order)

    def _parse(self, text: str, ctx: click.Context | None) -> Quantity:
        return _in_steps(units.parse(text, self.order), ctx)


class LengthType(_Parsed[Quantity]):
    """A distance whose motor is not known yet: 2um, 0.5 steps."""

    name = "LENGTH"

    def _parse(self, text: str, ctx: click.Context | None) -> Quantity:
        return units.parse(text, DISTANCE)


class _RangeType(_Parsed[int]):
    """A whole number within a range."""

    def __init__(self, least: int | None = None, most: int | None = None):
        self.least, self.most = least, most

    def _judge(self, value: int) -> int:
        return _within(value, self.least, self.most)


class StepsType(_RangeType):
    """A distance as a whole number of steps: 250, 3um, 0.5 mm."""

    name = "STEPS"

    def _parse(self, text: str, ctx: click.Context | None) -> int:
        return self._judge(_in_steps(units.parse(text, DISTANCE, signed=True), ctx).whole_steps())


class PixelsType(_RangeType):
    """A number of pixels: 4 or 4px."""

    name = "PIXELS"

    def _parse(self, text: str, ctx: click.Context | None) -> int:
        return self._judge(units.parse_pixels(text))


class WholeHzType(_Parsed[int]):
    """A frequency of a whole number of Hz: 16000000 or 16 MHz."""

    name = "HZ"

    def _parse(self, text: str, ctx: click.Context | None) -> int:
        hz = parse_hz(text, "frequency")
        if hz.denominator != 1:
            raise UserError(f"{text} is not a whole number of Hz")
        return int(hz)


class TimeType(_Parsed[float]):
    """A time: 500us, 1.5s, or a number of the unit `bare`, in which the result is too."""

    name = "TIME"

    def __init__(self, bare: str, least: float, most: float, kind: type[float] = float):
        self.bare, self.least, self.most, self.kind = bare, least, most, kind

    def _parse(self, text: str, ctx: click.Context | None) -> float:
        value = units.parse_seconds(text, self.bare) / units.parse_seconds("1", self.bare)
        if not self.least <= value <= self.most:
            raise UserError(f"{text} is not in the range {self.least} to {self.most} {self.bare}")
        if self.kind is int and value.denominator != 1:
            raise UserError(f"{text} is not a whole number of {self.bare}")
        return self.kind(value)


DISTANCE_TYPE = _QuantityType(DISTANCE)
SPEED_TYPE = _QuantityType(SPEED)
ACCELERATION_TYPE = _QuantityType(ACCELERATION)
JERK_TYPE = _QuantityType(JERK)


def limit_options(command: Decorated) -> Decorated:
    """Add --max-speed, --max-acceleration and --max-jerk, none of them required."""
    for name, kind, text in (
        ("--max-jerk", JERK_TYPE, "Largest change of the acceleration, steps/px3 or steps/s3."),
        ("--max-acceleration", ACCELERATION_TYPE, "Largest acceleration, steps/px2 or steps/s2."),
        ("--max-speed", SPEED_TYPE, "Largest speed, steps/px or steps/s."),
    ):
        command = click.option(name, type=kind, help=text)(command)
    return command


def whole_limit(quantity: Quantity | None, hz: Fraction | None, *, least: int = 1) -> int | None:
    """Return a limit that may be missing as whole steps/px^order; see `units.whole_limit`."""
    return None if quantity is None else units.whole_limit(quantity, hz, least=least)
