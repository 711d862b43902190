# SPDX-License-Identifier: MIT
"""The load of an axis behind its play, from the STEP and DIR edges of a run alone.

motor    . . . . . . M         the motor pushes the load up: slack 0
load     . . . . . . L
motor    . . M . . . .         it pulls the load down: slack -play
load     . . . . . . L
"""

from collections.abc import Iterable
from dataclasses import dataclass, field


@dataclass
class PlayLoad:
    """A load that stands still while the motor crosses the play."""

    play: int
    slack: int  # motor minus load, -play to 0
    place: int = 0
    cycles: list[int] = field(default_factory=list)  # of the STEP edges since `forget`
    places: list[int] = field(default_factory=list)  # of the load behind each of them
    _sign: int = 1

    def forget(self) -> None:
        """Begin the lists anew."""
        self.cycles, self.places = [], []

    def lacking(self, sign: int) -> int:
        """Return the steps in this direction before the load moves."""
        return -self.slack if sign > 0 else self.play + self.slack

    def turn(self, level: int) -> None:
        """Take the level of the DIR output: high is the negative direction."""
        self._sign = -1 if level else 1

    def step(self, cycle: int) -> None:
        """Take a STEP edge."""
        if self.lacking(self._sign):
            self.slack += self._sign
        else:
            self.place += self._sign
        self.cycles.append(cycle)
        self.places.append(self.place)

    def at(self, cycle: int) -> int | None:
        """Return the place behind the last STEP edge up to this cycle; None if there is none."""
        passed = sum(edge <= cycle for edge in self.cycles)
        return self.places[passed - 1] if passed else None


def follow(rows: Iterable[str], loads: dict[int, PlayLoad]) -> None:
    """Let the loads of axes follow rows of the simulator's list of edges."""
    for row in rows:
        cycle, _, axis, signal, level = row.split(",")
        if signal == "DIR":
            loads[int(axis)].turn(int(level))
        elif signal == "STEP" and level.strip() == "1":
            loads[int(axis)].step(int(cycle))
