# SPDX-License-Identifier: MIT
"""`pixstep board upload`: lines into the queues of a board, checked first, streamed if long."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TypedDict, Unpack

import click

from pixstep import formats, progress
from pixstep.board import clockstate, limits, run, settings, upload
from pixstep.board.device import Board
from pixstep.board.link import World
from pixstep.board.port import Port
from pixstep.cli import judging
from pixstep.cli.board.group import (
    Known,
    note_play,
    note_unattended,
    one_board,
    port_options,
    stopping,
    unit_option,
)
from pixstep.cli.board.recordoptions import (
    RecordFacts,
    Records,
    exit_status,
    record_options,
    recorded,
)
from pixstep.cli.clockoptions import (
    board_clock_options,
    board_gate_edges_option,
    board_sync_option,
)
from pixstep.cli.command import FILE, command
from pixstep.cli.manylines import (
    LineOptions,
    line_axes,
    line_axes_option,
    negative_option,
    read_lines,
)
from pixstep.cli.options import (
    DECODE,
    LINE_NUMBER,
    json_option,
    no_check_option,
    raw_option,
    say,
    show_json,
    teller,
)
from pixstep.cli.quantities import StepsType
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.lines.linecheck import Limits
from pixstep.lines.rational import hz_text, refuse_period
from pixstep.profiles import madefor

POLICIES = {"always": 0, "on_reversal": 1}


class _Options(LineOptions):
    pixel_hz: Fraction | None
    divider: int | None
    sync: str | None
    gate_edges: int | None
    backlash_policy: str | None


class AxisRow(TypedDict):
    """A line that was queued, and how its axis is then."""

    axis: int
    file: str
    decode: str
    pixels: int
    steps: int
    seconds: float
    state: str
    position_steps: int
    records: RecordFacts | None


class RunRow(TypedDict):
    """Lines that were queued on a board."""

    unit: int
    pixel_hz: str
    axes: list[AxisRow]


@command("upload")
@click.argument("csv", metavar="FILE...", type=FILE, nargs=-1, required=True)
@port_options
@unit_option
@line_axes_option
@click.option("--decode", type=DECODE, multiple=True, required=True, help="Once, or per line.")
@click.option("--backlash", type=StepsType(0), multiple=True, help="Steps; once, or per line.")
@negative_option
@board_clock_options
@board_sync_option
@board_gate_edges_option
@click.option("--backlash-policy", type=click.Choice(list(POLICIES)), help="Set the policy.")
@click.option("--arm", is_flag=True, help="Arm the axes once the lines are loaded.")
@click.option(
    "--wait/--no-wait",
    default=True,
    show_default=True,
    help="With --arm: follow the lines to their end. A line longer than the queue needs that; "
    "without it a board stops when no request comes for bus_timeout_ms (3 s by default).",
)
@record_options
@no_check_option
@json_option
@raw_option
@click.option(
    "--line", "line_number", type=LINE_NUMBER, metavar="N", multiple=True,
    help="Line N of files of many lines; once, or per line file.",
)  # fmt: skip
@click.pass_context
def upload_command(
    ctx: click.Context,
    csv: tuple[Path, ...],
    port: Port,
    unit: int,
    axis: tuple[int, ...],
    decode: tuple[str, ...],
    backlash: tuple[int, ...],
    arm: bool,
    wait: bool,
    check: bool,
    record_file: Path | None,
    record: bool,
    as_json: bool,
    **options: Unpack[_Options],
) -> None:
    """Queue lines, one file an axis; with --arm run them.

    Files are CSV or CSB. Each line is first checked with the board's own limits: what it would
    refuse is not sent. While lines are followed their per-pixel records are read, of every Nth
    pixel where the bus is too slow for all; --records writes them. Exit status 1 if such a file
    lacks records that were overwritten before they were read.
    """
    if record_file and not (arm and wait):
        raise UserError("--records: records are read while lines run: add --arm, without --no-wait")
    read = read_lines(csv, decode, backlash, options, pixel_hz=None)
    lines = dict(zip(line_axes(axis, len(read)), read, strict=True))
    with one_board(port, unit) as (found, known):
        known.axes(tuple(lines))
        if options["backlash_policy"]:
            known.board.require("backlash")
        divider = options["divider"] or settings.divider(known.board)
        pixel_hz = settings.pixel_hz(known.board, options["pixel_hz"], divider)
        clock = settings.of_clock(options["sync"], divider)
        refuse_period(pixel_hz, known.board.tick_hz())
        _compare(csv, pixel_hz, divider, check=check)
        if check:
            motors = judging.motor_limits(ctx, read, pixel_hz)
            check_lines(known, lines, pixel_hz, clock, motors)
        upload.forget_refused(known.board, lines)
        streamed = _streamed(known.board, lines, divider)
        if streamed and not (arm and wait):
            raise UserError(
                f"{streamed}: it is streamed while it moves: add --arm, without --no-wait"
            )
        if arm:
            upload.require_idle(known.board, lines)
        _set(known.board, options)
        group = [run.Lines(known.board, list(lines))]
        with recorded(
            group, record_file, wanted=record and arm and wait, streamed=bool(streamed)
        ) as records:
            summary = run_lines(group[0], found.world, lines, divider, records, arm=arm, wait=wait)
    if as_json:
        show_json(summary)
    else:
        _print(summary, teller(record_file))
    ctx.exit(exit_status(records, echo=not as_json))


def _set(board: Board, options: _Options) -> None:
    """Write the settings that were asked for."""
    settings.set_clock(
        board, options["pixel_hz"], options["sync"], options["divider"], options["gate_edges"]
    )
    if options["backlash_policy"]:
        board.write_setting("backlash_policy", POLICIES[options["backlash_policy"]])


def _compare(csv: tuple[Path, ...], hz: Fraction, divider: int, *, check: bool) -> None:
    """Say which files were made for another frequency than the board's; refuse a lower one."""
    for path in csv:
        header = formats.read_motion(path, raw=True).header
        say(madefor.notes(path, header, hz, refuse=check, divider=divider))


def check_lines(
    known: Known,
    lines: dict[int, Line],
    hz: Fraction | None,
    clock: Mapping[str, int] | None = None,
    motors: Sequence[Limits] = (),
) -> None:
    """Check lines with the limits of the board and of motors; warnings go to the error stream.

    `hz` is the frequency of pixels that the board will be set to, if another than its own; `clock`
    are the settings `sync` and `divider` that it gets.
    """
    if any(item.backlash for item in lines.values()):
        known.board.require("backlash")
    found = limits.connected(known.board, hz, len(lines), clock)
    bounds = motors or [Limits()] * len(lines)
    for item, motor in zip(lines.values(), bounds, strict=True):
        judging.check(item, found, motor, f"nothing was sent; {judging.ADVICE}")


def _streamed(board: Board, lines: dict[int, Line], divider: int) -> str:
    """Return which line does not fit its queue as a whole, in words; empty if all do."""
    for axis, item in lines.items():
        takes, free = upload.room(board, axis, item, divider)
        if takes > free:
            return f"{item.name} takes {takes} queue entries, axis {axis} has room for {free}"
    return ""


def run_lines(
    queues: run.Lines,
    world: World,
    lines: dict[int, Line],
    divider: int,
    records: Records,
    *,
    arm: bool,
    wait: bool,
) -> RunRow:
    """Queue the lines, and as asked arm and follow them; return what was done.

    `queues` are those of the board, `divider` is how many clock edges a pixel has on it.
    """
    board, axes = queues.board, queues.axes
    pixels = max(item.pixels for item in lines.values())
    if arm:
        clockstate.await_lock(board, world)
    group = [queues]
    shown = progress.shown("running") if arm and wait else contextlib.nullcontext(progress.unseen)
    with shown as show, stopping(group):
        group[0].uploads += upload.begin(board, lines, divider)
        if arm:
            run.arm_queued(queues)
            note_play(board, [axis for axis, item in lines.items() if item.backlash])
        if arm and wait:
            run.follow(group, world, pixels, show)
    if arm and not wait:
        note_unattended(board)
    state, where = run.states(board, axes), run.positions(board, axes)
    hz = limits.connected(board).pixel_hz
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


def _print(summary: RunRow, tell: Callable[..., None]) -> None:
    for row in summary["axes"]:
        tell(
            f"board {summary['unit']} axis {row['axis']}: {row['file']}, {row['decode']}, "
            f"{row['pixels']} pixels, {row['steps']} steps, {row['seconds']:g} s: {row['state']}, "
            f"position {row['position_steps']}"
        )
