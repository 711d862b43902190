# SPDX-License-Identifier: MIT
"""`pixstep board start`: loaded lines of one or several boards, off together."""

import contextlib
from pathlib import Path
from typing import TypedDict

import click

from pixstep import progress
from pixstep.board import run, together
from pixstep.board.link import World
from pixstep.board.port import Port
from pixstep.board.together import Together
from pixstep.cli.board.group import (
    Known,
    Units,
    axes_option,
    boards,
    note_play,
    note_unattended,
    port_options,
    stopping,
    units_option,
)
from pixstep.cli.board.recordoptions import (
    RecordFacts,
    Records,
    exit_status,
    record_options,
    recorded,
)
from pixstep.cli.command import command
from pixstep.cli.options import json_option, show_json, teller
from pixstep.errors import UserError


@command("start")
@port_options
@units_option
@axes_option
@click.option(
    "--wait/--no-wait", default=False, show_default=True, help="Follow the lines to their end."
)
@record_options
@json_option
@click.pass_context
def start_command(
    ctx: click.Context,
    port: Port,
    units: Units,
    axes: tuple[int, ...],
    wait: bool,
    record_file: Path | None,
    record: bool,
    as_json: bool,
) -> None:
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
    if record_file and not wait:
        raise UserError("--records: records are read while lines run: add --wait")
    with boards(port, units) as (found, known):
        group = [_lines(item, axes) for item in known]
        group = [item for item in group if item.axes]
        if not group:
            raise UserError("no axis has a line loaded: `pixstep board upload` loads one")
        shown = progress.shown("running") if wait else contextlib.nullcontext(progress.unseen)
        with (
            recorded(group, record_file, wanted=record and wait, queued=True) as records,
            shown as show,
            stopping(group),
        ):
            started = _start(group, found.world)
            for item in group:
                note_play(item.board, item.axes)
            if wait:
                run.follow(group, found.world, progress=show)
                if started:
                    started.compare(found.world)
        rows = [_row(item, records) for item in group]
        for item in group if not wait else ():
            note_unattended(item.board)
    if as_json:
        show_json({"token": started.token if started else None, "boards": rows})
        ctx.exit(exit_status(records, echo=False))
    tell = teller(record_file)
    for row in rows:
        for axis in row["axes"]:
            tell(
                f"board {row['unit']} axis {axis['axis']}: {axis['state']}, position "
                f"{axis['position_steps']}"
            )
    ctx.exit(exit_status(records, echo=True))


def _lines(known: Known, axes: tuple[int, ...]) -> run.Lines:
    """Return the axes of a board that are to start: those chosen, or all that are loaded."""
    chosen = known.axes(axes) if axes else run.loaded(known.board, known.who.axis_count)
    return run.Lines(known.board, chosen)


def _start(group: list[run.Lines], world: World) -> Together | None:
    """Start the lines; None of a single board."""
    if len(group) > 1:
        return together.start(group, world)
    run.arm(group[0].board, group[0].axes)
    return None


class _Axis(TypedDict):
    axis: int
    state: str
    position_steps: int
    records: RecordFacts | None


class _Row(TypedDict):
    unit: int
    axes: list[_Axis]


def _row(lines: run.Lines, records: Records) -> _Row:
    states, where = run.states(lines.board, lines.axes), run.positions(lines.board, lines.axes)
    axes: list[_Axis] = [
        {
            "axis": axis,
            "state": states[axis],
            "position_steps": where[axis],
            "records": records.of(lines.board.unit, axis),
        }
        for axis in lines.axes
    ]
    return {"unit": lines.board.unit, "axes": axes}
