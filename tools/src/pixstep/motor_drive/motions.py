# SPDX-License-Identifier: MIT
"""What an axis is asked to do, as lines of its board: a move with its second leg, a jog.

A motion knows what it has queued and when that ends; `judging.py` judges what the board says of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice

from pixstep.motor_drive.feed import Feed
from pixstep.motor_record.traffic import MotorCommand, Verb, whole
from pixstep.moves.trapezoid import JogLaw, MoveKinematics, Run, Trapezoid, line_entries

# A line follows the one before it without a gap if it is queued before the board decodes the end of
# that line. The board decodes ahead of the steps: as many periods as the ring of the step interrupt
# holds, and two pixels' pulse trains. A period is one step, or 65,535 ticks of a longer one.
_RING_PERIODS, _LONGEST_S = 252, 0.0041
_TRAINS_PX = 2
_HOST_S = 0.12  # the host may be this late
_SEGMENT_S, _SEGMENT_PX = 0.08, 2  # of a jog: a line of its own, at least
_SEGMENTS = 4  # that are queued at a time
_LATE_S = 0.05  # from arming to the first step, at most
_DRIFT = 1.01  # the board's oscillator against the host's clock, at most
_FIRST_RUNS = 12  # of a long leg: a line of their own
_SAME = 1e-9


@dataclass(frozen=True)
class MotionLeg:
    """One leg: kinematics and the target, a raw position in whole steps."""

    kinematics: MoveKinematics
    target_steps: int


@dataclass(frozen=True)
class PixelLimits:
    """What a board's pixels allow: their frequency, the highest speed, how it turns."""

    hz: float
    top_steps_px: int
    turns_below_steps_px: int
    rest_px: int


def second_of(
    commands: Sequence[MotorCommand], now: MoveKinematics, end_steps: int
) -> MotionLeg | None:
    """Return the leg that commands ask for after one that ends at `end_steps`; None for others."""
    wanted, target = WantedSpeeds(now), None
    for command in commands:
        if wanted.take(command):
            continue
        if command.verb is Verb.MOVE_ABS:
            target = whole(command.argument)
        elif command.verb is Verb.MOVE_REL:
            target = whole(end_steps + (command.argument or 0.0))
        elif command.verb is not Verb.GO:
            return None
    if target is None or not commands or commands[-1].verb is not Verb.GO:
        return None
    return MotionLeg(wanted.kinematics, target)


def same(some: Sequence[MotorCommand], others: Sequence[MotorCommand]) -> bool:
    """Whether commands ask for the same; a status that is wanted as well makes no difference."""
    left, right = [
        [one for one in commands if one.verb is not Verb.GET_INFO] for commands in (some, others)
    ]
    return len(left) == len(right) and all(
        one.verb is other.verb and _close(one.argument, other.argument)
        for one, other in zip(left, right, strict=True)
    )


def _close(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=_SAME, abs_tol=_SAME)


def decoded_ahead_s(steps_s: float, pixel_hz: float) -> float:
    """Return how long before its last step the end of a line must be known."""
    periods_s = max(abs(steps_s), 1 / _LONGEST_S)
    return _HOST_S + _TRAINS_PX / pixel_hz + _RING_PERIODS / periods_s


class WantedSpeeds:
    """The speeds that the record has set last."""

    def __init__(self, kinematics: MoveKinematics | None = None) -> None:
        self.kinematics = kinematics or MoveKinematics(1.0)

    def take(self, command: MotorCommand) -> bool:
        """Take a command that sets one; return whether it does."""
        now, value = self.kinematics, abs(command.argument or 0.0)
        if not math.isfinite(value):
            raise ValueError(f"{value} is not a speed or a target")
        if command.verb is Verb.SET_VELOCITY:
            now = MoveKinematics(value, now.base_steps_s, now.acceleration_steps_s2)
        elif command.verb is Verb.SET_VEL_BASE:
            now = MoveKinematics(now.speed_steps_s, value, now.acceleration_steps_s2)
        elif command.verb is Verb.SET_ACCEL:
            now = MoveKinematics(now.speed_steps_s, now.base_steps_s, value)
        else:
            return False
        self.kinematics = now
        return True


class DrivenMotion:
    """One motion of an axis, from its first block to rest."""

    def __init__(self, direction: int) -> None:
        self.direction = direction
        """+1 or -1: where it goes, or went last."""
        self.feed: Feed | None = None
        self.lines_before = 0
        """The axis' lines done when it was begun."""
        self.armed_s: float | None = None
        self.stopping = False
        self.refused = False
        """Whether the board has refused a part of it after it was armed."""
        self.queued_s = 0.0
        """How long all lasts that was queued so far."""

    def leads_to(self, target_steps: int) -> bool:
        """Whether it will end at a position by itself."""
        del target_steps
        return False

    def ends_s(self) -> float:
        """Return when the last step can come that is queued, by the host's clock."""
        if self.armed_s is None:
            return math.inf
        return self.armed_s + _LATE_S + _DRIFT * self.queued_s

    def entries(self) -> Iterator[Run]:
        """Return the queue entries to begin with."""
        raise NotImplementedError

    def due_s(self) -> float:
        """Return when more is to be queued."""
        return math.inf

    def armed(self, now_s: float) -> None:
        """Note that it was armed just now, or again after lines that were over too early."""
        self.armed_s = now_s

    def look_due_s(self) -> float:
        """Return when it is expected to end, or its first leg."""
        return math.inf

    def queue_more(self, now_s: float) -> bool:
        """Queue what follows if it is time for that; return whether there is something new."""
        del now_s
        return False


class DrivenMove(DrivenMotion):
    """A move to a target, and the second leg that the record has announced."""

    def __init__(
        self,
        start_steps: int,
        first: MotionLeg,
        second: MotionLeg | None,
        announced: Sequence[MotorCommand],
        pixels: PixelLimits,
    ) -> None:
        steps = first.target_steps - start_steps
        super().__init__(1 if steps > 0 else -1)
        self.first, self.second = first, second
        self.announced = tuple(announced)
        """What the record gives when the first leg has ended, if it decides as it said."""
        self.queued_second = self.confirmed = self.holding = False
        self.hold_until_s = math.inf
        self._pixels = pixels
        self._steps = steps
        self._leg = Trapezoid(steps, first.kinematics, pixels.hz)
        self.queued_s = self.first_s = self._leg.lasts_s
        self._parted = len([*islice(self._leg.runs(), _FIRST_RUNS + 1)]) > _FIRST_RUNS

    @property
    def target_steps(self) -> int:
        """Where it ends, by what was queued of it."""
        last = self.second if self.second and self.queued_second else self.first
        return last.target_steps

    @property
    def first_lines(self) -> int:
        """How many lines the first leg has."""
        return 1 + self._parted

    @property
    def lines(self) -> int:
        """How many lines were queued."""
        return self.first_lines + self.queued_second

    def entries(self) -> Iterator[Run]:
        """Return the queue entries to begin with: of a short first leg, those of both legs.

        A board begins a line that is not there to its end only when three quarters of its queue are
        full. A long leg therefore has its first runs as a line of their own.
        """
        runs = self._leg.runs()
        if self._parted:
            yield from line_entries(islice(runs, _FIRST_RUNS))
        yield from line_entries(runs)
        if self._second_at_once:
            yield from self._second_entries()

    def begin_second_at_once(self) -> None:
        """Note that `entries` has the second leg if the first one is short."""
        if self._second_at_once:
            self._note_second()

    def leads_to(self, target_steps: int) -> bool:
        """Whether it will end at a position by itself."""
        return target_steps == self.target_steps

    def due_s(self) -> float:
        """Return when the second leg is to be queued."""
        if self.armed_s is None or self.second is None or self.queued_second:
            return math.inf
        return self.armed_s + self.first_s - self._lead_s

    def look_due_s(self) -> float:
        """Return when it is expected to end, its first leg, or the wait for the record's answer."""
        if self.armed_s is None:
            return math.inf
        if self.holding:
            return self.hold_until_s
        waits = self.second is not None and not self.confirmed
        return self.armed_s + (self.first_s if waits else self.queued_s)

    def queue_more(self, now_s: float) -> bool:
        """Queue the second leg before the board decodes the end of the first one.

        What is queued cannot be taken back without a stop. Until then the record may want another
        target than it has announced.
        """
        if self.feed is None or now_s < self.due_s():
            return False
        self._note_second()
        self.feed.more(self._second_entries())
        return True

    def armed(self, now_s: float) -> None:
        """Note that it was armed, its second leg if that begins by itself."""
        self.armed_s = now_s - self.first_s if self.confirmed else now_s

    def turn_to_second(self) -> None:
        """Note that the second leg is under way."""
        if self.second and self.second.target_steps != self.first.target_steps:
            self.direction = 1 if self.second.target_steps > self.first.target_steps else -1

    @property
    def _second_at_once(self) -> bool:
        """Whether the first leg is too short for the second one to be queued during it."""
        return self.second is not None and self.first_s <= self._lead_s

    @property
    def _lead_s(self) -> float:
        return decoded_ahead_s(0.0, self._pixels.hz)

    def _note_second(self) -> None:
        self.queued_second = True
        self.queued_s = self.first_s + self._second().lasts_s + self._rest_px() / self._pixels.hz

    def _second(self) -> Trapezoid:
        assert self.second is not None
        steps = self.second.target_steps - self.first.target_steps
        return Trapezoid(steps, self.second.kinematics, self._pixels.hz)

    def _second_entries(self) -> Iterable[Run]:
        rest = [(0, self._rest_px())] if self._rest_px() else []
        return line_entries(chain(rest, self._second().runs()))

    def _rest_px(self) -> int:
        """Return how long the motor rests between the legs, to turn at a speed that needs it."""
        assert self.second is not None
        ends = (self.first.kinematics, self.second.kinematics)
        fastest = max(_end_steps_px(one, self._pixels.hz) for one in ends)
        turns = (self.second.target_steps - self.first.target_steps) * self._steps < 0
        return self._pixels.rest_px if turns and fastest > self._pixels.turns_below_steps_px else 0


def _end_steps_px(wanted: MoveKinematics, hz: float) -> int:
    """Return the most steps in the first or the last pixel of a leg."""
    acceleration, speed = wanted.acceleration_steps_s2, wanted.speed_steps_s
    if acceleration:
        speed = min(speed, wanted.base_steps_s + acceleration / hz)
    return math.ceil(speed / hz) + 1


class Jog(DrivenMotion):
    """A motion at a speed until it is stopped: short lines, each queued while those before run.

    They follow each other without a gap, and the motor stops after the last line that came. If the
    host dies, a slow motor stops within 1.3 s, one that makes 2000 steps/s within 0.3 s. (The
    board's `bus_timeout_ms` would stop it too.) A change of speed begins after the same time.
    """

    def __init__(
        self, velocity_steps_s: float, wanted: MoveKinematics, pixels: PixelLimits
    ) -> None:
        super().__init__(1 if velocity_steps_s > 0 else -1)
        self._pixels, self.kinematics = pixels, wanted
        self._law = JogLaw(pixels.hz, pixels.turns_below_steps_px, pixels.rest_px)
        self._dry = False

    def entries(self) -> Iterator[Run]:
        """Return the first lines."""
        while self.queued_s < self._ahead_s:
            yield from self._line()

    def due_s(self) -> float:
        """Return when the next line is to be queued."""
        if self.armed_s is None:
            return math.inf
        return self.armed_s + self.queued_s - self._ahead_s

    def queue_more(self, now_s: float) -> bool:
        """Queue the next lines."""
        if self.feed is None or now_s < self.due_s():
            return False
        while now_s >= self.due_s():
            self.feed.more([*self._line()])
        return True

    def armed(self, now_s: float) -> None:
        """Note that it was armed; what ran dry is queued ahead again."""
        self.armed_s = now_s if self.armed_s is None and not self._dry else now_s - self.queued_s
        self._dry = False

    def ran_dry(self) -> None:
        """Queue a line where there is none any more."""
        self._dry = True
        if self.feed is not None:
            self.feed.more([*self._line()])

    def change(self, velocity_steps_s: float, wanted: MoveKinematics) -> None:
        """Go on at another speed, from the next line to be queued on."""
        self.kinematics = wanted
        self.direction = 1 if velocity_steps_s > 0 else -1

    @property
    def _ahead_s(self) -> float:
        slowest = min(abs(self._law.steps_s), self.kinematics.speed_steps_s)
        return decoded_ahead_s(slowest, self._pixels.hz)

    def _line(self) -> Iterator[Run]:
        lasts_s = max(_SEGMENT_S, self._ahead_s / _SEGMENTS)
        count = max(_SEGMENT_PX, math.ceil(lasts_s * self._pixels.hz))
        found = self._law.pixels(self.kinematics, self.direction, count)
        self.queued_s += sum(repeat for _, repeat in found) / self._pixels.hz
        return line_entries(found)
