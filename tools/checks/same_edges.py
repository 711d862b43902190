# SPDX-License-Identifier: MIT
"""Do two images make the same edges? Runs the same trials on both and compares, byte for byte.

    same_edges.py OLD.elf NEW.elf --board mega [--lines 400] [--trials 40] [--seed 1] [--quick]

Both images run the worked example, random lines of both decode rules on one axis after another, on
a board of several axes one run of each decode rule with all axes at once, and so many trials of
each other kind (edge_trials.py): clocks of 500 to 5,000 Hz, locks to poor clocks, dividers, streams
whose records are read, stops, seeks. --quick: few of all. All that comes from outside comes in the
same cycle on both images; lines are armed halfway between two pixel edges.

STEP edges come from the timers and must agree to the cycle. DIR, ENABLE and PERMIT are switched by
software: their edges must follow the same number of steps, and the largest shift of a DIR edge is
printed. Counted by themselves, as what an image that is only faster or slower may do:

* a run whose edges all lie whole clock periods away, because its line was ready in time for another
  edge: it is armed at other phases of the clock first, until both images begin on the same one (a
  locked run may then be LOCK_TICKS off, as below); and a seek, which waits for no edge, wherever it
  has begun;
* a run in whose rests STEP falls elsewhere: the pulse before a rest ends when the timer's period
  does;
* a locked run whose STEP edges are all there and within LOCK_TICKS of the old ones, and the clock's
  jitter (rms) more: a line is planned by what the clock has done when it is decoded;
* a stopped or seeking run that is the same up to the stop or the switch, and ends as the other
  does: its last edge within ANSWER_MS, and by its own account where its edges have brought it;
* a seek of more or fewer pixels, if the old image makes the same one when it is armed at another
  phase of the clock: whether the next pixel is decoded before the switch has settled is chance;
* a run of which one image or both ended in a fault that an overloaded line has (LATE_FAULTS), the
  same up to there: one image came further than the other. Counted by which of the two that is.

The exit status is 0 if no run differs otherwise.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

from edge_trials import Trial, trials

from pixstep import formats, natives, progress
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.link import World
from pixstep.board.port import BAUD
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries, seek_entries
from pixstep.operations import run as demo
from pixstep.profiles import generator
from pixstep.progress import Progress, unseen
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import HEADER
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep.simulation.simulator import BOOT_S
from pixstep_dev.randomlines import campaign

CLOCK_START_MS = 20
UPLOAD_MS = 70  # for the requests before the first block of an axis, with a margin
ENTRY_MS = Fraction(1, 2)  # for an entry at 115200 baud, with its share of the block's head
MEASURED_MS, MEASURED_EDGES = 500, 800  # until a lock can begin, however poor the clock
LOCK_TICKS = 2
ANSWER_MS = 2
RACE_PHASES = tuple(Fraction(number, 32) for number in range(1, 32, 2))
PHASES = (  # of the clock, in which lines are armed
    *(Fraction(1, 2), Fraction(1, 4), Fraction(3, 4)),
    *(Fraction(1, 16), Fraction(15, 16)),
)
LATE_FAULTS = ("decoder_late", "underrun", "clock_edge_lost")
MISCOUNTED = "steps miscounted"
MOVED = "begin elsewhere"
FALLS = "have pulses that end elsewhere"
NEAR = "are locked and some ticks apart"
ANSWERED = "are the same until a stop or a switch"
RACED = "seek as the old image does at another phase"
FURTHER = "come further before a fault of an overloaded line"
LESS_FAR = "come less far before a fault of an overloaded line"
STOPPED_S = 0.1  # an axis is at rest by then
RECORDS_S = 0.1  # between two looks at them


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
    event: int | None = None  # cycle in which a stop or a switch came

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
    near_ticks: int = 0
    differing: int = 0
    first: str = ""
    excused: dict[str, int] = field(default_factory=dict)  # runs that differ as they may
    kinds: dict[str, int] = field(default_factory=dict)  # runs of each
    ends: dict[str, int] = field(default_factory=dict)  # how those of the old image ended


def worked_example(board: str) -> LineExperiment:
    """The worked example on the board's first axis."""
    speeds, _ = formats.read_prn(natives.example(demo.PROFILE))
    made = generator.generate(speeds, demo.REQUEST, demo.PROFILE)
    line = Line(tuple(made.counts), backlash=demo.REQUEST.backlash, name="worked example")
    return LineExperiment(board, {0: line}, demo.PIXEL_HZ)


def random_jobs(board: str, lines: int, seed: int) -> Iterator[LineExperiment]:
    """Random lines, smooth and plain in turn, each on the next axis."""
    axes = boards.load(board).axes
    plan = campaign.RandomLinesPlan(board, (lines + 1) // 2, seed=seed)
    both = zip(*(campaign.jobs(plan, decode) for decode in plan.decodes), strict=True)
    for number, job in enumerate(job for pair in both for job in pair):
        if number < lines:
            yield replace(job, lines={number % axes: job.lines[0]})


def all_axes_jobs(board: str, seed: int) -> Iterator[LineExperiment]:
    """One run of each decode rule with every axis at once, on a board of several."""
    axes = boards.load(board).axes
    plan = campaign.RandomLinesPlan(board, axes, seed=seed, axes=axes, min_interval_ticks=3_200)
    for decode in plan.decodes if axes > 1 else ():
        yield next(campaign.jobs(plan, decode))


def wanted_trials(board: str, lines: int, others: int, seed: int) -> list[Trial]:
    """Everything that is run: so many random lines, so many trials of each other kind."""
    found = [worked_example(board), *all_axes_jobs(board, seed), *random_jobs(board, lines, seed)]
    return [*map(Trial, found), *trials(board, others, seed)]


def run_image(trial: Trial, image: Path) -> Made:
    """Run a trial on an image."""
    job = trial.job
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        edges = Path(folder, "edges.csv")
        with SimulatedBoard(
            job.board,
            job.pixel_hz,
            image=image,
            edges=edges,
            pixel_ppm=job.pixel_ppm,
            flaws=job.flaws,
            seed=job.seed,
            plants={(0, axis): knobs for axis, knobs in job.plants.items()},
            extra=("--pixel-start-ms", str(CLOCK_START_MS)),
        ) as board:
            ended, event = run(trial, board)
            board.settle()
            board.finish()
        return Made(read(edges.read_bytes()), ended, event)


def run(trial: Trial, board: SimulatedBoard) -> tuple[str, int | None]:
    """Run a trial, armed at a cycle that depends on the trial alone.

    Return how it ended, and when a stop or a switch came.
    """
    event = None
    try:
        prepare(trial, board)
        left = arm_cycle(trial) - board.simulator.cycle
        if left < 0:
            raise UserError(f"the upload took {-left} cycles longer than there is time for")
        board.simulator.run(left)
        board.arm()
        if trial.stop_s:
            event = stop(trial, board)
            board.simulator.wait_s(STOPPED_S)
            in_time = True
        else:
            in_time = board.make((lambda: Records(board)) if trial.records else None, armed=True)
        board.settle()
        if trial.seek:
            event = switched(board)
        ended = [regs.axis_state(found["axis_state"]) for found in registers(board).values()]
        ended += [] if in_time else ["too late"]
        ended += [] if counted(board) else [MISCOUNTED]
        fault = board.board.fault_name()
    except LineRefusedByBoardError as refusal:
        return f"refused {refusal.name}", event
    except BoardError as error:
        return f"trouble: {error}", event
    return f"{', '.join(ended)}{' ' + fault if fault else ''}", event


def prepare(trial: Trial, board: SimulatedBoard) -> None:
    """Set the board up and load what the trial runs."""
    job = trial.job
    settings = job.settings() | ({"input_filter_us": 200} if trial.seek else {})
    board.set_up(job.pixel_hz, list(job.lines), **settings)
    if job.baud != BAUD:
        board.talk_at(job.baud)
    board.load(job.lines)
    if trial.seek:
        (axis,) = job.lines
        board.board.command("disarm", [axis])
        board.lines.uploads = [LineUpload(board.board, axis, seek_entries(trial.seek))]
        board.lines.uploads[0].push()


def stop(trial: Trial, board: SimulatedBoard) -> int:
    """Stop the lines so long behind arming; return the cycle."""
    simulator = board.simulator
    simulator.run(arm_cycle(trial) + simulator.cycles(trial.stop_s) - simulator.cycle)
    begun = simulator.cycle
    if trial.by_contact:
        pins = boards.load(board.name).pins
        (pin,) = (one for one in pins if one.signal == "ESTOP")
        simulator.pin(0, pin.port, pin.bit, 0)
    else:
        board.board.command("stop", board.axes)
    return begun


def switched(board: SimulatedBoard) -> int:
    """Return the first cycle of the home switch's last change."""
    return int(board.simulator.command(f"switches 0 {board.axes[0]}").split()[-1])


def registers(board: SimulatedBoard) -> dict[int, dict[str, int]]:
    """What the board says of its axes."""
    found = board.board.axes(board.axes[-1] + 1)
    return {axis: found[axis] for axis in board.axes}


def counted(board: SimulatedBoard) -> bool:
    """True if every axis is, by its own account, where its edges have brought it."""
    return all(
        found["position_steps"] == board.simulator.steps(0, axis)
        for axis, found in registers(board).items()
    )


class Records:
    """Reads the records of every axis while lines are streamed."""

    def __init__(self, board: SimulatedBoard) -> None:
        self.board, self.due_s = board, 0.0

    def look_if_due(self, world: World, uploads: list[LineUpload]) -> None:
        """Read the records if it is time for that."""
        if world.now_s() >= self.due_s:
            self.due_s = world.now_s() + RECORDS_S
            self.look(uploads)

    def look(self, uploads: list[LineUpload], *, ended: bool = False) -> None:
        """Read the records."""
        del uploads, ended
        for axis in self.board.axes:
            self.board.board.records(axis)


def arm_cycle(trial: Trial) -> int:
    """The cycle at which the host arms: between two clock edges, when all is uploaded."""
    job = trial.job
    period = job.clock_period
    ticks_a_ms = period * job.pixel_hz / 1000
    entries = sum(len(queue_entries(line)) for line in job.lines.values())
    boot = Fraction(BOOT_S) * 1000 * ticks_a_ms
    ready = boot + (UPLOAD_MS * len(job.lines) + ENTRY_MS * entries) * ticks_a_ms
    ready += MEASURED_MS * ticks_a_ms + MEASURED_EDGES * period if job.locked else 0
    start = CLOCK_START_MS * ticks_a_ms
    return int(start + ((ready - start) // period + 1 + trial.phase) * period)


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
    cycles = first_step(new) - first_step(old)
    pixels = round(cycles / period)
    if abs(cycles - pixels * period) > 1:
        return 0
    back = aligned(old, new)
    return 0 if difference(old, back) and not falls_elsewhere(old, back) else pixels


def step_rows(made: Made, levels: tuple[bytes, ...] = (b"0", b"1")) -> list[tuple[bytes, int]]:
    """Return what each STEP edge to these levels is and its cycle, axis by axis."""
    return sorted(
        (edge.rest, edge.cycle)
        for edge in made.edges
        if edge.signal == b"STEP" and edge.rest[-1:] in levels
    )


def same_but_for_cycles(old: Made, new: Made) -> bool:
    """True if two runs have the same edges in the same order, and end alike."""
    kinds = [[rest for rest, _ in step_rows(made)] for made in (old, new)]
    software = [[row for row in made.rows if row.startswith(b"after")] for made in (old, new)]
    return kinds[0] == kinds[1] and software[0] == software[1] and old.ended == new.ended


def falls_elsewhere(old: Made, new: Made) -> bool:
    """True if nothing but the ends of pulses differs."""
    rising = (b"1",)
    return same_but_for_cycles(old, new) and step_rows(old, rising) == step_rows(new, rising)


def near_ticks(old: Made, new: Made) -> int | None:
    """How far the rising STEP edges of two runs are apart at most; None if they differ in more."""
    if not same_but_for_cycles(old, new):
        return None
    pairs = zip(step_rows(old, (b"1",)), step_rows(new, (b"1",)), strict=True)
    return max((abs(one - other) for (_, one), (_, other) in pairs), default=0)


def answers(old: Made, new: Made, tick_hz: int) -> bool:
    """True if two runs are the same up to what came from outside, and end alike."""
    if old.event is None or new.event is None or old.ended != new.ended:
        return False
    if MISCOUNTED in old.ended:
        return False
    event = min(old.event, new.event)
    firsts = [
        replace(made, edges=[edge for edge in made.edges if edge.cycle < event])
        for made in (old, new)
    ]
    lasts = [max((edge.cycle for edge in made.edges), default=0) for made in (old, new)]
    apart_ms = abs(lasts[0] - lasts[1]) * 1000 / tick_hz
    return not difference(*firsts) and apart_ms <= ANSWER_MS


def lock_ticks(job: LineExperiment) -> float:
    """How far apart the steps of two runs of a line may be: not at all, unless it is locked."""
    return LOCK_TICKS + job.flaws.jitter_us * job.tick_hz / 1e6 if job.locked else 0


def is_near(job: LineExperiment, old: Made, new: Made) -> bool:
    """True if two runs of a locked line differ by the ticks of the lock alone."""
    near = near_ticks(old, new) if job.locked else None
    return near is not None and near <= lock_ticks(job)


def rises(made: Made) -> dict[bytes, list[int]]:
    """Return the cycles of the rising STEP edges of each axis."""
    found: dict[bytes, list[int]] = {}
    for edge in made.edges:
        if edge.rest.endswith(b",STEP,1"):
            found.setdefault(edge.axis, []).append(edge.cycle)
    return found


def overloaded(made: Made) -> bool:
    """True if a run ended in a fault that an overloaded line has."""
    return any(f"fault {name}" in made.ended for name in LATE_FAULTS)


def further(job: LineExperiment, old: Made, new: Made) -> str:
    """Return which of two runs of an overloaded line came further; empty if they differ before."""
    period, cycles = job.clock_period, first_step(new) - first_step(old)
    beside = abs(cycles - round(cycles / period) * period)
    if beside > (period / 8 if job.locked else 1) or MISCOUNTED in old.ended + new.ended:
        return ""
    ends = [made.ended for made in (old, new) if not overloaded(made)]
    if len(ends) == 2 or any("fault" in end for end in ends):
        return ""
    one, other = rises(old), rises(aligned(old, new))
    for axis in one.keys() & other.keys():
        pairs = zip(one[axis], other[axis], strict=False)
        if any(abs(before - now) > lock_ticks(job) for before, now in pairs):
            return ""
    return LESS_FAR if new.steps < old.steps or not overloaded(old) else FURTHER


def first_step(made: Made) -> int:
    """The cycle of the first STEP edge, 0 if there is none."""
    return next((edge.cycle for edge in made.edges if edge.signal == b"STEP"), 0)


def aligned(old: Made, new: Made) -> Made:
    """Return the new run as if it had begun where the old one did."""
    cycles = first_step(new) - first_step(old)
    back = [replace(edge, cycle=edge.cycle - cycles) for edge in new.edges]
    return Made(back, new.ended, None if new.event is None else new.event - cycles)


def describe(trial: Trial, number: int) -> str:
    """A trial in words, enough to run it again."""
    job = trial.job
    lines = ", ".join(
        f"axis {axis} {line.name}, {line.pixels} pixels" for axis, line in job.lines.items()
    )
    parts = [f"{float(job.pixel_hz):.2f} Hz", *job.flaws.texts()]
    parts += [f"{job.pixel_ppm:+g} ppm"] if job.pixel_ppm else []
    parts += [f"divider {job.divider}"] if job.divider > 1 else []
    return f"run {number} ({trial.kind}: {lines}, {', '.join(parts)})"


def begins_elsewhere(old: Made, new: Made, period: Fraction) -> bool:
    """True if two runs begin about whole periods of the clock apart."""
    cycles = first_step(new) - first_step(old)
    pixels = round(cycles / period)
    return pixels != 0 and abs(cycles - pixels * period) < period / 8


def run_both(
    trial: Trial, run_old: Callable[[Trial], Made], run_new: Callable[[Trial], Made]
) -> tuple[Made, Made]:
    """Run a trial on both images, so armed that both begin on the same edge of the clock."""
    for phase in PHASES:
        armed = replace(trial, phase=phase)
        old, new = run_old(armed), run_new(armed)
        if trial.seek or not begins_elsewhere(old, new, trial.job.clock_period):
            break
    return old, new


def compare(
    wanted: list[Trial],
    run_old: Callable[[Trial], Made],
    run_new: Callable[[Trial], Made],
    show: Progress = unseen,
) -> Outcome:
    """Run every trial on both and count."""
    outcome = Outcome()
    for number, trial in enumerate(wanted):
        old, new = run_both(trial, run_old, run_new)
        outcome.runs += 1
        outcome.steps += old.steps
        outcome.edges += len(old.edges)
        outcome.refused += old.ended.startswith("refused")
        outcome.kinds[trial.kind] = outcome.kinds.get(trial.kind, 0) + 1
        outcome.ends[old.ended] = outcome.ends.get(old.ended, 0) + 1
        outcome.direction_shift_cycles = max(outcome.direction_shift_cycles, shift(old, new))
        judge(trial, number, (old, new), outcome, run_old)
        show((number + 1) / len(wanted))
    return outcome


def raced(trial: Trial, new: Made, run_old: Callable[[Trial], Made]) -> str:
    """Return RACED if the old image makes the same seek at another phase; empty if it does not."""
    for phase in RACE_PHASES if trial.seek else ():
        old = run_old(replace(trial, phase=phase))
        if not difference(old, aligned(old, new)):
            return RACED
    return ""


def judge(
    trial: Trial,
    number: int,
    made: tuple[Made, Made],
    outcome: Outcome,
    run_old: Callable[[Trial], Made],
) -> None:
    """Count a run that differs."""
    old, new = made
    found = difference(old, new)
    why = (excuse(trial, old, new) or raced(trial, new, run_old)) if found else ""
    if why:
        outcome.excused[why] = outcome.excused.get(why, 0) + 1
    elif found:
        outcome.differing += 1
        outcome.first = outcome.first or f"{describe(trial, number)}: {found}"
    if why == NEAR:
        outcome.near_ticks = max(outcome.near_ticks, near_ticks(old, new) or 0)


def excuse(trial: Trial, old: Made, new: Made) -> str:
    """Return how a run differs as that of a faster or slower image may; empty if otherwise."""
    if trial.seek:
        new = aligned(old, new)
        if not difference(old, new):
            return MOVED
    if falls_elsewhere(old, new):
        return FALLS
    if is_near(trial.job, old, new):
        return NEAR
    if answers(old, new, trial.job.tick_hz):
        return ANSWERED
    period = trial.job.clock_period
    if moved_pixels(old, new, period) or (
        begins_elsewhere(old, new, period) and is_near(trial.job, old, aligned(old, new))
    ):
        return MOVED
    return further(trial.job, old, new)


def report(board: str, outcome: Outcome) -> bool:
    """Print the counts; return True if there were edges and none differed."""
    print(
        f"{board}: {outcome.runs} runs, {outcome.steps} steps, {outcome.edges} edges compared, "
        f"{outcome.refused} runs refused before, {outcome.differing} runs differ"
    )
    for why in (MOVED, FALLS, NEAR, ANSWERED, RACED, FURTHER, LESS_FAR):
        print(f"{outcome.excused.get(why, 0)} {why}")
    if outcome.near_ticks:
        print(f"locked steps are up to {outcome.near_ticks} ticks from their old places")
    print(f"DIR edges are up to {outcome.direction_shift_cycles} cycles from their old places")
    print(f"runs: {', '.join(f'{count} {kind}' for kind, count in outcome.kinds.items())}")
    print(f"they ended: {'; '.join(f'{count} {end}' for end, count in outcome.ends.items())}")
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
    parser.add_argument("--trials", type=int, default=40, help="of each other kind (default: 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="20 lines, 3 trials of each kind")
    return parser.parse_args()


def main() -> None:
    """Run all jobs on both images."""
    options = arguments()
    try:
        lines, others = (20, 3) if options.quick else (options.lines, options.trials)
        wanted = wanted_trials(options.board, lines, others, options.seed)
        with progress.shown("comparing") as show:
            outcome = compare(
                wanted,
                lambda trial: run_image(trial, options.old),
                lambda trial: run_image(trial, options.new),
                show,
            )
    except UserError as error:
        sys.exit(f"same_edges: {error}")
    sys.exit(0 if report(options.board, outcome) else 1)


if __name__ == "__main__":
    main()
