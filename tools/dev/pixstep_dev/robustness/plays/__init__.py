# SPDX-License-Identifier: MIT
"""Lines, moves, stops and resets on axes with play: where the load is at the pixel edges."""
