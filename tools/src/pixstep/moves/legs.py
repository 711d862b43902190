# SPDX-License-Identifier: MIT
"""What homing is to do: speeds, distances and the seek lines of its legs."""

from dataclasses import dataclass
from fractions import Fraction

from pixstep.errors import UserError
from pixstep.moves.accel import Acceleration
from pixstep.runs import Seek

MAX_SEARCH_STEPS = 10_000_000
REACTION_S = Fraction(10, 1000)  # the board decodes 8 ms ahead, and the switch is filtered


@dataclass(frozen=True)
class HomingRequest:
    """What the user chooses; None takes the profile's own.

    `direction` is where the home switch is sought (+1, -1), `haps` how many leading entries of
    the profile may be used, `slow` the speed of the second approach (steps/pixel), `search_steps`
    after how many steps a leg gives up, `clear_steps` how far from the switch the second approach
    begins at least.
    """

    axis: int
    direction: int
    haps: int | None = None
    slow: int | None = None
    search_steps: int = 20_000
    clear_steps: int | None = None


@dataclass(frozen=True)
class HomingPlan:
    """The legs' speeds and distances, all in steps and pixels, unsigned but for the direction."""

    axis: int
    direction: int
    ramp: Acceleration  # the entries that homing may use
    slow: int
    search_steps: int
    clear_steps: int

    @property
    def top(self) -> int:
        """The fastest that homing ever moves, steps/pixel."""
        return self.ramp.top

    def approach(self) -> Seek:
        """Towards the switch until it closes."""
        return seek_line(self.ramp, self.direction, self.search_steps)

    def back_off(self) -> Seek:
        """Away from the switch until it opens."""
        return seek_line(self.ramp, -self.direction, self.search_steps, opens=True)

    def slow_approach(self) -> Seek:
        """Towards the switch until it closes, at one slow speed."""
        steady = Acceleration((self.slow,), source=self.ramp.source)
        return seek_line(steady, self.direction, self.search_steps)


def plan(profile: Acceleration, request: HomingRequest, pixel_hz: Fraction) -> HomingPlan:
    """Return the plan of a request; raises UserError for one that cannot be.

    The slow approach begins at least as far away as it moves in two pixels and the board's
    reaction time, so that it has its speed when the switch comes.
    """
    ramp = profile.leading(_haps(profile, request))
    slow = ramp.counts[0] if request.slow is None else request.slow
    if not 1 <= slow <= ramp.counts[0]:
        raise UserError(
            f"slow approach at {slow} steps/pixel: 1 to {ramp.counts[0]}, the first entry of "
            f"{profile.source}, because it starts from rest"
        )
    if not 1 <= request.search_steps <= MAX_SEARCH_STEPS:
        raise UserError(f"search distance {request.search_steps}: 1 to {MAX_SEARCH_STEPS} steps")
    clear = request.clear_steps
    if clear is None:
        clear = slow * (2 + -(-REACTION_S * pixel_hz // 1))
    elif clear < 0:
        raise UserError(f"clear distance {clear} must not be negative")
    made = HomingPlan(request.axis, request.direction, ramp, slow, request.search_steps, clear)
    made.approach()  # refuses a search too short for a single pixel
    return made


def seek_line(ramp: Acceleration, direction: int, steps: int, *, opens: bool = False) -> Seek:
    """Return the longest line of at most `steps` steps: up the ramp, held, down mirrored.

    Of a short distance the ramp's upper entries stay unused. Raises UserError if not even one
    pixel at the first entry fits.
    """
    sums = ramp.stopping_sums()
    fitting = [index for index, count in enumerate(ramp.counts) if 2 * sums[index] + count <= steps]
    if not fitting:
        raise UserError(
            f"search distance {steps} is less than the first entry of {ramp.source}, "
            f"{ramp.counts[0]} steps"
        )
    last = fitting[-1]
    top = ramp.counts[last]
    hold = (steps - 2 * sums[last] - top) // top
    return Seek(tuple(direction * count for count in ramp.counts[: last + 1]), hold, opens)


def _haps(profile: Acceleration, request: HomingRequest) -> int:
    """Return how many leading entries homing may use: as asked, else as the file's header says."""
    if request.haps is not None:
        return request.haps
    if not profile.haps:
        raise UserError(
            f"{profile.source}: does not say how many entries homing may use (HAPs): give --haps"
        )
    return profile.haps
