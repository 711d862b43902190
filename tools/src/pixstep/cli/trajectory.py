# SPDX-License-Identifier: MIT
"""`pixstep trajectory`: tables of two axes, play taken up at reversals, the circle test."""

from __future__ import annotations

from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, NotRequired, TypedDict, Unpack

import click

from pixstep import progress
from pixstep.board import boards, capability
from pixstep.cli import directions
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.manylines import line_axes, line_axes_option
from pixstep.cli.options import (
    HZ,
    Facts,
    deliver_facts,
    json_option,
    out_option,
    pixel_hz_option,
    plot_option,
    plots_option,
    say,
    show_json,
    teller,
)
from pixstep.cli.quantities import StepsType
from pixstep.cli.trajectoryoptions import (
    GivenScale,
    LengthType,
    PlayOptions,
    axis_plays,
    board_play_options,
    counts_of,
    crest_of,
    find_circle,
    per_axis,
    play_options,
    read_table,
    scale_option,
    servo_of,
    unit_of,
)
from pixstep.errors import NEGATIVE, UserError
from pixstep.lazy import lazy
from pixstep.lines.units import Quantity
from pixstep.simulation.report import exit_status, new_console, new_table, print_files, ticks_text
from pixstep.trajectories import choose, circle, circletest, files, host, transitions
from pixstep.trajectories.boardsim import BoardJob
from pixstep.trajectories.circle import HOLDS, Circle, CircleRequest
from pixstep.trajectories.circletest import RUNS, CircleSummary, CircleTest, RunSummary
from pixstep.trajectories.table import AXES, MOST_RECORDS, Table
from pixstep.trajectories.trace import RoundnessData, Trace, Unit, of_points
from pixstep.trajectories.transitions import AxisPlay, Compensated

if TYPE_CHECKING:
    import rich.console
else:
    rich = lazy("rich")

_BOTH = "both"
_count = click.IntRange(0, MOST_RECORDS)
_table_argument = click.argument("table", metavar="TABLE", type=FILE)
_output_option = click.option(
    "-o", "--output", type=OUTPUT, required=True,
    help="Table to write: .csv or -, .parquet, else 16-byte records.",
)  # fmt: skip
_run_option = click.option(
    "--run", "which", type=click.Choice([*RUNS, _BOTH]), default=_BOTH, show_default=True,
    help="The table as it is, compensated, or both, one after the other.",
)  # fmt: skip


class _CircleOptions(TypedDict):
    points: int
    revolutions: int
    holds: int
    lead_in: int


class _SimOptions(PlayOptions):
    scale: GivenScale | None
    image: Path | None
    seed: int
    parquet: bool


class _Run(TypedDict):
    max_load_error_counts: list[float]
    max_following_error_counts: list[float]
    roundness: NotRequired[RoundnessData]


class _Facts(TypedDict):
    file: str
    records: int
    holds: int
    circle: dict[str, int] | None
    top_speed: list[int]
    runs: dict[str, _Run]


@command("circle")
@click.option("--diameter", type=LengthType(), help="Of the circle: 0.125in, 3mm or counts.")
@click.option("--radius", type=LengthType(), help="Instead of the diameter.")
@click.option("--points", type=click.IntRange(4, MOST_RECORDS), default=8192, show_default=True,
              help="Points of a revolution.")  # fmt: skip
@click.option("--revolutions", type=click.IntRange(1, 1000), default=3, show_default=True,
              help="Revolutions at full speed.")  # fmt: skip
@click.option("--holds", type=_count, default=HOLDS, show_default=True,
              help="Records at rest before the motion.")  # fmt: skip
@click.option("--lead-in", type=_count, default=0, show_default=True,
              help="Points in which the speed comes up along the circle before angle 0, and as "
              "many in which it goes down at the end.")  # fmt: skip
@scale_option
@_output_option
@json_option
@click.pass_context
def circle_command(
    ctx: click.Context,
    diameter: Quantity | None,
    radius: Quantity | None,
    scale: GivenScale | None,
    output: Path,
    as_json: bool,
    **options: Unpack[_CircleOptions],
) -> None:
    """Make the table of a circle, counter-clockwise from angle 0, in counts.

    Records are p1, v1, p2, v2, 32 bits each, little-endian: axis 1 is the cosine, axis 2 the sine,
    cut off towards zero. Without a lead-in axis 2 begins at full speed.
    """
    counts = _radius(ctx, diameter, radius, scale)
    request = CircleRequest(counts, **options)
    made = circle.make(request)
    files.write(output, made)
    speed = int(abs(made.counts(1)).max())
    first = int(abs(made.without_holds().counts(1)[:2]).max())
    if first > 1 and 2 * first > speed:
        say((f"axis 2 begins at {first} counts a point: --lead-in brings it up to speed",))
    facts = {"file": str(output), "records": made.records, **asdict(request), "top_speed": speed}
    text = (
        f"{output}: {made.records} records, {made.holds} of them holds, radius {counts} counts, at "
        f"most {speed} counts a point"
    )
    deliver_facts(facts, text, output, as_json=as_json)


@command("import")
@_table_argument
@_output_option
@json_option
def import_command(table: Path, output: Path, as_json: bool) -> None:
    """Check a table of your own and write it as 16-byte records.

    CSV or Parquet with columns p1, p2 and, together or not at all, v1, v2: whole counts, a row for
    each point. Velocities that are missing are taken from the positions around.
    """
    _convert(table, output, as_json=as_json)


@command("export")
@_table_argument
@_output_option
@json_option
def export_command(table: Path, output: Path, as_json: bool) -> None:
    """Write a table as CSV or Parquet, by the end of the output's name."""
    _convert(table, output, as_json=as_json)


@command("compensate")
@_table_argument
@play_options
@click.option("--pixel-hz", type=HZ, help="Points a second, for --bandwidth.")
@scale_option
@_output_option
@json_option
@click.pass_context
def compensate_command(
    ctx: click.Context,
    table: Path,
    pixel_hz: Fraction | None,
    scale: GivenScale | None,
    output: Path,
    as_json: bool,
    **options: Unpack[PlayOptions],
) -> None:
    """Write a table with the play of both axes taken up at every reversal.

    For a controller elsewhere: `trajectory sim` does this when it runs a table. Exit status 1 if a
    reversal comes before the play of the one before is taken up.
    """
    original = read_table(table)
    plays = axis_plays(options, original, pixel_hz)
    made = transitions.compensate(original, plays)
    files.write(output, made.table)
    predicted = _predicted(original, plays, pixel_hz, options)
    if as_json:
        show_json({"file": str(table), "output": str(output), **_plays_json(plays, predicted),
                   "transitions": circletest.transitions_as_json(made.transitions)})  # fmt: skip
    else:
        _print_compensated(made, plays, predicted, unit_of(ctx, scale), output)
    ctx.exit(NEGATIVE if any(item.missing for item in made.transitions) else 0)


@command("show")
@_table_argument
@play_options
@_run_option
@click.option("--pixel-hz", type=HZ, help="Points a second, for --bandwidth.")
@scale_option
@plot_option()
@json_option
@click.pass_context
def show_command(
    ctx: click.Context,
    table: Path,
    which: str,
    pixel_hz: Fraction | None,
    scale: GivenScale | None,
    plot: Path | None,
    as_json: bool,
    **options: Unpack[PlayOptions],
) -> None:
    """Show what is in a table and, with --play, what the load of a modelled machine does.

    The model has the play, and a servo of --bandwidth; radius errors are those at the points.
    """
    original = read_table(table)
    found = find_circle(original)
    traces = _modelled(original, which, pixel_hz, options) if options["play"] or plot else []
    unit = unit_of(ctx, scale)
    facts: _Facts = {
        "file": str(table), "records": original.records, "holds": original.holds,
        "circle": asdict(found) if found else None,
        "top_speed": [int(abs(original.counts(axis)).max()) for axis in range(AXES)],
        "runs": {run.name: _model_summary(run, found, unit) for run in traces},
    }  # fmt: skip
    if plot:
        along = "seconds" if pixel_hz else "points"
        _draw_model(traces, found, unit, f"{original.name} on a modelled machine", along, plot)
    if as_json:
        show_json(facts)
    else:
        _print_facts(facts, unit)


@command("sim")
@_table_argument
@board_play_options
@_run_option
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@line_axes_option
@pixel_hz_option
@click.option("--plant-play", type=StepsType(0), multiple=True,
              help="Play of the simulated axes; once, or per axis.  [default: --play]")  # fmt: skip
@scale_option
@click.option("--image", type=FILE, help="Another firmware image (ELF) for the board.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True,
              help="Of everything random.")  # fmt: skip
@click.option("--parquet", is_flag=True, help="Write the measurement records as Parquet.")
@out_option
@plots_option
@json_option
@click.pass_context
def sim_command(
    ctx: click.Context,
    table: Path,
    which: str,
    board: str,
    axis: tuple[int, ...],
    pixel_hz: Fraction,
    plant_play: tuple[int, ...],
    out: Path,
    plot: bool,
    as_json: bool,
    **options: Unpack[_SimOptions],
) -> None:
    """Run a table on two axes of a simulated board, and measure the circle that its loads make.

    The one table runs as it is and compensated; hold records are left out. Every edge is judged,
    and the load is looked at at every step of either motor. Exit status 0 only if the verdict is
    pass.
    """
    original = read_table(table).without_holds()
    cap = capability.of(board, pixel_hz, axes=min(AXES, boards.load(board).axes))
    most = cap.top_speed(capability.PLAIN) - int(abs(original.velocities).max()) - 1
    plays = axis_plays(options, original, pixel_hz, most)
    plants = per_axis(plant_play or options["play"], 0, "--plant-play")
    test = CircleTest(
        original,
        plays,
        BoardJob(
            board,
            pixel_hz,
            tuple(plants),
            tuple(line_axes(axis, AXES)),
            options["image"],
            options["seed"],
            directions.ways(ctx, AXES),
        ),
        find_circle(original),
        unit_of(ctx, options["scale"]),
        RUNS if which == _BOTH else (which,),
        ".parquet" if options["parquet"] else ".csv",
    )
    with progress.shown("simulating") as show:
        summary = circletest.simulate(test, out, plot=plot, progress=show)
    if as_json:
        show_json(summary)
    else:
        console = new_console()
        _print_summary(console, summary)
        print_files(console, out)
    ctx.exit(exit_status(summary["verdict"]))


def _radius(
    ctx: click.Context,
    diameter: Quantity | None,
    radius: Quantity | None,
    scale: GivenScale | None,
) -> int:
    """Return the radius in counts, cut off as the table's positions are."""
    length = radius or diameter
    if length is None or (diameter and radius):
        raise UserError("a circle has --diameter or --radius, one of them")
    counts = counts_of(ctx, length, scale) / (1 if radius else 2)
    if counts < 1:
        raise UserError(f"a radius of {float(counts):g} counts: at least 1")
    return int(counts)


def _convert(table: Path, output: Path, *, as_json: bool) -> None:
    """Read a table and write it in the form that the output's name says."""
    made = read_table(table)
    files.write(output, made)
    facts = {"file": str(table), "output": str(output), "records": made.records,
             "holds": made.holds}  # fmt: skip
    text = f"{output}: {made.records} records, {made.holds} of them holds"
    deliver_facts(facts, text, output, as_json=as_json)


def _predicted(
    original: Table, plays: tuple[AxisPlay, ...], hz: Fraction | None, options: PlayOptions
) -> list[float] | None:
    """Return the radius error of each axis' transitions; None without a circle, or points' time."""
    found = find_circle(original)
    if found is None or (servo_of(options) and hz is None):
        return None
    return [
        choose.predicted_error(crest_of(found, item.play, hz, options), item.steps)
        if item.play else 0.0
        for item in plays
    ]  # fmt: skip


def _plays_json(plays: tuple[AxisPlay, ...], predicted: list[float] | None) -> Facts:
    return {
        "play": [item.play for item in plays],
        "transition_points": [item.steps for item in plays],
        "predicted_radius_error_counts": predicted,
    }


def _print_compensated(
    made: Compensated, plays: tuple[AxisPlay, ...], predicted: list[float] | None, unit: Unit,
    output: Path,
) -> None:  # fmt: skip
    """Print a line for each axis, and one for each transition that is broken off."""
    tell = teller(output)
    for axis, item in enumerate(plays):
        mine = [one for one in made.transitions if one.axis == axis]
        error = f", predicted radius error {unit.text(predicted[axis])}" if predicted else ""
        tell(
            f"{output}: axis {axis + 1}: {len(mine)} transitions of {item.steps} points for "
            f"{item.play} counts{error}"
        )
    for one in made.transitions:
        if one.missing:
            tell(
                f"{output}: record {one.record + 1}: warning: axis {one.axis + 1}: the next "
                f"reversal comes {one.missing} counts too early"
            )


def _modelled(
    original: Table, which: str, hz: Fraction | None, options: PlayOptions
) -> list[Trace]:
    """Return what the load of a modelled machine does."""
    plays = axis_plays(options, original, hz)
    servo = servo_of(options)
    if servo and hz is None:
        raise UserError("a servo has a bandwidth in time: give --pixel-hz, or --bandwidth none")
    machine = host.Machine(tuple(item.play for item in plays), float(1 / hz) if hz else 1.0, servo)
    chosen = RUNS if which == _BOTH else (which,)
    return [host.run(original, plays, name, machine) for name in chosen]


def _model_summary(run: Trace, found: Circle | None, unit: Unit) -> _Run:
    errors = abs(run.load_errors).max(axis=0).tolist()
    lags = abs(run.following_errors).max(axis=0).tolist()
    facts: _Run = {
        "max_load_error_counts": [round(value, 3) for value in errors],
        "max_following_error_counts": [round(value, 3) for value in lags],
    }
    if found:
        facts["roundness"] = of_points(run, found).summary(unit)
    return facts


def _draw_model(
    traces: list[Trace], found: Circle | None, unit: Unit, below: str, along: str, path: Path
) -> None:
    from pixstep.trajectories import picture  # matplotlib takes a second to load

    if found:
        picture.draw([of_points(run, found) for run in traces], unit, below, path)
    else:
        picture.draw_errors(traces, unit, below, path, along)


def _print_facts(facts: _Facts, unit: Unit) -> None:
    """Print what is in a table, and the model's runs."""
    top = " and ".join(map(str, facts["top_speed"]))
    click.echo(
        f"{facts['file']}: {facts['records']} records, {facts['holds']} of them holds, at most "
        f"{top} counts a point"
    )
    found = facts["circle"]
    if found:
        click.echo(
            f"circle: radius {found['radius']} counts, {found['points']} points a revolution, "
            f"{found['revolutions']} revolutions from record {found['start'] + 1} on"
        )
    for name, run in facts["runs"].items():
        if "roundness" in run:
            click.echo(f"{name}: {_roundness_text(run['roundness'], unit)}")
        else:
            loads = " and ".join(f"{value:g}" for value in run["max_load_error_counts"])
            click.echo(f"{name}: load at most {loads} counts off")


def _roundness_text(found: RoundnessData, unit: Unit) -> str:
    return (
        f"radius error at most {unit.text(found['max_radius_error_counts'])} at "
        f"{found['at_degrees']:.1f} degrees, passes {found['passes_apart_counts']:g} counts apart"
    )


def _print_summary(console: rich.console.Console, summary: CircleSummary) -> None:
    """Print the verdict and a row for each run."""
    colour = "bold green" if summary["verdict"] == "pass" else "bold red"
    plays = " and ".join(map(str, summary["play_steps"]))
    points = " and ".join(map(str, summary["transition_points"]))
    console.print(
        f"[{colour}]{summary['verdict'].upper()}[/]  {summary['board']}, {summary['pixel_hz']} Hz, "
        f"play {plays} steps, taken up in {points} points"
    )
    for reason in summary["reasons"]:
        console.print(f"  {reason}", style="red", markup=False, highlight=False, soft_wrap=True)
    table = new_table("run", "ticks", "load off", "radius error", "at", "apart")
    for name, run in summary["runs"].items():
        table.add_row(name, *_cells(run))
    table.caption = (
        "ticks: edge minus exact instant; load off: counts from the\n"
        "table at a pixel edge; radius error: at any step; apart:\n"
        "passes at the same point, counts"
    )
    table.caption_justify = "left"
    console.print(table)


def _cells(run: RunSummary) -> list[str]:
    """Return what is told of a run in a row."""
    ticks = ticks_text(max(axis["max_edge_error_ticks"] for axis in run["edges"]))
    loads = " ".join(map(str, run.get("max_load_error_counts", []))) or "-"
    found = run.get("roundness")
    if not found:
        return [ticks, loads, "-", "-", "-"]
    error = f"{found['max_radius_error']:.6f} {found['unit']}"
    if found["unit"] == "counts":
        error = f"{found['max_radius_error']:.1f} counts"
    apart = f"{found['passes_apart_counts']:g}"
    return [ticks, loads, error, f"{found['at_degrees']:.1f}°", apart]
