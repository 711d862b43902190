# SPDX-License-Identifier: MIT
"""`pixstep home sim`: homing on a simulated board with a load and its switches."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from pixstep import progress
from pixstep.board import boards, limits
from pixstep.cli import machinedefaults
from pixstep.cli.command import command
from pixstep.cli.homeoptions import HomeOptions, home_options, make_plan
from pixstep.cli.options import json_option, out_option, pixel_hz_option, plots_option
from pixstep.cli.results import deliver
from pixstep.lazy import lazy
from pixstep.moves import homesim, hometask, legs
from pixstep.moves.homejudge import HomeSummary
from pixstep.simulation import report

if TYPE_CHECKING:
    import rich.console
    import rich.table
else:
    rich = lazy("rich")


class _SimOptions(HomeOptions):
    board: str
    pixel_hz: Fraction
    plant: str
    seed: int


@command("sim")
@home_options
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@pixel_hz_option
@click.option(
    "--plant",
    required=True,
    metavar="KNOBS",
    help="The load and its switches: home=2000,hyst=8,travel=-500..4000,start=123,delay=8000 "
    "(steps of the motor; delay in ticks of the board); more: pixstep-sim --help (in a clone "
    "build/host/bin/pixstep-sim).",
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
@out_option
@plots_option
@json_option
@click.pass_context
def home_sim(
    ctx: click.Context, out: Path, plot: bool, as_json: bool, **options: Unpack[_SimOptions]
) -> None:
    """Home a simulated axis by a CSV or CSB profile, and judge it by the simulator's own log.

    Exit status 0 only if the switch was found and the verdict is pass, 1 if not, 2 for misuse, 3
    for a profile that the board refuses.
    """
    plan = make_plan(options, options["pixel_hz"])
    legs.refuse(plan, limits.named(options["board"], options["pixel_hz"]))
    job = homesim.HomeJob(
        plan=plan,
        board=options["board"],
        pixel_hz=options["pixel_hz"],
        plant=options["plant"],
        inverted=options["inverted"] or "none",
        filter_us=options["filter_us"],
        home_is_limit=options["home_is_limit"] or "none",
        seed=options["seed"],
        scale=machinedefaults.scales(ctx).get(plan.axis) if plot else None,
    )
    with progress.shown("homing") as show:
        summary = hometask.simulate(job, out, plot=plot, progress=show)
    ctx.exit(deliver(summary, out, _print_page, as_json=as_json))


def _print_page(console: rich.console.Console, summary: HomeSummary) -> None:
    """Print the one-page verdict."""
    colour = "bold green" if summary["verdict"] == "pass" else "bold red"
    console.print(
        f"[{colour}]{summary['verdict'].upper()}[/]  {summary['board']} axis {summary['axis']}, "
        f"towards {summary['direction']}, {summary['pixel_hz']} Hz, {summary['decode']}"
    )
    for reason in summary["reasons"]:
        console.print(f"  {reason}", style="red", markup=False, highlight=False, soft_wrap=True)
    if summary["legs"]:
        console.print(_legs_table(summary))
    for line in _findings(summary):
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _legs_table(summary: HomeSummary) -> rich.table.Table:
    table = report.new_table("leg", "pixels", "steps", "top steps/s", "edge at", "tick", "seconds")
    table.columns[0].justify = "left"
    for leg in summary["legs"]:
        trip = leg["trip"] or {}
        table.add_row(
            leg["name"],
            str(len(leg["pixel_counts"])),
            str(leg["steps"]),
            f"{leg['fastest_steps_s']:.0f}",
            str(trip.get("position_steps", "")),
            str(trip.get("ticks", "")),
            f"{leg['ended_s'] - leg['began_s']:.3f}",
        )
    return table


def _findings(summary: HomeSummary) -> list[str]:
    """Return what was found, a line each."""
    lines = [
        f"fastest {summary['fastest_steps_s']:g} steps/s; HAPs {summary['haps']} allow "
        f"{summary['haps_entry_steps_s']:g}"
    ]
    if summary["capture_offset_ticks"] is not None:
        lines.append(
            f"{summary['captures']} edges captured, each on the tick of the simulator's own log "
            f"(timers started at cycle {summary['capture_offset_ticks']})"
        )
    edge = summary["edge"]
    if edge is None:
        return [*lines, "home not found"]
    lines.append(
        f"home found: its edge was at position {edge['position_steps']} before the "
        f"zero; the axis stopped {abs(summary['beyond_edge_steps'])} steps beyond it and now "
        f"stands on position {summary['position_steps']}"
    )
    if summary["switch_closes_at_steps"] is not None:
        lines.append(
            f"the load rests at {summary['load_at_rest_steps']}, its switch closes at "
            f"{summary['switch_closes_at_steps']} steps"
        )
    return lines
