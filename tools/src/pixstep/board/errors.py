# SPDX-License-Identifier: MIT
"""What a board can fail to do; each ends a command with its own text.

The exit status is 1, or 3 for what the board refuses.
"""

from pixstep.errors import REFUSED, PlainError, RefusedError

ILLEGAL_FUNCTION, IMPOSSIBLE, BUSY = 1, 4, 6
EXCEPTIONS = {
    1: "illegal function",
    2: "illegal address",
    3: "illegal value",
    4: "device failure",
    5: "acknowledge",
    6: "busy",
}


class BoardError(PlainError):
    """The board did not do as asked: no reply, an exception answer, a refused line, a fault."""

    def __init__(self, message: str, code: int | None = None) -> None:
        super().__init__(message)
        self.code: int | None = code
        """Code of the Modbus exception, if the board has answered with one."""


class NoReplyError(BoardError):
    """Nothing came back, or nothing that could be read: then `heard` bytes did.

    `brief` is its text without what to look for.
    """

    def __init__(self, unit: int, what: str, place: str = "", heard: int = 0) -> None:
        where = f" on {place}" if place else ""
        text, cure = f"no reply to {what}", ""
        if heard:
            text = f"an unreadable reply to {what} ({heard} bytes)"
            cure = ": another rate or parity, or two boards with this address"
        elif place:
            cure = (
                ": check its power, the wiring, its address, rate and parity "
                "(`pixstep board scan --bauds` looks for boards)"
            )
        self.brief: str = f"board {unit}{where}: {text}"
        super().__init__(f"{self.brief}{cure}")
        self.unit, self.heard = unit, heard


class LineLostError(BoardError):
    """The port went away while it was open; a later request tries to open it again."""


class ExceptionReplyError(BoardError):
    """The board answered with a Modbus exception; `code` is its number."""

    status = REFUSED

    def __init__(self, unit: int, what: str, code: int) -> None:
        text = EXCEPTIONS.get(code, "unknown exception")
        super().__init__(f"board {unit}: {what} answered with exception {code}, {text}", code)


class BusTakenError(RefusedError):
    """Another program writes on the bus; the text names it. No board did anything wrong.

    It is no BoardError: what moves is the other program's, and nobody stops it for this.
    """


class OvertakenError(BoardError):
    """A request was not sent, because a stop that came after it went first."""


class EmergencyStoppedError(BoardError):
    """A motion was not begun: the emergency stop is latched, and only a person clears it."""

    ADVICE = "the emergency stop is pressed: release it, then `pixstep board clear`"


class NotPossibleError(BoardError):
    """The board does not take a command in the state that it is in."""

    status = REFUSED


class BusyError(ExceptionReplyError):
    """The board takes no settings now; the text says what it is busy with and what ends that."""

    def __init__(self, unit: int, code: int, reason: str) -> None:
        BoardError.__init__(self, f"board {unit}: busy: {reason}", code)


class MissingFeatureError(BoardError):
    """The board's image was built without what was asked for; `feature` is its name."""

    status = REFUSED

    def __init__(self, unit: int, feature: str, bit: int, meaning: str) -> None:
        super().__init__(
            f"board {unit}: its image is built without {feature} (bit {bit % 16} of register "
            f"features{'_high' * (bit > 15)} is 0): {meaning}",
            ILLEGAL_FUNCTION,
        )
        self.unit, self.feature = unit, feature


class MapVersionError(BoardError):
    """The board and this tool know different register maps."""


class LineRefusedByBoardError(BoardError):
    """The board refused a line while it was queued; `name` and `pixel` say what and where."""

    status = REFUSED

    def __init__(self, axis: int, name: str, pixel: int, text: str) -> None:
        super().__init__(f"axis {axis}: line refused: {name} at pixel {pixel}: {text}")
        self.axis, self.name, self.pixel = axis, name, pixel


class FaultError(BoardError):
    """A fault has stopped the board; `name` is the fault's, as docs/FAULTS.md has it."""

    def __init__(self, message: str, name: str) -> None:
        super().__init__(message)
        self.name: str = name
        """Name of the fault."""


class MotionStoppedError(BoardError):
    """A motion was stopped before its end: by `stop`, or because its bus was closed."""


class MotionTimeoutError(BoardError, TimeoutError):
    """A motion takes longer than it was waited for; it goes on."""
