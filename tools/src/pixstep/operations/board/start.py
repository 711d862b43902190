# SPDX-License-Identifier: MIT
"""Loaded lines of one or several boards, off together."""

from __future__ import annotations

import contextlib
from typing import TypedDict

from pixstep.board import run, together
from pixstep.board.link import World
from pixstep.board.run import Lines
from pixstep.board.together import Together
from pixstep.errors import UserError
from pixstep.operations import bus
from pixstep.operations.board.records import ReadRecords, RecordFields, Records, recorded
from pixstep.operations.bus import Known, ToBoards, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.request import flag, operation
from pixstep.operations.result import Result
from pixstep.progress import unseen


class StartedAxis(TypedDict):
    """How an axis is that was started; `records` is None if they were not read."""

    axis: int
    state: str
    position_steps: int
    records: ReadRecords | None


class StartedBoard(TypedDict):
    """The axes of a board that were started."""

    unit: int
    axes: list[StartedAxis]


class Started(TypedDict):
    """The boards that were started; several have a token in common."""

    token: int | None
    boards: list[StartedBoard]


@operation("board start")
class Start(RecordFields, ToBoards):
    """Start loaded lines, of several boards on one clock edge.

    Of one board the axes are armed. Of several, each is armed with a random token and asked whether
    it is ready; then all agree on one edge of the pixel clock, some tenths of a second ahead, and
    each is told that edge. If one cannot begin there, all are stopped, and the lines must be
    uploaded again. While the clock rests the boards wait for it. With --wait the boards' counts of
    clock edges are compared at the end. Without --axis all loaded axes; a board without any is left
    out of it. Without --wait a board stops when no request comes for `bus_timeout_ms` (3 s by
    default). With --wait the per-pixel records are read while the lines run, as many as the boards
    are set to keep (`record_every`); --records writes them, with exit status 1 if some were
    overwritten before they were read.
    """

    result = Started

    axes: tuple[int, ...] = some_axes()
    wait: bool = flag("Follow the lines to their end.", off="--no-wait")

    def run(self, desk: Desk) -> Result:
        """Start them, and follow them if asked."""
        self.refuse_file(followed=self.wait, instead="add --wait")
        with bus.boards(desk, self) as (found, known):
            group = [self._lines(item) for item in known]
            group = [item for item in group if item.axes]
            if not group:
                raise UserError("no axis has a line loaded: `pixstep board upload` loads one")
            shown = desk.progress("running") if self.wait else contextlib.nullcontext(unseen)
            wanted = self.record and self.wait
            with (
                recorded(desk, group, self.record_file, wanted=wanted, queued=True) as records,
                shown as show,
                bus.stopping(group),
            ):
                started = _start(group, found.world)
                for item in group:
                    bus.note_play(desk, item.board, item.axes)
                if self.wait:
                    run.follow(group, found.world, progress=show)
                    if started:
                        started.compare(found.world)
            rows = [_row(item, records) for item in group]
            for item in group if not self.wait else ():
                bus.note_unattended(desk, item.board)
        texts = [
            f"board {row['unit']} axis {axis['axis']}: {axis['state']}, position "
            f"{axis['position_steps']}"
            for row in rows
            for axis in row["axes"]
        ]
        data: Started = {"token": started.token if started else None, "boards": rows}
        return records.result(data, texts)

    def _lines(self, known: Known) -> Lines:
        """Return the axes of a board that are to start: those chosen, or all that are loaded."""
        if self.axes:
            return Lines(known.board, known.axes(self.axes))
        return Lines(known.board, run.loaded(known.board, known.who.axis_count))


def _start(group: list[Lines], world: World) -> Together | None:
    """Start the lines; None of a single board."""
    if len(group) > 1:
        return together.start(group, world)
    run.arm_lines(group[0])
    return None


def _row(lines: Lines, records: Records) -> StartedBoard:
    states, where = run.states(lines.board, lines.axes), run.positions(lines.board, lines.axes)
    return {
        "unit": lines.board.unit,
        "axes": [
            {
                "axis": axis,
                "state": states[axis],
                "position_steps": where[axis],
                "records": records.of(lines.board.unit, axis),
            }
            for axis in lines.axes
        ],
    }
