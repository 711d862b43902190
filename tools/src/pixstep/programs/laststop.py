# SPDX-License-Identifier: MIT
"""mode1 without the last move assumed: the stop that two moves still allow.

The end of a program shows when only two moves can be changed. If their stop exceeds a limit they
are timed so that the highest acceleration of all blends from the committed move to rest is least,
found on a grid of their times.
"""

from dataclasses import replace

import numpy as np

from pixstep.programs.blends import Floats
from pixstep.programs.openmoves import OpenMove, corner_slowness

_TIMES = 1.01 ** np.arange(500)  # times of a move that are tried, up to 140 of its own
_LEAST_BLEND = 1e-3  # of a move's time


def reshaped(before: OpenMove | None, window: list[OpenMove]) -> list[OpenMove]:
    """Return the one or two moves of the window with times that stop best."""
    *first, last = window
    if first and last.entry is not None:
        return _around_corner(first[0], last)
    return _in_line(before, first[0] if first else None, last)


def _in_line(before: OpenMove | None, first: OpenMove | None, last: OpenMove) -> list[OpenMove]:
    """Return moves on a straight line: TA of each blend is what its change of speed needs."""
    moves = [one for one in (first, last) if one is not None]
    free = moves[0].entry is None
    grids = [_TIMES * one.tm if one is last or free else np.array([one.tm]) for one in moves]
    times = np.meshgrid(*grids, indexing="ij")
    zero = np.zeros(len(last.limits))
    speeds: list[Floats] = [np.array(before.speed) if before else zero]
    speeds += [np.array(one.distance) / tm[..., None] for one, tm in zip(moves, times, strict=True)]
    flanks = [*(one.flank for one in moves), last.stop_flank]
    changes = [
        np.max(np.abs(b - a) / np.array(last.limits), axis=-1) / (1 - flank)
        for a, b, flank in zip(speeds, [*speeds[1:], zero], flanks, strict=True)
    ]
    if not free:  # its corner is as it is
        changes[0] = np.zeros(1)
    ratio = changes[0] / (before.room if before else np.inf)
    for index, (one, tm) in enumerate(zip(moves, times, strict=True)):
        used = 0.0 if one.entry is None else one.used
        together = (changes[index] + changes[index + 1]) / (2 * (1 - used))
        ratio = np.maximum(
            ratio, np.maximum(together, np.maximum(*changes[index : index + 2])) / tm
        )
    slower = np.sum(times, axis=0)
    best = np.unravel_index(np.lexsort((slower.ravel(), ratio.ravel()))[0], ratio.shape)
    worst = max(float(ratio[best]), 1.0)
    found = []
    for index, (one, tm) in enumerate(zip(moves, times, strict=True)):
        ta = max(float(np.broadcast_to(changes[index], ratio.shape)[best]) / worst,
                 _LEAST_BLEND * float(tm[best]))  # fmt: skip
        made = one.slowed(float(tm[best]), f"stop in {len(moves)} moves")
        found.append(replace(made, ta=ta) if one.entry is None else made)
    return found


def _around_corner(first: OpenMove, last: OpenMove) -> list[OpenMove]:
    """Return moves with a corner between them: it is passed slower, as far as the first can."""
    best: tuple[float, list[OpenMove]] | None = None
    for slowness in max(first.k, last.k) * _TIMES:
        corner = last.move.ta / (2 * first.move.tm)
        slower = replace(first, exit=float(slowness))
        blend = replace(first, exit=None).used
        change, left = slower.used - blend, 1 - blend - corner
        if change > 0 and left <= 0:
            break
        hurry = first.hurry * (max(1.0, change / left) if change > 0 else 1.0)
        made = replace(
            last, tm=float(slowness) * last.move.tm, ta=float(slowness) * last.move.ta,
            entry=float(slowness), hurry=hurry, why="stop in 2 moves",
        )  # fmt: skip
        ratio = max(hurry, (corner_slowness(first, made) / slowness) ** 2, _stop_ratio(made))
        if best is None or ratio < best[0]:
            best = (ratio, [replace(slower, hurry=hurry), made])
    if best is None:  # no way is left to pass the corner more slowly
        return [first, last.loose(last.k * last.move.stop_ta / (2 * last.tm))]
    return best[1]


def _stop_ratio(last: OpenMove) -> float:
    """Return what the stop takes of the limits if it has all the room that is left."""
    need = max(abs(v) / limit for v, limit in zip(last.speed, last.limits, strict=True))
    return need / (1 - last.stop_flank) / last.room
