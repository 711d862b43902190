# SPDX-License-Identifier: MIT
"""Homing on a simulated board with a load and its switches."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.board import capability
from pixstep.moves import experiments, legs
from pixstep.moves.homing_judge import HomeJob, HomeSummary
from pixstep.operations import shared, simulated
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import TEXT
from pixstep.operations.motion.home_fields import HomeFields
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result
from pixstep.simulation import report

if TYPE_CHECKING:
    import rich.table


@operation("home sim")
class HomeSim(HomeFields):
    """Home a simulated axis by a CSV or CSB profile, and judge it by the simulator's own log.

    Exit status 0 only if the switch was found and the verdict is pass, 1 if not, 2 for misuse, 3
    for a profile that the board refuses.
    """

    result = HomeSummary

    board: str = shared.simulated_board()
    pixel_hz: Fraction = shared.pixel_hz()
    plant: str = option(
        TEXT,
        "The load and its switches: home=2000,hyst=8,travel=-500..4000,start=123,delay=8000 "
        "(steps of the motor; delay in ticks of the board); more: build/host/bin/pixstep-sim "
        "--help.",
        required=True, shown="KNOBS",
    )  # fmt: skip
    seed: int = shared.seed()
    out: Path = shared.out("homing")
    plot: bool = shared.plots()

    def run(self, desk: Desk) -> Result:
        """Home the axis in the simulator."""
        plan = self.plan(desk, self.pixel_hz)
        legs.refuse(plan, capability.named_limits(self.board, self.pixel_hz))
        job = HomeJob(
            plan=plan,
            board=self.board,
            pixel_hz=self.pixel_hz,
            plant=self.plant,
            inverted=self.inverted or "none",
            filter_us=self.filter_us,
            home_is_limit=self.home_is_limit or "none",
            seed=self.seed,
            scale=desk.facts.scales().get(plan.axis) if self.plot else None,
        )
        with desk.progress("homing") as show:
            summary = experiments.simulate_homing(job, self.out, plot=self.plot, progress=show)
        return simulated.result(summary, self.out, _write)


def _write(page: Page, summary: HomeSummary) -> None:
    """Write the one-page verdict."""
    about = f"{summary['board']} axis {summary['axis']}, towards {summary['direction']}"
    report.print_verdict(page, summary, f"{about}, {summary['pixel_hz']} Hz, {summary['decode']}")
    if summary["legs"]:
        page.print(_legs_table(summary))
    for line in _findings(summary):
        page.tell(line)


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
