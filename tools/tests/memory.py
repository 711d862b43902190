# SPDX-License-Identifier: MIT
"""The firmware's variables in a simulated board's RAM, by the name under which the tests know it."""

from pixstep.simulation.memory import Memory, member

__all__ = ["Memory", "member"]
