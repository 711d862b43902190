# SPDX-License-Identifier: MIT
"""`pixstep bench`: every figure of speed, measured on the real images in the simulator."""

import json
from pathlib import Path

import click
from rich.console import Console
from rich.text import Text

from pixstep import docs, progress
from pixstep.bench import compare, figures, run, tables
from pixstep.cli_options import FILE
from pixstep.errors import UserError

_MARKERS = "timing"  # of the generated part of docs/TIMING.md
_PIPE_WIDTH = 160  # columns, where no terminal says


@click.command("bench")
@click.option(
    "--only",
    type=click.Choice(figures.NAMES),
    multiple=True,
    help="Measure this figure; may be given again.  [default: all]",
)
@click.option("--quick", is_flag=True, help="Leave out the searches over many rates.")
@click.option("--compare", "comparing", is_flag=True, help="Ours beside the peers' and targets.")
@click.option("--from", "saved", type=FILE, help="Take a result that --json has saved.")
@click.option("--json", "as_json", is_flag=True, help="Machine-readable output.")
@click.option("--write", type=FILE, help="Rewrite the figures in FILE between its markers.")
@click.option("--plot", type=FILE, help="Draw the ramp's edge errors into FILE (PNG).")
@click.pass_context
def bench(ctx, only, quick, comparing, saved, as_json, write, plot):
    """Measure cycles, rates, CPU share, edge errors, waits and sizes of both boards' images.

    Exit status 0; 1 if any edge was wrong without a fault before it; 2 for misuse.
    """
    if write:
        if only or quick:
            raise UserError("--write takes all figures: leave out --only and --quick")
        docs.check(write, _MARKERS, "")  # names a missing file or marker before minutes pass
    measured = _saved(saved) if saved else _measure(figures.chosen(only, quick=quick))
    if plot:
        _plot(plot)
    if write:
        docs.write(write, _MARKERS, _document(measured))
        click.echo(f"{write}: written", err=True)
    if as_json:
        click.echo(json.dumps(compare.compare(measured) if comparing else measured, indent=2))
    elif not write:
        console = Console(highlight=False)
        if not console.is_terminal:
            console.width = _PIPE_WIDTH
        _print(console, measured, comparing=comparing)
    ctx.exit(1 if measured["failures"] else 0)


def _measure(chosen: list[figures.Figure]) -> dict:
    with progress.shown("measuring") as show:
        return run.measure(chosen, show)


def _saved(path: Path) -> dict:
    """Return a saved result; raises UserError if the file is none."""
    try:
        measured = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    except ValueError:
        measured = None
    if not isinstance(measured, dict) or not {"figures", "failures"} <= measured.keys():
        raise UserError(f"{path}: not a result of `pixstep bench --json`")
    return measured


def _print(console: Console, measured: dict, *, comparing: bool) -> None:
    if comparing:
        console.print(Text(compare.about(), style="dim"))
        rows = compare.compare(measured)
        for columns in (compare.columns(), compare.peer_columns()):
            console.print(tables.grid(columns, rows))
    else:
        tables.show(console, figures.FIGURES, measured)


def _document(measured: dict) -> str:
    """Return the generated part of docs/TIMING.md."""
    rows = compare.compare(measured)
    parts = ["### Targets, and what others reach", compare.about()]
    parts += [tables.pipes(compare.columns(), rows), tables.pipes(compare.peer_columns(), rows)]
    return "\n\n".join([*parts, tables.markdown(figures.FIGURES, measured)])


def _plot(path: Path) -> None:
    from pixstep.bench import picture  # matplotlib takes a second to load

    picture.draw(path)
    click.echo(f"{path}: drawn", err=True)


COMMANDS = (bench,)
