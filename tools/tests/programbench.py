# SPDX-License-Identifier: MIT
"""Setups, programs and plans for the tests of motion programs."""

from fractions import Fraction

import numpy as np
from scipy.spatial import cKDTree

from pixstep.programs.blends import Intervals, NominalPath, nominal
from pixstep.programs.language import read
from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.moves import Program
from pixstep.programs.plan import Plan
from pixstep.programs.plan_data import PlanOptions
from pixstep.programs.time_law import MotorLimits

WORDS = "XYZA"
CHORDS = 1e-3  # steps by which the chords of path_distance may lie beside the path
_NEIGHBOURS = 8
_THIRDS = 30  # of a chord, of a third of it ...: 5e-6 of it
SHORT_MOVES = "INC TS0 TA1 TM2\n" + "X100\n" * 50
RUN_IN = "INC\nTS0 TA50 TM100 X5000\nTA1 TM2\n" + "X100\n" * 50  # program R


def setup(acceleration=1.0, motors=1, hz=1000, speed=1e9, **more):
    """Return motors X, Y, Z, A that are alike, or with accelerations and speeds of their own."""
    accelerations = np.broadcast_to(acceleration, motors).tolist()
    speeds = np.broadcast_to(speed, motors).tolist()
    own = {name: more.pop(name) for name in ("feed_ms", "segment_ms", "path_tolerance",
                                             "arc_tolerance", "top_feed", "other_feed")
           if name in more}  # fmt: skip
    made = tuple(
        PlanMotor(word, word, most, fastest, axis=axis, **more)
        for axis, (word, most, fastest) in enumerate(
            zip(WORDS[:motors], accelerations, speeds, strict=True)
        )
    )
    return Setup(made, Fraction(hz), **own)


def events(text, of):
    """Return the moves of a program as programmed."""
    return list(Program("p.pmc", of).events(read("p.pmc", text.splitlines())))


def planned(text, of, **options):
    """Return the counts of a program and its report."""
    plan = Plan("p.pmc", text.splitlines(), of, PlanOptions(**options))
    return np.vstack(list(plan.counts())), plan.report


def path(text, of):
    """Return the nominal path, in intervals of programmed time."""
    parts = NominalPath(len(of.motors)).intervals(nominal(events(text, of)))
    return Intervals.joined(list(parts))


def limits(of):
    """Return the limits that a program is planned with."""
    return MotorLimits.of(of)


def random_program(rng, motors, moves, *, rising=False):
    """Return a program of relative moves; `rising` ones turn no motor round and end on even."""
    ta = int(rng.integers(1, 60))
    ts = int(rng.choice([0, ta // 4, ta // 2, ta]))
    lengths = rng.integers(0 if rising else -300, 300, (moves, motors))
    if rising:
        lengths[-1] += lengths.sum(axis=0) % 2
    rows = [
        " ".join(f"{word}{length}" for word, length in zip(WORDS, row, strict=False))
        for row in lengths.tolist()
    ]
    head = f"INC TA{ta} TS{ts} TM{int(rng.integers(2, 80))}\n"
    return head + "\n".join(rows), lengths.sum(axis=0)


def path_distance(counts, nominal_path):
    """Return how far the positions at pixel edges lie from the path, the motor that is worst.

    Distances are to the place of the path, in dense chords, where the worst motor is nearest: a
    plan may be slower or faster. The place that is nearest in space bounds them: the worst motor is
    at most twice as far from it, of up to four.
    """
    dense = nominal_path.divided(np.where(nominal_path.straight, 1, 24))
    points = np.vstack([dense.place, np.round(dense.place[-1:] + _last(dense))])
    places = np.unique(np.cumsum(counts, axis=0), axis=0).astype(float)
    straight = np.flatnonzero(dense.straight)
    bound = _nearest(places, points, straight, _in_space)
    return float(_nearest(places[bound >= bound.max() / 2], points, straight, _by_motor).max())


def _nearest(places, points, straight, distance):
    """Return the distance of each place to the chords near by, and to all that are straight."""
    begin, chord = points[:-1], np.diff(points, axis=0)
    near = cKDTree(points).query(places, k=min(_NEIGHBOURS, len(points)), p=np.inf)[1]
    beside = [index for column in near.T for index in (np.maximum(column - 1, 0), column)]
    found = np.full(len(places), np.inf)
    for index in (*beside, *(np.full(len(places), line) for line in straight)):
        index = np.minimum(index, len(chord) - 1)
        found = np.minimum(found, distance(places - begin[index], chord[index]))
    return found


def _in_space(away, chord):
    """Return how far the worst motor is from each chord, where the chord is nearest in space."""
    length = np.maximum(np.sum(chord**2, axis=1), 1e-12)
    share = np.clip(np.sum(away * chord, axis=1) / length, 0, 1)
    return np.abs(share[:, None] * chord - away).max(axis=1)


def _by_motor(away, chord):
    """Return how far the worst motor is from each chord, where it is nearest: found by thirds."""
    low, high = np.zeros(len(away)), np.ones(len(away))

    def at(share):
        return np.abs(share[:, None] * chord - away).max(axis=1)

    for _ in range(_THIRDS):
        third = (high - low) / 3
        left = at(low + third) <= at(high - third)
        low, high = np.where(left, low, low + third), np.where(left, high - third, high)
    return at((low + high) / 2)


def _last(intervals):
    """Return the way through the last interval."""
    du = intervals.du[-1]
    return du * (intervals.speed[-1] + du * (intervals.bend[-1] / 2 + du * intervals.twist[-1] / 6))
