# SPDX-License-Identifier: MIT
"""The few pieces of arithmetic that the record does its own way."""

import math


def nearest(number: float) -> int:
    """Return the nearest whole number, halves away from zero."""
    return int(math.floor(number + 0.5) if number > 0 else math.ceil(number - 0.5))


def within(number: float, lowest: float, highest: float) -> float:
    """Return the number, or the end that it is beyond. A highest of 0 means none."""
    if highest != 0 and max(number, lowest) > highest:
        return highest
    return max(number, lowest)
