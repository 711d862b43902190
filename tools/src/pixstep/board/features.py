# SPDX-License-Identifier: MIT
"""What a board's image was built with (firmware/build_features.def), and what needs which of it.

A board says in its input register `features` which of these it has. What needs a missing one is
refused before anything is sent.
"""

from dataclasses import dataclass
from functools import cache

from pixstep import natives
from pixstep.board.errors import MissingFeatureError
from pixstep.errors import UserError

REGISTER = "features"

# Registers that say nothing, and settings that change nothing, without a feature.
OF_REGISTERS = {
    "edge_error_ticks": "clock_statistics",
    "edge_error_max_ticks": "clock_statistics",
    "trip_code": "homing",
    "trip_axis": "homing",
    "trip_position_steps": "homing",
    "trip_ticks": "homing",
    "settings_serial": "store",
    "settings_state": "store",
    "idle_off_ms": "driver_timing",
    "enable_settle_ms": "driver_timing",
    "backlash_policy": "backlash",
    "gate_edges": "gate",
    "home_is_limit": "shared_switch",
}


@dataclass(frozen=True)
class Feature:
    """A row of the table: its bit in register `features`, its name, what it is."""

    bit: int
    name: str
    meaning: str


@cache
def table() -> tuple[Feature, ...]:
    """Return all features, in the order of their bits."""
    return tuple(Feature(**row) for row in natives.tables()["features"])


def named(name: str) -> Feature:
    """Return a feature by name; raises UserError if there is none."""
    for feature in table():
        if feature.name == name:
            return feature
    raise UserError(f"there is no feature {name!r}")


def names(word: int) -> frozenset[str]:
    """Return the names of the features of a register's value."""
    return frozenset(feature.name for feature in table() if word >> feature.bit & 1)


def missing(unit: int, name: str) -> MissingFeatureError:
    """Return the error for a board without a feature."""
    feature = named(name)
    return MissingFeatureError(unit, feature.name, feature.bit, feature.meaning)
