# SPDX-License-Identifier: MIT
"""Do two images make the same edges? Runs the same lines on both and compares, byte for byte.

    same_edges.py OLD.elf NEW.elf --board mega [--lines 400] [--seed 1]

Both images run the worked example, random lines of both decode rules on one axis after another, and
on a board of several axes one run of each decode rule with all axes at once. Each line is armed at
the same cycle on both images, halfway between two pixel edges. STEP edges come from the timers and
must agree to the cycle. DIR, ENABLE and PERMIT are switched by software: their edges must follow
the same number of steps, and the largest shift of a DIR edge is printed. A run whose edges all lie
whole pixels away, because its line was decoded in time for another pixel clock edge, is counted by
itself. The exit status is 0 if no run differs otherwise.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from pixstep import demo, formats, natives, progress
from pixstep.board import boards
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries
from pixstep.profiles import generator
from pixstep.progress import Progress, unseen
from pixstep.simulation.edges import HEADER
from pixstep.simulation.simboard import SimulatedBoard
from pixstep.simulation.simctl import BOOT_S
from pixstep.simulation.simrun import Job
from pixstep_dev.randomlines import campaign

CLOCK_START_MS = 20
UPLOAD_MS = 60  # for the requests before the first block of an axis, with a margin
ENTRY_MS = Fraction(1, 2)  # for an entry at 115200 baud, with its share of the block's head


@dataclass(frozen=True)
class Edge:
    """One row of an edge list: its cycle, and board, axis, signal and level as they stand there."""

    cycle: int
    rest: bytes

    @property
    def axis(self) -> bytes:
        """Board and axis."""
        return self.rest.rpartition(b",")[0].rpartition(b",")[0]

    @property
    def signal(self) -> bytes:
        """The signal's name."""
        return self.rest.split(b",")[2]


@dataclass(frozen=True)
class Made:
    """What an image made of one job, and how the job ended."""

    edges: list[Edge]
    ended: str

    @property
    def rows(self) -> list[bytes]:
        """The rows that are compared."""
        return comparable(self.edges)

    @property
    def steps(self) -> int:
        """Rising STEP edges."""
        return sum(edge.rest.endswith(b",STEP,1") for edge in self.edges)

    @property
    def directions(self) -> list[int]:
        """Cycles of the DIR edges, axis by axis."""
        found = sorted((edge.axis, edge.cycle) for edge in self.edges if edge.signal == b"DIR")
        return [cycle for _, cycle in found]


@dataclass
class Outcome:
    """Counts of a comparison, and the first difference in words."""

    runs: int = 0
    steps: int = 0
    edges: int = 0
    refused: int = 0
    direction_shift_cycles: int = 0
    moved: int = 0
    differing: int = 0
    first: str = ""


def worked_example(board: str) -> Job:
    """The worked example on the board's first axis."""
    speeds, _ = formats.read_prn(natives.source(demo.PROFILE))
    made = generator.generate(speeds, demo.REQUEST, demo.PROFILE)
    line = Line(tuple(made.counts), backlash=demo.REQUEST.backlash, name="worked example")
    return Job(board, {0: line}, demo.PIXEL_HZ)


def random_jobs(board: str, lines: int, seed: int) -> Iterator[Job]:
    """Random lines, smooth and plain in turn, each on the next axis."""
    axes = boards.load(board).axes
    plan = campaign.Plan(board, (lines + 1) // 2, seed=seed)
    both = zip(*(campaign.jobs(plan, decode) for decode in plan.decodes), strict=True)
    for number, job in enumerate(job for pair in both for job in pair):
        if number < lines:
            yield replace(job, lines={number % axes: job.lines[0]})


def all_axes_jobs(board: str, seed: int) -> Iterator[Job]:
    """One run of each decode rule with every axis at once, on a board of several."""
    axes = boards.load(board).axes
    plan = campaign.Plan(board, axes, seed=seed, axes=axes, min_interval_ticks=3_200)
    for decode in plan.decodes if axes > 1 else ():
        yield next(campaign.jobs(plan, decode))


def jobs(board: str, lines: int, seed: int) -> list[Job]:
    """Everything that is run."""
    found = [worked_example(board), *all_axes_jobs(board, seed)]
    return [*found, *random_jobs(board, lines, seed)]


def run_image(job: Job, image: Path) -> Made:
    """Run a job on an image."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        edges = Path(folder, "edges.csv")
        extra = ("--pixel-start-ms", str(CLOCK_START_MS))
        with SimulatedBoard(
            job.board, job.pixel_hz, image=image, edges=edges, extra=extra
        ) as board:
            ended = run(job, board)
            board.settle()
            board.finish()
        return Made(read(edges.read_bytes()), ended)


def run(job: Job, board: SimulatedBoard) -> str:
    """Run a job, armed at a cycle that depends on the job alone; return how it ended."""
    try:
        board.set_up(job.pixel_hz, list(job.lines))
        board.load(job.lines)
        left = arm_cycle(job) - board.simulator.cycle
        if left < 0:
            raise UserError(f"the upload took {-left} cycles longer than there is time for")
        board.simulator.run(left)
        board.arm()
        in_time = board.follow()
        states = board.states().values()
        fault = board.board.fault_name()
    except LineRefusedByBoardError as refusal:
        return f"refused {refusal.name}"
    except BoardError as error:
        return f"trouble: {error}"
    return f"{', '.join(states)}{'' if in_time else ' too late'}{' ' + fault if fault else ''}"


def arm_cycle(job: Job) -> int:
    """The cycle at which the host arms: halfway between pixel edges, when all is uploaded."""
    ticks_a_ms = job.period * job.pixel_hz / 1000
    entries = sum(len(queue_entries(line)) for line in job.lines.values())
    boot = Fraction(BOOT_S) * 1000 * ticks_a_ms
    ready = boot + (UPLOAD_MS * len(job.lines) + ENTRY_MS * entries) * ticks_a_ms
    start = CLOCK_START_MS * ticks_a_ms
    return int(start + ((ready - start) // job.period + Fraction(3, 2)) * job.period)


def read(csv: bytes) -> list[Edge]:
    """The rows of an edge list."""
    head, *rows = csv.splitlines()
    if head != HEADER.encode():
        raise UserError(f"the edge list begins with {head!r}, not with its header")
    return [Edge(int(cycle), rest) for cycle, _, rest in (row.partition(b",") for row in rows)]


def comparable(edges: list[Edge]) -> list[bytes]:
    """What must be the same: STEP edges whole, the others with the steps before them.

    They are sorted by axis, because the order in which the simulator logs the edges of one cycle
    means nothing.
    """
    rows: dict[bytes, list[bytes]] = {}
    steps: dict[bytes, int] = {}
    for edge in edges:
        if edge.signal == b"STEP":
            rows.setdefault(edge.axis, []).append(b"%d,%s" % (edge.cycle, edge.rest))
            steps[edge.axis] = steps.get(edge.axis, 0) + edge.rest.endswith(b",1")
        else:
            row = b"after %d steps,%s" % (steps.get(edge.axis, 0), edge.rest)
            rows.setdefault(edge.axis + edge.signal, []).append(row)
    return [row for key in sorted(rows) for row in rows[key]]


def shift(old: Made, new: Made) -> int:
    """The largest shift of a DIR edge, in cycles."""
    pairs = zip(old.directions, new.directions, strict=False)
    return max((abs(one - other) for one, other in pairs), default=0)


def difference(old: Made, new: Made) -> str:
    """The first difference between two runs in words; empty if there is none."""
    before, now = old.rows, new.rows
    for number, (one, other) in enumerate(zip(before, now, strict=False), 1):
        if one != other:
            return f"edge {number}: {one.decode()} before, {other.decode()} now"
    if len(before) != len(now):
        return f"{len(before)} edges before, {len(now)} now"
    if old.ended != new.ended:
        return f"ended as {old.ended!r} before, as {new.ended!r} now"
    return ""


def moved_pixels(old: Made, new: Made, period: Fraction) -> int:
    """By how many pixels the new run begins later; 0 if its edges differ in anything else too.

    A line starts on the first pixel clock edge by which it is decoded far enough ahead: a faster or
    slower decoder may take another edge. Within the line no edge moves.
    """
    firsts = [
        next((edge.cycle for edge in made.edges if edge.signal == b"STEP"), 0)
        for made in (old, new)
    ]
    cycles = firsts[1] - firsts[0]
    pixels = round(cycles / period)
    if abs(cycles - pixels * period) > 1:
        return 0
    back = [replace(edge, cycle=edge.cycle - cycles) for edge in new.edges]
    return 0 if difference(old, replace(new, edges=back)) else pixels


def describe(job: Job, number: int) -> str:
    """A job in words, enough to run it again."""
    lines = ", ".join(
        f"axis {axis} {line.name}, {line.pixels} pixels" for axis, line in job.lines.items()
    )
    return f"run {number} ({lines}, {float(job.pixel_hz):.2f} Hz)"


def compare(
    wanted: list[Job],
    run_old: Callable[[Job], Made],
    run_new: Callable[[Job], Made],
    show: Progress = unseen,
) -> Outcome:
    """Run every job on both and count."""
    outcome = Outcome()
    for number, job in enumerate(wanted):
        old, new = run_old(job), run_new(job)
        outcome.runs += 1
        outcome.steps += old.steps
        outcome.edges += len(old.edges)
        outcome.refused += old.ended.startswith("refused")
        outcome.direction_shift_cycles = max(outcome.direction_shift_cycles, shift(old, new))
        found = difference(old, new)
        if found and moved_pixels(old, new, job.period):
            outcome.moved += 1
        elif found:
            outcome.differing += 1
            outcome.first = outcome.first or f"{describe(job, number)}: {found}"
        show((number + 1) / len(wanted))
    return outcome


def report(board: str, outcome: Outcome) -> bool:
    """Print the counts; return True if there were edges and none differed."""
    print(
        f"{board}: {outcome.runs} runs, {outcome.steps} steps, {outcome.edges} edges compared, "
        f"{outcome.refused} runs refused before, {outcome.moved} begin at another pixel edge, "
        f"{outcome.differing} runs differ"
    )
    print(f"DIR edges are up to {outcome.direction_shift_cycles} cycles from their old places")
    if outcome.first:
        print(f"first difference: {outcome.first}")
    return outcome.steps > 0 and not outcome.differing


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Compare the edges that two images make.")
    parser.add_argument("old", type=Path, help="image before (ELF)")
    parser.add_argument("new", type=Path, help="image now (ELF)")
    parser.add_argument("--board", required=True, choices=boards.BOARD_NAMES)
    parser.add_argument("--lines", type=int, default=400, help="random lines (default: 400)")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def main() -> None:
    """Run all jobs on both images."""
    options = arguments()
    try:
        wanted = jobs(options.board, options.lines, options.seed)
        with progress.shown("comparing") as show:
            outcome = compare(
                wanted,
                lambda job: run_image(job, options.old),
                lambda job: run_image(job, options.new),
                show,
            )
    except UserError as error:
        sys.exit(f"same_edges: {error}")
    sys.exit(0 if report(options.board, outcome) else 1)


if __name__ == "__main__":
    main()
