# SPDX-License-Identifier: MIT
"""The flyer that bluesky's RunEngine flies: kickoff, complete, collect."""

from __future__ import annotations

import asyncio
import importlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property, partial
from typing import Any, cast

from pixstep import arguments, lazy
from pixstep.api import given
from pixstep.api.bus import Board, Bus
from pixstep.api.motion import Motion
from pixstep.api.running import Lines
from pixstep.api.words import Sync
from pixstep.board.device import Device
from pixstep.errors import UserError
from pixstep.fly.documents import DataKey, DocumentLayout, number_key
from pixstep.fly.flight import Flight, FlightStatus
from pixstep.fly.tracks import places_of

Page = dict[str, Any]
CLOCK_TIMEOUT_S = 10.0


class LineFlyer:
    """Lines that fly on the pixel clock, as one stream of documents for bluesky.

    `where` is a Board and `lines` are as `Board.start` takes them, or a Bus with several boards and
    `lines` by the addresses of boards, as `Bus.start` takes them. `kickoff` checks and arms them;
    they begin on the clock. `complete` ends with the lines. Each pixel is an event: the number of
    the pixel, the time since line zero, how many axes have a record of it, and of each axis where
    it was expected, where it was, and the difference in steps; of a scanspec's line also the number
    of the point. Timestamps are those of the clock's edges. `clock_timeout` is how long `complete`
    waits for a clock that rests. A plan that declares the stream (`bps.declare_stream`, for
    `collect_while_completing`) needs a flyer that is told so: `declared`. The same flyer flies
    again and again.
    """

    parent = None

    def __init__(
        self,
        where: Board | Bus,
        lines: Lines | Mapping[int, Lines],
        *,
        name: str = "fly",
        sync: Sync | None = None,
        divider: int | None = None,
        gate_edges: int | None = None,
        check: bool = True,
        clock_timeout: float | str = CLOCK_TIMEOUT_S,
        declared: bool = False,
    ) -> None:
        lazy.require_package("bluesky")
        self.name: str = arguments.text("name", name)
        """What its stream and its data keys are called."""
        by_unit = _by_unit(where, lines)
        self._link = where.link
        self._devices = _devices(where, by_unit)
        self._places = places_of(by_unit)
        start: Callable[..., Motion[Any]] = where.start
        self._begin: Callable[[], Motion[Any]] = partial(
            start, lines, sync=sync, divider=divider, gate_edges=gate_edges, check=check
        )
        self._clock_timeout_s = given.time("clock_timeout", clock_timeout)
        self._declared = arguments.flag("declared", declared)
        self._flight: Flight | None = None
        self._task: asyncio.Task[Any] | None = None
        self._cancelled = 0  # how often the task had been when the flight began

    def kickoff(self) -> FlightStatus:
        """Check the lines and arm the axes: over when they wait for the clock.

        Raises UserError while the last flight goes on. What else is wrong, with the lines, the
        board or the place of an axis, fails the status.
        """
        if self._flying:
            raise UserError(f"{self.name}: flies already: complete comes before another kickoff")
        flight = Flight(self._layout, self._link, self._devices, self._begin, self._clock_timeout_s)
        self._flight = flight
        self._watch_run(flight)
        return flight.armed

    def complete(self) -> FlightStatus:
        """Wait for the end of the lines: over then, failed by a fault, a stop, or without a clock.

        Raises UserError before a kickoff.
        """
        if self._flight is None:
            raise UserError(f"{self.name}: nothing flies: kickoff comes before complete")
        return self._flight.await_end()

    def describe_collect(self) -> dict[str, Any]:
        """Return the data keys of the stream, with their units: by its name, or as it is declared.

        bluesky has it by names where a plan does not declare the stream, as `fly` does not.
        """
        found = self._layout.data_keys()
        return found if self._declared else {self.name: found}

    def collect_pages(self) -> Iterator[Page]:
        """Give out a page of events: the pixels that are complete and were not collected yet.

        bluesky does not tell a flyer that its run was broken off, but collects what there is: then
        the axes are stopped first.
        """
        flight = self._flight
        if flight is None:
            return
        if self._broken_off(flight):
            flight.stop("its run was broken off")
        found = flight.columns()
        if found is None:
            return
        columns, instants = found
        times = instants.tolist()
        data = {key: columns[key].tolist() for key in self._layout.data_keys()}
        yield {"time": times, "data": data, "timestamps": dict.fromkeys(data, times)}

    def stop(self, *, success: bool = False) -> None:
        """Stop the axes if they fly: `complete` fails and says where they are.

        With `success` the flight ends well, and its documents end where it was stopped.
        """
        if self._flight is not None:
            self._flight.stop("stopped", well=success)

    def pause(self) -> None:
        """Stop the axes because the RunEngine pauses: a line cannot go on in its middle."""
        if self._flying and self._flight is not None:
            self._flight.stop("stopped by a pause, a line does not go on after one")
            raise importlib.import_module("bluesky.utils").NoReplayAllowed

    def resume(self) -> None:
        """Nothing to do: the flight is over."""

    def stage(self) -> list[object]:
        """Nothing to prepare."""
        return [self]

    def unstage(self) -> list[object]:
        """Stop the axes if they still fly."""
        self.stop()
        return [self]

    def describe_configuration(self) -> dict[str, DataKey]:
        """Return the data keys of the configuration, with their units."""
        return {key: dict(value[1]) for key, value in self._configuration().items()}

    def read_configuration(self) -> dict[str, dict[str, Any]]:
        """Return the pixels' frequency, and scale, play and length of the line of each axis."""
        now = time.time()
        return {
            key: {"value": value[0], "timestamp": now}
            for key, value in self._configuration().items()
        }

    @property
    def hints(self) -> dict[str, list[str]]:
        """What a plot of the run shows: where each axis was."""
        key = self._layout.key
        return {"fields": [key(place.name, "actual") for place in self._places]}

    @property
    def pixel(self) -> int:
        """The newest pixel of which there are records, from 1; 0 before the first."""
        return 0 if self._flight is None else self._flight.pixel

    def __repr__(self) -> str:
        names = ", ".join(place.name for place in self._places)
        return f"<LineFlyer {self.name} of {names}>"

    @cached_property
    def _layout(self) -> DocumentLayout:
        """The data keys; the first board is asked once what it can tell of the clock."""
        errors = self._devices[0].has("clock_statistics")
        return DocumentLayout(self.name, self._places, clock_errors=errors)

    @property
    def _flying(self) -> bool:
        return self._flight is not None and not self._flight.over.done

    def _configuration(self) -> dict[str, tuple[float, DataKey]]:
        key, found = self._layout.key, {}
        found[key("pixel_hz")] = (
            float(self._places[0].line.hz), number_key(f"pixstep:{self._link.port}", "Hz")
        )  # fmt: skip
        for place in self._places:
            unit, source = place.length_unit, place.source
            scale = abs(place.steps_per_unit)
            found[key(place.name, "scale")] = (scale, number_key(source, f"steps/{unit}"))
            play = float(place.line.line.backlash)
            found[key(place.name, "backlash")] = (play, number_key(source, "steps"))
            pixels = float(place.line.pixels)
            found[key(place.name, "pixels")] = (pixels, number_key(source, "px"))
        return found

    def _watch_run(self, flight: Flight) -> None:
        """Stop the axes at the latest when the run that has asked for the flight ends."""
        try:
            self._task = asyncio.current_task()
        except RuntimeError:  # no event loop: a program's own call
            self._task = None
        if self._task is not None:
            self._cancelled = self._task.cancelling()
            self._task.add_done_callback(lambda _: flight.stop("its run has ended"))

    def _broken_off(self, flight: Flight) -> bool:
        """True if a flight goes on whose run does not."""
        if flight.over.done or self._task is None:
            return False
        return not flight.awaited or self._task.cancelling() > self._cancelled


def _by_unit(where: Board | Bus, lines: Lines | Mapping[int, Lines]) -> Mapping[int, Lines]:
    """Return lines by the addresses of their boards."""
    if isinstance(where, Board):
        return {where.unit: cast(Lines, lines)}
    arguments.instance("where", where, Bus, "a Board or a Bus")
    if not isinstance(lines, Mapping) or not lines:
        raise UserError(f"lines {arguments.shown(lines)}: expected lines by address of a board")
    return lines


def _devices(where: Board | Bus, units: Iterable[int]) -> list[Device]:
    """Return the boards that take part."""
    if isinstance(where, Board):
        return [where.device]
    return [where.board(unit).device for unit in units]
