# SPDX-License-Identifier: MIT
"""Saturate the bus with valid requests of many kinds while the board moves."""

from collections.abc import Callable
from functools import partial
from itertools import cycle, islice

from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.upload import Upload
from pixstep.simulation.simctl import Simulator

_BURST = 4  # requests between two polls of the run
_MAX_READ = 125  # registers in one read


class SerialLoad:
    """A rotation of requests, sent back to back: the next follows the reply after the silence.

    Maximum-size reads and writes are among them; the write repeats the last queue block, which
    the board acknowledges and drops. `exceptions` counts exception answers (a setting that may
    not change while moving is one), which are valid traffic too.
    """

    def __init__(self, board: Board, axes: list[int], uploads: dict[int, Upload]) -> None:
        self.sent = 0
        self.exceptions = 0
        self._board = board
        self._uploads = uploads
        self._requests = cycle(self._kinds(axes))

    def until(self, simulator: Simulator, cycle: int) -> None:
        """Send at least one request, at most _BURST, until the simulated time is `cycle`.

        Raises BoardError only if one stays without a reply.
        """
        for request in islice(self._requests, _BURST):
            self.sent += 1
            try:
                request()
            except BoardError as error:
                if error.code is None:
                    raise
                self.exceptions += 1
            if simulator.cycle >= cycle:
                return

    def _kinds(self, axes: list[int]) -> list[Callable[[], object]]:
        """Return one rotation of requests."""
        board = self._board
        records = regs.RECORD_STRIDE * (axes[-1] + 1)
        setup = board.map.holding("dir_setup_us")
        setup_us = board.read_holdings(setup.address, 1)[0]
        kinds: list[Callable[[], object]] = [
            lambda: board.read_inputs(regs.RECORD_BASE, min(records, _MAX_READ)),
            board.inputs,
            board.identify if board.has("diagnosis") else board.who,
            lambda: board.read_holdings(0, 6),
            lambda: board.write_one(setup.address, setup_us),
            lambda: board.write(setup.address, [setup_us]),
        ]
        for axis in axes:
            kinds += [partial(board.axis, axis), partial(board.records, axis)]
            kinds.append(partial(self._repeat_block, axis))
        return kinds

    def _repeat_block(self, axis: int) -> None:
        """Send the last block of an axis again, as a master does that lost the reply."""
        self._uploads[axis].repeat_last()
