# SPDX-License-Identifier: MIT
"""Homings from random places with random delays of the switch: the uno's 500."""

import pytest

from effort import cases
from homebench import HomeBench, assert_repeats, repeat
from pixstep_trials.probe import BoardProbe

pytestmark = pytest.mark.usefixtures("simulator")
COUNT = cases(15, 125)
ACSR, ACBG, ACIC = 0x50, 0x40, 0x04  # the comparator's register and bits


@pytest.mark.parametrize("seed", range(4))
def test_many_homings_end_on_one_step(seed):
    assert_repeats(repeat("uno", 0, COUNT, seed=100 + seed), COUNT)


def test_the_switchs_reference_is_on_from_the_start():
    """It takes 70 us to settle: a seek that switched it on could see an edge that is none."""
    with HomeBench("uno") as bench:
        seen = [BoardProbe(bench.sim).peek(0, ACSR, 1)[0] & (ACBG | ACIC)]
        bench.home()
        seen.append(BoardProbe(bench.sim).peek(0, ACSR, 1)[0] & (ACBG | ACIC))
    assert seen == [ACBG, ACBG]
