# SPDX-License-Identifier: MIT
"""Timer ticks a second of the board that tests mean where they name none."""

from pixstep.board import boards

TICK_HZ = boards.load(boards.DEFAULT).tick_hz
