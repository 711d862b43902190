# SPDX-License-Identifier: MIT
"""Lines into the queues of boards, checked first, streamed if long, and off together."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TypedDict

from pixstep import formats
from pixstep.board import capability, guarantee, run, settings, snapshot, together, upload
from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.board.run import LinesOfBoard
from pixstep.board.together import Together
from pixstep.errors import AskedText, UserError
from pixstep.lines.line import Line
from pixstep.lines.line_check import Limits
from pixstep.lines.units import hz_text, refuse_period
from pixstep.operations import bus, judging, reading_lines, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.board.records import ReadRecords, RecordFields, RunRecords, recorded
from pixstep.operations.bus import Known, ToBoard, ToBoards, some_axes
from pixstep.operations.clocks import BoardLineClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Choice
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result
from pixstep.profiles import origin
from pixstep.progress import unseen

POLICIES = {"always": 0, "on_reversal": 1}


class QueuedLine(TypedDict):
    """A line that was queued, and how its axis is then; `records` is None if none were read."""

    axis: int
    file: str
    decode: str
    pixels: int
    steps: int
    seconds: float
    state: str
    position_steps: int
    records: ReadRecords | None


class QueuedLines(TypedDict):
    """Lines that were queued on a board."""

    unit: int
    pixel_hz: str
    axes: list[QueuedLine]


@operation("board upload")
class BoardUpload(RecordFields, BoardLineClock, ToBoard):
    """Queue lines, one file an axis; with --arm run them.

    Files are CSV or CSB. Each line is first checked with the board's own limits: what it would
    refuse is not sent. While lines are followed their per-pixel records are read, of every Nth
    pixel where the bus is too slow for all; --records writes them. Exit status 1 if such a file
    lacks records that were overwritten before they were read.
    """

    result = QueuedLines

    csv: tuple[Path, ...] = reading_lines.line_files()
    axis: tuple[int, ...] = reading_lines.axes()
    decode: tuple[str, ...] = reading_lines.decodes()
    backlash: tuple[int, ...] = reading_lines.backlashes()
    negative: bool | None = reading_lines.negative()
    backlash_policy: str | None = option(Choice(list(POLICIES)), "Set the policy.")
    arm: bool = flag("Arm the axes once the lines are loaded.")
    wait: bool = flag(
        "With --arm: follow the lines to their end. A line longer than the queue needs that; "
        "without it a board stops when no request comes for bus_timeout_ms (3 s by default).",
        off="--no-wait", default=True,
    )  # fmt: skip
    check: bool = judging.no_check()
    beyond: bool = judging.beyond()
    raw: bool = shared.raw()
    line_number: tuple[int, ...] = reading_lines.line_numbers()

    @property
    def followed(self) -> bool:
        """True if the lines are followed to their end."""
        return self.arm and self.wait

    def run(self, desk: Desk) -> Result:
        """Check the lines, queue them, and run them if asked."""
        self.refuse_file(followed=self.followed, instead="add {arm}, without {no_wait}")
        read = reading_lines.read_lines(desk, self, pixel_hz=None)
        lines = dict(zip(reading_lines.line_axes(self.axis, len(read)), read, strict=True))
        with bus.one_board(desk, self) as (found, known):
            known.axes(tuple(lines))
            if self.backlash_policy:
                known.board.require("backlash")
            divider = self.divider or settings.divider(known.board)
            self._judge(desk, known, lines, divider)
            upload.forget_refused(known.board, lines)
            streamed = _streamed(known.board, lines, divider)
            if streamed and not self.followed:
                raise AskedError(
                    "{what}: it is streamed while it moves: add {arm}, without {no_wait}",
                    what=streamed,
                )
            if self.arm:
                upload.require_idle(known.board, lines)
            self._set(known.board)
            queues = run.LinesOfBoard(known.board, list(lines))
            wanted, is_streamed = self.record and self.followed, bool(streamed)
            with recorded(
                desk, [queues], self.record_file, wanted=wanted, streamed=is_streamed
            ) as records:
                data = run_lines(
                    desk, queues, found.world, lines, divider, records, arm=self.arm, wait=self.wait
                )
        return records.result(data, _texts(data))

    def _judge(self, desk: Desk, known: Known, lines: dict[int, Line], divider: int) -> None:
        """Refuse what the board or a motor cannot do, and files for a lower frequency."""
        pixel_hz = settings.pixel_hz(known.board, self.edges_hz(known.board), divider)
        refuse_period(pixel_hz, known.board.tick_hz())
        for path in self.csv:
            header = formats.read_motion(path, raw=True).header
            desk.say(
                origin.frequency_notes(path, header, pixel_hz, refuse=self.check, divider=divider)
            )
        if self.check:
            motors = judging.motor_limits(desk.facts, list(lines.values()), pixel_hz)
            clock = settings.of_clock(self.sync, divider)
            check_lines(desk, known, lines, pixel_hz, clock, motors)
            world = guarantee.of_board(known.board, pixel_hz, clock)
            if world:
                gated = bool(self.gate_edges)
                judging.together(desk, list(lines.values()), world, beyond=self.beyond, gated=gated)

    def _set(self, board: Device) -> None:
        """Write the settings that were asked for."""
        self.set_clock(board)
        if self.backlash_policy:
            board.write_setting("backlash_policy", POLICIES[self.backlash_policy])


def check_lines(
    desk: Desk,
    known: Known,
    lines: dict[int, Line],
    hz: Fraction | None,
    clock: Mapping[str, int] | None = None,
    motors: Sequence[Limits] = (),
) -> None:
    """Check lines with the limits of the board and of motors; warnings are said.

    `hz` is the frequency of pixels that the board will be set to, if another than its own; `clock`
    are the settings `sync` and `divider` that it gets.
    """
    if any(item.backlash for item in lines.values()):
        known.board.require("backlash")
    found = capability.connected_limits(known.board, hz, len(lines), clock)
    bounds = motors or [Limits()] * len(lines)
    for item, motor in zip(lines.values(), bounds, strict=True):
        judging.check(
            desk, item, found, motor, AskedText("nothing was sent; {advice}", advice=judging.ADVICE)
        )


def _streamed(board: Device, lines: dict[int, Line], divider: int) -> str:
    """Return which line does not fit its queue as a whole, in words; empty if all do."""
    for axis, item in lines.items():
        takes, free = upload.room(board, axis, item, divider)
        if takes > free:
            return f"{item.name} takes {takes} queue entries, axis {axis} has room for {free}"
    return ""


def run_lines(
    desk: Desk,
    queues: run.LinesOfBoard,
    world: World,
    lines: dict[int, Line],
    divider: int,
    records: RunRecords,
    *,
    arm: bool,
    wait: bool,
) -> QueuedLines:
    """Queue the lines, and as asked arm and follow them; return what was done.

    `queues` are those of the board, `divider` is how many clock edges a pixel has on it.
    """
    board, axes = queues.board, queues.axes
    pixels = max(item.pixels for item in lines.values())
    if arm:
        snapshot.await_lock(board, world)
    shown = desk.progress("running") if arm and wait else contextlib.nullcontext(unseen)
    with shown as show, bus.stopping([queues]):
        queues.uploads += upload.begin(board, lines, divider)
        if arm:
            run.arm_queued(queues)
            bus.note_play(desk, board, [axis for axis, item in lines.items() if item.backlash])
        if arm and wait:
            run.follow([queues], world, pixels, show)
    if arm and not wait:
        bus.note_unattended(desk, board)
    state, where = run.states(board, axes), run.positions(board, axes)
    hz = capability.connected_limits(board).pixel_hz
    return {
        "unit": board.unit,
        "pixel_hz": hz_text(hz),
        "axes": [
            {
                "axis": axis,
                "file": item.name,
                "decode": item.decode,
                "pixels": item.pixels,
                "steps": item.total_steps,
                "seconds": round(float(item.pixels / hz), 3),
                "state": state[axis],
                "position_steps": where[axis],
                "records": records.of(board.unit, axis),
            }
            for axis, item in lines.items()
        ],
    }


def _texts(data: QueuedLines) -> list[str]:
    return [
        f"board {data['unit']} axis {row['axis']}: {row['file']}, {row['decode']}, "
        f"{row['pixels']} pixels, {row['steps']} steps, {row['seconds']:g} s: {row['state']}, "
        f"position {row['position_steps']}"
        for row in data["axes"]
    ]


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
    """The boards that were started; several share a token."""

    token: int | None
    boards: list[StartedBoard]


@operation("board start")
class BoardStart(RecordFields, ToBoards):
    """Start loaded lines; several boards begin on one clock edge.

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
        self.refuse_file(followed=self.wait, instead="add {wait}")
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

    def _lines(self, known: Known) -> LinesOfBoard:
        """Return the axes of a board that are to start: those chosen, or all that are loaded."""
        if self.axes:
            return LinesOfBoard(known.board, known.axes(self.axes))
        return LinesOfBoard(known.board, run.loaded(known.board, known.who.axis_count))


def _start(group: list[LinesOfBoard], world: World) -> Together | None:
    """Start the lines; None of a single board."""
    if len(group) > 1:
        return together.start(group, world)
    run.arm_lines(group[0])
    return None


def _row(lines: LinesOfBoard, records: RunRecords) -> StartedBoard:
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
