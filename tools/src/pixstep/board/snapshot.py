# SPDX-License-Identifier: MIT
"""How a board is at one moment, and how fast its counters count between two of them."""

from dataclasses import dataclass

from pixstep.board import clock_hz, clockstate
from pixstep.board import registers as regs
from pixstep.board.clockstate import ClockState
from pixstep.board.device import Board, Identity

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


def take(board: Board, who: Identity, time_s: float) -> Snapshot:
    """Read a board; raises BoardError if it does not answer."""
    inputs = board.inputs()
    return Snapshot(
        who, time_s, inputs, board.axes(who.axis_count), clock=clockstate.read(board, inputs),
        off_hz=clock_hz.interval_hz(inputs.get("clock_interval", 0), board.tick_hz()),
        set_hz=float(board.clock_hz()),
    )  # fmt: skip


def _is_in_line(axis: dict[str, int]) -> bool:
    return regs.axis_state(axis["axis_state"]) in _IN_LINE


def _modulus(name: str) -> int:
    return 1 << 16 * regs.register_map().input(name).words
