# SPDX-License-Identifier: MIT
"""How much a difference between a job's configuration and today's means: the rule of each field.

A key field decided the counts of the lines when the job was made: the machine cannot make a
difference good while it prints.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

Keys = tuple[str, ...]
ANY = "*"


class Colour(IntEnum):
    """What a difference means, the worst last."""

    GREEN = 0
    """Equal."""
    GREY = 1
    """It differs, and makes no difference."""
    AMBER = 2
    """It differs: a person has to agree before anything moves."""
    RED = 3
    """It differs: the job must not be printed."""

    @property
    def word(self) -> str:
        """Its name."""
        return self.name.lower()


GREEN, GREY, AMBER, RED = Colour.GREEN, Colour.GREY, Colour.AMBER, Colour.RED


@dataclass(frozen=True)
class Rule:
    """What a difference of a field means, and why."""

    colour: Colour
    why: str
    key: bool = False


_NAMES_ONLY = Rule(GREY, "where the board is found")
_DEFAULT = Rule(GREY, "a default of other commands")
_LIMIT = Rule(AMBER, "the lines still keep it, or their own row says not")
_PLACE = Rule(AMBER, "the job's lines have their own")

RULES: dict[Keys, Rule] = {
    ("clock", "pixel"): Rule(RED, "the counts are per pixel of the job's clock", key=True),
    ("clock", "divider"): Rule(RED, "the counts are per pixel of so many edges", key=True),
    ("clock", "sync"): Rule(AMBER, "lines follow the clock in another way"),
    ("clock", "gate_edges"): Rule(AMBER, "line zero is at another edge of a burst"),
    ("line", "motor"): _DEFAULT,
    ("line", "pixels"): _DEFAULT,
    ("line", "lead_in"): _PLACE,
    ("line", "lead_out"): _PLACE,
    ("line", "scan_offset_forward"): _PLACE,
    ("line", "scan_offset_back"): _PLACE,
    ("program", ANY): _DEFAULT,
    ("epics", ANY): _DEFAULT,
    ("boards", ANY, "kind"): Rule(RED, "another kind of board", key=True),
    ("boards", ANY, "port"): _NAMES_ONLY,
    ("boards", ANY, "unit"): _NAMES_ONLY,
    ("boards", ANY, "baud"): _NAMES_ONLY,
    ("boards", ANY, "parity"): _NAMES_ONLY,
    ("boards", ANY, "clock_out_hz"): Rule(AMBER, "the pixel clock comes from another source"),
    ("motors", ANY, "board"): Rule(RED, "the motor is on another board", key=True),
    ("motors", ANY, "axis"): Rule(RED, "the motor is on another axis", key=True),
    ("motors", ANY, "kind"): Rule(RED, "the counts are decoded in another way", key=True),
    ("motors", ANY, "steps_per_unit"): Rule(RED, "the counts are of another length", key=True),
    ("motors", ANY, "direction"): Rule(RED, "the load would run the other way", key=True),
    ("motors", ANY, "backlash"): Rule(AMBER, "no line of this motor takes it up"),
    ("motors", ANY, "word"): _DEFAULT,
    ("motors", ANY, "home_is_limit"): Rule(AMBER, "homing stops at another switch"),
    ("motors", ANY, "limits", ANY): _LIMIT,
    ("motors", ANY, "epics", ANY): _DEFAULT,
    ("motors", ANY, "epics", ANY, ANY): _DEFAULT,
    ("motors", ANY, "profiles", ANY): Rule(GREY, "the name of a file; its content has its own row"),
}
HAPS = Rule(AMBER, "homing is faster or slower")
NOT_USED = Rule(GREY, "not in the job")
UNKNOWN = Rule(AMBER, "this pixstep does not know the key")
GONE = Rule(RED, "the machine does not have it any more")
LINES = Rule(RED, "a line is refused by what the machine can do today")
LAYOUT = Rule(GREY, "comments or layout")

# What a board holds; a run writes its clock, so that a difference can be made good.
BOARD_KIND = Rule(RED, "another board answers there", key=True)
BOARD_AXIS = Rule(RED, "the board does not have the axis", key=True)
BOARD_ABSENT = Rule(RED, "it does not answer")
BOARD_FEATURE = Rule(RED, "its image cannot take up play")
BOARD_CLOCK = Rule(AMBER, "the board is set otherwise until a run sets it", key=True)
BOARD_FOLLOWS = Rule(AMBER, "the board is set otherwise until a run sets it")
BOARD_POLICY = Rule(AMBER, "play would be taken up at reversals only")
BOARD_SETTING = Rule(AMBER, "the board is set otherwise than when the job was made")
BOARD_OWN = Rule(GREY, "not as delivered; the job does not say what it should be")
BOARD_PORT = Rule(GREY, "how the board is spoken to")
FIRMWARE = Rule(AMBER, "another image than when the job was made")


def of(keys: Keys) -> Rule:
    """Return the rule of a field of a machine file."""
    for pattern, rule in RULES.items():
        if len(pattern) == len(keys) and all(
            one in (ANY, key) for one, key in zip(pattern, keys, strict=True)
        ):
            return rule
    return UNKNOWN


def profile(use: str, *, used: bool, from_files: bool) -> Rule:
    """Return the rule of what a profile holds: one that the lines were made by decided them."""
    if used:
        return Rule(RED, "the lines were made by another profile", key=True)
    if use != "line":
        return Rule(AMBER, "moves before and after the lines differ")
    if from_files:
        return Rule(AMBER, "the lines came from files that may have been made by it")
    return Rule(GREY, "no line was made by it")


def backlash(job: int, today: int, speed: int) -> Rule:
    """Return the rule of the play that a motor's lines take up, all in steps and steps/pixel."""
    if max(job, today) > speed:
        return Rule(RED, f"it does not fit a pixel at {speed} steps/px", key=True)
    if not job:
        return Rule(RED, "the lines have no room to take play up", key=True)
    if not today:
        return Rule(RED, "the lines take up play that the motor does not have", key=True)
    return Rule(AMBER, f"the job's {job} steps are sent", key=True)
