# SPDX-License-Identifier: MIT
"""The conformance list, and what every client needs to know of the board for it."""

from collections.abc import Callable
from dataclasses import dataclass

from pixstep.board import boards

OK = "ok"
REFUSED = "01"  # the board's image is without the feature, and says so by exception 01
NOT_OFFERED = "-"  # the client has no way to ask for it
FAIL = "FAIL"


class ConformanceError(Exception):
    """The board did not do as a case wants."""


class AnsweredError(ConformanceError):
    """The board answered with an exception that the case does not want; `code` is its number."""

    def __init__(self, code: int, text: str = "") -> None:
        super().__init__(text or f"exception {code}")
        self.code = code


# The feature that a function belongs to (firmware/build_features.def); others are in every image.
FEATURE_OF = (
    dict.fromkeys(("01", "02", "05", "15"), "bits")
    | dict.fromkeys(("08", "17", "22", "23", "43/14"), "diagnosis")
    | {"20": "files"}
)


@dataclass(frozen=True)
class ClientCase:
    """One case: its name, the function, what is asked for and what must come."""

    name: str
    function: str
    about: str

    @property
    def feature(self) -> str:
        """The feature that a board needs for it, empty if none."""
        return FEATURE_OF.get(self.function, "")

    def is_served(self, has: frozenset[str]) -> bool:
        """Whether a board with these features serves it; else it must refuse it."""
        return not self.feature or self.feature in has

    def of(self, checks: object) -> Callable[[], None] | None:
        """Return the method for this case, `c_` and its name with underscores; None if none is."""
        word = self.name.lower().replace(" ", "_").replace("-", "_")
        return getattr(checks, f"c_{word}", None)


def run_list(checks: object, has: frozenset[str]) -> dict[str, str]:
    """Return the result of every case; what goes wrong in one is that one's.

    `has` is what the board says that it has: without its feature a case must end with exception 01.
    """
    return {case.name: _result(case.of(checks), case.is_served(has)) for case in CASES}


def _result(check: Callable[[], None] | None, served: bool) -> str:
    if check is None:
        return NOT_OFFERED
    try:
        check()
    except Exception as error:
        if not served and getattr(error, "code", 0) == 1:
            return REFUSED
        return f"{FAIL}: {error or type(error).__name__}"
    return OK if served else f"{FAIL}: served without its feature"


def same(found: object, wanted: object) -> None:
    """Raise ConformanceError unless both are equal."""
    if found != wanted:
        raise ConformanceError(f"{found}, not {wanted}")


CASES = (
    ClientCase("coils read", "01", "driver and permit coils, as register `outputs` has them"),
    ClientCase("discrete inputs read", "02", "the first 16, as register `status` has them"),
    ClientCase("holding registers read", "03", "all settings are their defaults"),
    ClientCase("input registers read", "04", "version of the map, board, axes"),
    ClientCase("coil written", "05", "a driver on, seen in its coil and in `outputs`, and off"),
    ClientCase("register written", "06", "one setting, echoed and read back"),
    ClientCase("loopback", "08", "data come back as they were sent"),
    ClientCase("counter of exceptions", "08", "sub-function 13 counts a refused request"),
    ClientCase("coils written", "15", "permit on and off, seen in its coil"),
    ClientCase("registers written", "16", "two settings at once, read back"),
    ClientCase("server id", "17", "byte count, board, run indicator, text"),
    ClientCase("mask write", "22", "(value AND and-mask) OR (or-mask AND NOT and-mask)"),
    ClientCase(
        "write and read", "23", "two settings written, four read, the new values among them"
    ),
    ClientCase("device identification", "43/14", "vendor, product code, revision"),
    ClientCase("file record", "20", "settings as file 3"),
    ClientCase("32-bit pair read", "04", "pixel period, high word first"),
    ClientCase(
        "32-bit pair written", "16", "pixel frequency, high word first, and the period follows"
    ),
    ClientCase("exception 01", "07", "a function that is not served"),
    ClientCase("exception 02", "03", "a range that ends behind what is mapped"),
    ClientCase("exception 03", "06", "a value out of its range; the setting stays"),
    ClientCase("exception 06", "06", "a setting while a line is queued"),
    ClientCase("broadcast", "16", "a setting written to all: no reply, and it counts"),
    ClientCase("nothing by halves", "16", "two settings, the second out of range: both stay"),
    ClientCase("125 words read", "04", "a whole reply"),
    ClientCase("126 words", "03", "exception 03"),
    ClientCase(
        "123 words written", "16", "no more is mapped: exception 02, so the number was right"
    ),
    ClientCase("124 words", "16", "exception 03"),
    ClientCase("121 words in 23", "23", "exception 02, so the number was right"),
    ClientCase("2000 bits", "01", "exception 02, so the number was right"),
    ClientCase("2001 bits", "01", "exception 03"),
    ClientCase("1968 bits written", "15", "exception 02, so the number was right"),
    ClientCase("1969 bits", "15", "exception 03"),
)

UNIT = 1

# Input registers.
OUTPUTS = 0x0061
STATUS = 0x0004
FEATURES = 0x0068
PERIOD = 0x0014
RECORDS = 0x0100

# Holding registers, their defaults, and other values within their ranges.
DEFAULTS = (
    1, 1152, 0, 30, 0, 1, 20, 20, 0, 0, 1000, 0, 0, 2, 0, 3000, 0, 0, 1, 10_000, 4, 1, 1, 0, 0, 0,
)  # fmt: skip
PIXEL_HZ = 2
DIR_SETUP, DIR_HOLD = 6, 7
DIR_DEFAULT = 20
COMMAND = 0x0100
DISCARD = 5
QUEUE = 0x1000

# Coils.
DRIVER_0 = 0
PERMIT = 13


def period_ticks(board: str, hz: int) -> int:
    """Return the whole ticks of a board's pixel period."""
    return boards.load(board).tick_hz // hz


def block(number: int) -> list[int]:
    """Return the words of a queue block: axis 0, a line start, its parameters, a run."""
    return [number & 0xFFFF, 0, 0x0021, 0, 0, 0, 1, 10]
