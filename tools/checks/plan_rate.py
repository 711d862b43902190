# SPDX-License-Identifier: MIT
"""How fast a long program is planned, as a stream: processor time, memory, times real time.

    plan_rate.py [MOVES]         1,000,000 unless told: some fifteen minutes

Two motors that turn round in nearly every move, at 500 Hz. Nothing is written.
"""

import argparse
import resource
import time
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.plan import Plan
from pixstep.programs.plan_data import PlanOptions

PIXEL_HZ = 500
MACHINE = Setup(
    tuple(PlanMotor(word, word, 0.02, 5, axis=axis) for axis, word in enumerate("XY")),
    Fraction(PIXEL_HZ),
)


def program(moves: int) -> Iterator[str]:
    """Yield so many moves of up to 60 steps, a line at a time."""
    yield "INC TS0 TA20 TM40\n"
    rng = np.random.default_rng(1)
    for _ in range(moves):
        x, y = rng.integers(-60, 60, 2).tolist()
        yield f"X{x} Y{y}\n"


def main() -> None:
    """Plan and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("moves", type=int, nargs="?", default=1_000_000, metavar="MOVES")
    plan = Plan("p.pmc", program(parser.parse_args().moves), MACHINE, PlanOptions())
    pixels = sum(len(counts) for counts in plan.counts())
    took_s = time.process_time()
    memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    machine_s = pixels / PIXEL_HZ
    print(
        f"{plan.report.moves} moves, {pixels} pixels, {machine_s / 3600:.1f} h at {PIXEL_HZ} Hz: "
        f"{took_s:.0f} s of processor time, {memory_mb:.0f} MB, "
        f"{machine_s / took_s:.0f} times as fast as the machine"
    )


if __name__ == "__main__":
    main()
