# SPDX-License-Identifier: MIT
"""What commands print: notes, and facts as JSON."""

import functools
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import click

from pixstep import atomic
from pixstep.cli import origins
from pixstep.errors import one_line

Facts = Mapping[str, object]  # plain data, for JSON
SCHEMA = 1  # of all --json output; a field that is added does not change it


def teller(output: Path | None) -> Callable[..., None]:
    """Return `click.echo` on the stream that is free for words: not the one the output goes to."""
    return functools.partial(click.echo, err=atomic.is_stdout(output))


def show_json(facts: Facts) -> None:
    """Print facts as JSON, with the version of its layout and the machine file that was used."""
    machine = origins.told(click.get_current_context(silent=True))
    click.echo(json.dumps({"schema": SCHEMA, **machine, **facts}, indent=2))


def show_json_row(facts: Facts) -> None:
    """Print facts as one row of JSON, where more rows follow as they come."""
    click.echo(json.dumps({"schema": SCHEMA, **facts}))


def say(notes: Iterable[str]) -> None:
    """Print notes to the error stream."""
    for note in notes:
        click.echo(f"note: {one_line(note)}", err=True)
