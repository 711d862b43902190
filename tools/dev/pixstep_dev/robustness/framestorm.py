# SPDX-License-Identifier: MIT
"""Mutated frames against an image while lines run: not one STEP edge may differ.

The same lines are run twice, armed at the same cycle: once under fire, once undisturbed. The two
edge lists must be the same to the byte, and the board must answer, at rest and without a fault,
when it is over.
"""

import itertools
import random
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.robustness import strikes
from pixstep_trials import wire

PIXEL_HZ = Fraction(30)
PART_PX = 62
_PARTS = 4
_FRAME_S = Fraction(12, 1000)  # more than a strike takes, with what is asked in between
_HOUSEKEEPING = 20  # strikes between two looks at the board
_LAST_S = 0.5  # so long before the end of the lines the last frame is sent
_LOOK_S = 0.1  # how long the undisturbed run looks away
_REFILL = 8  # free entries worth a block
_SAME_CYCLE = 64  # lines that may stand in another order at once


@dataclass(frozen=True)
class FramestormPlan:
    """So many mutated frames against one board."""

    board: str
    frames: int
    seed: int = 1


@dataclass
class FramestormOutcome:
    """What a storm did. `complaints` is empty if every promise was kept."""

    plan: FramestormPlan
    frames: int = 0
    kinds: Counter[str] = field(default_factory=Counter[str])
    answers: int = 0
    exceptions: int = 0
    edges: int = 0
    turns: int = 0
    turn_shift_cycles: int = 0
    seconds: float = 0.0
    complaints: list[str] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)

    def complain(self, text: str) -> None:
        """Note a broken promise; a few say enough."""
        if len(self.complaints) < 20:
            self.complaints.append(text)


def hump(step: int, pixels: int, hold: int) -> list[int]:
    """Return counts of a smooth rise to `step * pixels` steps/pixel, `hold` pixels and the fall."""
    rise = [step * (2 * index + 1) // 2 for index in range(pixels)]
    return [*rise, *[step * pixels] * hold, *reversed(rise)]


def line(axis: int, parts: int) -> Line:
    """Return an axis' line, smooth or plain in turn: slow humps, every fourth with a fast one.

    The axes take turns at being fast, so that together they ask for no more than the board makes.
    """
    fast = [*hump(80, 12, 4), 0, 0, *hump(8, 4, 22), 0, 0]
    slow = [*hump(8, 4, PART_PX - 10), 0, 0]
    smooth = axis % 2 == 0
    counts: list[int] = []
    for part in range(parts):
        sign = 1 if smooth or part % 3 else -1
        counts += [sign * count for count in (fast if part % _PARTS == axis else slow)]
    return Line(tuple(counts), SMOOTH if smooth else PLAIN, negative=axis == 2)


def run(plan: FramestormPlan, progress: Progress = unseen) -> FramestormOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = FramestormOutcome(plan)
    pixels = plan.frames * _FRAME_S * PIXEL_HZ
    lines = {axis: line(axis, int(pixels) // PART_PX + 1) for axis in range(_axes(plan.board))}
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        folder = Path(name)
        with _Run(plan, lines, folder / "quiet.csv") as quiet:
            quiet.follow(lambda share: progress(share / 5))
        with _Run(plan, lines, folder / "storm.csv") as storm:
            storm.strike(outcome, lambda share: progress(0.2 + 0.8 * share))
        _compare(folder / "quiet.csv", folder / "storm.csv", outcome)
    if outcome.frames < plan.frames:
        outcome.complain(f"only {outcome.frames} frames while the lines ran")
    return outcome


class _Run:
    """One board with its lines running; a context manager that ends with whole edge lists."""

    def __init__(self, plan: FramestormPlan, lines: dict[int, Line], edges: Path) -> None:
        self._plan, self._lines, self._edges = plan, lines, edges

    def __enter__(self) -> "_Run":
        self._run = SimulatedBoard(self._plan.board, PIXEL_HZ, edges=self._edges)
        self._simulator, self._board = self._run.simulator, self._run.board
        try:
            self._start()
        except BaseException:
            self._simulator.kill()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self._run.finish()
        self._simulator.kill()

    def _start(self) -> None:
        """Bring the board up to its first clock edge with every axis armed."""
        # A storm may leave no request whole.
        self._run.set_up(PIXEL_HZ, list(self._lines), bus_timeout_ms=0)
        self._run.load(self._lines)
        self._run.arm()
        while self._states() != {"running"}:
            self._simulator.wait_s(0.01)

    def _states(self) -> set[str]:
        return {regs.AXIS_STATES[found["axis_state"]] for found in self._look()}

    def _look(self) -> list[dict[str, int]]:
        self._seen = self._board.axes(len(self._lines))
        return self._seen

    def _keep_up(self) -> bool:
        """Stream, look at the board; return False when no axis runs any more."""
        states = self._states()
        pushed = 0
        for upload, seen in zip(self._run.uploads.values(), self._seen, strict=True):
            if not upload.done and seen["queue_free"] >= _REFILL:
                pushed += upload.push()
        if pushed:
            self._look()  # another block is next
        return "running" in states

    def _last(self) -> bool:
        """Return whether the lines go on for longer than the frames between two looks.

        Behind their end the board takes settings that it refuses while lines run, its bus address
        among them.
        """
        left_px = min(
            line.pixels - seen["pixel"]
            for line, seen in zip(self._lines.values(), self._seen, strict=True)
        )
        return left_px > _LAST_S * PIXEL_HZ

    def _share(self) -> float:
        return self._seen[0]["pixel"] / self._lines[0].pixels

    def follow(self, progress: Progress) -> None:
        """Let the lines run undisturbed to their end."""
        while self._keep_up():
            progress(self._share())
            self._simulator.wait_s(_LOOK_S)
        self._simulator.wait_s(0.1)

    def strike(self, outcome: FramestormOutcome, progress: Progress) -> None:
        """Send mutated frames until the lines are nearly over, then look at the board."""
        plan = self._plan
        safety = wire.Safety(len(self._lines), lambda axis: self._seen[axis]["next_block"])
        rng = random.Random(f"{plan.seed} {plan.board}")
        generator = strikes.Generator(
            rng, self._board.unit, safety, strikes.Pauses.at(self._simulator.tick_hz)
        )
        running = True
        try:
            while running:
                for strike in itertools.islice(generator, _HOUSEKEEPING):
                    self._send(strike, outcome, generator)
                self._simulator.run(generator.pauses.certain)
                generator.silence()
                running = self._keep_up() and self._last()
                progress(self._share())
            self.follow(progress)
            self._judge(outcome)
        except BoardError as error:
            outcome.complain(f"after {outcome.frames} frames: {error}")
        outcome.seconds = self._simulator.cycle / self._simulator.tick_hz

    def _send(
        self, strike: strikes.Strike, outcome: FramestormOutcome, generator: strikes.Generator
    ) -> None:
        """Send the pieces of a strike and look at what comes back."""
        outcome.frames += 1
        outcome.kinds[strike.kind] += 1
        reply = b""
        for piece, pause in strike.pieces:
            if piece:
                reply = self._simulator.transmit(piece, pause)
            else:
                self._simulator.run(pause)
            if reply and piece:
                outcome.answers += 1
                complaint = reply_fault(strike, reply, self._board.unit)
                if complaint:
                    outcome.complain(f"frame {outcome.frames}, {strike.kind}: {complaint}")
                outcome.exceptions += reply[1] >= 0x80
        if strike.request and not reply:
            outcome.complain(
                f"frame {outcome.frames}, {strike.kind}: {strike.request.hex()} was not answered"
            )
        if reply:
            generator.silence()

    def _judge(self, outcome: FramestormOutcome) -> None:
        """The board is at rest, without a fault, and its positions are the simulator's."""
        state = self._board.inputs()
        outcome.counters = {
            name: state[name] for name in ("frames_ok", "crc_errors", "exceptions", "rx_overruns")
        }
        if state["fault_code"]:
            outcome.complain(self._board.fault_text())
        for axis, found in enumerate(self._look()):
            done = regs.AXIS_STATES[found["axis_state"]]
            if done != "done" or found["lines_done"] != 1:
                outcome.complain(f"axis {axis}: {done} after {found['lines_done']} lines")
            made = self._simulator.steps(0, axis)
            wanted = sum(self._lines[axis].counts) * (-1 if self._lines[axis].negative else 1)
            if not made == found["position_steps"] == wanted:
                outcome.complain(
                    f"axis {axis}: {made} steps, position {found['position_steps']}, not {wanted}"
                )


def reply_fault(strike: strikes.Strike, reply: bytes, unit: int) -> str:
    """Return what is wrong with a reply to a strike, empty if nothing."""
    if strike.silent:
        return f"answered by {reply.hex()}"
    if len(reply) < 5 or wire.crc16(reply) or reply[0] != unit:
        return f"a malformed reply {reply.hex()}"
    if strike.request and reply[1] & 0x7F != strike.request[1]:
        return f"another function's reply {reply.hex()}"
    reads = strike.request and strike.request[1] == 4
    if reads and reply[1:3] != bytes([4, 2 * strike.request[5]]):
        return f"a read answered by {reply.hex()}"
    return ""


def _compare(quiet: Path, storm: Path, outcome: FramestormOutcome) -> None:
    """Compare two edge lists up to the last STEP edge: behind it settings may change.

    STEP to the cycle; all else, which the program writes, in its order.
    """
    others: tuple[list[bytes], list[bytes]] = ([], [])
    missing: Counter[bytes] = Counter()
    end = 0
    with quiet.open("rb") as left, storm.open("rb") as right:
        steps = [_steps(file, apart) for file, apart in zip((left, right), others, strict=True)]
        for one, other in itertools.zip_longest(*steps, fillvalue=b""):
            outcome.edges += 1
            end = _cycle_of(one) if one else end
            if one == other:
                continue
            # Edges of one cycle may stand in any order.
            missing[one] += 1
            missing[other] -= 1
            missing = Counter({edge: number for edge, number in missing.items() if number})
            if len(missing) > _SAME_CYCLE:
                break
    if missing:
        edge = min(missing, key=_cycle_of)
        where = "only undisturbed" if missing[edge] > 0 else "only under fire"
        outcome.complain(f"edges differ from {edge.decode().strip()!r} on, which is {where}")
    before, after = ([edge for edge in edges if _cycle_of(edge) <= end] for edges in others)
    _compare_others(before, after, outcome)


def _steps(file: BinaryIO, apart: list[bytes]) -> Iterator[bytes]:
    """Yield the STEP edges of a list; put the others, the heading left out, into `apart`."""
    next(file)
    for edge in file:
        if b"STEP" in edge:
            yield edge
        else:
            apart.append(edge)


def _compare_others(quiet: list[bytes], storm: list[bytes], outcome: FramestormOutcome) -> None:
    """Compare DIR, ENABLE and PERMIT, output by output: the same edges, and how far DIR moved."""
    found = [sorted(edges, key=lambda edge: edge.split(b",")[1:4]) for edges in (quiet, storm)]
    kinds = [[edge.split(b",")[1:] for edge in edges] for edges in found]
    outcome.turns = sum(kind[2] == b"DIR" for kind in kinds[0])
    if kinds[0] != kinds[1]:
        outcome.complain("other edges of direction, enable or permit outputs than undisturbed")
        return
    found = [[edge for edge in edges if b",DIR," in edge] for edges in found]
    shifts = (abs(_cycle_of(a) - _cycle_of(b)) for a, b in zip(*found, strict=True))
    outcome.turn_shift_cycles = max(shifts, default=0)


def _cycle_of(edge: bytes) -> int:
    """Return the cycle of a line of an edge list; the end of the list is last."""
    return int(edge.split(b",")[0]) if edge else 1 << 62


def _axes(board: str) -> int:
    return boards.load(board).axes
