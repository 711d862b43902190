# SPDX-License-Identifier: MIT
"""What a board is told of the switches that homing uses."""

from dataclasses import dataclass

INVERTED = {"none": 0, "home": 1, "limits": 2, "both": 3}
FILTER_US = (100, 20_000)  # the range of the setting
SHARED = {"none": 0, "minus": 1, "plus": 2}  # the limit that the home switch is too
_ESTOP = 4  # bit of inputs_inverted


@dataclass(frozen=True)
class Inputs:
    """Settings of the inputs; None leaves the board's.

    `inverted` are the switches that are tripped when their pin is high, a key of INVERTED;
    `home_is_limit` is the limit switch that an axis' home switch is too, a key of SHARED.
    """

    inverted: str | None = None
    filter_us: int | None = None
    home_is_limit: str | None = None

    def settings(self, old: dict[str, int], axis: int) -> dict[str, int]:
        """Return the settings for an axis; what is another axis' or another switch's stays."""
        wanted: dict[str, int] = {}
        if self.inverted is not None:
            wanted["inputs_inverted"] = old["inputs_inverted"] & _ESTOP | INVERTED[self.inverted]
        if self.filter_us is not None:
            wanted["input_filter_us"] = self.filter_us
        if self.home_is_limit is not None:
            wanted["home_is_limit"] = shared_limits(old["home_is_limit"], axis, self.home_is_limit)
        return wanted


def shared_limits(word: int, axis: int, limit: str) -> int:
    """Return setting `home_is_limit` with another limit for one axis: none, minus or plus."""
    return word & ~(3 << 2 * axis) | SHARED[limit] << 2 * axis
