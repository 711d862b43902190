# SPDX-License-Identifier: MIT
"""Moves of exactly N steps, and homing: how they are asked for, and simulated."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep import formats
from pixstep.board import boards, capability
from pixstep.errors import AskedText, UserError
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import Quantity
from pixstep.moves import experiments, fast, legs
from pixstep.moves.fast import Acceleration, FastMove
from pixstep.moves.homing_judge import HomeJob, HomeSummary
from pixstep.moves.move_judge import MoveJob
from pixstep.operations import machine_defaults as machine
from pixstep.operations import reading_lines, shared
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, SPEED_FIGURE, TEXT, Choice, Steps, Time, Whole
from pixstep.operations.request import Request, argument, operation, option, shared_fields
from pixstep.operations.result import Page, Result
from pixstep.operations.run import simulated_result
from pixstep.profiles import origin
from pixstep.simulation import report
from pixstep.simulation.summary import Move, Summary

if TYPE_CHECKING:
    import rich.table


@shared_fields
class MoveFields(Request):
    """A move of exactly so many steps by a profile."""

    profile: Path = argument(FILE, machine=machine.profile("move"))
    steps: int = option(
        Steps(-fast.MAX_STEPS, fast.MAX_STEPS), "Steps to move, signed, not 0; or 3mm.",
        required=True,
    )  # fmt: skip
    max_speed: Quantity | None = shared.max_speed("Never faster: steps/px or steps/s.")
    raw: bool = shared.raw()
    line_number: int | None = shared.line_number()

    def plan(
        self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False
    ) -> tuple[Acceleration, FastMove]:
        """Read the profile and plan the move in the motor's steps.

        `refuse` a profile that was made for a lower pixel frequency.
        """
        top = None if self.max_speed is None else units.whole_limit(self.max_speed, pixel_hz)
        profile = fast.read(self.profile, raw=self.raw, number=self.line_number, max_speed=top)
        desk.say(reading_lines.motor_notes(desk.facts, self.profile, profile.header))
        desk.say(profile.notes_at(pixel_hz, refuse=refuse))
        return profile, fast.plan(profile, reading_lines.way(desk.facts) * self.steps)


def headline(move: FastMove, pixel_hz: Fraction) -> str:
    """Return a move in one line."""
    return (
        f"{move.steps} steps in {move.pixels} pixels, {move.seconds(pixel_hz):.3f} s at "
        f"{float(pixel_hz):g} Hz, top {move.top} steps/pixel = "
        f"{float(move.top * pixel_hz):g} steps/s"
    )


_MOST_ROWS = 40


class WrittenMove(Move):
    """The plan of a move, and the file that has it."""

    file: str


@operation("move make")
class MoveMake(MoveFields):
    """Write a move as a plain line: one signed count per pixel, in the fewest pixels possible."""

    result = WrittenMove

    pixel_hz: Fraction = shared.pixel_hz()
    output: Path = option(OUTPUT, "CSV file to write (plain).", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Plan the move and write it."""
        job = MoveJob(*self.plan(desk, self.pixel_hz, refuse=True), "", 0, self.pixel_hz)
        formats.write_csv(self.output, list(job.move.counts))
        data: WrittenMove = {"file": str(self.output), **job.plan_summary()}
        return Result(data, f"{self.output}: {headline(job.move, self.pixel_hz)}")


@operation("move show")
class MoveShow(MoveFields):
    """Show a move: how fast in which pixels, how long, where."""

    result = Move

    pixel_hz: Fraction = shared.pixel_hz()
    plot: Path | None = shared.picture(what="Draw speed and position over time")

    def run(self, desk: Desk) -> Result:
        """Plan the move and, if asked, draw it."""
        scale = desk.facts.scales().get(0) if self.plot else None
        job = MoveJob(*self.plan(desk, self.pixel_hz), "", 0, self.pixel_hz, scale)
        if self.plot:
            from pixstep.moves import plots  # matplotlib takes a second to load

            plots.draw_move(job, self.plot)

        def write(page: Page) -> None:
            page.tell(headline(job.move, job.pixel_hz))
            _print_runs(page, job)

        return Result(job.plan_summary(), write)


@operation("move sim")
class MoveSim(MoveFields):
    """Make a move on a simulated board and judge every STEP edge and where it ends.

    Exit status 0 only if the verdict is pass, 1 if it is not, 2 for misuse.
    """

    result = Summary

    pixel_hz: Fraction = shared.pixel_hz()
    board: str = shared.simulated_board()
    axis: int = option(shared.AXIS, "Axis of the board.", default=0, machine=machine.axis)
    out: Path = shared.out("move")
    plot: bool = shared.plots()
    details: bool = shared.details()

    def run(self, desk: Desk) -> Result:
        """Make the move in the simulator."""
        if self.axis >= boards.load(self.board).axes:
            raise UserError(f"axis {self.axis}: the {boards.axes_text(self.board)}")
        planned = self.plan(desk, self.pixel_hz)
        scale = desk.facts.scales().get(self.axis) if self.plot else None
        job = MoveJob(*planned, self.board, self.axis, self.pixel_hz, scale)
        with desk.progress("moving") as show:
            done = experiments.simulate_move(job, self.out, plot=self.plot, progress=show)

        def write(page: Page, summary: Summary) -> None:
            report.print_page(page, summary, details=self.details)
            page.tell(headline(job.move, job.pixel_hz))
            move = summary["move"]
            page.tell(
                f"ends at {_known(move['position_register_steps'])} by the board's position "
                f"register, {move['counted_steps']} by the simulator's count of STEP edges"
            )

        return simulated_result(done.judged.summary, self.out, write)


def _print_runs(page: Page, job: MoveJob) -> None:
    """Print one row for each stretch of equal pixels; of very many the first and last ones."""
    table = report.new_table("pixels", "steps/pixel", "steps/s", "position at its end")
    pixel = place = 0
    hidden = range(_MOST_ROWS // 2, len(job.move.runs) - _MOST_ROWS // 2)
    for index, (count, repeat) in enumerate(job.move.runs):
        span = f"{pixel + 1}" if repeat == 1 else f"{pixel + 1} to {pixel + repeat}"
        pixel, place = pixel + repeat, place + count * repeat
        if index not in hidden:
            table.add_row(span, str(count), f"{float(count * job.pixel_hz):g}", str(place))
        elif index == hidden.start:
            table.add_row("...", "", "", "")
    page.print(table)


def _known(value: int | None) -> str:
    return "no position" if value is None else str(value)


_AS_SET = "none; on a board as it is set"


@shared_fields
class HomeFields(Request):
    """Homing by a profile: where the switch is sought, how fast, and what it is."""

    profile: Path = argument(FILE, machine=machine.profile("home"))
    axis: int = option(shared.AXIS, "Axis of the board.", default=0, machine=machine.axis)
    direction: str = option(
        Choice(list(legs.DIRECTIONS)),
        "Direction to the switch, which is closed from its place on.", default="plus",
    )  # fmt: skip
    decode: str | None = shared.decode(
        "How the motor takes the profile while it seeks the switch; moves in between are plain.",
        required=False, default_text="by the motor in the file's name, smooth for M39, else plain",
    )  # fmt: skip
    haps: int | None = option(
        Whole(), "Entries of the profile to use.", default_text="its header's"
    )
    slow: Quantity | None = option(
        SPEED_FIGURE, "Speed of the second approach, steps/px or steps/s; an even number if "
                      "smooth.",
        default_text="first entry, or the even number below",
    )  # fmt: skip
    search: int = option(Steps(), "Give a leg up after this many steps.", default=legs.SEARCH_STEPS)
    clear: int | None = option(Steps(), "Begin the second approach at least this many steps away.")
    filter_us: int | None = option(
        Time("us", *legs.FILTER_US, int), "How long a change of a switch must last to count."
    )
    inverted: str | None = option(
        Choice(list(legs.INVERTED)), "Switches that are tripped when their pin is high.",
        default_text=_AS_SET,
    )  # fmt: skip
    home_is_limit: str | None = option(
        Choice(list(legs.SHARED)), "The motor's limit switch that the home switch also is.",
        machine=machine.home_is_limit, default_text=_AS_SET,
    )  # fmt: skip
    raw: bool = shared.raw()
    line_number: int | None = shared.line_number()

    def read_profile(
        self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False
    ) -> fast.Acceleration:
        """Read the profile. `refuse` one for a lower frequency."""
        read = fast.read(self.profile, raw=self.raw, number=self.line_number)
        desk.say(reading_lines.motor_notes(desk.facts, self.profile, read.header))
        desk.say(read.notes_at(pixel_hz, refuse=refuse))
        return read

    def plan(self, desk: Desk, pixel_hz: Fraction, *, refuse: bool = False) -> legs.HomingPlan:
        """Read the profile and plan the homing that is asked for."""
        decode = self.decode or self._motor_decode(desk)
        way, smooth = reading_lines.way(desk.facts), decode == SMOOTH
        slow = None
        if self.slow is not None:
            slow = units.whole_speed(self.slow, pixel_hz, None, smooth=smooth)
        request = legs.HomingRequest(
            axis=self.axis,
            direction=way * legs.DIRECTIONS[self.direction],
            turned=way < 0,
            haps=self.haps,
            slow=slow,
            search_steps=self.search,
            clear_steps=self.clear,
            decode=decode,
        )
        return legs.plan(self.read_profile(desk, pixel_hz, refuse=refuse), request, pixel_hz)

    def _motor_decode(self, desk: Desk) -> str:
        """Return how the motor in a conventional file name decodes; plain if it names none."""
        named = origin.parse_name(self.profile)
        decode = reading_lines.motor_decode(desk.facts, self.profile)
        if named is None or decode is None:
            return PLAIN
        desk.say([AskedText(
            "{path}: named for {motor}, so homing is {rule} ({decode})",
            path=self.profile, motor=named.motor, rule=decode,
        )])  # fmt: skip
        return decode


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
        return simulated_result(summary, self.out, _write)


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
