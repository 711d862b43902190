# SPDX-License-Identifier: MIT
"""Simulated boards that a program drives as it drives real ones."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Self

from pixstep import arguments, natives
from pixstep.api import given
from pixstep.api.bus import Board, Bus
from pixstep.api.clocks import PixelClock
from pixstep.api.given import Hz
from pixstep.api.words import BoardKind
from pixstep.board import boards, settings, shared_time
from pixstep.errors import UserError
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions, SimulatorError

_MOST_BOARDS = 8


class VirtualBoard(Board):
    """A simulated board, on a bus of its own: `simulated_board`."""

    def __init__(self, bus: VirtualBus) -> None:
        super().__init__(bus._link, 1, bus._motions)
        self._bus = bus

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *more: object) -> None:
        self._bus.__exit__(kind, *more)

    @property
    def time_s(self) -> float:
        """Simulated seconds since the board got its supply."""
        return self._bus.time_s

    def let_pass(self, seconds: float | str) -> None:
        """Let simulated time pass; motions go on meanwhile."""
        self._bus.let_pass(seconds)

    def made_steps(self, axis: int = 0) -> int:
        """Return the signed steps that came out of the pins of an axis."""
        return self._bus.made_steps(1, axis)

    def close(self) -> None:
        """Stop what moves, and end the simulator."""
        self._bus.close()


class VirtualBus(Bus):
    """A bus with simulated boards, at the addresses 1, 2, 3 ...: `simulated_bus`."""

    def __init__(self, link: SimLink, kinds: Sequence[str]) -> None:
        super().__init__(link)
        self._simulated, self._kinds = link, kinds

    @property
    def time_s(self) -> float:
        """Simulated seconds since the boards got their supply."""
        return self._simulated.world.now_s()

    def let_pass(self, seconds: float | str) -> None:
        """Let simulated time pass; motions go on meanwhile."""
        shared_time.lender_of(self._simulated).pass_time(given.time("seconds", seconds))

    def made_steps(self, unit: int, axis: int = 0) -> int:
        """Return the signed steps that came out of the pins of an axis."""
        place = arguments.whole("unit", unit, 1, len(self._kinds)) - 1
        kind, number = self._kinds[place], given.axis(axis)
        if number >= boards.load(kind).axes:
            raise UserError(f"axis {number}: the {boards.axes_text(kind)}")
        return self._simulated.simulator.steps(place, number)

    def close(self) -> None:
        """Stop what moves, and end the simulator: its files are complete then."""
        self._motions.stop()
        with contextlib.suppress(SimulatorError):
            self._simulated.simulator.quit()
        super().close()


def simulated_board(
    board: BoardKind,
    *,
    pixel_hz: Hz,
    divider: int = 1,
    clock: PixelClock | None = None,
    plant: str | Mapping[int, str] | None = None,
    seed: int = 1,
    edges: str | PathLike[str] | None = None,
) -> VirtualBoard:
    """Return a simulated board that has booted, a Board like any other, for a `with` statement.

    `board` is `"uno"`, `"mega"` or `"m1284"`; it runs its firmware, cycle by cycle. `pixel_hz` is
    the frequency of its pixels, of which each has `divider` edges of the clock that is connected;
    the board is set to it. `clock` is how the clock strays. `plant` is what axis 0 moves, or what
    axes move by number: `"home=2000,play=40"` has a home switch and play (docs/TESTING.md). `edges`
    is a CSV file for every edge of the STEP and DIR pins. Its time passes only while something is
    asked of it, a motion is waited for, or in `let_pass`: as fast as the simulator can, and the
    same every time. Needs the simulator, pixstep-sim.

    Example:
        >>> from pixstep import line
        >>> with simulated_board("mega", pixel_hz=30) as board:
        ...     state = board.run(line([2, 6, 8, 6, 2], pixel_hz=30))[0]
        ...     state.position_steps, board.made_steps(0), len(state.records)
        (24, 24, 5)
    """
    bus = simulated_bus(
        [board], pixel_hz=pixel_hz, divider=divider, clock=clock,
        plants={(1, axis): knobs for axis, knobs in _plants(plant).items()}, seed=seed, edges=edges,
    )  # fmt: skip
    return VirtualBoard(bus)


def simulated_bus(
    kinds: Sequence[BoardKind],
    *,
    pixel_hz: Hz,
    divider: int = 1,
    clock: PixelClock | None = None,
    plants: Mapping[tuple[int, int], str] | None = None,
    seed: int = 1,
    edges: str | PathLike[str] | None = None,
) -> VirtualBus:
    """Return a bus with simulated boards on one pixel clock: units 1, 2, 3 ... in this order.

    `kinds` are those of the boards, `["mega", "uno"]`. `plants` are what axes move, by unit and
    axis; the rest is as `simulated_board` has it. Each board has a little random time until its
    supply comes, by `seed`.
    """
    names = _kinds(kinds)
    hz = given.exact_hz(pixel_hz)
    if hz is None:
        raise UserError("pixel_hz None: expected the frequency of the pixels")
    edges_px = given.divider(divider) or 1
    strays = PixelClock() if clock is None else clock
    strays = arguments.instance("clock", strays, PixelClock, "a PixelClock")
    options = SimOptions(
        [(name, natives.image(name)) for name in names],
        hz * edges_px,
        pixel_ppm=strays.ppm,
        flaws=strays.flaws,
        seed=arguments.whole("seed", seed, high=given.MOST_SEED),
        plants=_places(plants or {}, len(names)),
    )
    if edges is not None:
        options = replace(options, edges=arguments.path("edges", edges))
    bus = VirtualBus(SimLink(options), names)
    try:
        for unit in range(1, len(names) + 1):
            settings.set_clock(bus.board(unit).device, hz * edges_px, None, edges_px)
    except BaseException:
        bus.close()
        raise
    return bus


def _kinds(kinds: Sequence[str]) -> list[str]:
    if isinstance(kinds, str) or not isinstance(kinds, Sequence) or not kinds:
        raise UserError(f"kinds {arguments.shown(kinds)}: expected a list of kinds of boards")
    if len(kinds) > _MOST_BOARDS:
        raise UserError(f"kinds: {len(kinds)} are too many: {_MOST_BOARDS} at most")
    return [given.board(one) or "" for one in kinds]


def _plants(plant: str | Mapping[int, str] | None) -> dict[int, str]:
    """Return the plants by axis; one text is that of axis 0."""
    if plant is None:
        return {}
    if isinstance(plant, str):
        return {0: plant}
    return given.by_axis("plant", plant)


def _places(plants: Mapping[tuple[int, int], str], boards: int) -> dict[tuple[int, int], str]:
    """Return plants by the simulator's numbers of boards, from 0."""
    found = {}
    for place, knobs in plants.items():
        if not (isinstance(place, tuple) and len(place) == 2):
            raise UserError(f"plants: {arguments.shown(place)}: expected (unit, axis)")
        unit = arguments.whole("plants: unit", place[0], 1, boards)
        found[unit - 1, given.axis(place[1])] = arguments.text("plants", knobs)
    return found
