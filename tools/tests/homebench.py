# SPDX-License-Identifier: MIT
"""Homing again and again on one simulated board, from wherever its load is put."""

import random
from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction

from bench import Bench
from pixstep.moves import fast, homing, legs

HZ = Fraction(500)
PROFILE = fast.Acceleration((2, 20, 50, 70, 110), haps=4)
SLOW_STEPS_PX = 2  # 1000 steps/s: a millisecond of the switch's delay is one step
MOST_DELAY_TICKS = 16_000
KNOBS = "home=0,hyst=2,travel=-900..900,start=-300"


class HomeBench(Bench):
    """A board with a load and switches on one axis."""

    def __init__(self, board, axis=0, knobs=KNOBS, hz=HZ, edges=None):
        super().__init__(board, (axis,), hz, edges, {(0, axis): knobs})
        self.axis = axis

    def plan(self, direction=1, profile=PROFILE, **changes):
        options = {"slow": SLOW_STEPS_PX, "search_steps": 2500, "clear_steps": 5, **changes}
        return legs.plan(profile, legs.HomingRequest(self.axis, direction, **options), self.hz)

    def home(self, **changes):
        return homing.home(self.board, self.plan(**changes), self.hz, self.world)

    def load_position(self):
        return self.sim.plant(0, self.axis)[1]

    def switch_cycle(self):
        """Cycle of the first edge of the home switch's last change."""
        return int(self.sim.command(f"switches 0 {self.axis}").split()[-1])

    def assert_follows_zero(self):
        """The register counts on from 0: a move to and fro ends on it."""
        for steps in (-35, 35):
            self.move(steps)
        assert self.board.axis(self.axis)["position_steps"] == 0

    def move(self, steps):
        """Make a fast move and wait for its end."""
        self.load(fast.plan(PROFILE.leading(PROFILE.haps), steps).line(), self.axis)
        self.arm()
        self.until(lambda: self.state(self.axis) == "done")


@dataclass
class Repeats:
    """Where many homings ended, and how far apart captured ticks and switch edges were."""

    ends: Counter = field(default_factory=Counter)
    offsets: Counter = field(default_factory=Counter)
    positions: Counter = field(default_factory=Counter)


def repeat(board, axis, count, seed, **changes):
    """Home `count` times from random places, the switch late by a random delay; return Repeats."""
    rng = random.Random(seed)
    found = Repeats()
    with HomeBench(board, axis) as bench:
        for index in range(count):
            if index % 5 == 4:  # from where a move leads, else from where the load is put
                bench.move(rng.choice((-1, 1)) * rng.randint(1, 700))
                bench.sim.knobs(0, axis, f"delay={rng.randint(0, MOST_DELAY_TICKS)}")
            else:
                place, delay = rng.randint(-800, 800), rng.randint(0, MOST_DELAY_TICKS)
                bench.sim.knobs(0, axis, f"start={place},delay={delay}")
            bench.sim.run(3 * MOST_DELAY_TICKS)  # switch and filter follow
            homed = bench.home(**changes)
            found.offsets[(bench.switch_cycle() - homed.edge.ticks) % 2**32] += 1
            found.ends[bench.load_position()] += 1
            found.positions[homed.position_steps] += 1
    return found


def assert_repeats(found, count):
    """All ends within one step of each other, every captured tick on the switch's edge."""
    assert sum(found.ends.values()) == count
    assert max(found.ends) - min(found.ends) <= 1, found.ends
    assert len(found.offsets) == 1, found.offsets
    assert set(found.positions) == {0}
