# SPDX-License-Identifier: MIT
"""What homing is to do: speeds, distances, the seek lines of its legs, the switches.

A seek line goes up the first entries of a profile, holds its speed, and goes down mirrored. A
smooth one holds the boundary speed behind its last entry, at least for a pixel: without it the two
highest pixels would be equal counts entered at another speed.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from pixstep.board.capability import BoardCapability
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import core, line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import Seek, queue_entries, seek_entries
from pixstep.lines.units import hz_text
from pixstep.moves import fast
from pixstep.moves.fast import Acceleration

DIRECTIONS = {"plus": 1, "minus": -1}
SEARCH_STEPS, MAX_SEARCH_STEPS = 20_000, 10_000_000
REACTION_S = Fraction(10, 1000)  # the board decodes 8 ms ahead, and the switch is filtered

INVERTED = {"none": 0, "home": 1, "limits": 2, "both": 3}
FILTER_US = (100, 20_000)  # the range of the setting
SHARED = {"none": 0, "minus": 1, "plus": 2}  # the limit that the home switch is too
_ESTOP = 4  # bit of inputs_inverted


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
        return self._seek(self._slow_ramp(), self.direction)

    def slow_back_off(self) -> Seek:
        """Away from the switch until it opens, at the slow speed."""
        return self._seek(self._slow_ramp(), -self.direction, opens=True)

    def _slow_ramp(self) -> Acceleration:
        return Acceleration(
            (self.slow // 2 if self.smooth else self.slow,), source=self.ramp.source
        )

    def _seek(self, ramp: Acceleration, direction: int, *, opens: bool = False) -> Seek:
        return seek_line(ramp, direction, self.search_steps, opens=opens, decode=self.decode)


def plan(profile: Acceleration, request: HomingRequest, pixel_hz: Fraction) -> HomingPlan:
    """Return the plan of a request; raises UserError for one that cannot be.

    The slow approach begins at least as far away as it moves in two pixels and the board's
    reaction time, so that it has its speed when the switch comes.
    """
    if request.haps is None and not profile.haps:
        raise UserError(AskedText(
            "{source}: does not say how many entries homing may use (HAPs): give {haps}",
            source=profile.source,
        ))  # fmt: skip
    ramp = profile.leading(profile.haps if request.haps is None else request.haps)
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
        request.axis, request.direction, ramp, slow, request.search_steps, clear, request.decode,
        request.turned,
    )  # fmt: skip
    made.approach()  # refuses a search too short for a single pixel
    return made


def refuse(homing: HomingPlan, board: BoardCapability) -> None:
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


def seek_line(
    ramp: Acceleration, direction: int, steps: int, *, opens: bool = False, decode: str = PLAIN
) -> Seek:
    """Return the longest line of at most `steps` steps: up the ramp, held, down mirrored.

    Of a short distance the ramp's upper entries stay unused. Raises UserError if not even the line
    through the first entry fits.
    """
    least_px = int(decode == SMOOTH)  # held at least
    sums, speeds = ramp.stopping_sums(), ramp.speeds(decode)
    # One held pixel counts in either; the last entry of a plain ramp is the first one held.
    least = [2 * sums[index + least_px] + speed for index, speed in enumerate(speeds)]
    fitting = [index for index, length in enumerate(least) if length <= steps]
    if not fitting:
        what = f"the first entry of {ramp.source}, {least[0]} steps"
        if decode == SMOOTH:
            what = f"a smooth line needs by the first entry of {ramp.source}, {least[0]} steps"
        raise UserError(f"search distance {steps} is less than {what}")
    last = fitting[-1]
    rising = tuple(direction * count for count in ramp.counts[: last + 1])
    hold = least_px + (steps - least[last]) // speeds[last]
    return Seek(rising, hold, opens, smooth=decode == SMOOTH)


def require_smooth(ramp: Acceleration) -> None:
    """Refuse a ramp that a smooth axis cannot follow, or not back from any of its pixels.

    The line check's errors count, and every speed that falls: the stop goes down the ramp from
    wherever the switch comes, so each speed must lie above those before it. Raises UserError.
    """
    speeds = ramp.speeds(SMOOTH)
    # Holding longer than two pixels changes nothing: the speed stays as it is.
    line = Line((*ramp.counts, speeds[-1], speeds[-1], *reversed(ramp.counts)))
    errors = [item for item in line_check.check(line) if item.severity == line_check.ERROR]
    falls = [
        (entry, f"the speed falls from {low} to {high}")
        for entry, (low, high) in enumerate(pairwise((0, *speeds)), 1)
        if high < low
    ]
    last = len(ramp.counts)  # what is wrong with the held speed is its entry's fault
    found = [*((min(item.pixel, last), item.message) for item in errors), *falls]
    if found:
        entry, why = min(found, key=lambda item: item[0])
        raise RefusedError(AskedText(
            "{source}: entry {entry}, decoded as smooth: {why}; `pixstep profile check` "
            "shows all, `pixstep profile repair` mends, {decode} plain takes it as it is",
            source=ramp.source, entry=entry, why=why,
        ))  # fmt: skip


@dataclass(frozen=True)
class Inputs:
    """Settings of the inputs; None leaves the board's.

    `inverted` are the switches that are tripped when their pin is high, a key of INVERTED;
    `home_is_limit` is the limit switch that an axis' home switch is too, a key of SHARED.
    """

    inverted: str | None = None
    filter_us: int | None = None
    home_is_limit: str | None = None

    def settings(self, old: dict[str, int], axis: int) -> dict[str, int]:
        """Return the settings for an axis; what is another axis' or another switch's stays."""
        wanted: dict[str, int] = {}
        if self.inverted is not None:
            wanted["inputs_inverted"] = old["inputs_inverted"] & _ESTOP | INVERTED[self.inverted]
        if self.filter_us is not None:
            wanted["input_filter_us"] = self.filter_us
        if self.home_is_limit is not None:
            wanted["home_is_limit"] = shared_limits(old["home_is_limit"], axis, self.home_is_limit)
        return wanted


def shared_limits(word: int, axis: int, limit: str) -> int:
    """Return setting `home_is_limit` with another limit for one axis: none, minus or plus."""
    return word & ~(3 << 2 * axis) | SHARED[limit] << 2 * axis
