# SPDX-License-Identifier: MIT
"""Lines uploaded over a bad line: what the board then holds must be exactly what was sent.

The host's side is the project's own (client, block numbers, retries), the board's side is the
firmware: natively for many blocks, where the queues are looked into, or the image in the simulator,
where lines are played and their STEP edges counted.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeVar

from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.modbus import SimClient
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from pixstep_trials.noise import NoiseModel, NoisyLine

NATIVE = "native"
_ATTEMPTS = 200  # of one step of an upload, before the line counts as dead
_DOUBTS = 3
_STEPS_PX = 40  # counts are smaller, so that lines are short on the simulated boards
_NATIVE_AXES = 4
_LOOK_S = 0.05
PIXEL_HZ = Fraction(200)


@dataclass(frozen=True)
class UploadsPlan:
    """So many accepted blocks; `board` is native or the name of one."""

    board: str
    blocks: int
    seed: int = 1
    model: NoiseModel = field(default_factory=NoiseModel)
    go_on: bool = False  # after a line that was not exact; else the first of them is the end


@dataclass
class UploadsOutcome:
    """What a campaign did. `complaints` is empty if every queue was exact.

    Lines that were not are `reported`, by the board or the client, or `silent`.
    """

    plan: UploadsPlan
    lines: int = 0
    blocks: int = 0
    entries: int = 0
    requests: int = 0
    given_up: int = 0  # steps for which every retry failed, and which were begun again
    steps: int = 0
    reported: int = 0
    silent: int = 0
    undetected: int = 0  # spoilt frames whose checksum was right all the same
    noise: Counter[str] = field(default_factory=Counter[str])
    complaints: list[str] = field(default_factory=list)


def random_entries(rng: random.Random, most: int) -> list[tuple[int, int]]:
    """Return the queue entries, at most `most`, of a plain line with random counts and lengths."""
    counts: list[int] = []
    for _ in range(rng.choice((1, rng.randint(1, 20), rng.randint(1, most)))):
        counts += [rng.randint(1, _STEPS_PX)] * rng.choice((1, 1, 2, rng.randint(1, 9)))
    entries = queue_entries(Line(tuple(counts), PLAIN))
    return entries if len(entries) <= most else random_entries(rng, most)


def run(plan: UploadsPlan, progress: Progress = unseen) -> UploadsOutcome:
    """Run a plan; raises UserError if the board cannot be run."""
    rng = random.Random(f"{plan.seed} {plan.board}")
    outcome = UploadsOutcome(plan)
    with _board(plan) as link:
        side = (_Native if plan.board == NATIVE else _Image)(link, plan, rng, outcome)
        while outcome.blocks < plan.blocks and (plan.go_on or not outcome.complaints):
            side.line()
            progress(min(1.0, outcome.blocks / plan.blocks))
        outcome.requests = side.client.requests
        outcome.noise, outcome.undetected = side.bad_line.noise, side.bad_line.undetected
    return outcome


@contextmanager
def _board(plan: UploadsPlan) -> Iterator[SimLink]:
    """Start the board."""
    if plan.board == NATIVE:
        options = SimOptions([], PIXEL_HZ)
        program = [natives.program("pixstep-native-board")]
    else:
        options = SimOptions([(plan.board, natives.image(plan.board))], PIXEL_HZ)
        program = None
    with SimLink(options, program) as link:
        yield link
        link.simulator.quit()


_Result = TypeVar("_Result")


class _Side:
    """Uploads over the bad line; what comes after is the board's kind's."""

    most = 150  # entries of a line

    def __init__(
        self, link: SimLink, plan: UploadsPlan, rng: random.Random, outcome: UploadsOutcome
    ):
        self.simulator, self.rng, self.outcome = link.simulator, rng, outcome
        self.quiet = link.board()
        self.bad_line = NoisyLine(link.simulator, rng, plan.model)
        self.client = SimClient(self.bad_line)
        self.noisy = Device(self.client)
        self.axes = _NATIVE_AXES if plan.board == NATIVE else boards.load(plan.board).axes

    def line(self) -> None:
        """Upload a random line and look at what became of it."""
        axis = self.rng.randrange(self.axes)
        entries = random_entries(self.rng, self.most)
        where = f"line {self.outcome.lines}, {len(entries)} entries"
        try:
            if not self.exact(axis, entries):
                self.outcome.silent += 1
                self.outcome.complaints.append(f"{where}: axis {axis} does not hold them")
                self.recover(axis)
        except BoardError as error:
            self.outcome.reported += 1
            self.outcome.complaints.append(f"{where}: {error}")
            self.recover(axis)
        self.outcome.lines += 1
        self.outcome.entries += len(entries)

    def exact(self, axis: int, entries: list[tuple[int, int]]) -> bool:
        """Upload; return True if the board has exactly these entries."""
        raise NotImplementedError

    def recover(self, axis: int) -> None:
        """Have what is queued forgotten, over a good line."""
        self.quiet.command("discard", [axis])

    def persistently(self, step: Callable[[], _Result]) -> _Result:
        """Do a step until its requests come through.

        An exception may be the answer to a request that was spoilt and passed the checksum: a few
        are asked about again, then it is the caller's.
        """
        doubts = 0
        for _ in range(_ATTEMPTS):
            try:
                return step()
            except LineRefusedByBoardError:
                raise
            except BoardError as error:
                doubts += error.code is not None
                if doubts > _DOUBTS:
                    raise
                self.outcome.given_up += 1
        raise BoardError(f"not through in {_ATTEMPTS} attempts")

    def begin(self, axis: int, entries: list[tuple[int, int]]) -> LineUpload:
        """Return the upload of a line."""
        return self.persistently(lambda: LineUpload(self.noisy, axis, entries))

    def push(self, upload: LineUpload) -> None:
        """Push once, whatever it takes, and count the blocks."""
        before = upload.block
        self.persistently(upload.push)
        self.outcome.blocks += (upload.block - before) & 0xFFFF


class _Native(_Side):
    """The firmware natively: queues are emptied and compared entry by entry."""

    def exact(self, axis: int, entries: list[tuple[int, int]]) -> bool:
        """Upload, taking out what has arrived again and again."""
        upload = self.begin(axis, entries)
        held: list[tuple[int, int]] = []
        while not upload.done:
            self.push(upload)
            held += self._pop(axis)
        return held == entries

    def _pop(self, axis: int) -> list[tuple[int, int]]:
        pairs = (word.split(",") for word in self.simulator.command(f"pop {axis}").split()[1:])
        return [(int(count), int(repeat)) for count, repeat in pairs]


class _Image(_Side):
    """The image in the simulator: the line is played, its edges and pixels are counted.

    Its lines fit the queue: on a line as bad as this one a longer one would run dry.
    """

    def __init__(
        self, link: SimLink, plan: UploadsPlan, rng: random.Random, outcome: UploadsOutcome
    ):
        super().__init__(link, plan, rng, outcome)
        self.quiet.set_pixel_hz(PIXEL_HZ)
        self.quiet.command("enable", list(range(self.axes)))
        self.most = self.quiet.axis(0)["queue_free"]

    def exact(self, axis: int, entries: list[tuple[int, int]]) -> bool:
        """Upload over the bad line, arm, let it run, count the steps and pixels."""
        before = self.simulator.steps(0, axis)
        upload = self.begin(axis, entries)
        while not upload.done:
            self.push(upload)
        self.quiet.command("arm", [axis])
        name = "armed"
        while name in ("armed", "running"):
            self.simulator.wait_s(_LOOK_S)
            state = self.quiet.axis(axis)
            name = regs.AXIS_STATES[state["axis_state"]]
        made = self.simulator.steps(0, axis) - before
        self.outcome.steps += made
        wanted = sum(count * repeat for count, repeat in entries[2:-1])
        pixels = sum(repeat for _, repeat in entries[2:-1])
        return (name, made, state["pixel"]) == ("done", wanted, pixels)
