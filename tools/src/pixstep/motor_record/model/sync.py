# SPDX-License-Identifier: MIT
"""Targets become readbacks: SYNC, and a stop of a motor that rests already."""

from pixstep.motor_record.model import coordinates
from pixstep.motor_record.model.readback import newest_position
from pixstep.motor_record.model.state import State


def targets_become_readbacks(r: State) -> None:
    """Make all targets the newest position, also as the last ones."""
    newest_position(r)
    coordinates.targets_from_readback(r.v)
    coordinates.keep_as_last(r.v)
