# SPDX-License-Identifier: MIT
"""How much a test tries: some cases in `tools/check`, all of them in `tools/check long`."""

import os

import pytest

from pixstep.board import boards

LONG = bool(os.environ.get("PIXSTEP_LONG"))

only_long = pytest.mark.skipif(not LONG, reason="only in tools/check long")


def cases(usual, long):
    """Return a count, a stride or a list of cases: the usual one, or that of a long check."""
    return long if LONG else usual


# The smallest board and the largest. What is tried on these alone in the quick check is the same
# firmware on the others, whose own timers, pins and limits other tests try on every board.
TRIED_BOARDS = cases(("uno", "mega"), boards.BOARD_NAMES)
