# SPDX-License-Identifier: MIT
"""The firmware's variables in a simulated board's RAM, as the tests know them."""

from pixstep.simulation.memory import Memory, place

__all__ = ["Memory", "place"]
