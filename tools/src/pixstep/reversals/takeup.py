# SPDX-License-Identifier: MIT
"""One transition: extra steps laid over the counts of a window, within the motor's limits.

All counts here are in the direction of the take-up, so those of the window are >= 0; the pixel
before it may hold a negative one. Which count may follow which is a constraint on neighbours only,
and closed under minimum and maximum: if two sequences keep it, so do the lower and the higher of
the two at every pixel. Hence under any caps there is one highest sequence (two passes find it),
and between two sequences, one above the other, there is always a pixel that may give up one step.
"""

from dataclasses import dataclass

from pixstep.lines.line_check import MAX_COUNT


@dataclass(frozen=True)
class MotionLimits:
    """What the motor can do from pixel to pixel: speeds in steps/pixel, steps/pixel2.

    Counts up to `start_stop` may follow each other freely, whatever their directions; beyond it a
    count changes by at most `max_acceleration` (at least 1) and never turns to the other direction.
    """

    max_acceleration: int
    start_stop: int
    max_speed: int = MAX_COUNT

    def highest_beside(self, count: int) -> int:
        """Return the highest count >= 0 that may stand next to `count`, before or after it."""
        if count < 0:
            free = self.start_stop if -count <= self.start_stop else 0
        elif count <= self.start_stop:
            free = max(count + self.max_acceleration, self.start_stop)
        else:
            free = count + self.max_acceleration
        return min(free, self.max_speed)


@dataclass(frozen=True)
class Window:
    """The ideal counts of a window's pixels and the counts made just before and behind it."""

    ideal: tuple[int, ...]
    before: int
    behind: int
    limits: MotionLimits

    def highest(self, level: int) -> list[int]:
        """Return the highest counts within the limits, at most `level` above the ideal ones."""
        counts = []
        last = self.before
        for count in self.ideal:
            last = min(count + level, self.limits.highest_beside(last))
            counts.append(last)
        last = self.behind
        for index in reversed(range(len(counts))):
            last = counts[index] = min(counts[index], self.limits.highest_beside(last))
        return counts

    def room(self, level: int | None = None) -> int:
        """Return the extra steps that fit, at most `level` a pixel (None: any number)."""
        level = self.limits.max_speed if level is None else level
        return sum(self.highest(level)) - sum(self.ideal)

    def take_up(self, steps: int) -> list[int] | None:
        """Return counts with exactly `steps` extra, no pixel taking more than it must.

        None if they do not fit. What the lowest sufficient level gives too much is given up at the
        last pixels that may, so that the play is taken up as early as that level allows.
        """
        if self.room() < steps:
            return None
        counts = self.highest(self._lowest_level(steps))
        start = len(counts) - 1
        for _ in range(sum(counts) - sum(self.ideal) - steps):
            index = self._last_spare(counts, start)
            counts[index] -= 1
            start = min(index + 1, len(counts) - 1)  # only its neighbours can have become spare
        return counts

    def _lowest_level(self, steps: int) -> int:
        """Return the lowest level with room for `steps`; there must be one."""
        low, high = 0, self.limits.max_speed
        while low < high:
            middle = (low + high) // 2
            if self.room(middle) >= steps:
                high = middle
            else:
                low = middle + 1
        return low

    def _last_spare(self, counts: list[int], start: int) -> int:
        """Return the last pixel up to `start` that can do with one step less.

        Only the pixel before can forbid it: the one behind is at its ideal, or was passed over
        because this one is too high for it.
        """
        for index in range(start, -1, -1):
            best = self.limits.highest_beside(counts[index] - 1)
            before = counts[index - 1] if index else self.before
            if counts[index] > self.ideal[index] and before <= best:
                return index
        raise AssertionError("two sequences within the limits and no step between them")
