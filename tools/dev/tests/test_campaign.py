# SPDX-License-Identifier: MIT
"""Random lines on the real images: every edge and every position.

`pixstep-dev campaign --lines 200 --board mega` runs the long form of this set.
"""

import pytest

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep_dev.randomlines import campaign

pytestmark = pytest.mark.usefixtures("simulator")


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
@pytest.mark.parametrize("decode", [SMOOTH, PLAIN])
def test_random_lines(lines_option, board, decode):
    plan = campaign.RandomLinesPlan(board, lines=max(2, lines_option // 5), decodes=(decode,))
    outcome = campaign.run(plan)
    assert outcome["results"][0]["failures"] == []
