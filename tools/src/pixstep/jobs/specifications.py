# SPDX-License-Identifier: MIT
"""Scan specifications of other projects as images: useq-schema and scanspec.

A useq-schema sequence (YAML or JSON) has a stage's x and y in micrometres. A scanspec specification
(JSON) names its axes, which are motors, in the unit of each motor's scale. Both say places; a job's
motors pass them at constant speed, a pixel a place.

A raster from the places that a scan specification visits, one after the other.

A job's lines run at constant speed: so the places of a line must be evenly apart, lines equally
long and evenly apart, and either all in one direction or one forth, one back.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from pixstep.errors import AskedText, RefusedError, UserError, one_line
from pixstep.jobs.header import SourceTable
from pixstep.jobs.image import ImageGeometry
from pixstep.jobs.making import AskedImage, source_files
from pixstep.lazy import missing_package, require_package
from pixstep.lines.units import MM, SPEED, Quantity
from pixstep.machine import files
from pixstep.machine.files import MachineFile
from pixstep.machine.model import MotorTable

Point = tuple[Fraction, Fraction]
_DIGITS = 9  # of a coordinate that count
_NEAR = Fraction(1, 10_000)  # of a pixel


@dataclass(frozen=True)
class Raster:
    """A raster of two axes: which one scans (0 or 1), lengths in the unit of the places.

    `first` is the place of the first pixel's middle, of the axis that scans and of the other one;
    `pixel` and `pitch` have the sign of the first line and of the way from line to line.
    """

    fast: int
    lines: int
    pixels: int
    first: Point
    pixel: Fraction
    pitch: Fraction
    alternate: bool


def exact(value: float) -> Fraction:
    """Return a coordinate as the decimal number that was meant."""
    return Fraction(str(round(float(value), _DIGITS)))


def raster(points: Sequence[Point], where: str) -> Raster:
    """Return the raster of some places. Raises RefusedError naming the first that is not in one."""
    if len(points) < 2:
        raise RefusedError(f"{where}: {len(points)} places: a line has two pixels at least")
    first, second = points[0], points[1]
    moving = [axis for axis in (0, 1) if first[axis] != second[axis]]
    if len(moving) != 1:
        raise RefusedError(f"{where}: place 2: one axis scans and the other one stands in a line")
    (fast,) = moving
    slow = 1 - fast
    rows = [[*row] for _, row in groupby(points, key=lambda point: point[slow])]
    signs = _signs(rows, fast, where)
    pixel = _apart([point[fast] for point in rows[0]])
    pitch = _apart([row[0][slow] for row in rows])
    made = Raster(
        fast, len(rows), len(rows[0]), (first[fast], first[slow]), pixel, pitch,
        alternate=len(signs) > 1 and signs[1] < 0,
    )  # fmt: skip
    _compare(points, made, where)
    return made


def _signs(rows: Sequence[Sequence[Point]], fast: int, where: str) -> list[int]:
    """Return of each line whether it runs as the first one (1) or against it (-1)."""
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise RefusedError(
                f"{where}: line {number} has {len(row)} pixels, line 1 has {len(rows[0])}: all "
                f"lines of a job are equally long"
            )
    ways = [row[1][fast] - row[0][fast] for row in rows]
    return [1 if way * ways[0] > 0 else -1 for way in ways]


def _compare(points: Sequence[Point], made: Raster, where: str) -> None:
    """Refuse the first place that is not where the raster has it."""
    for index, (point, right) in enumerate(zip(points, _places(made), strict=True)):
        off = max(abs(found - wanted) for found, wanted in zip(point, right, strict=True))
        if off > _NEAR * abs(made.pixel):
            line, pixel = divmod(index, made.pixels)
            told, expected = (
                ", ".join(f"{float(value):g}" for value in place) for place in (point, right)
            )
            raise RefusedError(
                f"{where}: line {line + 1}, pixel {pixel + 1} at {told}: {expected} expected: "
                f"lines and pixels of a job are evenly apart"
            )


def _apart(places: Sequence[Fraction]) -> Fraction:
    """Return how far places are apart on average, 0 of one alone."""
    return (places[-1] - places[0]) / (len(places) - 1) if len(places) > 1 else Fraction(0)


def _places(made: Raster) -> list[Point]:
    found: list[Point] = []
    for line in range(made.lines):
        back = made.alternate and line % 2 == 1
        order = range(made.pixels - 1, -1, -1) if back else range(made.pixels)
        for pixel in order:
            pair = (made.first[0] + pixel * made.pixel, made.first[1] + line * made.pitch)
            found.append(pair if made.fast == 0 else (pair[1], pair[0]))
    return found


_MICROMETRES = Fraction(1, 1000)  # of a millimetre
_MOST_SHOWN = 60  # characters of a value
_OF_LIBRARY = ("value_error", "model_type", "dataclass_type", "is_instance_of")  # names classes
Kind = Literal["useq", "scanspec"]


@dataclass(frozen=True)
class Places:
    """The places that a specification visits: the names of two axes, and pairs."""

    axes: tuple[str, str]
    points: Sequence[Point]
    unit: Fraction | None = None  # of a millimetre; None: that of each motor's scale


def read_useq(path: Path) -> Places:
    """Return the places of a useq-schema sequence."""
    require_package("useq")
    import useq

    sequence = _loaded(path, "useq", lambda: useq.MDASequence.from_file(path))
    points = []
    for number, event in enumerate(sequence, 1):
        if event.x_pos is None or event.y_pos is None:
            raise RefusedError(f"{path}: event {number} has no place: x and y are wanted")
        points.append((exact(event.x_pos), exact(event.y_pos)))
    return Places(("x", "y"), points, _MICROMETRES)


def read_scanspec(path: Path) -> Places:
    """Return the places of a scanspec specification, of two axes."""
    require_package("scanspec")
    from scanspec.specs import Spec  # type: ignore[import-untyped]

    spec: Any = _loaded(
        path, "scanspec", lambda: Spec.deserialize(json.loads(path.read_text("utf-8")))
    )
    axes = [str(axis) for axis in spec.axes() if str(axis) != "DURATION"]
    if len(axes) != 2:
        raise RefusedError(f"{path}: axes {', '.join(axes)}: two are wanted, as motors are called")
    first, second = axes
    points = [(exact(one[first]), exact(one[second])) for one in spec.midpoints()]
    return Places((first, second), points)


def image_of(machine: MachineFile, kind: Kind, path: Path, motors: Mapping[str, str]) -> AskedImage:
    """Return the image that a specification describes, without lead-ins and offsets.

    `motors` are those of its axes, by the axis. Raises UserError for what is no raster, or not a
    whole number of steps.
    """
    places = read_useq(path) if kind == "useq" else read_scanspec(path)
    found = raster(places.points, str(path))
    names = _names(machine, path, places.axes, motors)
    fast, slow = (machine[names[axis]] for axis in (found.fast, 1 - found.fast))
    with _named(path):
        return _image(kind, path, found, fast, slow, places.unit)


def _names(
    machine: MachineFile, path: Path, axes: Sequence[str], motors: Mapping[str, str]
) -> list[str]:
    """Return the motors of the axes."""
    for axis, name in motors.items():
        if axis not in axes:
            raise UserError(AskedText(
                "{axis_of} {name}={axis}: {path} has axes {axes}",
                name=name, axis=axis, path=path, axes=" and ".join(axes),
            ))  # fmt: skip
        _ = machine[name]  # names the motors that there are
    for axis in axes:
        if axis not in motors and axis not in machine.motors:
            raise UserError(AskedText(
                "{path}: axis {axis}: no motor is called so: {axis_of} MOTOR={axis} names one of "
                "{motors}",
                path=path, axis=axis, motors=", ".join(machine.motors),
            ))  # fmt: skip
    return [motors.get(axis, axis) for axis in axes]


@contextlib.contextmanager
def _named(path: Path) -> Iterator[None]:
    """Let what is wrong with places name their file."""
    try:
        yield
    except UserError as error:
        raise UserError(f"{path}: {error}") from None


def _image(
    kind: Kind, path: Path, found: Raster, fast: MotorTable, slow: MotorTable,
    unit: Fraction | None,
) -> AskedImage:  # fmt: skip
    """Return the image of a raster whose axes are these motors."""
    pixel = _in_steps(fast, found.pixel, unit)
    first = _in_steps(fast, found.first[0], unit) - pixel / 2
    return AskedImage(
        ImageGeometry(found.lines, found.pixels, alternate=found.alternate),
        {fast.name: Quantity(abs(pixel), SPEED, False, f"of {_text(found)} a pixel")},
        _steps(slow, found, unit),
        still=() if found.pitch else (slow.name,),
        source=SourceTable(kind=kind, files=source_files([path])),
        image_at={
            fast.name: round(first),
            slow.name: round(_in_steps(slow, found.first[1], unit)),
        },
        backwards=pixel < 0,
    )


def _steps(slow: MotorTable, found: Raster, unit: Fraction | None) -> dict[str, int]:
    if not found.pitch:
        return {}
    steps = _in_steps(slow, found.pitch, unit)
    if steps.denominator != 1:
        raise UserError(
            f"motor {slow.name}: {float(found.pitch):g} from line to line are "
            f"{float(steps):.7g} steps, not a whole number: nearest {steps.__floor__()} and "
            f"{steps.__floor__() + 1}"
        )
    return {slow.name: int(steps)}


def _in_steps(motor: MotorTable, length: Fraction, unit: Fraction | None) -> Fraction:
    """Return a length in a motor's steps; without a unit it is in that of the motor's scale."""
    scale = motor.steps_per_unit
    if scale is None:
        raise UserError(f"motor {motor.name}: steps_per_unit is wanted for places in lengths")
    if unit is not None and scale.length != MM:
        raise UserError(f"motor {motor.name}: has {scale}, the places are in micrometres")
    return length * (unit or 1) * scale.steps_per_unit


def _text(found: Raster) -> str:
    return f"{float(abs(found.pixel)):g}"


def _loaded(path: Path, kind: Kind, load: Any) -> Any:
    """Return what a library reads of a file; its own errors become one line."""
    try:
        return load()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    except ModuleNotFoundError as error:
        raise missing_package(error) or error from None
    except UnicodeDecodeError as error:
        raise RefusedError(f"{path}: not UTF-8 at byte {error.start}") from None
    except Exception as error:  # whatever the library raises for what it does not take
        raise RefusedError(f"{path}{_place_and_reason(error, kind)}") from None


def _place_and_reason(error: Exception, kind: Kind) -> str:
    """Return where a specification is wrong, and why, without the words of its library."""
    if isinstance(error, json.JSONDecodeError):
        return f":{error.lineno}:{error.colno}: no JSON: {error.msg}"
    if mark := getattr(error, "problem_mark", None):  # of YAML
        return f":{mark.line + 1}:{mark.column + 1}: no YAML: {getattr(error, 'problem', '')}"
    if not isinstance(error, ValidationError):
        return f": no {kind} specification: {one_line(str(error))}"
    # Where several forms are possible each has its mistakes: those that lead deepest are meant.
    found = error.errors(include_url=False)
    first = max(found, key=lambda one: len(one["loc"]))
    field, value = ".".join(str(key) for key in first["loc"]), first["input"]
    if first["type"] == "json_invalid":
        why = re.fullmatch(r"(.*) at line (\d+) column (\d+)", first["ctx"]["error"])
        return f":{why[2]}:{why[3]}: no JSON: {why[1]}" if why else ": no JSON"
    if first["type"] == "union_tag_invalid":
        place, tags = f"{field}.type".lstrip("."), first["ctx"]
        return f": {place} = {tags['tag']!r}: one of {tags['expected_tags'].replace(chr(39), '')}"
    if not field:
        return f": no {kind} specification: fields with values are wanted"
    shown = "" if isinstance(value, (dict, list)) else f" = {one_line(repr(value), _MOST_SHOWN)}"
    reason = files.reason(first["type"], first["msg"])
    if first["type"] in _OF_LIBRARY:
        reason = f"not what {kind} has there"
    return f": {field}{shown}: {reason}"
