# SPDX-License-Identifier: MIT
"""Lines of one kind of pixel each, and what an image spends on them.

Decoding is counted over a whole run, from the upload to the last edge: nothing else decodes. The
account is looked at by every board at rest too, so that it is counted in the middle of the line.
"""

import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.board.errors import FaultError
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.bench import sections
from pixstep_dev.bench.drive import view
from pixstep_trials import lines

_MIDDLE = (0.25, 0.9)  # of a line's steps
_SLICE_S = 0.001
BETWEEN_PPM = (0, 600)  # of a clock whose edges come with steps, and right before them
_BUSY_HZ = (2000, 2600, 3200, 4000, 4800)  # as fast as the board can, edges are most of its work


@dataclass(frozen=True)
class CostProbe:
    """A line for each of so many axes; `costs` are those that it tells."""

    name: str
    hz: int
    line: Line
    axes: int = 1
    locked: bool = False
    divider: int = 1
    ppm: int = 0  # by which the clock is faster


@dataclass(frozen=True)
class Spent:
    """What a probe has cost: cycles of the main loop, and how often."""

    probe: CostProbe
    decode: float  # of the whole line, of one axis
    calls: float
    share: float  # of the line's steps that were looked at
    account: float  # of one axis, while these were made
    looks: float
    rounds: float  # cycles of everything else but requests
    passes: float
    edges: float
    cycles: int = 0
    handlers: dict[str, dict[str, Any]] = field(default_factory=dict)


def _constant(count: int, hz: int, seconds: float) -> Line:
    return lines.constant(count, max(12, round(hz * seconds)))


def _turns(low: int, high: int, pixels: int, hz: int) -> Line:
    up = lines.ramp(low, Fraction(hz))
    return lines.smooth([*up, *lines.wobble(low, high, pixels)[1:], low, *reversed(up[:-1])])


def _own(low: int, high: int, pixels: int) -> Line:
    some = random.Random(low)
    return Line(tuple(some.randint(low, high) for _ in range(pixels)), PLAIN, name="own")


def _untrained(board: str, hz: int) -> list[int]:
    """Return counts that no pulse train can make: their shorter interval is 256 k ticks."""
    ticks = boards.load(board).tick_hz // hz
    return [-(-ticks // (256 * k + 1)) + 1 for k in (1, 2, 3)]


def _shifted(speed: int, hz: int, backlash: int) -> Line:
    up = lines.ramp(speed, Fraction(hz))
    counts = lines.smooth([*up, *reversed(up)]).counts
    return Line((0, *counts), SMOOTH, backlash=backlash, name="shifted")


def _bends(speeds: tuple[int, ...], pixels: int) -> Line:
    return lines.smooth([0, *(speeds * (pixels // 2 // len(speeds))), 0])


def _down(speed: int) -> range:
    """Return boundary speeds that fall by a sixteenth of a speed each."""
    step = max(2, speed // 16 * 2)
    return range(speed - step, 0, -step)


def of_board(board: str) -> list[CostProbe]:
    """Return the probes of a board. Their lines fit its queues: a host has nothing to add."""
    own = 20 if board == "uno" else 60
    all_axes = boards.load(board).axes
    found = [
        CostProbe(f"even {n} {hz}", hz, _constant(n, hz, 0.4))
        for n, hz in ((4, 1000), (10, 1000), (20, 1000), (60, 400), (110, 250))
    ]
    found += [CostProbe(f"even 10 {hz}", hz, _constant(10, hz, 0.4)) for hz in (2500, 3500)]
    found += [
        CostProbe(f"own {a}-{b}", 500, _own(a, b, own)) for a, b in ((8, 12), (14, 20), (30, 50))
    ]
    found += [
        CostProbe(f"train {n} {hz}", hz, _constant(n, hz, 0.4))
        for n, hz in ((150, 200), (300, 200), (600, 100), (1500, 30))
    ]
    found += [CostProbe(f"singles {n}", 30, _constant(n, 30, 0.5)) for n in _untrained(board, 30)]
    found += [
        CostProbe(f"slow {n} {hz}", hz, _constant(n, hz, 0.6))
        for n, hz in ((2, 30), (6, 30), (12, 30))
    ]
    found += [CostProbe(f"short {n} 70", 70, _constant(n, 70, 0.4)) for n in (20, 90)]
    found += [
        CostProbe(f"curves {a}-{b} {hz}", hz, _turns(a, b, px, hz))
        for a, b, px, hz in (
            (860, 900, 12, 30), (200, 600, 12, 30), (40, 60, 15, 30), (960, 1000, 9, 10),
            (200, 240, 24, 100), (100, 200, 24, 100), (80, 120, 24, 200), (40, 60, 24, 100),
        )
    ]  # fmt: skip
    found += [
        CostProbe(f"bends {a}-{b} {hz}", hz, _turns(a, b, 60, hz))
        for a, b, hz in ((8, 12, 500), (16, 24, 500), (4, 16, 500), (30, 44, 500), (40, 56, 300))
    ]
    found += [
        CostProbe(f"drops {v} {hz}", hz, lines.smooth([0, *[v] * 12, 0]))
        for v, hz in (
            (1436, 46),
            (848, 46),
            (300, 46),
            (400, 150),
            (100, 300),
            (60, 500),
            (600, 30),
        )
        if v * hz < (60_000 if board == "uno" else 70_000)
    ]
    found += [
        CostProbe(f"curves near {v} {hz}", hz, _turns(low, v, 15, hz))
        for v, hz in ((3000, 30), (5000, 10), (700, 100), (900, 60), (400, 150))
        for low in (v * 24 // 50 * 2, v * 9 // 20 * 2)
        if v * hz < (60_000 if board == "uno" else 95_000)
    ]
    found += [
        CostProbe(f"drops down {v} {hz}", hz, lines.smooth([0, *[v] * 3, *_down(v), 0]))
        for v, hz in ((200, 30), (1500, 20), (300, 100), (1200, 46), (120, 250))
    ]
    found += [
        CostProbe(f"bends up {a} {hz}", hz, lines.smooth([*range(0, a, 2), a, *range(a, -1, -2)]))
        for a, hz in ((40, 300), (60, 250), (16, 1000))
    ]
    found += [
        CostProbe(f"few {name} {hz}", hz, _bends(speeds, own))
        for hz in (500, 1500)
        for name, speeds in (
            ("2-0", (2, 0)), ("4-0", (4, 0)), ("4-2", (4, 2)), ("4-2-0", (4, 2, 0)),
            ("4-4-2", (4, 4, 2)), ("2-4-4-2-0", (2, 4, 4, 2, 0)), ("8-4", (8, 4)),
        )
    ]  # fmt: skip
    found += [
        CostProbe(f"steep {v} {hz}", hz, _bends((2, v, v, 2), own))
        for v, hz in ((30, 100), (30, 200), (30, 500), (60, 100), (60, 200), (102, 100))
    ]
    found += [
        CostProbe(f"steep peaks {v} {hz}", hz, _bends((v, 2, v + 2, 4, v + 4, 0), own))
        for v, hz in ((20, 75), (40, 64), (60, 50))
    ]
    found += [
        CostProbe(f"shifted {v} {hz}", hz, _shifted(v, hz, 7))
        for v, hz in ((14, 1000), (20, 500), (100, 200), (400, 60))
    ]
    found += [
        CostProbe(f"turns {name} {hz}", hz, Line(tuple(counts * 5), PLAIN, name="turns"))
        for hz in (200, 800)
        for name, counts in (
            ("each", [2, -2]),
            ("every other", [3, 3, -3, -3]),
            ("rests", [2, 0, -2, 0]),
        )
    ]
    found += [
        CostProbe(f"turns uneven {hz}", hz, Line((2, -4) * 10, PLAIN, name="turns"))
        for hz in (200, 400)
    ]
    found += [
        CostProbe(f"{name} {counts} {hz} {axes}", hz, Line(counts * (own // 6), PLAIN), axes)
        for axes in sorted({1, all_axes})
        for name, hz, counts in (
            ("turns bursts", 500, (10, 10, 1, -1, -10, -10, -1, 1)),
            ("turns over rests", 500, (12, 12, 12, 0, -12, -12, -12, 0)),
            ("turns in bursts", 400, (20, 20, 20, 0, -20, -20, 0, 20)),
            ("rests", 30, (20, 20, 20, 0)),
            ("rests", 200, (20, 20, 20, 0)),
            ("rests", 500, (20, 20, 20, 0)),
            ("rests", 500, (12, 0)),
            ("mixed", 60, (150, 121, 60, 130)),
            ("mixed", 60, (150, 60)),
            ("mixed", 120, (120, 121, 119, 122)),
            ("mixed", 100, (86, 177, 259, 172, 86, 0)),
            ("mixed", 100, (86, 177)),
            ("crowds", 100, (86,)),
            ("crowds", 100, (110,)),
            ("crowds", 150, (177,)),
            ("crowds", 150 if board == "mega" else 400, (120, 121, 119, 122)),
            ("crowds", 100, (400,)),
        )
    ]
    found += [
        CostProbe(f"busy {n} {hz}", hz, _turns(n - n // 12 * 2, n, own // 2, hz), all_axes)
        for n, hz in ((600, 30), (160, 100))
    ]
    found += [
        CostProbe(f"between {ppm}", 300, _constant(8, 300, 0.5), all_axes, divider=8, ppm=ppm)
        for ppm in BETWEEN_PPM
    ]
    for locked, name in ((False, "all"), (True, "locked")):
        found += [
            CostProbe(
                f"{name} {hz}", hz, _constant(6 if hz > 1000 else 20, hz, 0.3), all_axes, locked
            )
            for hz in (50, 500, 1000, *_BUSY_HZ)
        ]
    return found


def run(board: str, probe: CostProbe) -> Spent:
    """Run a probe to its end."""
    hz = Fraction(probe.hz * probe.divider)
    axes = list(range(probe.axes))
    with SimulatedBoard(board, hz * (1 + Fraction(probe.ppm, 1_000_000))) as under:
        under.set_up(
            hz, axes, bus_timeout_ms=0, sync=2 if probe.locked else 1, divider=probe.divider
        )
        under.load(dict.fromkeys(axes, probe.line))
        if probe.locked:
            under.await_clock()
        before = _decoding(under)
        under.arm()
        steps = probe.line.total_steps
        first, last = (round(share * steps) for share in _MIDDLE)
        _until(under, first)
        opened = under.simulator.stats() | {"made": under.simulator.count(0, 0)}
        under.simulator.mark()
        _until(under, last)
        seen = view(opened, under.simulator.stats() | {"made": under.simulator.count(0, 0)})
        _until(under, steps)
        under.settle()
        decode, calls = (
            (b - a) / probe.axes for a, b in zip(before, _decoding(under), strict=True)
        )
        if name := under.board.fault_name():
            raise FaultError(f"{board}, {probe.name}: {name}", name)
    entries = dict(zip(sections.SECTIONS, seen["section_entries"], strict=True))
    cycles = dict(zip(sections.SECTIONS, seen["sections"], strict=True))
    captures = sum(row["count"] for name, row in seen["handlers"].items() if "CAPT" in name)
    return Spent(
        probe,
        decode,
        calls,
        seen["steps"] / steps,
        cycles["ledger"] / probe.axes,
        entries["ledger"] / probe.axes,
        cycles["round"] + cycles["serial"],
        entries["serial"],
        captures,
        seen["cycles"],
        seen["handlers"],
    )


def _decoding(under: SimulatedBoard) -> tuple[int, int]:
    """Return the cycles of all decoding so far, and the calls."""
    seen = under.simulator.stats()["boards"][0]
    return sections.decoding(seen), sum(
        seen["section_entries"][sections.SECTIONS.index(name)] for name in sections.DECODING
    )


def _until(under: SimulatedBoard, steps: int) -> None:
    """Let time pass until the first axis has made so many steps."""
    simulator = under.simulator
    end = simulator.cycle + simulator.cycles(under.lasts_s + 1)
    while simulator.count(0, 0) < steps and simulator.cycle < end:
        simulator.run(simulator.cycles(_SLICE_S))


def run_all(board: str, chosen: Sequence[CostProbe]) -> list[Spent]:
    """Run probes one after the other; clocks that are too fast for the board are left out."""
    found, too_fast = [], False
    for probe in sorted(chosen, key=lambda one: (one.axes > 1, one.locked, one.hz)):
        busy = probe.hz in _BUSY_HZ
        if busy and too_fast:
            continue
        try:
            found.append(run(board, probe))
            too_fast = False
        except FaultError:
            if not busy:
                raise
            too_fast = True
    return found
