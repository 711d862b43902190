# SPDX-License-Identifier: MIT
"""Random seeks beside lines of the other axes, with bounces and commands: small enough to repeat.

The captured tick differs from the simulator's own by when the timers started: the same for all
runs of an image.
"""

import pytest

from effort import cases
from seek_trial import Run, Trial

pytestmark = pytest.mark.usefixtures("simulator")


# The quick check has seeds that end in more than one way.
@pytest.mark.parametrize(
    ("board", "seeds"),
    [
        ("uno", range(cases(7, 14))),
        ("mega", range(cases(7, 14))),
        ("m1284", range(cases(9, 0), cases(13, 14))),
    ],
)
def test_random_seeks(tmp_path, board, seeds):
    endings, offsets = set(), set()
    for seed in seeds:
        ending, offset = Run(Trial(board, seed), tmp_path).go()
        endings.add(ending)
        if offset is not None:
            offsets.add(offset)
    assert len(offsets) == 1, offsets
    assert "tripped" in endings and len(endings) > 1, endings
