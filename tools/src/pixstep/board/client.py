# SPDX-License-Identifier: MIT
"""All that a program needs to talk to a board, in one place.

board = Board(transport.serial_client("/dev/ttyACM0"))
board.set_pixel_hz(Fraction(30))
Upload(board, 0, queue_entries(line)).push()
board.command("arm", [0])
"""

from pixstep.board.device import Board
from pixstep.board.errors import (
    BoardError,
    ExceptionReplyError,
    LineLostError,
    LineRefusedByBoardError,
    MapVersionError,
    MissingFeatureError,
    NoReplyError,
)
from pixstep.board.state import (
    TRIP_ALREADY,
    TRIP_CLOSED,
    TRIP_NONE,
    TRIP_OPENED,
    Event,
    Record,
    Records,
    Switches,
    Trip,
)
from pixstep.board.upload import Upload, feed

__all__ = [
    "TRIP_ALREADY",
    "TRIP_CLOSED",
    "TRIP_NONE",
    "TRIP_OPENED",
    "Board",
    "BoardError",
    "Event",
    "ExceptionReplyError",
    "LineLostError",
    "LineRefusedByBoardError",
    "MapVersionError",
    "MissingFeatureError",
    "NoReplyError",
    "Record",
    "Records",
    "Switches",
    "Trip",
    "Upload",
    "feed",
]
