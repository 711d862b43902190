# SPDX-License-Identifier: MIT
"""How homing is asked for, of a simulated axis and of a board's."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import Quantity
from pixstep.moves import accel, legs
from pixstep.operations import directions, meant_for, shared
from pixstep.operations import machine_defaults as machine
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, SPEED_FIGURE, Choice, Steps, Time, Whole
from pixstep.operations.request import Request, argument, option, shared_fields
from pixstep.profiles import origin

DIRECTIONS = {"plus": 1, "minus": -1}
_AS_SET = "none; on a board as it is set"


@shared_fields
class HomeFields(Request):
    """Homing by a profile: where the switch is sought, how fast, and what it is."""

    profile: Path = argument(FILE, machine=machine.profile("home"))
    axis: int = option(shared.AXIS, "Axis of the board.", default=0, machine=machine.axis)
    direction: str = option(
        Choice(list(DIRECTIONS)),
        "Where the switch is sought: closed from its place on, in this direction.", default="plus",
    )  # fmt: skip
    decode: str | None = shared.decode(
        "How the motor takes the profile where it seeks the switch; moves in between are plain.",
        required=False, default_text="by the motor in the file's name, smooth for M39, else plain",
    )  # fmt: skip
    haps: int | None = option(
        Whole(), "Entries of the profile to use.", default_text="its header's"
    )
    slow: Quantity | None = option(
        SPEED_FIGURE, "Second approach, steps/px or steps/s, even if smooth.",
        default_text="first entry, or the even number below",
    )  # fmt: skip
    search: int = option(Steps(), "Give a leg up after so many steps.", default=20_000)
    clear: int | None = option(Steps(), "Second approach from at least so many steps away.")
    filter_us: int | None = option(Time("us", 100, 20_000, int), "Filter of the switches.")
    inverted: str | None = option(
        Choice(list(legs.INVERTED)), "Switches that are tripped when their pin is high.",
        default_text=_AS_SET,
    )  # fmt: skip
    home_is_limit: str | None = option(
        Choice(list(legs.SHARED)), "The motor's limit switch that the home switch is, too.",
        machine=machine.home_is_limit, default_text=_AS_SET,
    )  # fmt: skip
    raw: bool = shared.raw()
    line_number: int | None = shared.line_number()

    def read_profile(
        self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False
    ) -> accel.Acceleration:
        """Read the profile. `refuse` one for a lower frequency."""
        read = accel.read(self.profile, raw=self.raw, number=self.line_number)
        desk.say(meant_for.motor_notes(desk.facts, self.profile, read.header))
        desk.say(read.notes_at(pixel_hz, refuse=refuse))
        return read

    def plan(self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False) -> legs.HomingPlan:
        """Read the profile and plan the homing that is asked for."""
        decode = self.decode or self._motor_decode(desk)
        way, smooth = directions.way(desk.facts), decode == SMOOTH
        slow = None
        if self.slow is not None:
            slow = units.whole_speed(self.slow, pixel_hz, None, smooth=smooth)
        request = legs.HomingRequest(
            axis=self.axis,
            direction=way * DIRECTIONS[self.direction],
            turned=way < 0,
            haps=self.haps,
            slow=slow,
            search_steps=self.search,
            clear_steps=self.clear,
            decode=decode,
        )
        return legs.plan(self.read_profile(desk, pixel_hz, refuse=refuse), request, pixel_hz)

    def _motor_decode(self, desk: Desk) -> str:
        """Return how the motor in a conventional file name decodes; plain if it names none."""
        named = origin.parse_name(self.profile)
        decode = meant_for.motor_decode(desk.facts, self.profile)
        if named is None or decode is None:
            return PLAIN
        desk.say((f"{self.profile}: named for {named.motor}, so homing is {decode} (--decode)",))
        return decode
