# SPDX-License-Identifier: MIT
"""How a move is asked for: simulated, shown, written or made by a board."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from pixstep.lines import units
from pixstep.lines.units import Quantity
from pixstep.moves import accel, fast
from pixstep.moves.accel import Acceleration
from pixstep.moves.fast import FastMove
from pixstep.operations import directions, meant_for, shared
from pixstep.operations import machine_defaults as machine
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, Steps
from pixstep.operations.request import Request, argument, option, shared_fields


@shared_fields
class MoveFields(Request):
    """A move of exactly so many steps by a profile."""

    profile: Path = argument(FILE, machine=machine.profile("move"))
    steps: int = option(
        Steps(-fast.MAX_STEPS, fast.MAX_STEPS), "Steps to move, signed, not 0; or 3mm.",
        required=True,
    )  # fmt: skip
    max_speed: Quantity | None = shared.max_speed("Never faster: steps/px or steps/s.")
    raw: bool = shared.raw()
    line_number: int | None = shared.line_number()

    def plan(
        self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False
    ) -> tuple[Acceleration, FastMove]:
        """Read the profile and plan the move in the motor's steps.

        `refuse` a profile that was made for a lower pixel frequency.
        """
        top = None if self.max_speed is None else units.whole_limit(self.max_speed, pixel_hz)
        profile = accel.read(self.profile, raw=self.raw, number=self.line_number, max_speed=top)
        desk.say(meant_for.motor_notes(desk.facts, self.profile, profile.header))
        desk.say(profile.notes_at(pixel_hz, refuse=refuse))
        return profile, fast.plan(profile, directions.way(desk.facts) * self.steps)


def headline(move: FastMove, pixel_hz: Fraction) -> str:
    """Return a move in one line."""
    return (
        f"{move.steps} steps in {move.pixels} pixels, {move.seconds(pixel_hz):.3f} s at "
        f"{float(pixel_hz):g} Hz, top {move.top} steps/pixel = "
        f"{float(move.top * pixel_hz):g} steps/s"
    )
