# SPDX-License-Identifier: MIT
"""What a board is guaranteed to follow: lines that run together, its clock, its bus.

The board's main loop is replayed with the costs that were measured on its image, once for each of
some margins: which part of a line comes first depends on every cost, so that no single margin is
the worst one. A line that passes runs without a fault whatever a host asks meanwhile, and with
every record kept; what a replay cannot know (noise on the clock's input, a host that sends line
data too late) it does not promise.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction

from pixstep.board import boards, costs, settings
from pixstep.lines.line import Line
from pixstep.lines.replay import Loop, Replay, Verdict
from pixstep.lines.units import period_ticks

MARGINS = (1.0, 1.05, 1.1)
BAUD = 115_200
# A master that asks again as soon as it has a reply: bytes of a request and its reply, and how long
# the bus rests between them, measured (silences, rounds of the board).
_BYTES, _REST_S, _BYTE_BITS = 100, 0.0043, 11
_LEAD_TICKS = 0x20000  # firmware/app/reference.c
_MARKS = 16
_DECLARED_PPM = 1000  # a clock may be so much faster


@dataclass(frozen=True)
class World:
    """What lines run on: the board, the frequency of pixels, settings, the bus."""

    board: str
    pixel_hz: Fraction
    sync: int = 1
    divider: int = 1
    baud: int = BAUD
    ppm: float = _DECLARED_PPM


def loop_of(world: World, margin: float = 1.0) -> Loop:
    """Return the board's main loop in this world."""
    kind = boards.load(world.board)
    nominal = float(period_ticks(world.pixel_hz, kind.tick_hz))
    locked = settings.locks({"sync": world.sync})
    clock = nominal / world.divider
    most = _MARKS * world.divider
    lead, all_ahead = (
        min(int(ticks // clock) + 1, most) for ticks in (_LEAD_TICKS, _LEAD_TICKS + clock * 3 / 8)
    )
    return Loop(
        kind.axes,
        kind.all_features,
        nominal / (1 + world.ppm / 1e6) if locked else nominal,
        world.divider,
        lead if locked else 0,
        all_ahead - lead if locked else 0,
        _BYTES / (_BYTES * _BYTE_BITS / world.baud + _REST_S) / kind.tick_hz,
        margin,
    )


def verdicts(
    lines: Sequence[Line], world: World, table: Mapping[str, float] | None = None
) -> Iterator[Verdict]:
    """Yield how the lines fare with each margin."""
    found = table or asdict(costs.of(world.board))
    replay = Replay(lines)
    for margin in MARGINS:
        yield replay.judge(found, loop_of(world, margin))


def first_late(
    lines: Sequence[Line], world: World, table: Mapping[str, float] | None = None
) -> Verdict | None:
    """Return the verdict of the first margin with which a line is late; None: all are followed."""
    return next((one for one in verdicts(lines, world, table) if not one.follows), None)
