# SPDX-License-Identifier: MIT
"""A line by its speed and its acceleration: how many clock edges a pixel has, and its counts.

Speeds at pixel ends are whole numbers of steps per pixel, even ones for a smooth motor, so that the
least acceleration at f pixels a second is 2 f^2 steps/s2 (f^2 of a plain motor). A pixel of M clock
edges makes it smaller by M^2. The smallest M is chosen that allows the acceleration asked for.

    f = 1000 Hz     M = 1: 2,000,000 steps/s2     M = 4: 125,000     M = 32: 1,953

A length in steps that is no whole number of pixels at the line's speed has a pixel more in its
deceleration: it divides the fall from one speed to the next into two.
"""

from bisect import bisect_right
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from pixstep.errors import AskedText, UserError
from pixstep.lines.units import (
    ACCELERATION,
    JERK,
    PERIOD_TICKS,
    SPEED,
    Quantity,
    Scale,
    both_text,
    number_text,
    period_ticks,
    whole_speed,
)
from pixstep.profiles import generator
from pixstep.profiles.generator import MAX_SPEED, GeneratedLine, LineRequest
from pixstep.profiles.origin import MOST_EDGES

_NEARLY = Fraction(19, 20)  # of the acceleration asked for, of which no more need be said
_FASTEST_TIMER_HZ = 20_000_000


@dataclass(frozen=True)
class WantedLine:
    """What a line shall do; speeds even (and accelerations too) unless it is plain."""

    speed: Quantity
    acceleration: Quantity
    jerk: Quantity | None
    clock_hz: Fraction
    plain: bool = False

    @property
    def unit(self) -> int:
        """What speeds and accelerations are multiples of."""
        return 1 if self.plain else 2

    def limit(self, quantity: Quantity, edges: int) -> int:
        """Return the largest figure within a limit that counts can have, at so many edges."""
        return int(quantity.per_pixel(self.clock_hz / edges) // self.unit) * self.unit

    def allows(self, edges: int) -> bool:
        """True if a pixel of so many clock edges allows acceleration and speed as they are."""
        speed = self.speed.per_pixel(self.clock_hz / edges)
        limits = [self.acceleration] if self.jerk is None else [self.acceleration, self.jerk]
        return (
            period_ticks(self.clock_hz / edges, _FASTEST_TIMER_HZ) <= PERIOD_TICKS[1]
            and all(self.limit(limit, edges) for limit in limits)
            and speed % self.unit == 0
            and 0 < speed <= MAX_SPEED
        )

    def share(self, edges: int) -> Fraction:
        """Return which part of the acceleration asked for the counts make use of."""
        return self.limit(self.acceleration, edges) / self.acceleration.per_pixel(
            self.clock_hz / edges
        )


def choose_divider(wanted: WantedLine) -> int:
    """Return the smallest number of clock edges of a pixel that allows what is wanted.

    Raises UserError if none does.
    """
    if not wanted.acceleration.value:
        raise UserError(f"acceleration {wanted.acceleration.text}: above 0 is expected")
    if wanted.jerk is not None and not wanted.jerk.value:
        raise UserError(f"jerk {wanted.jerk.text}: above 0 is expected")
    found = _fewest_edges(wanted)
    if found is None:
        jerk = f", jerk {wanted.jerk.text}" if wanted.jerk else ""
        raise UserError(
            f"acceleration {wanted.acceleration.text}{jerk} and speed {wanted.speed.text}: "
            f"no pixel of 1 to {MOST_EDGES} edges of a {float(wanted.clock_hz):g} Hz clock has "
            f"them in {'whole' if wanted.plain else 'even'} steps per pixel"
        )
    return found


def _fewest_edges(wanted: WantedLine) -> int | None:
    return next((edges for edges in range(1, MOST_EDGES + 1) if wanted.allows(edges)), None)


def note(wanted: WantedLine, edges: int) -> str:
    """Return what the counts make of the acceleration asked for; empty if that is nearly all."""
    share = wanted.share(edges)
    if share >= _NEARLY:
        return ""
    better = next(
        (
            more
            for more in range(edges + 1, MOST_EDGES + 1)
            if wanted.allows(more) and wanted.share(more) >= _NEARLY
        ),
        None,
    )
    more = f": {{divider}} {better} uses more" if better else ""
    return AskedText(
        "uses {share} % of the acceleration {text}" + more,
        share=number_text(round(100 * share, 1)), text=wanted.acceleration.text,
    )  # fmt: skip


def speeds(wanted: WantedLine, top: int, edges: int) -> list[int]:
    """Return the speeds at the pixels' ends from rest to `top`, in the least time."""
    acceleration = _legal(wanted, wanted.acceleration, ACCELERATION, edges)
    jerk = acceleration
    if wanted.jerk is not None:
        jerk = min(jerk, _legal(wanted, wanted.jerk, JERK, edges))
    if wanted.plain:
        return [*range(acceleration, top, acceleration), top]
    return generator.shortest_profile(generator.ProfileLimits(top, acceleration, jerk))


def line(
    wanted: WantedLine, edges: int, steps: int | None, request: LineRequest, scale: Scale | None
) -> tuple[GeneratedLine, int, list[str]]:
    """Return a line of so many steps, else of the pixels that `request` has, its speed, and notes.

    The notes say what it makes of acceleration and speed, if that is not nearly all.
    """
    hz = wanted.clock_hz / edges
    top = whole_speed(wanted.speed, hz, scale, smooth=not wanted.plain)
    notes = [text for text in (note(wanted, edges),) if text]
    if steps is None:
        made = generator.generate(speeds(wanted, top, edges), replace(request, speed=top))
        return made, top, notes
    made, speed = line_of_length(wanted, top, edges, steps, request)
    if speed < top:
        notes.append(f"the length allows a speed of {both_text(speed, SPEED, hz, scale)}")
    return made, speed, notes


def line_of_length(
    wanted: WantedLine, top: int, edges: int, steps: int, request: LineRequest
) -> tuple[GeneratedLine, int]:
    """Return a line of exactly so many steps, and its speed: `top`, or what the length allows.

    `request` has backlash and lead-in. Raises UserError for a length that the counts cannot make.
    """
    if steps % wanted.unit:
        raise UserError(
            f"length {steps} steps: a smooth line has an even number of them, nearest "
            f"{steps - 1} and {steps + 1}"
        )

    def shortest(speed: int) -> int:
        """Return the steps of the shortest line at a speed: ramps, lead-in, an image pixel."""
        ramp = _ramp(wanted, speeds(wanted, speed, edges), speed)
        return 2 * sum(ramp) + speed * (request.lead_in + 1)

    possible = range(wanted.unit, top + 1, wanted.unit)
    slower = bisect_right(possible, steps, key=shortest)  # the speeds that the length allows
    if not slower:
        raise UserError(
            f"length {steps} steps: too short for a line, at least {shortest(wanted.unit)}"
        )
    speed = possible[slower - 1]
    return _fill(wanted, speeds(wanted, speed, edges), speed, steps, request), speed


def _ramp(wanted: WantedLine, ends: list[int], speed: int) -> list[int]:
    counts = generator.plain_counts if wanted.plain else generator.acceleration_counts
    return counts(ends, speed)


def _fill(
    wanted: WantedLine, ends: list[int], speed: int, steps: int, request: LineRequest
) -> GeneratedLine:
    ramp = _ramp(wanted, ends, speed)
    whole, rest = divmod(steps - 2 * sum(ramp), speed)
    pixels = 2 * len(ramp) + whole + (2 if request.backlash else 0)
    asked = LineRequest(speed, pixels, request.backlash, request.lead_in, request.plain)
    made = generator.generate(ends, asked)
    if not rest:
        return made
    if wanted.jerk is not None:
        below = steps - rest
        raise UserError(
            f"length {steps} steps: with a limit of the jerk whole pixels at {speed} steps/px are "
            f"needed, nearest {below} and {below + speed}"
        )
    down = falling_with_rest(ramp, ends, rest, plain=wanted.plain)
    tail = len(ramp) + (1 if request.backlash else 0)
    zero = [0] if request.backlash else []
    counts = [*made.counts[: len(made.counts) - tail], *down, *zero]
    return GeneratedLine(counts, made.accelerating_pixels, made.image_pixel)


def falling_with_rest(ramp: list[int], ends: list[int], rest: int, *, plain: bool) -> list[int]:
    """Return the falling counts of a ramp with a pixel more, which has `rest` steps on the whole.

    `ends` are the speeds at the ends of the ramp's pixels. Of a smooth ramp a fall from one speed
    to the next is divided at the speed `rest`.
    """
    if plain:
        return sorted([*ramp, rest], reverse=True)
    falls = [(high, low) for low, high in pairwise([0, *ends])][::-1][-len(ramp) :]
    counts: list[int] = []
    for high, low in falls:
        if low < rest <= high:
            counts += [(high + rest) // 2, (rest + low) // 2]
        else:
            counts.append((high + low) // 2)
    return counts


def _legal(wanted: WantedLine, quantity: Quantity, order: int, edges: int) -> int:
    """Return a limit in steps/px2 or steps/px3. Raises UserError for less than counts can have."""
    hz = wanted.clock_hz / edges
    try:
        if not wanted.plain:
            return generator.legal_limit(quantity.per_pixel(hz), order, hz)
        if limit := wanted.limit(quantity, edges):
            return limit
        raise UserError(f"{quantity.text} is less than a step per pixel and pixel at {hz} Hz")
    except UserError as error:
        enough = _fewest_edges(wanted)
        hint = f"; {{divider}} {enough} has pixels that allow it" if enough else ""
        raise UserError(AskedText("{error}" + hint, error=error)) from None
