# SPDX-License-Identifier: MIT
"""`pixstep bench`: every figure of speed, measured on the real images in the simulator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pixstep import natives, progress
from pixstep.board import boards
from pixstep.cli.command import FILE, PICTURE, command
from pixstep.cli.from_operation import SCHEMA
from pixstep.errors import UserError
from pixstep.lazy import lazy
from pixstep_dev import markdown
from pixstep_dev.bench import compare, figures, run
from pixstep_dev.bench.figure import BenchFigure

if TYPE_CHECKING:
    import rich.console
    import rich.text

    from pixstep_dev.bench import tables
else:
    rich = lazy("rich")
    tables = lazy("pixstep_dev.bench.tables")

_MARKERS = "timing"  # of the generated part of docs/TIMING.md
_KEYS = {"figures", "failures", "not_measured"}  # of a result
_PIPE_WIDTH = 160  # columns, where no terminal says


@command("bench")
@click.option(
    "--only",
    type=click.Choice(figures.NAMES),
    multiple=True,
    help="Measure this figure; may be given again.  [default: all]",
)
@click.option(
    "--board",
    "names",
    type=click.Choice(boards.BOARD_NAMES),
    multiple=True,
    help="Measure this board; may be given again.  [default: all]",
)
@click.option("--quick", is_flag=True, help="Leave out the searches over many rates.")
@click.option("--compare", "comparing", is_flag=True, help="Ours beside the peers' and targets.")
@click.option(
    "--from",
    "saved",
    type=FILE,
    multiple=True,
    help="Take a result that --json has saved; may be given again, as of other boards.",
)
@click.option("--json", "as_json", is_flag=True, help="Machine-readable output.")
@click.option("--write", type=FILE, help="Rewrite the figures in FILE between its markers.")
@click.option("--plot", type=PICTURE, help="Draw the ramp's edge errors into FILE (PNG).")
@click.pass_context
def bench(
    ctx: click.Context,
    only: tuple[str, ...],
    names: tuple[str, ...],
    quick: bool,
    comparing: bool,
    saved: tuple[Path, ...],
    as_json: bool,
    write: Path | None,
    plot: Path | None,
) -> None:
    """Measure cycles, rates, CPU share, edge errors, waits and sizes of all boards' images.

    Exit status 0; 1 if any edge was wrong without a fault before it, or if a figure could not be
    measured; 2 for misuse.
    """
    if write:
        if only or names or quick:
            raise UserError("--write takes all figures: leave out --only, --board and --quick")
        markdown.check(write, _MARKERS, "")  # names a missing file or marker before minutes pass
    if saved:
        measured = run.merged([_saved(path) for path in saved])
    else:
        measured = _measure(figures.chosen(only, quick=quick), names)
    if plot:
        _plot(plot)
    try:
        _deliver(measured, comparing, as_json, write)
    except (KeyError, TypeError) as error:
        if not saved:
            raise
        files = ", ".join(map(str, saved))
        raise UserError(f"{files}: not a result of this version: {error}") from None
    ctx.exit(1 if measured["failures"] or measured["not_measured"] else 0)


def _deliver(measured: dict[str, Any], comparing: bool, as_json: bool, write: Path | None) -> None:
    """Write the document, print JSON or tables."""
    if write and measured["not_measured"]:
        raise UserError(f"{write}: not written, a figure is missing: {measured['not_measured'][0]}")
    if write:
        markdown.write(write, _MARKERS, _document(measured))
        click.echo(f"{write}: written", err=True)
    if as_json:
        facts = {"targets": compare.compare(measured)} if comparing else measured
        click.echo(json.dumps({"schema": SCHEMA, **facts}, indent=2))
    elif not write:
        console = rich.console.Console(highlight=False)
        if not console.is_terminal:
            console.width = _PIPE_WIDTH
        _print(console, measured, comparing=comparing)


def _measure(chosen: list[BenchFigure], names: tuple[str, ...]) -> dict[str, Any]:
    if not chosen:
        raise UserError("nothing to measure: --quick leaves out what --only names")
    natives.program("pixstep-sim")  # named once, not by every task
    for board in names or boards.BOARD_NAMES:
        natives.image(board)
    with progress.shown("measuring") as show:
        return {"compiler": _compiler(), **run.measure(chosen, show, boards=names)}


def _compiler() -> str:
    """Return the first line in which the compiler of the images names itself."""
    done = natives.run(["avr-gcc", "--version"])
    return done.stdout.partition("\n")[0]


def _saved(path: Path) -> dict[str, Any]:
    """Return a saved result; raises UserError if the file is none."""
    try:
        measured = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    except ValueError:
        measured = None
    if not isinstance(measured, dict) or not measured.keys() >= _KEYS:
        raise UserError(f"{path}: not a result of `pixstep bench --json`")
    return measured


def _print(console: rich.console.Console, measured: dict[str, Any], *, comparing: bool) -> None:
    if comparing:
        rows = compare.compare(measured)
        console.print(rich.text.Text(compare.about(), style="dim"))
        for columns in (compare.columns(), compare.peer_columns()):
            console.print(tables.grid(columns, rows))
    else:
        tables.show(console, figures.FIGURES, measured)


def _document(measured: dict[str, Any]) -> str:
    """Return the generated part of docs/TIMING.md."""
    rows = compare.compare(measured)
    parts = [f"Compiler of the images: {measured.get('compiler', 'unknown')}."]
    parts += ["### Targets, and what others reach", compare.about()]
    parts += [tables.pipes(compare.columns(), rows), tables.pipes(compare.peer_columns(), rows)]
    return "\n\n".join([*parts, tables.markdown(figures.FIGURES, measured)])


def _plot(path: Path) -> None:
    from pixstep_dev.bench import picture  # matplotlib takes a second to load

    picture.draw(path)
    click.echo(f"{path}: drawn", err=True)


COMMANDS = (bench,)
