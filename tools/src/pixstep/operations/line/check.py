# SPDX-License-Identifier: MIT
"""Check a line by what a motor and a board let it do, plan its edges, show what it does."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import TypedDict

from pixstep import atomic, formats
from pixstep.board import boards, guarantee, settings
from pixstep.board.capability import named_limits
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import core, line_check, units
from pixstep.lines.line import Line
from pixstep.lines.line_check import Finding, FindingFacts, Limits
from pixstep.lines.units import Quantity
from pixstep.operations import judging, machine_defaults, reading_lines, shared, showing
from pixstep.operations.asked import AskedError, AskedRefusedError
from pixstep.operations.clocks import OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, JERK_FIGURE, OUTPUT, Pixels, Whole, WholeHz
from pixstep.operations.reading_lines import backlash_of, load_line
from pixstep.operations.request import argument, flag, operation, option
from pixstep.operations.result import STATUSES, VERDICTS, Page, Result
from pixstep.operations.showing import ShownMotion
from pixstep.profiles.kinematics import LineDrawing


class LineFindings(TypedDict):
    """What a check says of one line; its speed in steps/pixel."""

    file: str
    line: int
    decode: str
    backlash: int
    verdict: str
    pixels: int
    steps: int
    line_speed: int | None
    findings: list[FindingFacts]


class CheckedLine(LineFindings):
    """The check of the first line and of those beside it; the first verdict is that of them all."""

    board: str | None
    beside: list[LineFindings]


@operation("line check")
class LineCheck(OfClock):
    """Check a line of a CSV or CSB file, and the file's form as `file check` does.

    With a pixel frequency by the limits of the board too and by those of the machine file's motor.
    Where the board is named, by what it is guaranteed to follow in time: several files are lines
    that run together, each with its own findings.
    What is refused here `sim` and `board upload` refuse too, unless they are given --no-check.
    Exit status 0 fine, 1 warnings, 3 refused.
    """

    result = CheckedLine

    csv: tuple[Path, ...] = reading_lines.line_files()
    decode: tuple[str, ...] = reading_lines.decodes()
    backlash: tuple[int, ...] = reading_lines.backlashes()
    raw: bool = shared.raw()
    lenient: bool = flag("Accept LF and a missing final newline, as `file check` does.")
    line_number: tuple[int, ...] = reading_lines.line_numbers()
    needs_clock = False  # with a frequency the board's step rate and reversals are checked too
    negative = False  # a line that runs backwards is judged as one that runs forwards

    sync: str = shared.sync()
    board: str = shared.timer_of()
    axes: int | None = option(
        Whole(1), "Axes that move at once, the line's own included: the more, the slower.",
        default_text="as many as there are files",
    )  # fmt: skip
    baud: int = shared.board_baud("Rate of the serial line while the axes move.")
    beyond: bool = judging.beyond()
    min_interval: int | None = option(
        Whole(1, 65_535), "Shortest interval between two steps, ticks. [default: the board's]"
    )
    max_speed: Quantity | None = shared.max_speed(
        "Largest speed, steps/px or steps/s.", machine=machine_defaults.limit_of_one("max_speed")
    )
    max_acceleration: Quantity | None = shared.max_acceleration(
        "Largest acceleration, steps/px2 or steps/s2.",
        machine=machine_defaults.limit_of_one("max_acceleration"),
    )
    start_stop: Quantity | None = shared.start_stop(
        "Up to here a plain line may start, stop and turn without a ramp: steps/px or steps/s.",
        machine=machine_defaults.limit_of_one("start_stop"),
    )
    jerk_warn: Quantity | None = option(JERK_FIGURE, "Warn of larger acceleration changes.")

    def run(self, desk: Desk) -> Result:
        """Read the lines and check them."""
        self._refuse_what_no_board_has(desk)
        lines = self._read(desk)
        found = [
            line_check.check(*one) for one in zip(lines, self._bounds(lines, desk), strict=True)
        ]
        if not any(map(line_check.refused, found)):
            for axis, item in self._together(lines, desk):
                found[axis].append(item)
        first, *beside = map(self._facts, range(len(lines)), lines, found)
        severity = max(map(line_check.exit_status, found))
        data: CheckedLine = {
            **first,
            "verdict": VERDICTS[severity],
            "board": self.board if self.pixel_hz else None,
            "beside": beside,
        }
        names = [line.name for line in lines] if beside else [first["file"]]
        page = functools.partial(_page, names, [first, *beside], found)
        return Result(data, page, STATUSES[severity])

    @property
    def together(self) -> int:
        """How many axes move at once."""
        return self.axes or len(self.csv)

    def _refuse_what_no_board_has(self, desk: Desk) -> None:
        """Refuse fewer axes than files, and axes or a baud rate that the board does not have."""
        if self.together < len(self.csv):
            raise AskedError(
                f"{{axes}} {self.axes}: {len(self.csv)} files are lines of as many axes",
                cure=f": {{axes}} {len(self.csv)} or more, or none",
            )
        is_judged = self.axes or self.pixel_hz or _board_is_named(desk)
        if is_judged and self.together > boards.load(self.board).axes:
            asked = f"{{axes}} {self.axes}" if self.axes else f"{len(self.csv)} files, {{board}}"
            raise AskedError(f"{asked}: {boards.axes_text(self.board)}")
        if _board_is_named(desk):
            shared.refuse_baud(self.board, self.baud)

    def _read(self, desk: Desk) -> list[Line]:
        return reading_lines.read_lines(
            desk,
            self,
            pixel_hz=self.pixel_hz,
            divider=self.edges,
            refuse_faster=True,
            read=functools.partial(_read_strictly, lenient=self.lenient),
        )

    def _facts(self, index: int, line: Line, found: list[Finding]) -> LineFindings:
        severity = line_check.exit_status(found)
        numbers = reading_lines.per_line("line_number", self.line_number, len(self.csv), 1)
        return {
            "file": str(self.csv[index]),
            "line": numbers[index],
            "decode": line.decode,
            "backlash": line.backlash,
            "verdict": VERDICTS[severity],
            "pixels": line.pixels,
            "steps": line.total_steps,
            "line_speed": line.line_speed if severity < 2 else None,
            "findings": line_check.as_json(found),
        }

    def _together(self, lines: list[Line], desk: Desk) -> Iterator[tuple[int, Finding]]:
        """Yield what the board's time says and of which line: of one as many as there are axes."""
        if not self.pixel_hz or not _board_is_named(desk):
            return
        several = [*lines, *[lines[0]] * (self.together - len(lines))]
        clock = settings.of_clock(self.sync, self.edges)
        world = guarantee.world(self.board, self.pixel_hz, clock, self.baud)
        late = guarantee.judge(several, world)
        if late is None:
            return
        severity = line_check.WARNING if self.beyond else line_check.ERROR
        told = guarantee.reason(late, several, world)
        place = late.axis if late.axis < len(lines) else 0
        yield place, Finding(guarantee.NAME, severity, late.pixel, told)

    def _bounds(self, lines: list[Line], desk: Desk) -> list[Limits]:
        """Return what the board and its motor let each line do."""
        if self.pixel_hz and not _board_is_named(desk):
            label = boards.load(self.board).label
            desk.say([AskedText(
                "{path}: checked by what the {label} can do ({board})",
                path=self.csv[0], label=label,
            )])  # fmt: skip
        of_board = [self._of_board(line) for line in lines]
        motors = self._of_motors(lines, desk)
        _refuse_idle(desk, lines, motors)
        return [one.lower(motor) for one, motor in zip(of_board, motors, strict=True)]

    def _of_motors(self, lines: list[Line], desk: Desk) -> list[Limits]:
        """Return the limits of the motors: what is asked for comes before a machine file's."""
        from pixstep.machine import line_limits  # pydantic takes a while to load

        names = ("max_speed", "max_acceleration", "start_stop")
        motors = desk.facts.motors_in_force
        found = []
        for index, line in enumerate(lines):
            motor = motors[index] if len(motors) == len(lines) > 1 else None
            asked = [
                motor.limit(name) if motor and not desk.given(name) else getattr(self, name)
                for name in names
            ]
            limits = line_limits.of_quantities(line, self.pixel_hz, *asked)
            by_motor = not desk.given("max_acceleration")
            found.append(limits.with_rounding(line) if by_motor else limits)
        return found

    def _of_board(self, line: Line) -> Limits:
        hz, found = self.pixel_hz, Limits()
        if hz:
            clock = settings.of_clock(self.sync, self.edges)
            found = named_limits(self.board, hz, axes=self.together, clock=clock).of(line)
        jerk = self.jerk_warn
        return replace(
            found,
            jerk_warning=None if jerk is None else units.whole_limit(jerk, hz, least=0),
            min_interval_ticks=self.min_interval or found.min_interval_ticks,
        )


def _refuse_idle(desk: Desk, lines: list[Line], limits: list[Limits]) -> None:
    """Refuse a start/stop speed that nothing would be judged by."""
    if not desk.given("start_stop"):
        return
    plain = [motor for line, motor in zip(lines, limits, strict=True) if not line.smooth]
    if not plain:
        raise AskedError("{start_stop}: is for plain lines, these are smooth")
    if not all(motor.max_acceleration for motor in plain):
        raise AskedError(
            "{start_stop}: needs {max_acceleration}, which judges starts and stops beyond it"
        )


def _board_is_named(desk: Desk) -> bool:
    """Whether somebody has said which board it is, not the default alone."""
    return bool(desk.given("board") or desk.by_machine("board"))


def _read_strictly(path: Path, *, raw: bool, lenient: bool) -> formats.MotionFile:
    """Read a file as `file check` does; a refusal that --lenient would lift says so."""
    try:
        return formats.read_motion(path, raw=raw, lenient=lenient, strict=not lenient)
    except RefusedError as error:
        if lenient or not _reads_leniently(path, raw=raw):
            raise
        raise AskedRefusedError("{reason} ({lenient} accepts it)", reason=error) from None


def _reads_leniently(path: Path, *, raw: bool) -> bool:
    try:
        formats.read_motion(path, raw=raw, lenient=True)
    except UserError:
        return False
    return True


def _page(
    names: Sequence[str], checked: Sequence[LineFindings], found: Sequence[list[Finding]],
    page: Page,
) -> None:  # fmt: skip
    """Write the findings of each line, and its verdict."""
    for name, data, items in zip(names, checked, found, strict=True):
        _write_line(name, data, items, page)


def _write_line(name: str, data: LineFindings, found: list[Finding], page: Page) -> None:
    """Write the findings of a line, one for neighbours that say the same, and the verdict."""
    # Neighbours are alike but for their pixels, which count up as their places do.
    placed = [(replace(item, pixel=item.pixel - place), item) for place, item in enumerate(found)]
    for _, run in groupby(placed, lambda one: one[0]):
        first, *more = (item for _, item in run)
        last = more[-1].pixel if more else first.pixel
        pixels = f"pixel {last}" if first.pixel == last else f"pixels {first.pixel} to {last}"
        page.tell(f"{name}: {pixels}: {first.severity} {first.name}: {first.message}")
    page.tell(f"{name}: {data['verdict']}: {data['pixels']} pixels, {data['steps']} steps")


class PlannedLine(TypedDict):
    """A plan that was written: its rows are of steps or of pixel edges."""

    file: str
    of: str
    rows: int
    tick_hz: int


@operation("ticks")
class PlanTicks(OfClock):
    """Plan the edges of a line of a CSV or CSB with the native build of the firmware's core."""

    result = PlannedLine

    csv: Path = argument(FILE, shown="FILE")
    decode: str = shared.decode()
    backlash: int = shared.backlash()
    raw: bool = shared.raw()
    line_number: int | None = shared.line_number()
    board: str = shared.timer_of()
    timer_hz: int | None = option(WholeHz(), "Ticks a second.", default_text="the board's")
    pixels: bool = flag("Pixel edges and expected positions instead.")
    output: Path = option(OUTPUT, "CSV file to write.", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Plan the line and write its edges."""
        hz = self.line_hz
        line = load_line(
            desk, self.csv, self.decode, self.backlash, raw=self.raw, number=self.line_number,
            pixel_hz=hz, divider=self.edges,
        )  # fmt: skip
        tick_hz = self.timer_hz or boards.load(self.board).tick_hz
        limits = named_limits(self.board, hz, tick_hz).of_core()
        planned = core.plan(line, hz, tick_hz=tick_hz, pixels=self.pixels, limits=limits)
        desk.say(planned.warnings)
        atomic.write_text(self.output, planned.csv)
        data: PlannedLine = {
            "file": str(self.output),
            "of": "pixel edges" if self.pixels else "steps",
            "rows": len(planned),
            "tick_hz": tick_hz,
        }
        return Result(data, f"{self.output}: {data['rows']} {data['of']}", value=planned)


@operation("line show")
class LineShow(OfClock):
    """Show speed, acceleration, jerk and position of a line: a table, with --plot a drawing."""

    result = ShownMotion

    csv: Path = argument(FILE)
    decode: str = shared.decode()
    backlash: int = shared.backlash()
    raw: bool = shared.raw()
    lead_in: int | None = option(
        Pixels(0),
        "Constant pixels before the image, to mark its start. Default: the header's.",
    )
    needs_clock = False  # the header may say it

    max_speed: Quantity | None = shared.max_speed()
    max_acceleration: Quantity | None = shared.max_acceleration()
    max_jerk: Quantity | None = shared.max_jerk()
    plot: Path | None = shared.picture("-o", "--output")

    def run(self, desk: Desk) -> Result:
        """Read the line and show it."""
        read = formats.read_csv(self.csv, raw=self.raw)
        desk.say(read.notes)
        hz = showing.used_frequency(desk, self.pixel_hz, self.csv, read.header, self.edges)
        lead_in = self.lead_in
        if lead_in is None and read.header:
            lead_in = read.header.lead_in_px
        name = str(self.csv)
        play = backlash_of(desk, name, read.header, read.values, self.decode, self.backlash)
        line = Line(read.values, self.decode, play, name=name)
        _refuse_backlash(line)
        bounds = showing.limits(hz, self.max_speed, self.max_acceleration, self.max_jerk)
        image, scale = _image_pixel(line, lead_in), desk.facts.scale_if_known()
        return showing.shown(LineDrawing(line, self.csv.name, hz, bounds, image, scale), self.plot)


def _refuse_backlash(line: Line) -> None:
    """Refuse a backlash that the line cannot take up: there is nothing right to draw."""
    for item in line_check.check(line):
        if item.name.startswith("backlash"):
            raise UserError(f"{line.name}: {item.message}")


def _image_pixel(line: Line, lead_in: int | None) -> int | None:
    """Return the 1-based pixel where the image starts, None if the lead-in is not known.

    It lies `lead_in` pixels after the first one at the line's speed.
    """
    if lead_in is None or not line.line_speed:
        return None
    speeds = line.speeds if line.smooth else [abs(count) for count in line.counts]
    first = speeds.index(line.line_speed) + 1
    return first + lead_in if first + lead_in <= line.pixels else None
