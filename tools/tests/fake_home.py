# SPDX-License-Identifier: MIT
"""A test double of a board with one axis, a load and its switches, for homing without a simulator.

It stands where `Device` does, below its names. A line is worked out when it is armed; the double is
its world too, and time passes by `wait`. The rules of a seek line are those of the protocol: the
filtered switch skips the runs up to the mark DOWN, then those not slower than the pixel decoded
last (a smooth one's end), which lies up to 8 ms and the rest of a pixel ahead of the switch.
"""

from dataclasses import dataclass, field
from math import ceil, sqrt

from clock import TICK_HZ
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.state import TRIP_ALREADY, TRIP_CLOSED, TRIP_NONE, TRIP_OPENED, Trip
from pixstep.lines import runs

FILTER_S = 0.001
AHEAD_S = 0.008


@dataclass
class Plant:
    """A load that moves with the motor; the home switch is closed from `home` upwards."""

    start: int = 0
    home: int = 2000
    hysteresis: int = 8
    travel: tuple[int, int] = (-500, 4000)
    delay_s: float = 0.0
    stuck: bool | None = None
    load: int = field(init=False)
    closed: bool = field(init=False)

    def __post_init__(self):
        self.load = self.start
        self.closed = self.load >= self.home
        self.step(0)

    def step(self, direction):
        self.load += direction
        edge = self.home - self.hysteresis if self.closed else self.home - 1
        self.closed = self.load > edge if self.stuck is None else self.stuck

    def limits(self):
        return self.load <= self.travel[0], self.load >= self.travel[1]


class FakeHome(Device):
    """The board and its world."""

    def __init__(self, plant, hz=300, queue=32):
        super().__init__(None)
        self.plant, self.hz, self.queue = plant, hz, queue
        self.time, self.position, self.entries, self.block = 0.0, 0, [], 0
        self.end_s, self.final, self.pixels = 0.0, "empty", 0
        self.fault = self.code = self.trip_position = self.trip_ticks = 0
        self.moves = []  # the counts of every line as made
        self.marks = []  # their start marks
        self.steps = []  # (cycle, direction) of every STEP edge
        self.switch_edges = []  # (cycle, 1 closed) of the home switch

    def now_s(self):
        return self.time

    def wait(self, seconds):
        self.time += seconds

    def axis(self, axis):
        state = self.final if self.time >= self.end_s else "running"
        return {
            "axis_state": regs.AXIS_STATES.index(state),
            "queue_free": self.queue - len(self.entries),
            "next_block": self.block,
            "position_steps": self.position,
            "pixel": self.pixels,
            "lines_done": 0,
        }

    def axes(self, count):
        return [self.axis(axis) for axis in range(count)]

    def inputs(self):
        minus, plus = self.plant.limits()
        return {
            "inputs": self.plant.closed | minus << 1 | plus << 2,
        }

    def trip(self):
        return Trip(self.code, 0, self.trip_position, self.trip_ticks)

    def input(self, name):
        return self.inputs()[name]

    def fault_name(self):
        return {0: "", 8: "limit_minus", 9: "limit_plus", 10: "home_not_found", 11: "home_stuck"}[
            self.fault
        ]

    def packs(self):
        return False

    def write_block(self, axis, block, entries):
        assert (axis, block) == (0, self.block) and len(entries) <= self.queue
        self.entries += entries
        self.block += 1

    def command(self, name, axes, _argument=0):
        if name == "zero":
            assert self.code
            self.position -= self.trip_position
        elif name == "arm":
            assert not self.fault
            entries, self.entries = self.entries, []
            self.run(entries)

    def run(self, entries):
        """Work out a line: its end, its state, where it leaves the load."""
        (mark, _), _, *body, end = entries
        assert end == (runs.MARK_END, 0)
        seeks = bool(mark & runs.MARK_SEEK)
        wanted = not mark & runs.MARK_SEEK_OPEN
        self.pixels, self.final, counts = 0, "done", []
        if seeks:
            self.code = TRIP_NONE
        if seeks and self.plant.closed == wanted:
            self.code, body = TRIP_ALREADY, []
        line = _Line(body, mark)
        edge_s = None
        while (count := line.following(edge_s, self.time + self.pixels / self.hz)) is not None:
            counts.append(count)
            edge_s = self.pixel(count, line.shares, wanted if seeks else None, edge_s)
            if self.final == "fault":
                self.pixels += 1
                break
        self.moves.append(counts)
        self.marks.append(mark)
        assert line.speed == 0 or self.final == "fault", "a smooth line ran dry"
        self.end_s = self.time + self.pixels / self.hz
        if seeks and body and edge_s is None and self.final == "done":
            self.fault = 10 if wanted else 11  # at rest, in state done

    def pixel(self, count, shares, wanted, edge_s):
        """Make the steps of a pixel; return when the sought edge came, None if not yet."""
        begin = self.time + self.pixels / self.hz
        sign = 1 if count > 0 else -1
        for share in shares:
            when = begin + share / self.hz
            was = self.plant.closed
            self.plant.step(sign)
            self.position += sign
            self.steps.append((ceil(when * TICK_HZ), sign))
            if self.plant.closed != was:
                contact_s = when + self.plant.delay_s
                self.switch_edges.append((ceil(contact_s * TICK_HZ), int(self.plant.closed)))
            if wanted is not None and edge_s is None and self.plant.closed == wanted:
                edge_s = when + self.plant.delay_s
                self.trip_position = self.position  # and the steps made during the delay
                self.trip_ticks = ceil(edge_s * TICK_HZ)
                self.code = TRIP_CLOSED if wanted else TRIP_OPENED
            elif edge_s is not None and when <= edge_s:
                self.trip_position = self.position
            if self.plant.limits()[sign > 0]:
                self.final, self.fault = "fault", 9 if sign > 0 else 8
                return edge_s
        self.pixels += 1
        return edge_s


class _Line:
    """The counts of a line one by one, cut short by a switch."""

    def __init__(self, body, mark):
        self.smooth = bool(mark & runs.MARK_SMOOTH)
        self.sign = -1 if mark & runs.MARK_NEGATIVE else 1
        down = body.index((runs.MARK_DOWN, 0)) if (runs.MARK_DOWN, 0) in body else len(body)
        self.rising = runs.decode(body[:down])
        self.falling = runs.decode(body[down + 1 :])
        self.last = self.speed = 0  # of the last pixel: its count, a smooth one's speed at its end
        self.shares = []

    def following(self, edge_s, now_s):
        """Return the signed count decoded for the pixel that begins now, None at the end."""
        if edge_s is not None and edge_s + FILTER_S <= now_s - AHEAD_S and self.rising:
            self.rising = []
            speed = self.speed if self.smooth else abs(self.last)
            while self.falling and abs(self.falling[0]) >= speed:
                del self.falling[0]
        source = self.rising or self.falling
        if not source:
            return None
        self.last = source.pop(0)
        self.shares = self._shares()
        return self.sign * self.last

    def _shares(self):
        """Return which share of the pixel has passed at each step."""
        count = abs(self.last)
        if not self.smooth:
            return [step / count for step in range(1, count + 1)]
        before, self.speed = self.speed, 2 * count - self.speed
        assert self.speed >= 0, "a smooth line reversed"
        gained = 2 * (self.speed - before)
        return [
            2 * step / (before + sqrt(max(0, before * before + gained * step)))
            for step in range(1, count + 1)
        ]
