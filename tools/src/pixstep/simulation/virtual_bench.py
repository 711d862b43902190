# SPDX-License-Identifier: MIT
"""A simulated board on a pseudo terminal, in real time, and the hands that work its wires.

The simulator keeps the time: it passes only in `wait`, which takes as long as on a board. What is
done between two waits happens in the same cycle, so a script gives the same cycles every time.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Self, TypedDict

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import PlainError
from pixstep.lines.units import hz_text
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.simulator import SimOptions, Simulator

SIGNALS = {"home": "HOME", "minus": "LIMIT_MINUS", "plus": "LIMIT_PLUS"}
START_S = 0.3  # what is sent to a board while it starts is lost
SLICE_S = 0.05  # of a wait: how often someone may look
REST_S = 0.1  # an axis without an edge for so long is at rest
_CLOCK_WIRE = ("--clock-wire", "0:0")
_PARAMETER_OF = {"home": "home", "minus": "travel", "plus": "travel"}


class NotInTimeError(PlainError):
    """What a script waits for has not come."""


@dataclass
class AxisWiring:
    """The switches of an axis: worked by hand, and those of its mechanics."""

    parameters: set[str] = field(default_factory=set)  # of its mechanics, that were given
    active_high: bool = False

    def has(self, switch: str) -> bool:
        """True if the switch is one of the mechanics: it follows the load."""
        return _PARAMETER_OF[switch] in self.parameters

    def closed_level(self, switch: str) -> int:
        """Return the level of the switch's pin when it is closed."""
        return int(self.has(switch) and self.active_high)


@dataclass
class Wiring:
    """What is connected to the board now."""

    clock_hz: Fraction
    clock_ppm: float = 0.0
    clock_runs: bool = True
    clock_wire: bool = False
    powered: bool = True
    estop_pressed: bool = False
    axes: list[AxisWiring] = field(default_factory=list)


class ClockStatus(TypedDict):
    """The pixel clock that is connected; `own`: it is the board's, by a wire, and no other."""

    hz: float
    ppm: float
    runs: bool
    own: bool


class AxisStatus(TypedDict):
    """What can be seen of an axis."""

    steps: int
    edges: int
    load_steps: int
    closed: list[str]


class BenchStatus(TypedDict):
    """What can be seen of a bench from outside."""

    time_s: float
    cycle: int
    port: str
    board: str
    powered: bool
    estop_pressed: bool
    permit: int
    clock: ClockStatus
    lost_s: float
    axes: list[AxisStatus]


class VirtualBench:
    """One simulated board behind a pseudo terminal; use as a context manager.

    `look` is called several times a second of every wait.
    """

    def __init__(self, options: SimOptions, look: Callable[[], None] = lambda: None) -> None:
        self.name = options.boards[0][0]
        self.kind = boards.load(self.name)
        self.look = look
        self.ended = False
        axes = [AxisWiring() for _ in range(self.kind.axes)]
        self.wiring = Wiring(
            options.pixel_hz, options.pixel_ppm, clock_wire=_CLOCK_WIRE[0] in options.extra,
            axes=axes,
        )  # fmt: skip
        self._pins = {(pin.signal, pin.axis): pin for pin in self.kind.pins}
        self.simulator = Simulator(options)
        try:
            self.simulator.wait_s(START_S)
            self.port = self.simulator.command("pty").split()[1]
        except BaseException:
            self.simulator.kill()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.simulator.kill()

    @property
    def time_s(self) -> float:
        """Simulated time since the start."""
        return self.simulator.cycle / self.simulator.tick_hz

    @property
    def lost_s(self) -> float:
        """Time by which the bench has fallen behind real time."""
        return int(self.simulator.command("lost").split()[1]) / self.simulator.tick_hz

    def wait(self, seconds: float) -> None:
        """Let the board run for so long."""
        end = self.simulator.cycle + self.simulator.cycles(seconds)
        most = self.simulator.cycles(SLICE_S)
        while self.simulator.cycle < end:
            self.simulator.run(min(most, end - self.simulator.cycle))
            self.look()

    def wait_until(self, holds: Callable[[], bool], limit_s: float, what: str) -> None:
        """Let the board run until something holds. Raises NotInTimeError."""
        end = self.simulator.cycle + self.simulator.cycles(limit_s)
        while not holds():
            if self.simulator.cycle >= end:
                raise NotInTimeError(f"{what}: not within {limit_s:g} s")
            self.wait(SLICE_S / 10)

    def edges(self, axis: int) -> int:
        """Return the STEP edges that an axis has made since the start."""
        return self.simulator.count(0, axis)

    def permit(self) -> int:
        """Return the level of the permit output."""
        return self.simulator.permit(0).level

    def turn_switch(self, switch: str, axis: int, *, closed: bool) -> None:
        """Press or release a switch; one of the axis' mechanics goes back to following the load."""
        if self.wiring.axes[axis].has(switch):
            self.simulator.knobs(0, axis, f"stuck={switch}:{'closed' if closed else 'free'}")
        else:
            self._drive(SIGNALS[switch], axis, closed=closed)

    def turn_estop(self, *, pressed: bool) -> None:
        """Press or release the emergency stop."""
        self._drive("ESTOP", 0, closed=pressed)
        self.wiring.estop_pressed = pressed

    def set_clock_hz(self, hz: Fraction) -> None:
        """Give the pixel clock another frequency; it runs then."""
        self.simulator.command(f"clock hz {hz_text(hz)}")
        self.wiring.clock_hz = hz
        self.run_clock(True)

    def set_clock_ppm(self, ppm: float) -> None:
        """Let the pixel clock be wrong by so much."""
        self.simulator.command(f"clock ppm {ppm!r}")
        self.wiring.clock_ppm = ppm

    def run_clock(self, runs: bool) -> None:
        """Start or stop the pixel clock."""
        self.simulator.command(f"clock {'on' if runs else 'off'}")
        self.wiring.clock_runs = runs

    def set_load(self, axis: int, parameters: str) -> None:
        """Change the mechanics of an axis, in the words of the simulator's --plant."""
        self.simulator.knobs(0, axis, parameters)
        given = dict(word.partition("=")[::2] for word in parameters.split(","))
        wiring = self.wiring.axes[axis]
        wiring.parameters |= given.keys()
        wiring.active_high = given.get("active", "") == "high" or (
            wiring.active_high and "active" not in given
        )

    def switch_supply(self, *, powered: bool) -> None:
        """Cut the board's 5 V, or give them back."""
        self.simulator.supply(0, "on" if powered else "off")
        self.wiring.powered = powered

    def status(self) -> BenchStatus:
        """Return what can be seen from outside, as plain data."""
        wiring = self.wiring
        return {
            "time_s": self.time_s,
            "cycle": self.simulator.cycle,
            "port": self.port,
            "board": self.name,
            "powered": wiring.powered,
            "estop_pressed": wiring.estop_pressed,
            "permit": self.permit(),
            "clock": {
                "hz": float(wiring.clock_hz), "ppm": wiring.clock_ppm, "runs": wiring.clock_runs,
                "own": wiring.clock_wire,
            },
            "lost_s": self.lost_s,
            "axes": [self._axis_status(axis) for axis in range(self.kind.axes)],
        }  # fmt: skip

    def _axis_status(self, axis: int) -> AxisStatus:
        levels = self.simulator.command(f"switches 0 {axis}").split()[2::2]
        wiring = self.wiring.axes[axis]
        closed = [
            switch
            for switch, level in zip(SIGNALS, levels, strict=False)
            if wired(self.kind, switch, axis) and int(level) == wiring.closed_level(switch)
        ]
        return {
            "steps": self.simulator.steps(0, axis),
            "edges": self.edges(axis),
            "load_steps": self.simulator.plant(0, axis)[1],
            "closed": closed,
        }

    def _drive(self, signal: str, axis: int, *, closed: bool) -> None:
        """Connect an input to ground as a contact does, or leave it to its pull-up."""
        pin = self._pins[signal, axis]
        self.simulator.pin(0, pin.port, pin.bit, 0 if closed else 1)


def wired(kind: boards.BoardKind, switch: str, axis: int) -> bool:
    """True if the board has an input for this switch."""
    return any((pin.signal, pin.axis) == (SIGNALS[switch], axis) for pin in kind.pins)


def options(
    name: str, pixel_hz: Fraction, *, image: Path | None = None, seed: int = 1,
    gate: tuple[int, float] | None = None, wired: bool = False,
) -> SimOptions:  # fmt: skip
    """Return the options of a bench; `gate` is edges and the rest after them in ms.

    `wired`: a wire from the board's CLOCK_OUT is its only clock.

    Raises UserError if simulator or image is not there.
    """
    natives.program("pixstep-sim")
    flaws = ClockFlaws(0.0, 0.0, 0.0, 0, 0, 0, *(gate or ()))
    return SimOptions(
        [(name, image or natives.image(name))],
        pixel_hz,
        flaws=flaws,
        seed=seed,
        extra=_CLOCK_WIRE if wired else (),
    )
