# SPDX-License-Identifier: MIT
"""The conformance list by mbpoll, as a person would type it: -0 for addresses from 0 on, -B for
pairs with the high word first.
"""

import re
import shutil
import subprocess
from collections.abc import Callable

from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.hostile.clients import cases

_LIMIT_S = 20
_VALUE = re.compile(r"^\[(\d+)\]:\s+(-?\w+)", re.M)
_EXCEPTIONS = {
    1: "Illegal function",
    2: "Illegal data address",
    3: "Illegal data value",
    6: "Slave device or server is busy",
}
COIL, DISCRETE, INPUT, HOLDING = "0", "1", "3", "4"


class ConformanceError(Exception):
    """The board did not do as a case wants."""


def run(port: str, board: str) -> dict[str, str]:
    """Return the result of every case."""
    if shutil.which("mbpoll") is None:
        raise UserError("mbpoll is missing: tools/setup installs it")
    checks = _checks(_Poll(port), board)
    return {case.name: _one(checks.get(case.name)) for case in cases.CASES}


def _one(check: Callable[[], None] | None) -> str:
    if check is None:
        return cases.NOT_OFFERED
    try:
        check()
    except ConformanceError as error:
        return f"{cases.FAIL}: {error}"
    return cases.OK


def _same(found: object, wanted: object) -> None:
    if found != wanted:
        raise ConformanceError(f"{found}, not {wanted}")


class _Poll:
    """Calls of mbpoll on one port."""

    def __init__(self, port: str) -> None:
        self._words = ["mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-a", str(cases.UNIT)]
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
            raise ConformanceError(_last(text))
        return found

    def write(self, kind: str, address: int, *values: int) -> None:
        """Write values."""
        text = self.call("-t", kind, "-B", "-r", str(address), values=values)
        if f"Written {len(values)} reference" not in text:
            raise ConformanceError(_last(text))

    def refused(self, code: int, kind: str, address: int, *values: int, count: int = 1) -> None:
        """The call must end with this exception."""
        options = ("-t", kind, "-r", str(address))
        options += () if values else ("-c", str(count))
        text = self.call(*options, values=values)
        if _EXCEPTIONS[code] not in text:
            raise ConformanceError(_last(text))


def _last(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no output"


def _checks(poll: _Poll, board: str) -> dict[str, Callable[[], None]]:
    """Return the check of every case that mbpoll has a way to ask for."""

    def reset() -> None:
        poll.write(HOLDING, cases.DIR_SETUP, cases.DIR_DEFAULT, cases.DIR_DEFAULT)

    def coils_read() -> None:
        outputs = poll.read(INPUT, cases.OUTPUTS)[0]
        _same(poll.read(COIL, cases.DRIVER_0), [outputs & 1])
        _same(poll.read(COIL, cases.PERMIT), [outputs >> 8 & 1])

    def discrete_inputs_read() -> None:
        bits = poll.read(DISCRETE, 0, 16)
        status = poll.read(INPUT, cases.STATUS)[0]
        _same(sum(bit << index for index, bit in enumerate(bits)), status)

    def holding_registers_read() -> None:
        _same(tuple(poll.read(HOLDING, 0, len(cases.DEFAULTS))), cases.DEFAULTS)

    def input_registers_read() -> None:
        version, _, number, axes = poll.read(INPUT, 0, 4)
        wanted = (3, boards.BOARD_NAMES.index(board) + 1, boards.load(board).axes)
        _same((version, number, axes), wanted)

    def coil_written() -> None:
        for on in (1, 0):
            poll.write(COIL, cases.DRIVER_0, on)
            _same(poll.read(COIL, cases.DRIVER_0), [on])
            _same(poll.read(INPUT, cases.OUTPUTS)[0] & 1, on)

    def register_written() -> None:
        poll.write(HOLDING, cases.DIR_SETUP, 33)
        _same(poll.read(HOLDING, cases.DIR_SETUP), [33])
        reset()

    def coils_written() -> None:
        # Fault cleared where there is none, and permit: two coils side by side.
        for on in (1, 0):
            poll.write(COIL, cases.PERMIT - 1, 0, on)
            _same(poll.read(COIL, cases.PERMIT), [on])

    def registers_written() -> None:
        poll.write(HOLDING, cases.DIR_SETUP, 41, 42)
        _same(poll.read(HOLDING, cases.DIR_SETUP, 2), [41, 42])
        reset()

    def server_id() -> None:
        text = poll.call("-u")
        for wanted in (f"pixstep {board}", "Status: Off"):
            if wanted.lower() not in text.lower():
                raise ConformanceError(f"no {wanted!r}: {_last(text)}")

    def pair_read() -> None:
        _same(poll.read(f"{INPUT}:int", cases.PERIOD), [cases.PERIOD_30_HZ])

    def pair_written() -> None:
        poll.write(f"{HOLDING}:int", cases.PIXEL_HZ, 50)
        found = poll.read(f"{INPUT}:int", cases.PERIOD)
        poll.write(f"{HOLDING}:int", cases.PIXEL_HZ, 30)
        _same(found, [cases.PERIOD_50_HZ])

    def exception_03() -> None:
        poll.refused(3, HOLDING, cases.DIR_SETUP, 0)
        _same(poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def exception_06() -> None:
        poll.write(HOLDING, cases.QUEUE, *cases.block(poll.read(INPUT, 0x0022)[0]))
        try:
            poll.refused(6, HOLDING, cases.DIR_SETUP, 33)
        finally:
            poll.write(HOLDING, cases.COMMAND, 1, cases.DISCARD)
        _same(poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def nothing_by_halves() -> None:
        poll.refused(3, HOLDING, cases.DIR_SETUP, 71, 0)
        _same(poll.read(HOLDING, cases.DIR_SETUP), [cases.DIR_DEFAULT])

    return {
        "coils read": coils_read,
        "discrete inputs read": discrete_inputs_read,
        "holding registers read": holding_registers_read,
        "input registers read": input_registers_read,
        "coil written": coil_written,
        "register written": register_written,
        "coils written": coils_written,
        "registers written": registers_written,
        "server id": server_id,
        "32-bit pair read": pair_read,
        "32-bit pair written": pair_written,
        "exception 02": lambda: poll.refused(2, HOLDING, len(cases.DEFAULTS) - 1, count=2),
        "exception 03": exception_03,
        "exception 06": exception_06,
        "nothing by halves": nothing_by_halves,
        "125 words read": lambda: _same(len(poll.read(INPUT, cases.RECORDS, 125)), 125),
        "123 words written": lambda: poll.refused(2, HOLDING, 0, *[1] * 123),
    }
