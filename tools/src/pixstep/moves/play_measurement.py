# SPDX-License-Identifier: MIT
"""The play of an axis, measured at its home switch, which is approached from both sides.

    motor  closes at c, coming from below: the load is pushed
      |    opens at o, coming from above: the load is pulled
      v
    ---o---------------c---->      c - o = play + hysteresis of the switch

The hysteresis is known from the switch, or an encoder at the load tells the play by itself: motor
less load differs by the play between the two sides. Both edges are found quickly first, then slowly
and again and again: at the slow speed a step takes longer than the contact's delay, so that the
captured position is the very step.
"""

import contextlib
import math
import shlex
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from statistics import median_low

from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.errors import UserError
from pixstep.lines.runs import Seek
from pixstep.moves.homing import HomingError, Legs
from pixstep.moves.legs import HomingPlan
from pixstep.progress import Progress, unseen

Encoder = Callable[[], float]
_TIMEOUT_S = 10.0
LEGS = ("leave the switch", "find where it closes", "find where it opens", "go below",
        "close slowly", "go above", "open slowly")  # fmt: skip
_LEAVE, _CLOSES, _OPENS, _BELOW, _CLOSE, _ABOVE, _OPEN = LEGS
_QUICK = 3  # legs before the slow ones
_CONTACT_S = 2e-3  # by which a contact may follow the load, on the quick legs
_TRIES = 6  # each from twice as far away


@dataclass(frozen=True)
class Approach:
    """Where the motor was, in steps, when the switch closed and when it opened.

    `play` is what an encoder at the load tells, None without one.
    """

    closed_steps: int
    opened_steps: int
    play: float | None = None

    @property
    def apart(self) -> int:
        """Steps between the two: play and hysteresis."""
        return abs(self.closed_steps - self.opened_steps)


@dataclass(frozen=True)
class MeasuredPlay:
    """The approaches, and what follows from them; `hysteresis` None: it is within the play."""

    axis: int
    approaches: tuple[Approach, ...]
    hysteresis: float | None
    by_encoder: bool

    @property
    def plays(self) -> list[float]:
        """The play by each approach, steps."""
        if self.by_encoder:
            return [item.play for item in self.approaches if item.play is not None]
        return [item.apart - (self.hysteresis or 0) for item in self.approaches]

    @property
    def play(self) -> int:
        """The play in whole steps: the middle one of all approaches."""
        return round(median_low(self.plays))

    @property
    def spread(self) -> float:
        """How far the approaches are apart, steps."""
        return max(self.plays) - min(self.plays)

    def as_json(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "axis": self.axis,
            "play_steps": self.play,
            "spread_steps": self.spread,
            "hysteresis_steps": self.hysteresis,
            "by_encoder": self.by_encoder,
            "approaches": [
                {"closed_steps": item.closed_steps, "opened_steps": item.opened_steps}
                for item in self.approaches
            ],
        }


def of_command(text: str) -> Encoder:
    """Return what runs a command and takes the number that it prints: the load's position, steps.

    Raises UserError for a text that is no command; so does a call if the command fails, takes more
    than 10 s, or prints something else.
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise UserError(f"encoder {text!r}: {error}") from None
    if not words:
        raise UserError(f"encoder {text!r}: expected a command")

    def read() -> float:
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError) as error:
            raise UserError(f"encoder {text!r}: {error}") from None
        if done.returncode:
            raise UserError(f"encoder {text!r}: ended with status {done.returncode}")
        with contextlib.suppress(ValueError):
            if math.isfinite(value := float(done.stdout)):
                return value
        raise UserError(f"encoder {text!r}: printed {done.stdout[:40]!r}, expected a number")

    return read


def measure(
    board: Device, plan: HomingPlan, pixel_hz: Fraction, world: World, *, repeat: int = 3,
    hysteresis: float | None = None, encoder: Encoder | None = None, progress: Progress = unseen,
) -> MeasuredPlay:  # fmt: skip
    """Measure the play of one axis, at rest and enabled, `repeat` times.

    `encoder` returns the load's position in the motor's steps; it is asked at rest. Raises
    HomingError naming the fault if the switch is not found, or saying that it does not close and
    open at two places, UserError for a hysteresis that is larger than all that was measured.
    """
    if repeat < 1:
        raise UserError(f"{repeat} approaches: at least 1")
    work = _Measuring(board, plan, pixel_hz, world, progress)
    work.repeat, work.encoder = repeat, encoder
    approaches = work.go()
    if encoder:
        hysteresis = median_low([item.apart - (item.play or 0.0) for item in approaches])
    found = MeasuredPlay(plan.axis, approaches, hysteresis, encoder is not None)
    if found.play < 0:
        raise UserError(
            f"axis {plan.axis}: the switch closes and opens {approaches[0].apart} steps apart, "
            f"less than its hysteresis of {hysteresis:g} steps"
        )
    return found


class _Measuring(Legs):
    """The legs of one measurement."""

    repeat = 1
    encoder: Encoder | None = None

    def go(self) -> tuple[Approach, ...]:
        """Find both edges quickly, then slowly as often as wanted."""
        if self.board.switches(self.plan.axis).home:
            self.seek(_LEAVE, self.plan.back_off())
        closed = self._edge(_CLOSES, self.plan.approach())
        opened = self._edge(_OPENS, self.plan.back_off())
        found = []
        for _ in range(self.repeat):
            closed, gap = self._slowly(_BELOW, _CLOSE, self.plan.slow_approach(), closed)
            opened, other = self._slowly(_ABOVE, _OPEN, self.plan.slow_back_off(), opened)
            play = None if gap is None or other is None else abs(gap - other)
            found.append(Approach(closed, opened, play))
        return tuple(found)

    def show(self, name: str, share: float) -> None:
        """Show how far all legs are."""
        slow = len(LEGS) - _QUICK
        self.progress(min(1.0, (len(self.legs) + share) / (_QUICK + slow * self.repeat)))

    def _edge(self, name: str, seek: Seek) -> int:
        """Make a leg that must find an edge; return the motor's position at it."""
        trip = self.seek(name, seek)
        if trip is None:
            raise HomingError(
                f"axis {self.plan.axis}: the switch was {'open' if seek.opens else 'closed'} "
                f"before the leg to '{name}': does it bounce for long?"
            )
        return trip.position_steps

    def _slowly(self, before: str, name: str, seek: Seek, edge: int) -> tuple[int, float | None]:
        """Find an edge again, slowly, from the side where the switch has not changed yet.

        Return the motor's position at it and, with an encoder, motor less load behind it. A start
        from where the switch has changed already is repeated from further away.
        """
        away = self.plan.direction * (1 if seek.opens else -1)
        margin = self.plan.clear_steps + math.ceil(self.plan.top * self.pixel_hz * _CONTACT_S)
        for _ in range(_TRIES):
            distance = edge + away * margin - self.position()
            if distance and not (distance * self.plan.direction > 0 and self._at_limit()):
                self.move(before, distance)
            if self.board.switches(self.plan.axis).home == seek.opens:
                found = self._edge(name, seek)
                return found, self.position() - self.encoder() if self.encoder else None
            margin *= 2
        raise HomingError(
            f"axis {self.plan.axis}: the switch is {'open' if seek.opens else 'closed'} "
            f"{margin} steps from where it changed before"
        )

    def _at_limit(self) -> bool:
        """True on a home switch that is a limit switch too: only a seek may lead on towards it."""
        bit = 2 * self.plan.axis + (self.plan.direction > 0)
        shared = self.board.setting("home_is_limit") >> bit & 1
        return bool(shared) and self.board.switches(self.plan.axis).home
