# SPDX-License-Identifier: MIT
"""Homings from random places with random delays of the switch: the uno's 500."""

import pytest

from effort import cases
from homebench import assert_repeats, repeat

pytestmark = pytest.mark.usefixtures("simulator")
COUNT = cases(15, 125)


@pytest.mark.parametrize("seed", range(4))
def test_many_homings_end_on_one_step(seed):
    assert_repeats(repeat("uno", 0, COUNT, seed=100 + seed), COUNT)
