# SPDX-License-Identifier: MIT
"""The bits of MIP: what the record has asked of the motor and has not seen end."""

from typing import Final


class Mip:
    """What is in progress. Plain numbers, since every processing asks for some of them."""

    DONE: Final = 0
    JOGF: Final = 0x0001
    JOGR: Final = 0x0002
    JOG_BL1: Final = 0x0004
    """The jog is over, the motor goes to where the approach against backlash begins."""
    HOMF: Final = 0x0008
    HOMR: Final = 0x0010
    MOVE: Final = 0x0020
    RETRY: Final = 0x0040
    LOAD_P: Final = 0x0080
    MOVE_BL: Final = 0x0100
    """The second leg of a move: the approach against backlash."""
    STOP: Final = 0x0200
    """The motor is to stop. With HOMF or JOGF and so on, that begins after the stop."""
    DELAY_REQ: Final = 0x0400
    """The settling time DLY runs."""
    DELAY_ACK: Final = 0x0800
    """The settling time is over."""
    JOG_REQ: Final = 0x1000
    """A jog is wanted."""
    JOG_STOP: Final = 0x2000
    JOG_BL2: Final = 0x4000
    """The approach against backlash after a jog."""
    EXTERNAL: Final = 0x8000
    """Others move the motor."""

    DELAY: Final = DELAY_REQ | DELAY_ACK
    HOME: Final = HOMF | HOMR
    JOGGING: Final = JOGF | JOGR
    JOG: Final = JOGF | JOGR | JOG_BL1 | JOG_BL2
    AFTER_JOG: Final = JOG_STOP | JOG_BL1 | JOG_BL2
