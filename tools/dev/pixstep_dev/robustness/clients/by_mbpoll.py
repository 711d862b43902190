# SPDX-License-Identifier: MIT
"""The conformance list by mbpoll, as a person would type it: -0 for addresses from 0 on, -B for
pairs with the high word first.
"""

import re
import shutil
import subprocess

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.errors import UserError
from pixstep_dev.robustness.clients import cases
from pixstep_dev.robustness.clients.cases import AnsweredError, ConformanceError, same

_LIMIT_S = 120
_VALUE = re.compile(r"^\[(\d+)\]:\s+(-?\w+)", re.M)
_EXCEPTIONS = {
    1: "Illegal function",
    2: "Illegal data address",
    3: "Illegal data value",
    6: "Slave device or server is busy",
}
COIL, DISCRETE, INPUT, HOLDING = "0", "1", "3", "4"


def run(port: str, board: str) -> dict[str, str]:
    """Return the result of every case."""
    if shutil.which("mbpoll") is None:
        raise UserError("mbpoll is missing: tools/setup installs it")
    poll = _Poll(port)
    return cases.run_list(
        _MbpollCases(poll, board), boards.feature_names(poll.read(INPUT, cases.FEATURES)[0])
    )


class _Poll:
    """Calls of mbpoll on one port."""

    def __init__(self, port: str) -> None:
        self._words = [
            "mbpoll",
            "-m",
            "rtu",
            "-b",
            "115200",
            "-P",
            "none",
            "-a",
            str(cases.UNIT),
            "-o",
            "10",
        ]
        self._port = port

    def call(self, *options: str, values: tuple[int, ...] = ()) -> str:
        """Return what one call prints."""
        words = [*self._words, "-0", "-1", *options, self._port, *map(str, values)]
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, timeout=_LIMIT_S, check=False
            )
        except subprocess.TimeoutExpired:
            raise ConformanceError("mbpoll does not end") from None
        return done.stdout + done.stderr

    def read(self, kind: str, address: int, count: int = 1) -> list[int]:
        """Return values."""
        text = self.call("-t", kind, "-B", "-r", str(address), "-c", str(count))
        found = [int(value, 0) & 0xFFFFFFFF for _, value in _VALUE.findall(text)]
        if len(found) != count:
            raise _error(text)
        return found

    def write(self, kind: str, address: int, *values: int) -> None:
        """Write values."""
        text = self.call("-t", kind, "-B", "-r", str(address), values=values)
        if f"Written {len(values)} reference" not in text:
            raise _error(text)

    def refused(self, code: int, kind: str, address: int, *values: int, count: int = 1) -> None:
        """The call must end with this exception."""
        options: tuple[str, ...] = ("-t", kind, "-r", str(address))
        options += () if values else ("-c", str(count))
        text = self.call(*options, values=values)
        if _EXCEPTIONS[code] not in text:
            raise _error(text)


def _error(text: str, about: str = "") -> ConformanceError:
    """Return the error for what mbpoll printed, with the exception that it names."""
    words = f"{about}{_last(text)}"
    for code, name in _EXCEPTIONS.items():
        if name in text:
            return AnsweredError(code, words)
    return ConformanceError(words)


def _last(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no output"


class _MbpollCases:
    """A method for every case that mbpoll has a way to ask for."""

    def __init__(self, poll: _Poll, board: str) -> None:
        self.poll, self.board = poll, board

    def reset(self) -> None:
        self.poll.write(HOLDING, cases.DIR_SETUP, cases.DIR_DEFAULT, cases.DIR_DEFAULT)

    def c_coils_read(self) -> None:
        outputs = self.poll.read(INPUT, cases.OUTPUTS)[0]
        same(self.poll.read(COIL, cases.DRIVER_0), [outputs & 1])
        same(self.poll.read(COIL, cases.PERMIT), [outputs >> 8 & 1])

    def c_discrete_inputs_read(self) -> None:
        bits = self.poll.read(DISCRETE, 0, 16)
        status = self.poll.read(INPUT, cases.STATUS)[0]
        same(sum(bit << index for index, bit in enumerate(bits)), status)

    def c_holding_registers_read(self) -> None:
        same(tuple(self.poll.read(HOLDING, 0, len(cases.DEFAULTS))), cases.DEFAULTS)

    def c_input_registers_read(self) -> None:
        version, _, number, axes = self.poll.read(INPUT, 0, 4)
        wanted = (regs.MAP_VERSION, boards.load(self.board).id, boards.load(self.board).axes)
        same((version, number, axes), wanted)

    def c_coil_written(self) -> None:
        for on in (1, 0):
            self.poll.write(COIL, cases.DRIVER_0, on)
            same(self.poll.read(COIL, cases.DRIVER_0), [on])
            same(self.poll.read(INPUT, cases.OUTPUTS)[0] & 1, on)

    def c_register_written(self) -> None:
        self.poll.write(HOLDING, cases.DIR_SETUP, 33)
        same(self.poll.read(HOLDING, cases.DIR_SETUP), [33])
        self.reset()

    def c_coils_written(self) -> None:
        # Fault cleared where there is none, and permit: two coils side by side.
        for on in (1, 0):
            self.poll.write(COIL, cases.PERMIT - 1, 0, on)
            same(self.poll.read(COIL, cases.PERMIT), [on])

    def c_registers_written(self) -> None:
        self.poll.write(HOLDING, cases.DIR_SETUP, 41, 42)
        same(self.poll.read(HOLDING, cases.DIR_SETUP, 2), [41, 42])
        self.reset()

    def c_server_id(self) -> None:
        text = self.poll.call("-u")
        for wanted in (f"pixstep {self.board}", "Status: Off"):
            if wanted.lower() not in text.lower():
                raise _error(text, f"no {wanted!r}: ")

    def c_32_bit_pair_read(self) -> None:
        same(self.poll.read(f"{INPUT}:int", cases.PERIOD), [cases.period_ticks(self.board, 30)])

    def c_32_bit_pair_written(self) -> None:
        self.poll.write(f"{HOLDING}:int", cases.PIXEL_HZ, 50)
        found = self.poll.read(f"{INPUT}:int", cases.PERIOD)
        self.poll.write(f"{HOLDING}:int", cases.PIXEL_HZ, 30)
        same(found, [cases.period_ticks(self.board, 50)])

    def c_exception_03(self) -> None:
        self.poll.refused(3, HOLDING, cases.DIR_SETUP, 0)
        same(self.poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_exception_06(self) -> None:
        self.poll.write(HOLDING, cases.QUEUE, *cases.block(self.poll.read(INPUT, 0x0022)[0]))
        try:
            self.poll.refused(6, HOLDING, cases.DIR_SETUP, 33)
        finally:
            self.poll.write(HOLDING, cases.COMMAND, 1, cases.DISCARD)
        same(self.poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_nothing_by_halves(self) -> None:
        self.poll.refused(3, HOLDING, cases.DIR_SETUP, 71, 0)
        same(self.poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_exception_02(self) -> None:
        self.poll.refused(2, HOLDING, len(cases.DEFAULTS) - 1, count=2)

    def c_125_words_read(self) -> None:
        same(len(self.poll.read(INPUT, cases.RECORDS, 125)), 125)

    def c_123_words_written(self) -> None:
        self.poll.refused(2, HOLDING, 0, *[1] * 123)
