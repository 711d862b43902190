# SPDX-License-Identifier: MIT
"""Random sequences of lines, moves and stops on axes with play.

Some axes of a board get motions of their own, again and again. They are stopped at random cycles:

    none       to their end
    stop       a command in motion, mostly in the first pixels: zero pixel, ramp, take-up
    estop      the emergency stop at a random cycle, cleared afterwards
    disarm     before line zero

A line that takes up backlash must move its load by its own steps at every pixel edge behind the
take-up, or the board says that it did not know its play. Once a line with backlash came to its end
the board must know.
"""

import random
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.robustness.plays import motions
from pixstep_dev.robustness.plays.load import PlayLoad, follow
from pixstep_dev.robustness.plays.motions import ClockEdges, PlayMotion

TOLERANCE_STEPS = 1
_TOGETHER = 2  # axes that move
_PIXEL_HZ = {1: Fraction(100)}  # by the number of axes of a board
_SLOWER_HZ = Fraction(40)
_CLOCK_START_MS = 10
_SETTLE_S = 0.01
_ACTS = 7  # of a sequence, on average


@dataclass(frozen=True)
class PlaysPlan:
    """So many sequences of one board; `first` is the number of the first."""

    board: str
    sequences: int
    seed: int = 1
    first: int = 0


@dataclass
class PlaysOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: PlaysPlan
    sequences: int = 0
    lines: int = 0  # with backlash, each axis by itself
    warned: int = 0  # of these: the board said that it did not know the play
    edges: int = 0  # pixel edges at which a load was compared
    worst_steps: int = 0
    ends: dict[str, int] = field(default_factory=dict)  # of motions, by name
    complaints: list[str] = field(default_factory=list)


def run(plan: PlaysPlan, progress: Progress = unseen) -> PlaysOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = PlaysOutcome(plan)
    for number in range(plan.first, plan.first + plan.sequences):
        rng = random.Random(f"{plan.seed} {plan.board} {number}")
        with (
            tempfile.TemporaryDirectory(prefix="pixstep-") as folder,
            Sequence(plan.board, rng, Path(folder) / "edges.csv", outcome) as sequence,
        ):
            sequence.where = f"sequence {plan.seed}:{number}"
            sequence.run()
        outcome.sequences += 1
        progress(outcome.sequences / plan.sequences)
    return outcome


class Sequence:
    """A board that has just been started, and loads behind its axes."""

    where = ""

    def __init__(self, name: str, rng: random.Random, edges: Path, outcome: PlaysOutcome) -> None:
        table = boards.load(name)
        self._name, self._rng, self._edges, self._outcome = name, rng, edges, outcome
        self._hz = _PIXEL_HZ.get(table.axes, _SLOWER_HZ)
        self._pixel_cycles = int(table.tick_hz / self._hz)
        self._clock = ClockEdges(table.tick_hz * _CLOCK_START_MS // 1000, self._pixel_cycles)
        self._pins = table.pins
        self._plays = [round(motions.MOST_PLAY ** rng.random()) for _ in range(table.axes)]
        self._loads = {
            axis: PlayLoad(play, -rng.randint(0, play)) for axis, play in enumerate(self._plays)
        }
        self._axes = sorted(rng.sample(range(table.axes), min(_TOGETHER, table.axes)))
        self._sure: set[int] = set()  # axes of which the board must know the play

    def __enter__(self) -> "Sequence":
        start = ("--pixel-start-ms", str(_CLOCK_START_MS))
        link = SimulatedBoard(self._name, self._hz, edges=self._edges, extra=start)
        self._sim, self._board = link.simulator, link.board
        try:
            self._board.set_pixel_hz(self._hz)
            self._board.write_setting("backlash_policy", self._rng.randint(0, 1))
            self._sim.command("flush")
            self._log = self._edges.open(encoding="utf-8")
            self._log.readline()
        except BaseException:
            self._sim.kill()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._log.close()
        self._sim.kill()

    def run(self) -> None:
        """Give motions, and judge each."""
        acts = self._rng.randint(_ACTS // 2, _ACTS * 3 // 2)
        for act in range(acts):
            try:
                if self._rng.random() < 0.1:
                    self._seek()
                else:
                    self._move(f"{self.where}, act {act}")
            except BoardError as error:
                self._complain(f"{self.where}, act {act}: {error}")
                return

    def _complain(self, text: str) -> None:
        self._outcome.complaints.append(text)

    def _look(self) -> None:
        """Let the loads follow what was made so far."""
        self._sim.command("flush")
        follow(self._log, self._loads)

    def _load(self, axis: int, motion: PlayMotion) -> None:
        """Queue all of a motion."""
        for entries in motion.entries:
            upload = LineUpload(self._board, axis, entries)
            upload.push()
            if not upload.done:
                raise BoardError(f"axis {axis}: the queue is full")

    def _twice(self, command: str, axes: Iterable[int]) -> None:
        for _ in range(2):
            self._board.command(command, list(axes))

    def _move(self, where: str) -> None:
        """Give some axes a motion each, end them somehow, and judge them."""
        given = {
            axis: motions.motion(self._rng, self._plays[axis], chains=axis in self._sure)
            for axis in self._axes
        }
        before = {axis: (load.place, load.slack) for axis, load in self._loads.items()}
        for axis, motion in given.items():
            self._loads[axis].forget()
            self._load(axis, motion)
        self._board.command("arm", list(given))
        unknown = self._board.input("status") >> regs.STATUS_PLAY
        end = self._rng.choices(("none", "stop", "estop", "disarm"), (4, 4, 2, 1))[0]
        self._end(end, given)
        self._outcome.ends[end] = self._outcome.ends.get(end, 0) + 1
        self._look()
        for axis, motion in given.items():
            whole = end == "none"
            if motion.judged:
                self._judge(
                    axis,
                    motion,
                    f"{where} ({end}), axis {axis}",
                    before[axis],
                    unknown=bool(unknown >> axis & 1),
                    whole=whole,
                )
            if whole and motion.judged:
                self._sure.add(axis)

    def _end(self, how: str, given: dict[int, PlayMotion]) -> None:
        """Let the motions come to their end, or stop them."""
        pixels = max(motion.pixels for motion in given.values())
        # Behind arming the clock's next edge but one is line zero.
        most = 6 if self._rng.random() < 0.7 else pixels + 2
        cut = self._rng.randrange(most * self._pixel_cycles)
        if how == "none":
            self._sim.run((pixels + 3) * self._pixel_cycles)
            self._require_done(given)
        elif how == "disarm":
            self._disarm(given)
        elif how == "stop":
            self._sim.run(cut)
            self._twice("stop", given)
            self._sim.wait_s(_SETTLE_S)
        else:
            pin = next(pin for pin in self._pins if pin.signal == "ESTOP")
            self._sim.pin(0, pin.port, pin.bit, 0, at=self._sim.cycle + cut)
            self._sim.run(cut + self._sim.cycles(_SETTLE_S))
            self._sim.pin(0, pin.port, pin.bit, 1)
            self._sim.wait_s(0.001)
            self._twice("clear_fault", [])
            self._twice("discard", given)

    def _disarm(self, given: dict[int, PlayMotion]) -> None:
        """Disarm before line zero; an axis that has begun is stopped."""
        for axis in given:
            try:
                self._twice("disarm", [axis])
            except BoardError:
                self._twice("stop", [axis])
        self._sim.wait_s(_SETTLE_S)

    def _require_done(self, given: dict[int, PlayMotion]) -> None:
        for axis in given:
            state = regs.axis_state(self._board.axis(axis)["axis_state"])
            if state != "done":
                raise BoardError(f"axis {axis} is {state}: {self._board.fault_text()}")

    def _seek(self) -> None:
        """Let an axis search for its switch, and make the place of the switch its zero."""
        axis = self._rng.choice(self._axes)
        seek = PlayMotion(seek=motions.seek(self._rng))
        pin = next(pin for pin in self._pins if pin.signal == "HOME" and pin.axis == axis)
        self._load(axis, seek)
        self._board.command("arm", [axis])
        cut = self._rng.randrange(12 * self._pixel_cycles)
        self._sim.pin(0, pin.port, pin.bit, 0, at=self._sim.cycle + cut)
        self._sim.run((seek.pixels + 3) * self._pixel_cycles)
        self._require_done({axis: seek})
        if self._board.input("trip_code") and self._rng.random() < 0.7:
            self._board.command("zero", [axis])
        self._sim.pin(0, pin.port, pin.bit, 1)
        self._sim.wait_s(_SETTLE_S)
        self._look()
        self._outcome.ends["seek"] = self._outcome.ends.get("seek", 0) + 1

    def _judge(
        self,
        axis: int,
        motion: PlayMotion,
        where: str,
        before: tuple[int, int],
        *,
        unknown: bool,
        whole: bool,
    ) -> None:
        """Compare the load with the motion's lines at every pixel edge away from take-ups."""
        load, outcome = self._loads[axis], self._outcome
        outcome.lines += 1
        if unknown:
            outcome.warned += 1
            if axis in self._sure:
                self._complain(f"{where}: play {load.play} unknown to the board")
            return
        if not load.cycles:
            return
        place, slack = before
        lacking = PlayLoad(load.play, slack).lacking(motion.lines[0].direction)
        for cycle, way in motions.edges(motion, load.cycles[0], lacking, self._clock):
            if cycle > load.cycles[-1] and not whole:
                break  # cut off in this pixel
            outcome.edges += 1
            off = (load.at(cycle) or 0) - place - way
            outcome.worst_steps = max(outcome.worst_steps, abs(off))
            if abs(off) > TOLERANCE_STEPS:
                self._complain(f"{where}: play {load.play}, load {off} steps off at cycle {cycle}")
                return
