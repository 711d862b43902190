# SPDX-License-Identifier: MIT
"""What homing is to do: speeds, distances and the seek lines of its legs."""

from dataclasses import dataclass
from fractions import Fraction

from pixstep.board.capability import BoardLimits
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import core
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.runs import Seek, queue_entries, seek_entries
from pixstep.lines.units import hz_text
from pixstep.moves import fast
from pixstep.moves.accel import Acceleration
from pixstep.moves.seeklines import require_smooth, seek_line

DIRECTIONS = {"plus": 1, "minus": -1}
SEARCH_STEPS, MAX_SEARCH_STEPS = 20_000, 10_000_000
REACTION_S = Fraction(10, 1000)  # the board decodes 8 ms ahead, and the switch is filtered


@dataclass(frozen=True)
class HomingRequest:
    """What the user chooses; None takes the profile's own.

    `direction` is where the motor seeks the home switch (+1, -1), `turned` is True if the load's
    plus direction is the motor's minus one, `haps` how many leading entries of
    the profile may be used, `slow` the speed of the second approach (steps/pixel), `search_steps`
    after how many steps a leg gives up, `clear_steps` how far from the switch the second approach
    begins at least, `decode` how the legs that seek the switch change their speed: smoothly inside
    a pixel, or plainly from pixel to pixel.
    """

    axis: int
    direction: int
    haps: int | None = None
    slow: int | None = None
    search_steps: int = SEARCH_STEPS
    clear_steps: int | None = None
    decode: str = PLAIN
    turned: bool = False


@dataclass(frozen=True)
class HomingPlan:
    """The legs' speeds and distances, all in steps and pixels, unsigned but for the direction."""

    axis: int
    direction: int
    ramp: Acceleration  # the entries that homing may use
    slow: int
    search_steps: int
    clear_steps: int
    decode: str = PLAIN
    turned: bool = False

    @property
    def towards(self) -> str:
        """Where the load seeks the switch, plus or minus."""
        return "minus" if (self.direction < 0) != self.turned else "plus"

    @property
    def smooth(self) -> bool:
        """True if the legs that seek the switch are smooth lines."""
        return self.decode == SMOOTH

    @property
    def speeds(self) -> tuple[int, ...]:
        """Speeds at the end of the ramp's entries, steps/pixel."""
        return self.ramp.speeds(self.decode)

    @property
    def top(self) -> int:
        """The fastest that homing ever moves, steps/pixel."""
        return self.speeds[-1]

    def seek(self, *, opens: bool) -> Seek:
        """In the plan's direction until the switch closes, or opens."""
        return self._seek(self.ramp, self.direction, opens=opens)

    def approach(self) -> Seek:
        """Towards the switch until it closes."""
        return self._seek(self.ramp, self.direction)

    def back_off(self) -> Seek:
        """Away from the switch until it opens."""
        return self._seek(self.ramp, -self.direction, opens=True)

    def slow_approach(self) -> Seek:
        """Towards the switch until it closes, at one slow speed."""
        first = self.slow // 2 if self.smooth else self.slow
        return self._seek(Acceleration((first,), source=self.ramp.source), self.direction)

    def slow_back_off(self) -> Seek:
        """Away from the switch until it opens, at the slow speed."""
        first = self.slow // 2 if self.smooth else self.slow
        ramp = Acceleration((first,), source=self.ramp.source)
        return self._seek(ramp, -self.direction, opens=True)

    def _seek(self, ramp: Acceleration, direction: int, *, opens: bool = False) -> Seek:
        return seek_line(ramp, direction, self.search_steps, opens=opens, decode=self.decode)


def plan(profile: Acceleration, request: HomingRequest, pixel_hz: Fraction) -> HomingPlan:
    """Return the plan of a request; raises UserError for one that cannot be.

    The slow approach begins at least as far away as it moves in two pixels and the board's
    reaction time, so that it has its speed when the switch comes.
    """
    ramp = profile.leading(_haps(profile, request))
    if request.decode == SMOOTH:
        require_smooth(ramp)
    slow = _slow(ramp, request)
    if not 1 <= request.search_steps <= MAX_SEARCH_STEPS:
        raise UserError(f"search distance {request.search_steps}: 1 to {MAX_SEARCH_STEPS} steps")
    clear = request.clear_steps
    if clear is None:
        clear = slow * (2 + -(-REACTION_S * pixel_hz // 1))
    elif clear < 0:
        raise UserError(f"clear distance {clear} must not be negative")
    made = HomingPlan(
        request.axis,
        request.direction,
        ramp,
        slow,
        request.search_steps,
        clear,
        request.decode,
        request.turned,
    )
    made.approach()  # refuses a search too short for a single pixel
    return made


def refuse(homing: HomingPlan, board: BoardLimits) -> None:
    """Raise RefusedError for the first leg that a board would refuse, by the firmware's check.

    The moves between the seeks are no faster than the longest one, up the whole ramp.
    """
    up = sum(homing.ramp.counts)
    between = fast.plan(homing.ramp, 2 * up + homing.ramp.counts[-1]).line("move")
    legs = (
        ("approach", seek_entries(homing.approach())),
        ("back off", seek_entries(homing.back_off())),
        ("move", queue_entries(between)),
        ("slow approach", seek_entries(homing.slow_approach())),
    )
    for name, entries in legs:
        errors = (code for code in core.check(entries, board.of_core()) if code.is_error)
        first = next(errors, None)
        if first:
            raise RefusedError(
                f"{homing.ramp.source}: homing at {hz_text(board.pixel_hz)} Hz: {name}: line "
                f"refused: {first.name} at pixel {first.pixel}: {first.text} (nothing was sent)"
            )


def _haps(profile: Acceleration, request: HomingRequest) -> int:
    """Return how many leading entries homing may use: as asked, else as the file's header says."""
    if request.haps is not None:
        return request.haps
    if not profile.haps:
        raise UserError(AskedText(
            "{source}: does not say how many entries homing may use (HAPs): give {haps}",
            source=profile.source,
        ))  # fmt: skip
    return profile.haps


def _slow(ramp: Acceleration, request: HomingRequest) -> int:
    """Return the speed of the second approach: as asked, else about the profile's first entry.

    It is reached in one pixel from rest: a plain axis jumps to it, a smooth one may accelerate as
    it does in the first entry, and only to an even speed.
    """
    slow, first = request.slow, ramp.counts[0]
    if request.decode == SMOOTH:
        slow = max(2, first // 2 * 2) if slow is None else slow
        if slow % 2 or not 2 <= slow <= 2 * first:
            raise UserError(
                f"slow approach at {slow} steps/pixel: an even number, 2 to {2 * first}, twice "
                f"the first entry of {ramp.source}, because a smooth axis starts from rest"
            )
        return slow
    slow = first if slow is None else slow
    if not 1 <= slow <= first:
        raise UserError(
            f"slow approach at {slow} steps/pixel: 1 to {first}, the first entry of "
            f"{ramp.source}, because it starts from rest"
        )
    return slow
