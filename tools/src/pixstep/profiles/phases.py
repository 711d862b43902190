# SPDX-License-Identifier: MIT
"""The parts of a line by what the motor does in them: rest, up, constant, down, swinging."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from pixstep import plotting
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.profiles import kinematics

REST, UP, CONSTANT, DOWN, SWING, TAKE_UP = "rest", "up", "constant", "down", "swing", "take-up"


@dataclass(frozen=True)
class Phase:
    """From `begin` to `end` in pixel periods; a name, and a shorter one."""

    kind: str
    begin: float
    end: float
    text: str
    short: str


def of(line: Line) -> list[Phase]:
    """Return the phases of a line in order, without gaps."""
    motion = kinematics.of(line)
    kinds = list(_kinds(line, motion))
    phases = []
    first = 0
    for (kind, speeds), group in groupby(kinds):
        behind = first + len(list(group))
        begin, end = float(motion.edges_px[first]), float(motion.edges_px[behind])
        phases.append(Phase(kind, begin, end, *_texts(kind, speeds)))
        first = behind
    return phases


def _kinds(line: Line, motion: kinematics.Kinematics) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield the kind of every piece, with the speeds that tell it from another of its kind."""
    swings: dict[int, tuple[int, int]] = {}
    for run in line_check.oscillations(line) if line.smooth else ():
        swings |= dict.fromkeys(range(run.pixel - 1, run.pixel - 1 + run.length), run.swing)
    changes = motion.accelerations if line.smooth else motion.speed_changes
    for piece, speed in enumerate(motion.begin_speeds.tolist()):
        take_up = bool(line.shifted_pixels) and piece == line.shifted_pixels
        pixel = piece - int(bool(line.shifted_pixels) and piece > line.shifted_pixels)
        if take_up:
            yield TAKE_UP, ()
        elif pixel in swings:
            yield SWING, swings[pixel]
        else:
            yield _kind(line, int(changes[piece]), speed, int(motion.end_speeds[piece]))


def _kind(line: Line, change: int, begin: int, end: int) -> tuple[str, tuple[int, ...]]:
    """Return the kind of a piece that neither swings nor takes up backlash."""
    if begin == 0 and end == 0:
        return REST, ()
    if not line.smooth or change == 0:
        return CONSTANT, (begin,)
    faster = abs(end) > abs(begin)
    return (UP if faster else DOWN), ()


def _texts(kind: str, speeds: tuple[int, ...]) -> tuple[str, str]:
    """Return the name of a phase and a shorter one."""
    numbers = [plotting.number(speed) for speed in speeds]
    if kind == CONSTANT:
        return f"constant {numbers[0]}", numbers[0]
    if kind == SWING:
        return "oscillates between {} and {} steps/px".format(*numbers), "oscillates"
    return {
        REST: ("rest", "rest"),
        UP: ("speeding up", "up"),
        DOWN: ("slowing down", "down"),
        TAKE_UP: ("backlash", "B"),
    }[kind]
