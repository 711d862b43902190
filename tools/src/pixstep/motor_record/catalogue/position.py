# SPDX-License-Identifier: MIT
"""Fields of targets, positions and coordinates."""

from pixstep.motor_record.field import (
    button,
    choice,
    count,
    counted,
    flag,
    reading,
    setting,
)
from pixstep.motor_record.menus import DIRECTION, NO_YES, OFFSET, USE_SET

USER = ("LLM", "HLM")
DIAL = ("DLLM", "DHLM")
RAW = ("RLLM", "RHLM")

TARGETS = (
    setting("VAL", meaning="target, user coordinates", unit="EGU", processes=True, limits=USER),
    setting("DVAL", meaning="target, dial coordinates", unit="EGU", processes=True, limits=DIAL),
    count("RVAL", meaning="target, raw", unit="steps", processes=True, limits=RAW),
    setting("RLV", meaning="distance to move by, 0 afterwards", unit="EGU", processes=True),
    setting("TWV", meaning="distance of a tweak", unit="EGU"),
    button("TWF", meaning="tweak: move by TWV", processes=True),
    button("TWR", meaning="tweak: move by -TWV", processes=True),
    reading("LVAL", meaning="VAL of the last move", unit="EGU", monitored=False),
    reading("LDVL", meaning="DVAL of the last move", unit="EGU", monitored=False),
    counted("LRVL", meaning="RVAL of the last move", unit="steps", monitored=False),
    reading("LRLV", meaning="RLV of the last move", unit="EGU", monitored=False),
)

READBACKS = (
    reading("RBV", meaning="position, user coordinates", unit="EGU", limits=USER),
    reading("DRBV", meaning="position, dial coordinates", unit="EGU", limits=DIAL),
    counted("RRBV", meaning="position, raw", unit="steps", limits=RAW),
    counted("RMP", meaning="position as the motor counts", unit="steps"),
    counted("REP", meaning="position as the encoder counts", unit="counts"),
    counted("RVEL", meaning="raw speed", unit="steps/s"),
    reading("DIFF", meaning="DVAL - DRBV", unit="EGU"),
    counted("RDIF", meaning="DIFF in steps", unit="steps"),
)

COORDINATES = (
    setting("OFF", meaning="user = dial x direction + OFF", unit="EGU", processes=True),
    choice(
        "FOFF",
        menu=OFFSET,
        meaning="does setting a position change OFF or VAL",
        group="coordinates",
    ),
    button("FOF", meaning="write: FOFF becomes Frozen", monitored=False),
    button("VOF", meaning="write: FOFF becomes Variable", monitored=False),
    choice("DIR", menu=DIRECTION, meaning="direction of user against dial", processes=True),
    choice("SET", menu=USE_SET, meaning="targets move (Use) or say where the axis is (Set)"),
    button("SSET", meaning="write: SET becomes Set", monitored=False),
    button("SUSE", meaning="write: SET becomes Use", monitored=False),
    button("IGSET", meaning="SET has no effect"),
    button("SYNC", meaning="write 1: targets become readbacks", processes=True),
)

RESOLUTION = (
    setting("MRES", meaning="one step", unit="EGU", processes=True),
    setting("ERES", meaning="one count of the encoder", unit="EGU", processes=True),
    setting("RRES", meaning="one unit of what RDBL gives", unit="EGU"),
    count("SREV", meaning="steps of a revolution", unit="steps/rev", default=200, processes=True),
    setting("UREV", meaning="travel of a revolution", unit="EGU/rev", processes=True),
    choice("UEIP", menu=NO_YES, meaning="positions from the encoder", processes=True),
    choice("URIP", menu=NO_YES, meaning="positions from the link RDBL", processes=True),
)

LIMITS = (
    setting("HLM", meaning="high limit, user", unit="EGU", processes=True),
    setting("LLM", meaning="low limit, user", unit="EGU", processes=True),
    setting("DHLM", meaning="high limit, dial; with DLLM 0: none", unit="EGU", processes=True),
    setting("DLLM", meaning="low limit, dial", unit="EGU", processes=True),
    reading("RHLM", meaning="high limit, raw", unit="steps"),
    reading("RLLM", meaning="low limit, raw", unit="steps"),
    flag("LVIO", meaning="a target or the position violates a limit", default=1),
    flag("HLS", meaning="high limit switch, user direction"),
    flag("LLS", meaning="low limit switch, user direction"),
    flag("RHLS", meaning="high limit switch, raw direction"),
    flag("RLLS", meaning="low limit switch, raw direction"),
)

TABLE = TARGETS + READBACKS + COORDINATES + RESOLUTION + LIMITS
