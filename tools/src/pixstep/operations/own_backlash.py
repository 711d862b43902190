# SPDX-License-Identifier: MIT
"""The backlash that a line was made with, beside the one that an operation is given.

A line file whose header has it is for that backlash: its counts leave room for the take-up, and a
machine file that says another one today does not change them. What the caller says comes first all
the same, and every difference is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pixstep.lines.line import SMOOTH

if TYPE_CHECKING:
    from pixstep.formats import ProfileHeader
    from pixstep.operations.desk import Desk


def taken(
    desk: Desk, name: str, header: ProfileHeader | None, counts: Sequence[int], decode: str,
    asked: int,
) -> int:  # fmt: skip
    """Return the backlash that a line takes up; what it says otherwise, or does not say, is said.

    `asked` is the operation's: the caller's, the machine file's or the default.
    """
    if decode != SMOOTH:
        return asked
    own = header.backlash if header else None
    given = desk.given("backlash")
    if own is None:
        if not given and _has_room(counts):
            desk.say((_unsaid(desk, name, asked),))
        return asked
    if given:
        if own != asked:
            desk.say((f"{name}: made for a backlash of {own} steps, {asked} is taken as asked",))
        return asked
    if own != asked and desk.by_machine("backlash"):
        desk.say((
            f"{name}: its own backlash of {own} steps is taken; {desk.facts.machine.path} has "
            f"{asked}",
        ))  # fmt: skip
    return own


def _has_room(counts: Sequence[int]) -> bool:
    """True if a line begins and ends as those do that take play up."""
    return len(counts) > 2 and not counts[0] and not counts[-1] and any(counts)


def _unsaid(desk: Desk, name: str, asked: int) -> str:
    """Return that a line has room for a take-up and does not say of how many steps."""
    if desk.by_machine("backlash"):
        return (
            f"{name}: does not say the backlash that it was made for: the {asked} steps of "
            f"{desk.facts.machine.path} are taken"
        )
    return (
        f"{name}: begins and ends without steps, as lines do that take up backlash, and does not "
        f"say how much: none is taken up"
    )
