# SPDX-License-Identifier: MIT
"""What the rules know about the boards: the constants and timers of firmware/avr/boards/*.def, and
the part's interrupt vectors as avr-libc numbers them."""

import functools
import re
from dataclasses import dataclass
from pathlib import Path

from avr_image import run
from common import ROOT

FOLDER = ROOT / "firmware" / "avr" / "boards"

CONSTANT = re.compile(r'^#define BOARD_(\w+) +("[^"]*"|[^\s/]+)', re.MULTILINE)
AXIS = re.compile(r"^BOARD_AXIS\((\d+), *(\d+)\)", re.MULTILINE)
VECTOR = re.compile(r"^#define (\w+)_vect_num +(\d+)", re.MULTILINE)

# The handlers of the serial port, by the part's name for it.
SERIAL = ("RX", "UDRE", "TX")


@dataclass(frozen=True)
class Board:
    """One board: its constants without BOARD_ and quotes, the timer of each axis, vectors."""

    constants: dict[str, str]
    timers: tuple[int, ...]
    vectors: dict[str, int]

    def number(self, name: str) -> int:
        """The value of a constant that is a number."""
        return int(self.constants[name], 0)

    @property
    def serial_vectors(self) -> set[int]:
        """The three handlers of the serial port."""
        port = "USART0" if "USART0_RX" in self.vectors else "USART"
        return {self.vectors[f"{port}_{handler}"] for handler in SERIAL}

    def timer_vectors(self, handler: str) -> list[int]:
        """One handler (OVF, COMPA, ...) of each axis's timer, in the order of axes."""
        return [self.vectors[f"TIMER{timer}_{handler}"] for timer in self.timers]

    @property
    def pixel_clock_vector(self) -> int:
        """The handler of the pixel clock's edges."""
        return self.vectors[f"TIMER{self.number('PIXEL_CLOCK_TIMER')}_CAPT"]


def names() -> list[str]:
    """All boards, in the order of BOARD_ID."""
    return sorted((path.stem for path in FOLDER.glob("*.def")), key=_board_id)


def _constants(name: str) -> dict[str, str]:
    """The constants of one board file."""
    text = (FOLDER / f"{name}.def").read_text(encoding="utf-8")
    return {constant: value.strip('"') for constant, value in CONSTANT.findall(text)}


def _board_id(name: str) -> int:
    return int(_constants(name)["ID"])


@functools.cache
def load(name: str) -> Board:
    """Read a board; ImageError if avr-gcc is missing or does not know the part."""
    constants = _constants(name)
    text = (FOLDER / f"{name}.def").read_text(encoding="utf-8")
    timers = tuple(int(timer) for _, timer in sorted(AXIS.findall(text)))
    return Board(constants, timers, _vectors(constants["MCU"]))


def _vectors(mcu: str) -> dict[str, int]:
    """The part's vectors by name."""
    header = Path(__file__).with_name("vectors.h")
    macros = run(["avr-gcc", f"-mmcu={mcu}", "-E", "-dM", str(header)])
    return {vector: int(number) for vector, number in VECTOR.findall(macros)}
