# SPDX-License-Identifier: MIT
"""The verdict on each line of a chain: by its own edges, as a line alone, and at its seams.

A line alone has its zero and its play for granted. In a chain both follow from the lines before:
the grid goes on over the seam, with its part of a tick, the motor begins where the line before has
left it, and its load where it has left the load. So a line's load is compared with where the counts
of all lines so far take it, and its zero with where the grid has it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

from pixstep.board import boards
from pixstep.jobs.shapes import MINUS, PLUS
from pixstep.jobs.simulated.cuts import JobBlock
from pixstep.jobs.simulated.rows import FAIL, MOST_REASON, PASS, Edges, LineRow
from pixstep.lazy import np
from pixstep.lines import exact
from pixstep.lines.line import Line
from pixstep.simulation import clock_judge, pixel_clock, verdict
from pixstep.simulation.job import FREE, LOCK, START, LineExperiment
from pixstep.simulation.logs import AxisEdges, AxisPlant, ClockLog, EdgeLog
from pixstep.simulation.pixel_clock import PixelGrid
from pixstep.simulation.verdict import CLOCK_TOLERANCE, AxisVerdict

LOAD_STEPS = 1
_ROUNDED_TICKS = 2  # that two edges may be apart by their rounding
_KEPT_REASONS = 3


@dataclass(frozen=True)
class BlockOutcome:
    """What a run of a block has left; `trouble` says what went wrong in it."""

    block: JobBlock
    edges: EdgeLog
    clock: ClockLog
    plants: Mapping[tuple[int, int], AxisPlant]
    trouble: str = ""


@dataclass(frozen=True)
class JudgedBlock:
    """Rows and edges of a block's lines, without those that only ran before."""

    rows: list[LineRow]
    edges: list[Edges]


@dataclass
class _Part:
    """A motor in a line of the chain: its line, its edges, what is found."""

    number: int
    motor: str
    line: Line
    edges: AxisEdges
    of: LineExperiment
    axis: int
    rounded: bool  # its board has other ticks than the cycles of the edges
    found: AxisVerdict = field(init=False)
    grid: PixelGrid | None = None
    reasons: list[str] = field(default_factory=list)
    late_ticks: float | None = None
    clock_error_ticks: float | None = None
    apart_ticks: float | None = None
    load_error_steps: int | None = None
    off_steps: int = 0

    @property
    def zero(self) -> int | None:
        """The cycle of line zero, as its steps tell it."""
        return self.found.line_zero_cycle


def judge(made: BlockOutcome) -> JudgedBlock:
    """Judge all lines of a block."""
    motors = {name: [*_parts(made, name)] for name in made.block.place.motors}
    chain = _LineGrid(made)
    for name, parts in motors.items():
        chain.judge(parts)
        _turns(parts)
        _positions(made, name, parts)
        _loads(made, name, parts)
    for line in zip(*motors.values(), strict=True):
        chain.together(line)
    _blame(made, motors)
    begin = min((int(part.edges.rising[0]) for parts in motors.values() for part in parts
                 if len(part.edges.rising)), default=0)  # fmt: skip
    found = JudgedBlock([], [])
    for line in [*zip(*motors.values(), strict=True)][made.block.run_in :]:
        for part in line:
            edges = Edges(
                part.number - made.block.run_in, part.motor, part.edges.rising - begin,
                part.edges.directions(),
            )  # fmt: skip
            found.edges.append(edges)
            found.rows.append(_row(made, part, edges, begin))
    return found


def _parts(made: BlockOutcome, name: str) -> Iterator[_Part]:
    """Yield a motor's lines with their edges: as many as each has to make, the last one the rest.

    The cycles of all boards are those of the first one.
    """
    block, (board, axis) = made.block, made.block.place.motors[name]
    follows = block.follows
    kinds = [*block.place.boards.values()]
    rounded = boards.load(kinds[board]).tick_hz != boards.load(kinds[0]).tick_hz
    of_line = LineExperiment(
        kinds[0], {}, block.job.machine.tables.clock_hz, block.world.ppm, block.world.flaws,
        follows.sync, follows.divider, follows.gate_edges,
    )  # fmt: skip
    edges, done = made.edges.axis(board, axis), 0
    ups = np.flatnonzero(edges.step_levels == 1)
    for number in range(1, block.job.lines + 1):
        line = block.job.line(number)[name]
        until = len(ups) if number == block.job.lines else done + line.total_steps
        mine = _between(edges, ups, done, until)
        yield _Part(number, name, line, mine, replace(of_line, lines={axis: line}), axis, rounded)
        done = until


def _between(edges: AxisEdges, ups: np.ndarray, first: int, until: int) -> AxisEdges:
    """Return some steps of an axis, with the directions that they and those before them have."""
    chosen = ups[first:until]
    if not len(chosen):
        return AxisEdges()
    begin, end = int(chosen[0]), len(edges.step_cycles) if until >= len(ups) else int(ups[until])
    last = int(edges.step_cycles[chosen[-1]])
    known = int(np.searchsorted(edges.direction_cycles, last, side="right"))
    return AxisEdges(
        edges.step_cycles[begin:end], edges.step_levels[begin:end],
        edges.direction_cycles[:known], edges.direction_levels[:known],
    )  # fmt: skip


class _LineGrid:
    """The grid of a block's lines: where it begins, and where each line should."""

    def __init__(self, made: BlockOutcome) -> None:
        self._made, self._job = made, made.block.job
        self._follows = made.block.follows
        self._locked = self._follows.sync == LOCK
        self._zeros: dict[object, int] = {}  # the chain's line zero, or its edge, by who shares it

    def judge(self, parts: list[_Part]) -> None:
        """Judge a motor's lines: each alone, and its zero by the chain's."""
        for part in parts:
            if self._locked:
                self._judge_locked(part)
            else:
                self._judge_own_time(part)
            part.reasons[:0] = part.found.reasons

    def _begins(self, part: _Part) -> Fraction:
        """Return where the line begins, in ticks of the board's time since the chain began."""
        return (part.number - 1) * self._job.pixels * part.of.period

    def _judge_own_time(self, part: _Part) -> None:
        """Judge a line on its board's time; the first one begins on an edge of the clock."""
        whole, of = int(self._begins(part) // 1), part.of
        phase = self._begins(part) - whole
        if part.rounded:
            part.found, part.grid = verdict.judge_locked_axis(
                part.line, of.period, part.edges, part.axis, tick_hz=of.tick_hz, rounded=True
            )
        else:
            part.found = verdict.judge_axis(
                part.line, of.period, part.edges, part.axis, tick_hz=of.tick_hz, phase=phase
            )
        zero = part.zero
        if zero is None:
            return
        if part.grid is None:
            part.grid = pixel_clock.nominal(part.line, of.period, zero + float(phase))
        sync, motor = self._follows.sync, self._made.block.place.motors[part.motor]
        who = motor if sync == FREE else motor[0]  # free lines begin one after the other
        if who not in self._zeros:
            self._zeros[who] = zero - whole
            if sync == START:
                _, reason = verdict.judge_clock(
                    self._zeros[who], of.clock_period, self._made.clock.seen
                )
                part.reasons += [reason] if reason else []
        late = zero - whole - self._zeros[who]
        part.late_ticks = float(late)
        if abs(late) > _ROUNDED_TICKS * part.rounded:
            part.reasons.append(f"line zero is {late:+} ticks off the grid of the lines before")

    def _judge_locked(self, part: _Part) -> None:
        """Judge a line on the clock: its own grid, the clock's edges, the edge of its line zero."""
        of, clock = part.of, self._made.clock
        part.found, part.grid = verdict.judge_locked_axis(
            part.line, of.period, part.edges, part.axis, tick_hz=of.tick_hz, rounded=part.rounded
        )
        if part.grid is None:
            return
        kept = clock_judge.keep(of, part.axis, part.line, part.edges, part.grid, clock)
        if kept is None:
            return
        part.clock_error_ticks = round(float(np.max(np.abs(kept.errors_ticks))), 3)
        part.reasons += clock_judge.reasons(of, kept)
        if self._follows.gate_edges:
            part.reasons += clock_judge.gate_reasons(of, kept)
            return
        due = (part.number - 1) * self._job.pixels * self._follows.divider
        late = kept.first_edge - due - self._zeros.setdefault(0, kept.first_edge - due)
        part.late_ticks = float(late * of.clock_period)
        if late:
            part.reasons.append(f"line zero is {late:+} clock edges off the end of the line before")

    def together(self, parts: tuple[_Part, ...]) -> None:
        """Compare the motors of a line: pixels that end with a step end together."""
        ends: dict[int, tuple[int, int]] = {}
        for part in parts:
            if part.grid is None:
                continue
            for pixel, done in exact.edge_ends(part.line):
                if done <= len(part.edges.rising):
                    cycle = int(part.edges.rising[done - 1])
                    low, high = ends.get(pixel, (cycle, cycle))
                    ends[pixel] = min(low, cycle), max(high, cycle)
        if sum(part.grid is not None for part in parts) < 2 or not ends:
            return
        apart = max(high - low for low, high in ends.values())
        most = clock_judge.EDGE_TICKS if self._locked else CLOCK_TOLERANCE
        for part in parts:
            part.apart_ticks = float(apart)
        # A clock that jitters is seen otherwise by each board; how far is told, and not judged.
        if apart > most and self._follows.sync != FREE and self._made.block.world.flaws.even:
            parts[0].reasons.append(f"pixel edges of the motors are up to {apart} ticks apart")


def _turns(parts: list[_Part]) -> None:
    """Require the driver's hold time between the last step of a line and a turn for the next."""
    last: int | None = None
    for part in parts:
        turns, ups = part.edges.direction_cycles, part.edges.rising
        if last is not None and len(turns):
            after = turns[turns >= last]
            if len(after) and after[0] - last < verdict.DIRECTION_SETUP_S * part.of.tick_hz:
                part.reasons.append(
                    f"DIR changes {after[0] - last} ticks after the last step of the line before"
                )
        last = int(ups[-1]) if len(ups) else last


def _positions(made: BlockOutcome, name: str, parts: list[_Part]) -> None:
    """Compare where a motor begins and ends with the job, and from which side it comes."""
    where, side = 0, ""
    for part in parts:
        run = made.block.job.runs_of(part.number)[name]
        if side and run.play_side != side:
            part.reasons.append(
                f"the motor comes from {side}, the job has it from {run.play_side or 'none'}"
            )
        if where != run.start_steps:
            part.reasons.append(
                f"the motor begins {where - run.start_steps:+} steps from where the job has it"
            )
        made_steps = part.edges.directions()
        where += int(made_steps.sum())
        end = made.block.job.expected(part.number, name)[-1]
        part.off_steps = where - end
        if len(made_steps):
            side = MINUS if made_steps[-1] < 0 else PLUS


def _loads(made: BlockOutcome, name: str, parts: list[_Part]) -> None:
    """Compare a motor's load at pixel edges with where the lines' counts take it."""
    plant = made.plants.get(made.block.place.motors[name])
    if plant is None:
        return
    where = 0
    for part in parts:
        line, counts = part.line, np.cumsum(part.line.counts) * part.line.direction
        if part.grid is not None:
            # Where the play was taken up the load follows the counts.
            pixels = np.arange(max(1, line.shifted_pixels), line.pixels + 1)
            cycles = part.grid.edges(line.pixels)[pixels - 1]
            # An edge between two ticks: the step that ends the pixel is the motor's by then.
            errors = plant.load_at(cycles) - (where + counts[pixels - 1])
            worst = int(np.argmax(np.abs(errors)))
            part.load_error_steps = int(errors[worst])
            if abs(part.load_error_steps) > LOAD_STEPS:
                part.reasons.append(
                    f"the load is {part.load_error_steps:+} steps off at pixel {pixels[worst]}"
                )
        where += int(counts[-1])


def _blame(made: BlockOutcome, motors: Mapping[str, list[_Part]]) -> None:
    """Put what broke the run to the first line that was not made as a whole."""
    if not made.trouble:
        return
    lines = zip(*motors.values(), strict=True)
    cut = (line for line in lines if any(len(part.edges.rising) != part.line.total_steps
                                         for part in line))  # fmt: skip
    broken = next(cut, [parts[-1] for parts in motors.values()])
    for part in broken:
        part.reasons.insert(0, made.trouble)


def _row(made: BlockOutcome, part: _Part, edges: Edges, begin: int) -> LineRow:
    block = made.block
    board, axis = block.place.motors[part.motor]
    told = "; ".join(dict.fromkeys(part.reasons[:_KEPT_REASONS]))
    error = part.found.max_edge_error_ticks if part.found.errors_ticks is not None else None
    return LineRow(
        part.number - block.run_in, part.motor, [*block.place.boards][board], axis,
        FAIL if part.reasons else PASS, told[:MOST_REASON], len(part.edges.rising),
        part.line.total_steps, part.off_steps, part.late_ticks,
        None if error is None else round(error, 6), part.clock_error_ticks, part.apart_ticks,
        part.load_error_steps, None if part.zero is None else part.zero - begin, edges.sum(),
    )  # fmt: skip
