# SPDX-License-Identifier: MIT
"""A thousand homings from random places with random delays of the switch: the mega's 500."""

import pytest

from effort import cases
from homebench import assert_repeats, repeat

pytestmark = pytest.mark.usefixtures("simulator")
COUNT = cases(10, 125)


@pytest.mark.parametrize("axis", range(4))
def test_many_homings_end_on_one_step(axis):
    assert_repeats(repeat("mega", axis, COUNT, seed=axis), COUNT)
