# SPDX-License-Identifier: MIT
"""The seek lines of homing: up the first entries of a profile, held, down mirrored.

A smooth line holds the boundary speed behind its last entry, at least for a pixel: without it the
two highest pixels would be equal counts entered at another speed.
"""

from itertools import pairwise

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import Seek
from pixstep.moves.accel import Acceleration


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
