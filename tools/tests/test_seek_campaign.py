# SPDX-License-Identifier: MIT
"""Random seeks beside lines of the other axes, with bounces and commands: small enough to repeat.

The captured tick differs from the simulator's own by when the timers started: the same for all
runs of an image.
"""

import pytest

from effort import cases
from seek_trial import Run, Trial

pytestmark = pytest.mark.usefixtures("simulator")


@pytest.mark.parametrize(
    ("board", "trials"), [("uno", cases(7, 14)), ("mega", cases(7, 14)), ("m1284", cases(4, 14))]
)
def test_random_seeks(tmp_path, board, trials):
    endings, offsets = set(), set()
    for seed in range(trials):
        ending, offset = Run(Trial(board, seed), tmp_path).go()
        endings.add(ending)
        if offset is not None:
            offsets.add(offset)
    assert len(offsets) == 1, offsets
    assert "tripped" in endings and len(endings) > 1, endings
