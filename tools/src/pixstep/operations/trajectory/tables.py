# SPDX-License-Identifier: MIT
"""Tables of two axes: make a circle's, convert one, write one with its play taken up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any, TypedDict

from pixstep.errors import FINE, NEGATIVE, AskedText
from pixstep.lines.units import Quantity
from pixstep.operations import shared
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import OUTPUT, Length, Whole
from pixstep.operations.request import Request, operation, option, shared_fields
from pixstep.operations.result import Page, Result
from pixstep.operations.trajectory import fields
from pixstep.operations.trajectory.fields import GivenScale, PlayFields
from pixstep.trajectories import circle, circle_test, table, transitions
from pixstep.trajectories.circle import HOLDS, CircleRequest
from pixstep.trajectories.table import MOST_RECORDS, TwoAxisTable
from pixstep.trajectories.transitions import TablePlay

_COUNT = Whole(0, MOST_RECORDS)


@shared_fields
class _WritesTable(Request):
    """What writes a table."""

    output: Path = option(
        OUTPUT, "Table to write: .csv or -, .parquet, else 16-byte records.", "-o", "--output",
        required=True,
    )  # fmt: skip


class MadeCircle(TypedDict):
    """The table of a circle: lengths in counts, the top speed in counts a point."""

    file: str
    records: int
    radius: int
    points: int
    revolutions: int
    holds: int
    lead_in: int
    top_speed: int


@operation("trajectory circle")
class TrajectoryCircle(_WritesTable):
    """Make the table of a circle, counter-clockwise from angle 0, in counts.

    Records are p1, v1, p2, v2, 32 bits each, little-endian: axis 1 is the cosine, axis 2 the sine,
    cut off towards zero. Without a lead-in axis 2 begins at full speed.
    """

    result = MadeCircle

    diameter: Quantity | None = option(Length(), "Of the circle: 0.125in, 3mm or counts.")
    radius: Quantity | None = option(Length(), "Instead of the diameter.")
    points: int = option(Whole(4, MOST_RECORDS), "Points of a revolution.", default=8192)
    revolutions: int = option(Whole(1, 1000), "Revolutions at full speed.", default=3)
    holds: int = option(_COUNT, "Records at rest before the motion.", default=HOLDS)
    lead_in: int = option(
        _COUNT,
        "Points in which the speed comes up along the circle before angle 0, and as many in which "
        "it goes down at the end.",
        default=0,
    )
    scale: GivenScale | None = fields.scale()

    def run(self, desk: Desk) -> Result:
        """Make the table and write it."""
        counts = self._radius(desk)
        request = CircleRequest(counts, self.points, self.revolutions, self.holds, self.lead_in)
        made = circle.make(request)
        table.write(self.output, made)
        speed = int(abs(made.counts(1)).max())
        first = int(abs(made.without_holds().counts(1)[:2]).max())
        if first > 1 and 2 * first > speed:
            desk.say([AskedText(
                f"axis 2 begins at {first} counts a point: {{lead_in}} brings it up to speed"
            )])  # fmt: skip
        data = {
            "file": str(self.output), "records": made.records, **asdict(request),
            "top_speed": speed,
        }  # fmt: skip
        text = (
            f"{self.output}: {made.records} records, {made.holds} of them holds, radius {counts} "
            f"counts, at most {speed} counts a point"
        )
        return Result(data, text)

    def _radius(self, desk: Desk) -> int:
        """Return the radius in counts, cut off as the table's positions are."""
        length = self.radius or self.diameter
        if length is None or (self.diameter and self.radius):
            raise AskedError("a circle has {diameter} or {radius}, one of them")
        counts = fields.counts_of(desk.facts, length, self.scale) / (1 if self.radius else 2)
        if counts < 1:
            raise AskedError("a radius of {counts} counts: at least 1", counts=f"{float(counts):g}")
        return int(counts)


class ConvertedTable(TypedDict):
    """A table that was written in another form."""

    file: str
    output: str
    records: int
    holds: int


@shared_fields
class _Convert(_WritesTable):
    """Read a table and write it in the form that the output's name says."""

    result = ConvertedTable

    table: Path = fields.table_argument()

    def run(self, desk: Desk) -> Result:
        """Read the table and write it."""
        made = fields.read_table(desk, self.table)
        table.write(self.output, made)
        data: ConvertedTable = {
            "file": str(self.table), "output": str(self.output), "records": made.records,
            "holds": made.holds,
        }  # fmt: skip
        return Result(data, f"{self.output}: {made.records} records, {made.holds} of them holds")


@operation("trajectory import")
class TrajectoryImport(_Convert):
    """Check a table of your own and write it as 16-byte records.

    CSV or Parquet with columns p1, p2 and, together or not at all, v1, v2: whole counts, a row for
    each point. Velocities that are missing are taken from the positions around.
    """


@operation("trajectory export")
class TrajectoryExport(_Convert):
    """Write a table as CSV or Parquet, by the end of the output's name."""


class CompensatedTable(TypedDict):
    """A table whose play is taken up: what was added where; axes and records count from 1."""

    file: str
    output: str
    play: list[int]
    transition_points: list[int]
    predicted_radius_error_counts: list[float] | None
    transitions: list[dict[str, Any]]


@operation("trajectory compensate")
class TrajectoryCompensate(_WritesTable, PlayFields):
    """Write a table with the play of both axes taken up at every reversal.

    For a controller elsewhere: `trajectory sim` does this when it runs a table. Exit status 1 if a
    reversal comes before the play of the one before is taken up.
    """

    result = CompensatedTable

    table: Path = fields.table_argument()
    pixel_hz: Fraction | None = shared.pixel_hz("Points a second, for --bandwidth.", required=False)
    scale: GivenScale | None = fields.scale()

    def run(self, desk: Desk) -> Result:
        """Read the table, take its play up, and write it."""
        original = fields.read_table(desk, self.table)
        plays = self.axis_plays(original, self.pixel_hz)
        made = transitions.compensate(original, plays)
        table.write(self.output, made.table)
        predicted = self._predicted(original, plays)

        def write(page: Page) -> None:
            for axis, item in enumerate(plays):
                mine = [one for one in made.transitions if one.axis == axis]
                error = ""
                if predicted:
                    unit = fields.unit_of(self.scale)
                    error = f", predicted radius error {unit.text(predicted[axis])}"
                page.tell(
                    f"{self.output}: axis {axis + 1}: {len(mine)} transitions of {item.steps} "
                    f"points for {item.play} counts{error}"
                )
            for one in made.transitions:
                if one.missing:
                    page.tell(
                        f"{self.output}: record {one.record + 1}: warning: axis {one.axis + 1}: "
                        f"the next reversal comes {one.missing} counts too early"
                    )

        data: CompensatedTable = {
            "file": str(self.table),
            "output": str(self.output),
            "play": [item.play for item in plays],
            "transition_points": [item.steps for item in plays],
            "predicted_radius_error_counts": predicted,
            "transitions": circle_test.transitions_as_json(made.transitions),
        }
        early = any(item.missing for item in made.transitions)
        return Result(data, write, NEGATIVE if early else FINE)

    def _predicted(self, original: TwoAxisTable, plays: Sequence[TablePlay]) -> list[float] | None:
        """Return the radius error of each axis' transitions; None without a circle, or time."""
        found = fields.find_circle(original)
        if found is None or (self.servo and self.pixel_hz is None):
            return None
        return [
            transitions.predicted_error(self.crest(found, item.play, self.pixel_hz), item.steps)
            if item.play else 0.0
            for item in plays
        ]  # fmt: skip
