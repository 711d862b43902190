# SPDX-License-Identifier: MIT
"""The backlash that a line was made with, beside the one that it is asked to take up.

A line file whose header has it is for that backlash: its counts leave room for the take-up, and a
machine file that says another one today does not change them. What the caller says comes first all
the same, and every difference is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pixstep.formats import ProfileHeader
from pixstep.lines.line import SMOOTH


@dataclass(frozen=True)
class AskedBacklash:
    """A backlash in steps, and who says it: the caller, a machine file by its name, or nobody."""

    steps: int
    given: bool = False
    machine: str = ""


def taken(
    name: str, header: ProfileHeader | None, counts: Sequence[int], decode: str,
    asked: AskedBacklash,
) -> tuple[int, list[str]]:  # fmt: skip
    """Return the backlash that a line takes up, and what it says otherwise, or does not say."""
    if decode != SMOOTH:
        return asked.steps, []
    own = header.backlash if header else None
    if own is None:
        unsaid = not asked.given and _has_room(counts)
        return asked.steps, [_unsaid(name, asked)] if unsaid else []
    if asked.given:
        text = f"{name}: made for a backlash of {own} steps, {asked.steps} is taken as asked"
        return asked.steps, [text] if own != asked.steps else []
    text = f"{name}: its own backlash of {own} steps is taken; {asked.machine} has {asked.steps}"
    return own, [text] if asked.machine and own != asked.steps else []


def _has_room(counts: Sequence[int]) -> bool:
    """True if a line begins and ends as those do that take play up."""
    return len(counts) > 2 and not counts[0] and not counts[-1] and any(counts)


def _unsaid(name: str, asked: AskedBacklash) -> str:
    """Return that a line has room for a take-up and does not say of how many steps."""
    if asked.machine:
        return (
            f"{name}: does not say the backlash that it was made for: the {asked.steps} steps of "
            f"{asked.machine} are taken"
        )
    return (
        f"{name}: begins and ends without steps, as lines do that take up backlash, and does not "
        f"say how much: none is taken up"
    )
