# SPDX-License-Identifier: MIT
"""What the profile commands print: figures per pixel and per second, changes of a repair."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NotRequired, TypedDict

from pixstep.lazy import rich
from pixstep.lines import units
from pixstep.lines.units import ACCELERATION, JERK, SPEED
from pixstep.profiles.kinematics import LineMagnitudes
from pixstep.profiles.repair import ValueChange

_SHOWN = 12  # values of a change that are printed
_LINES = 20  # findings or changes that are printed


def figures_table(figures: LineMagnitudes, hz: Fraction | None) -> rich.table.Table:
    """Return the figures as a table, with a column per second if the frequency is known."""
    table = rich.table.Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    table.add_column("per pixel", justify="right")
    table.add_column("")
    if hz is not None:
        table.add_column("per second", justify="right")
        table.add_column("")
    for name, order, value in (
        ("peak speed", SPEED, figures.peak_speed),
        ("peak acceleration", ACCELERATION, figures.peak_acceleration),
        ("peak jerk", JERK, figures.peak_jerk),
    ):
        row = [name, str(value), units.unit(order)]
        if hz is not None:
            row += [units.number_text(units.per_second(value, order, hz)),
                    units.unit(order, per_second=True)]  # fmt: skip
        table.add_row(*row)
    row = ["length", str(figures.pixels), "px"]
    if hz is not None:
        row += [f"{float(figures.pixels / hz):.6g}", "s"]
    table.add_row(*row)
    table.add_row("steps made", str(figures.steps), "steps")
    return table


class MotionFigures(TypedDict):
    """Magnitudes of a line or profile; those per second where the pixel frequency is known."""

    pixels: int
    steps: int
    peak_speed_steps_per_px: int
    peak_acceleration_steps_per_px2: int
    peak_jerk_steps_per_px3: int
    pixel_hz: NotRequired[str]
    length_s: NotRequired[float]
    peak_speed_steps_per_s: NotRequired[float]
    peak_acceleration_steps_per_s2: NotRequired[float]
    peak_jerk_steps_per_s3: NotRequired[float]


def figures_json(figures: LineMagnitudes, hz: Fraction | None) -> MotionFigures:
    """Return the figures as plain data."""
    data: MotionFigures = {
        "pixels": figures.pixels,
        "steps": figures.steps,
        "peak_speed_steps_per_px": figures.peak_speed,
        "peak_acceleration_steps_per_px2": figures.peak_acceleration,
        "peak_jerk_steps_per_px3": figures.peak_jerk,
    }
    if hz is not None:
        data["pixel_hz"] = str(hz)
        data["length_s"] = float(figures.pixels / hz)
        data["peak_speed_steps_per_s"] = float(figures.peak_speed * hz)
        data["peak_acceleration_steps_per_s2"] = float(figures.peak_acceleration * hz**2)
        data["peak_jerk_steps_per_s3"] = float(figures.peak_jerk * hz**3)
    return data


def change_text(change: ValueChange, place: str) -> str:
    """Return one change as a line: 'pixel 1: 10 -> 5: why'."""
    after = _values(change.after)
    if not change.before:
        return f"before {place} {change.pixel}: {after} inserted: {change.reason}"
    last = change.pixel + len(change.before) - 1
    where = f"{place} {change.pixel}" if last == change.pixel else f"{place}s {change.pixel}-{last}"
    return f"{where}: {_values(change.before)} -> {after}: {change.reason}"


class ChangeFacts(TypedDict):
    """Values that a repair replaced, from a pixel or record of the original on, from 1."""

    pixel: int
    before: list[int]
    after: list[int]
    reason: str


def changes_json(changes: tuple[ValueChange, ...]) -> list[ChangeFacts]:
    """Return the changes as plain data."""
    return [
        {
            "pixel": one.pixel,
            "before": list(one.before),
            "after": list(one.after),
            "reason": one.reason,
        }
        for one in changes
    ]


def first_lines(lines: Sequence[str]) -> list[str]:
    """Return the first lines of a long list, and how many more there are."""
    if len(lines) <= _LINES:
        return list(lines)
    return [*lines[:_LINES], f"and {len(lines) - _LINES} more; --json lists them all"]


def _values(values: tuple[int, ...]) -> str:
    """Return values as text, long equal runs and long lists cut short."""
    if len(values) > 3 and len(set(values)) == 1:
        return f"{len(values)} x {values[0]}"
    if len(values) > _SHOWN:
        head = ", ".join(map(str, values[: _SHOWN - 2]))
        return f"{head}, ... {values[-1]} ({len(values)} values)"
    return ", ".join(map(str, values))
