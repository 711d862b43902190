# SPDX-License-Identifier: MIT
"""A move that mode1 can still stretch, and the arithmetic of its times and limits.

A move of nominal time TM that takes k TM runs its straight part at 1/k of its nominal speed. Its
blends and changes of speed take up parts of its way, together at most all of it.
"""

import math
from dataclasses import dataclass, replace

from pixstep.programs.blends import CornerRamp, Timed

Speeds = tuple[float, ...]  # counts/ms
SAME = 1e-9
_LEAST_WAY = 1e-3  # part of the way in which a speed may change
_BENT = 1e-9  # part of a speed that turns aside: less is what rounding makes of a straight line


@dataclass(frozen=True)
class OpenMove:
    """A move in the window: `move` is the nominal one, `limits` are the accelerations.

    The blend before it lasts `ta`. Where that is a corner it is passed `entry` times as slowly as
    nominal, and the corner behind the move `exit` times; None is no corner, where the move has its
    own speed. `hurry` is how many times a limit its changes of speed on the straight may take.
    """

    move: Timed
    distance: tuple[float, ...]
    limits: tuple[float, ...]
    tm: float
    ta: float
    why: str = ""
    entry: float | None = None
    exit: float | None = None
    hurry: float = 1.0

    @property
    def k(self) -> float:
        """How many times its nominal time it takes."""
        return self.tm / self.move.tm

    @property
    def speed(self) -> Speeds:
        """The speed of its straight part."""
        return tuple([length / self.tm for length in self.distance])

    @property
    def nominal_speed(self) -> Speeds:
        """The speed of the nominal move."""
        return tuple([length / self.move.tm for length in self.distance])

    @property
    def flank(self) -> float:
        """TS as a part of TA."""
        return self.move.ts / self.move.ta

    @property
    def stop_flank(self) -> float:
        """TS of the stop behind it as a part of its TA."""
        return self.move.stop_ts / self.move.stop_ta

    @property
    def used(self) -> float:
        """The part of its way that its blend and its changes of speed take."""
        if self.entry is None:
            return self.ta / (2 * self.tm) + self._change_part(self.exit)
        blend = self.move.ta / (2 * self.move.tm)
        return blend + self._change_part(self.entry) + self._change_part(self.exit)

    @property
    def room(self) -> float:
        """The longest TA of a blend behind it on the straight line."""
        return 2 * self.tm * (1 - self.used)

    def _change_part(self, corner: float | None) -> float:
        """Return the part of the way on which it gets its own speed from a corner's, or back."""
        if corner is None:
            return 0.0
        return self._change_ms() * abs(self.k**-2 - corner**-2) / (2 * self.move.tm)

    def _change_ms(self) -> float:
        """Return how long its nominal speed takes from rest on the straight."""
        still = tuple([0.0] * len(self.distance))
        return least_ta(still, self.nominal_speed, self.limits, self.flank) / self.hurry

    def slowed(self, tm: float, why: str) -> "OpenMove":
        """Return it with so much time; itself if it has that already."""
        return replace(self, tm=tm, why=why) if tm > self.tm else self

    def loose(self, behind: float) -> "OpenMove":
        """Return it as what always fits the nominal blends, limits of acceleration or not.

        `behind` is the part of the way that the corner behind takes; it is passed at the move's own
        speed. The change from the corner before is as quick as it must be; where no way is left for
        it the move goes on as the corner is passed.
        """
        if self.entry is None:
            return replace(self, ta=min(self.ta, 2 * self.tm * (1 - behind)), exit=None)
        change = self._change_part(self.entry)
        left = 1 - behind - self.move.ta / (2 * self.move.tm)
        if change <= left:
            return replace(self, exit=None)
        if left > _LEAST_WAY:
            return replace(self, exit=None, hurry=self.hurry * change / left)
        return replace(self, tm=self.entry * self.move.tm, exit=None)

    def timed(self, stretched: str, stop_ta: float = 0.0) -> Timed:
        """Return the move for the path; `stop_ta` of the last one.

        `stretched` says why its blend lasts longer than programmed, if it does.
        """
        longer = max(self.ta, stop_ta) > self.move.asked_ta + SAME
        return self.move._replace(
            tm=self.tm, ta=self.ta, ts=self.flank * self.ta, stop_ta=stop_ta,
            stop_ts=self.stop_flank * stop_ta, why=self.why or (stretched if longer else ""),
            entry=self._ramp(self.entry), exit=self._ramp(self.exit),
        )  # fmt: skip

    def _ramp(self, corner: float | None) -> CornerRamp:
        if corner is None:
            return CornerRamp()
        return CornerRamp(self.k / corner, self._change_ms() * abs(1 / self.k - 1 / corner))


def is_corner(before: tuple[float, ...], after: tuple[float, ...]) -> bool:
    """Whether the way turns aside or back between two distances."""
    length = math.hypot(*before)
    along = sum(a * b for a, b in zip(before, after, strict=True))
    square = sum(b * b for b in after)
    if not length or not square:
        return False
    aside = [a - b * along / square for a, b in zip(before, after, strict=True)]
    return along < 0 or math.hypot(*aside) > _BENT * length


def corner_slowness(before: OpenMove, after: OpenMove) -> float:
    """Return how many times as slowly as nominal the corner between two moves must be passed."""
    least = least_ta(before.nominal_speed, after.nominal_speed, after.limits, after.flank)
    return max(1.0, math.sqrt(least / after.move.ta))


def least_ta(before: Speeds, after: Speeds, limits: tuple[float, ...], flank: float) -> float:
    """Return the shortest TA that keeps every acceleration; its peak is dV/(TA - TS)."""
    return max(
        [
            abs(new - old) / (limit * (1 - flank))
            for old, new, limit in zip(before, after, limits, strict=True)
        ]
    )


def least_time(tm: float, before: float, length: float, limit: float) -> float:
    """Return the least time from `tm` on with |before - length/time| <= limit * time."""
    if length < 0 or (length == 0 and before < 0):
        before, length = -before, -length
    # Not too fast: limit t^2 + before t - length >= 0, which holds from its upper root on.
    tm = max(tm, (math.sqrt(before**2 + 4 * limit * length) - before) / (2 * limit))
    # Not too slow: limit t^2 - before t + length >= 0, which fails between its roots.
    under = before**2 - 4 * limit * length
    if before > 0 and under > 0:
        root = math.sqrt(under)
        low, high = (before - root) / (2 * limit), (before + root) / (2 * limit)
        if low * (1 + SAME) < tm < high:
            return high
    return tm
