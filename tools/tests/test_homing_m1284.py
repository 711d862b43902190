# SPDX-License-Identifier: MIT
"""Homings from random places with random delays of the switch, at another clock: the m1284's."""

import pytest

from effort import cases
from homebench import assert_repeats, repeat

pytestmark = pytest.mark.usefixtures("simulator")
COUNT = cases(10, 25)


@pytest.mark.parametrize("axis", range(2))
def test_many_homings_end_on_one_step(axis):
    assert_repeats(repeat("m1284", axis, COUNT, seed=200 + axis), COUNT)
