# SPDX-License-Identifier: MIT
"""A simulated board from its boot to its last edge, on a link like a serial port's.

with SimulatedBoard("mega", Fraction(30), edges=path) as run:
    run.set_up(run.pixel_hz, [0])
    run.load({0: line})
    run.arm()
    in_time = run.follow()
    run.settle()
    run.finish()
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Self, Unpack

from pixstep import natives
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.handle import BoardRun
from pixstep.board.modbus import SimClient
from pixstep.errors import UserError
from pixstep.simulation.simctl import MoreOptions, SimOptions, Simulator

SETTLE_PIXELS = 2


@dataclass(frozen=True)
class SimWorld:
    """The simulator's time."""

    simulator: Simulator

    def now_s(self) -> float:
        """Return simulated seconds since the start."""
        return self.simulator.cycle / self.simulator.tick_hz

    def wait(self, seconds: float) -> None:
        """Let simulated time pass."""
        self.simulator.wait_s(seconds)


class SimLink:
    """The bus of simulated boards that have booted; use as a context manager."""

    port = "the simulator"

    def __init__(self, options: SimOptions, program: Sequence[str | Path] | None = None) -> None:
        self.simulator = Simulator(options, program)
        try:
            self.simulator.boot()
        except BaseException:
            self.simulator.kill()
            raise
        self.modbus = SimClient(self.simulator)
        self.world = SimWorld(self.simulator)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def board(self, unit: int = 1) -> Board:
        """Return a unit of the bus, the first board's if no other is given."""
        return Board(self.modbus, unit)

    def close(self) -> None:
        """End the simulator if it still runs."""
        self.simulator.kill()


class SimulatedBoard(BoardRun):
    """One board alone in the simulator, booted; use as a context manager.

    `more` are other fields of SimOptions.
    """

    def __init__(
        self,
        name: str,
        pixel_hz: Fraction,
        *,
        image: Path | None = None,
        program: Sequence[str | Path] | None = None,
        **more: Unpack[MoreOptions],
    ) -> None:
        self.name, self.pixel_hz = name, pixel_hz
        options = SimOptions([(name, image or natives.image(name))], pixel_hz)
        link = SimLink(replace(options, **more), program)
        self.simulator, self.client = link.simulator, link.modbus
        super().__init__(link)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.link.close()

    def talk_at(self, baud: int) -> None:
        """Set the board and the simulator's end of the bus to another rate, a multiple of 100.

        Raises UserError for a rate that the board cannot make.
        """
        try:
            self.board.write_setting("baud_100", baud // 100)
        except BoardError as error:
            if error.code is None:
                raise
            raise UserError(f"the {self.name} cannot make {baud} baud within 2.5 %") from None
        self.simulator.command(f"baud {baud} E")

    def settle(self) -> None:
        """Let late edges show themselves."""
        self.simulator.run(int(SETTLE_PIXELS * self.simulator.tick_hz / self.pixel_hz))

    def finish(self) -> None:
        """End the simulator; all of its files are complete afterwards."""
        self.simulator.quit()
