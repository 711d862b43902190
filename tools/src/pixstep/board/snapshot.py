# SPDX-License-Identifier: MIT
"""How a board is at one moment, and how fast its counters count between two of them.

Its pixel clock is as it has measured it: period, offset from its setting, jitter.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TypedDict

from pixstep.board import registers as regs
from pixstep.board import settings, values
from pixstep.board.device import Device, Identity
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.state import beside_set, interval_hz

_MEASURING_EDGES = 500  # of a clock that is not too bad, in which a board measures it
_POLL_EDGES, _POLL_S = 8, 0.1  # between two looks, whichever is less
_REST_S = 120.0  # the longest rest of a gated clock that is waited for
_COUNT_S, _COUNT_EDGES = 0.5, 10  # in which edges are counted; fewer tell no frequency
_OFF_LOOKS = 8  # in a row that see a clock of another frequency: it is another one


class ClockData(TypedDict):
    """A clock as plain data."""

    period_ticks: float
    period_us: float
    offset_ppm: float
    mean_jitter_us: float
    missing_edges: int
    false_edges: int


@dataclass(frozen=True)
class ClockState:
    """Figures of a clock, in timer ticks of which there are `tick_hz` a second.

    `jitter_ticks` is the mean distance of its edges from where they were expected; missing and
    false edges are counted since the board's reset.
    """

    period_ticks: float
    nominal_ticks: float
    jitter_ticks: float
    missing: int
    false: int
    tick_hz: int

    @property
    def offset_ppm(self) -> float:
        """How much higher the clock's frequency is than the board's setting."""
        return 1e6 * (self.nominal_ticks / self.period_ticks - 1)

    @property
    def period_us(self) -> float:
        """Its period in microseconds."""
        return 1e6 * self.period_ticks / self.tick_hz

    @property
    def jitter_us(self) -> float:
        """Its jitter in microseconds."""
        return 1e6 * self.jitter_ticks / self.tick_hz

    @property
    def text(self) -> str:
        """All of it in words."""
        return (
            f"period {self.period_us:.3f} us ({self.offset_ppm:+.1f} ppm), jitter "
            f"{self.jitter_us:.2f} us, {self.missing} missing, {self.false} false"
        )

    def as_json(self) -> ClockData:
        """Return plain data."""
        return {
            "period_ticks": round(self.period_ticks, 4),
            "period_us": round(self.period_us, 5),
            "offset_ppm": round(self.offset_ppm, 3),
            "mean_jitter_us": round(self.jitter_us, 3),
            "missing_edges": self.missing,
            "false_edges": self.false,
        }


def is_awaited(board: Device, inputs: Mapping[str, int]) -> bool:
    """True if a board locks lines to its pixel clock and has not measured it yet."""
    return settings.locks(settings.read(board)) and not regs.is_measured(inputs["status"])


def await_lock(board: Device, world: World) -> None:
    """Wait, if the board locks lines to its pixel clock, until it can: then it has measured it.

    Raises BoardError if it does not in a time that a steady clock needs.
    """
    known = settings.read(board)
    if settings.locks(known):
        await_measured(board, world, float(1 / values.hz_of(known)))


def await_measured(
    board: Device, world: World, clock_s: float, edges: int = _MEASURING_EDGES
) -> None:
    """Wait until a board has measured its pixel clock, whose edges are `clock_s` apart.

    The clock must run then, if it is not gated: a board knows the period of a clock that rests, but
    a line that is armed for it is given an edge's time only. Rests of a gated clock do not count.
    Raises BoardError if it has not after so many edges, or sees a clock of another frequency.
    """
    end_s, off = world.now_s() + edges * clock_s + _POLL_S, 0
    looked_s = world.now_s()
    rests_until_s, gated = looked_s + _REST_S, _gated(board)
    while not _is_known(status := board.input("status"), gated=gated):
        seen_hz = interval_hz(board.input("clock_interval"), board.tick_hz())
        off = off + 1 if seen_hz else 0
        if seen_hz and off > _OFF_LOOKS:
            raise BoardError(
                f"board {board.unit}: the pixel clock is another one: "
                f"{beside_set(seen_hz, 1 / clock_s)}"
            )
        before_s, looked_s = looked_s, world.now_s()
        if gated and not regs.flags(status)["clock"] and looked_s < rests_until_s:
            end_s += looked_s - before_s
        if looked_s > end_s:
            said = clock_beside(board, world)
            raise BoardError(f"board {board.unit}: no steady pixel clock in {edges} edges: {said}")
        world.wait(min(_POLL_S, _POLL_EDGES * clock_s))


def clock_beside(board: Device, world: World | None = None) -> str:
    """Return in words the frequency that a board sees beside the one that it is set to.

    While the board has measured none, its count of edges tells, if there is time for that.
    """
    state = board.inputs()
    seen_hz = measured_hz(read_clock(board, state), state, board.tick_hz())
    set_hz = float(board.clock_hz())
    if seen_hz is None and world:
        first, begun_s = board.input("pixel_edges"), world.now_s()
        world.wait(_COUNT_S)
        count = (board.input("pixel_edges") - first) % (1 << 32)
        seconds = world.now_s() - begun_s
        if count < _COUNT_EDGES:
            came = f"{count or 'no'} edge{'' if count <= 1 else 's'} came in {seconds:.1f} s"
            return f"{came}, {beside_set(None, set_hz)}"
        seen_hz = count / seconds
    return beside_set(seen_hz, set_hz)


def _is_known(status: int, *, gated: bool) -> bool:
    """Whether a board has measured its clock, and edges come if the clock is not gated."""
    comes = gated or regs.flags(status)["clock"]
    return comes and regs.is_measured(status)


def _gated(board: Device) -> bool:
    return settings.gate_of(settings.read(board)) != 0


def measured_hz(clock: ClockState | None, inputs: Mapping[str, int], tick_hz: int) -> float | None:
    """Return the frequency of the clock as the board sees it; None while it knows of none.

    By its measured period, or, of a clock that is another one than it is set to, by the newest
    interval between two edges.
    """
    off = interval_hz(inputs.get("clock_interval", 0), tick_hz)
    if off is None and clock is not None:
        return clock.tick_hz / clock.period_ticks
    return off


def read_clock(
    board: Device, inputs: Mapping[str, int], clock_hz: Fraction | None = None
) -> ClockState | None:
    """Return what a board has measured, by its input registers and its settings.

    None before it has seen enough edges, and of a board without the registers. The board is asked
    for the frequency that it is set to unless that is given.
    """
    measured = regs.is_measured(inputs["status"])
    if not measured or not inputs.get("clock_period_ticks"):
        return None
    tick_hz = board.tick_hz()
    return ClockState(
        inputs["clock_period_ticks"] + inputs["clock_period_fraction"] / 0x10000,
        float(tick_hz / (clock_hz or board.clock_hz())),
        inputs["clock_jitter"] / 16,
        inputs["clock_missing"],
        inputs["clock_glitches"],
        tick_hz,
    )


LINE_COUNTERS = (
    "frames_ok",
    "crc_errors",
    "exceptions",
    "rx_overruns",
    "bus_messages",
    "no_replies",
    "busy_replies",
)
_IN_LINE = ("running", "fault")
COUNTED = ("pixel_edges", *LINE_COUNTERS)


@dataclass(frozen=True)
class Snapshot:
    """The registers of a board, read at `time_s`; `trouble` if it did not answer."""

    who: Identity
    time_s: float
    inputs: dict[str, int]
    axes: list[dict[str, int]]
    trouble: str = ""
    clock: ClockState | None = None  # what it has measured of its pixel clock
    off_hz: float | None = None  # the clock's frequency, if it is another one
    set_hz: float = 0.0  # than the board is set to

    @property
    def flags(self) -> dict[str, bool]:
        """The bits of its status by name."""
        return regs.flags(self.inputs["status"])

    @property
    def shown_axes(self) -> list[dict[str, int | None]]:
        """The registers of the axes; an expected position only of a line that is not over.

        It is that at the line's last pixel edge: behind its end the axis may have got a new zero.
        """
        return [
            {**axis, "expected_steps": axis["expected_steps"] if _is_in_line(axis) else None}
            for axis in self.axes
        ]

    @property
    def fault(self) -> str:
        """Name, axis and pixel of its fault, empty if it has none."""
        code = self.inputs["fault_code"]
        if not code:
            return ""
        name = regs.code_name(regs.faults(), code)
        return (
            f"{name} (axis {self.inputs['fault_axis']}, pixel {self.inputs['fault_pixel']}, "
            f"argument {self.inputs['fault_argument']})"
        )

    @property
    def switches(self) -> str:
        """The switches that are closed or tripped, in words."""
        return regs.words(regs.register_map().input("inputs"), self.inputs["inputs"])

    def rates(self, before: "Snapshot | None") -> dict[str, float]:
        """Return how many a second each counter has counted since an earlier snapshot.

        Nothing without one to compare with, nor if a counter went back: the board was reset.
        """
        if before is None or before.trouble or self.trouble or self.time_s <= before.time_s:
            return {}
        seconds = self.time_s - before.time_s
        counted = {
            name: (self.inputs[name] - before.inputs[name]) % _modulus(name) for name in COUNTED
        }
        if any(count > _modulus(name) // 2 for name, count in counted.items()):
            return {}
        return {name: count / seconds for name, count in counted.items()}

    def as_json(self, before: "Snapshot | None" = None) -> dict[str, object]:
        """Return plain data."""
        row: dict[str, object] = {
            "unit": self.who.unit,
            "board": self.who.board,
            "time_s": self.time_s,
        }
        if self.trouble:
            return row | {"trouble": self.trouble}
        return row | {
            "status": self.flags,
            "fault": self.fault,
            "switches": self.switches,
            "pixel_edges": self.inputs["pixel_edges"],
            "edge_error_ticks": self.inputs["edge_error_ticks"],
            "pixel_clock": self.clock.as_json() if self.clock else None,
            "set_hz": self.set_hz,
            "other_clock_hz": self.off_hz,
            "counters": {name: self.inputs[name] for name in LINE_COUNTERS},
            "rates_per_s": {name: round(rate, 2) for name, rate in self.rates(before).items()},
            "axes": [
                shown | {"axis_state": regs.axis_state(axis["axis_state"])}
                for axis, shown in zip(self.axes, self.shown_axes, strict=True)
            ],
        }


def take(
    board: Device, who: Identity, time_s: float, axes: list[dict[str, int]] | None = None
) -> Snapshot:
    """Read a board, but for its axes if these are given; raises BoardError for no answer."""
    inputs, clock_hz = board.inputs(), board.clock_hz()
    return Snapshot(
        who, time_s, inputs, axes or board.axes(who.axis_count),
        clock=read_clock(board, inputs, clock_hz),
        off_hz=interval_hz(inputs.get("clock_interval", 0), board.tick_hz()),
        set_hz=float(clock_hz),
    )  # fmt: skip


def _is_in_line(axis: dict[str, int]) -> bool:
    return regs.axis_state(axis["axis_state"]) in _IN_LINE


def _modulus(name: str) -> int:
    return 1 << 16 * regs.register_map().input(name).words
