# SPDX-License-Identifier: MIT
"""`pixstep board log`: per-pixel records into a CSV as they come; the event log."""

import contextlib
import functools
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from pixstep import atomic, signals
from pixstep.board import features, logs
from pixstep.board.logs import AxisLog
from pixstep.board.port import Port
from pixstep.board.state import Event
from pixstep.cli.board.group import Known, axes_option, one_board, port_options, unit_option
from pixstep.cli.command import OUTPUT, command
from pixstep.cli.options import json_option, show_json_row

_MOST_WAIT_S = 0.5
_MOVES = ("armed", "running")
_FOLLOW_S = 0.2
output_option = click.option(
    "-o", "--output", type=OUTPUT,
    help="CSV file to write, whole at the end.  [default: the terminal]",
)  # fmt: skip
follow_option = click.option("--follow", is_flag=True, help="Go on until Ctrl-C.")


@command("records")
@port_options
@unit_option
@axes_option
@output_option
@follow_option
def records_command(
    port: Port, unit: int, axes: tuple[int, ...], output: Path | None, follow: bool
) -> None:
    """Write per-pixel records as CSV, each as it comes.

    Reads until no axis is armed or moves; with --follow until Ctrl-C, line after line. The board
    keeps only the newest records: how many were overwritten before they were read is said at the
    end, and is exit status 1.
    """
    with one_board(port, unit) as (found, known), _rows_to(output) as put:
        _note_statistics(known)
        put(logs.HEADER)
        followed = [AxisLog(known.board, axis) for axis in known.axes(axes)]
        wait_s = _wait_s(known)
        ended = 0
        try:
            while True:
                for item in followed:
                    for row in item.poll():
                        put(row.text)
                if not follow and all(item.state not in _MOVES for item in followed):
                    break
                found.world.wait(wait_s)
        except signals.Ended as error:  # what was read is kept
            ended = signals.status(error)
        except KeyboardInterrupt:
            pass
    missed = {item.axis: item.missed for item in followed if item.missed}
    rows = sum(item.rows for item in followed)
    click.echo(f"{rows} records{_missed_text(missed)}", err=True)
    click.get_current_context().exit(ended or int(bool(missed)))


@command("events")
@port_options
@unit_option
@follow_option
@json_option
def events_command(port: Port, unit: int, follow: bool, as_json: bool) -> None:
    """Print faults and resets with their times.

    Times are since the board's last reset. Refused for a board without an event log (`pixstep board
    features`).
    """
    with one_board(port, unit) as (found, known), signals.until_ctrl_c():
        known.board.require("events")
        total, events = known.board.events()
        _say_lost(total, events)
        seen = _print(events, 0, as_json=as_json)
        while follow:
            found.world.wait(_FOLLOW_S)
            total, events = known.board.events()
            seen = _print(events, seen, as_json=as_json)


@contextlib.contextmanager
def _rows_to(output: Path | None) -> Iterator[Callable[[str], None]]:
    """Yield what takes rows: the terminal, or a file that appears whole."""
    if output is None or atomic.is_stdout(output):
        yield click.echo
        return
    with (
        atomic.replacing(output) as temporary,
        temporary.open("w", encoding="ascii", newline="\n") as file,
    ):
        yield functools.partial(print, file=file)


def _wait_s(known: Known) -> float:
    """Return how long to wait between looks so that no record is overwritten unread."""
    period_s = known.board.pixel_period_s()
    every = known.board.setting("record_every")
    return min(_MOST_WAIT_S, period_s * every * known.board.record_capacity() / 3)


def _note_statistics(known: Known) -> None:
    """Say that a column of the records says nothing, if the board does not measure it."""
    if not known.board.has("clock_statistics"):
        note = features.missing(known.board.unit, "clock_statistics")
        click.echo(f"note: edge_error_ticks is always 0: {note}", err=True)


def _missed_text(missed: dict[int, int]) -> str:
    """Return in words how many records were overwritten unread."""
    if not missed:
        return ", none missed"
    each = ", ".join(f"{count} of axis {axis}" for axis, count in missed.items())
    return (
        f"; missed: {each}, overwritten before they were read (`board upload`, `start` and `run` "
        f"have --records, which reads them while the line runs)"
    )


def _say_lost(total: int, events: list[Event]) -> None:
    """Say how many events are no longer kept."""
    if total > len(events):
        click.echo(f"note: {total - len(events)} older events are no longer kept", err=True)


def _print(events: list[Event], seen: int, *, as_json: bool) -> int:
    """Print the events behind number `seen`; return the newest number."""
    for event in events:
        if event.number <= seen:
            continue
        if as_json:
            row = {"name": event.name, "text": event.text}
            show_json_row({**vars(event), **row})
        else:
            click.echo(_text(event))
    return max([seen, *(event.number for event in events)])


def _text(event: Event) -> str:
    """Return an event as a line."""
    time = f"{event.number:>5}  {event.time_ms / 1000:>10.3f} s  {event.name}"
    if event.name == "reset":
        return f"{time}: {event.text}"
    where = f"axis {event.axis}, pixel {event.pixel}, argument {event.argument}"
    return f"{time}: {event.text} ({where})"
