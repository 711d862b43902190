# SPDX-License-Identifier: MIT
"""Fields on the pixel clock: what a board is set to, and how a simulated clock strays."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar

from pixstep import arguments
from pixstep.board import settings
from pixstep.board.device import Device
from pixstep.errors import UserError
from pixstep.lines.units import hz_words
from pixstep.operations import shared
from pixstep.operations.asked import AskedError, MissingError
from pixstep.operations.desk import Source
from pixstep.operations.kinds import Number, Parsed, Whole
from pixstep.operations.request import Request, fields, option, shared_fields
from pixstep.simulation.pixel_clock import MOST_JITTER_US, MOST_PPM, MOST_REST_MS, ClockFlaws

_THE_BOARDS = "the board's"


@shared_fields
class OfClock(Request):
    """The pixel clock, by its edges or by the pixels of which each has `divider` edges.

    Each frequency follows from the other; without any both are None, or one is missing.
    """

    needs_clock: ClassVar[bool] = True

    clock_hz: Fraction | None = shared.clock_hz()
    pixel_hz: Fraction | None = shared.hz_of_pixels()
    divider: int | None = shared.divider(default=1)

    @classmethod
    def complete(cls, values: dict[str, Any], sources: dict[str, Source]) -> None:
        """Find the frequency that follows from the other."""
        clock_hz, pixel_hz, edges = (values[name] for name in ("clock_hz", "pixel_hz", "divider"))
        if pixel_hz is not None:
            values["divider"] = edges = edges or 1
            if sources["clock_hz"] is Source.CALLER and clock_hz != pixel_hz * edges:
                raise AskedError(
                    "{clock_hz} {clock} and {pixel_hz} {pixel}: pixels of {edges} are {follows}",
                    clock=hz_words(clock_hz), pixel=hz_words(pixel_hz),
                    edges="1 clock edge" if edges == 1 else f"{edges} clock edges",
                    follows=hz_words(clock_hz / edges),
                )  # fmt: skip
            values["clock_hz"], sources["clock_hz"] = pixel_hz * edges, Source.DEFAULT
        elif clock_hz is not None:
            values["pixel_hz"] = clock_hz / (edges or 1)
            sources["pixel_hz"] = sources["clock_hz"]
        elif cls.needs_clock:
            raise MissingError(fields(cls)["pixel_hz"])

    @property
    def edges_hz(self) -> Fraction:
        """The frequency of the clock's edges, of a request that needs it."""
        assert self.clock_hz is not None
        return self.clock_hz

    @property
    def line_hz(self) -> Fraction:
        """The frequency of pixels, of a request that needs it."""
        assert self.pixel_hz is not None
        return self.pixel_hz

    @property
    def edges(self) -> int:
        """The clock edges of a pixel."""
        return self.divider or 1


def refuse_both(values: Mapping[str, Any], sources: Mapping[str, Source]) -> None:
    """Refuse both frequencies of a caller, where what a pixel has of the clock is not known yet."""
    if Source.CALLER is sources["clock_hz"] is sources["pixel_hz"]:
        raise AskedError("{clock_hz} and {pixel_hz}: one of them says the other")


@shared_fields
class BoardClock(Request):
    """The pixel clock that a board is set to before something moves."""

    clock_hz: Fraction | None = shared.clock_hz(
        "Set the frequency of the pixel clock's edges.", default_text=_THE_BOARDS
    )
    pixel_hz: Fraction | None = shared.hz_of_pixels(
        "Set that frequency by the frequency of pixels.", default_text=_THE_BOARDS
    )
    divider: int | None = shared.divider(
        "Set the clock edges of a pixel.", default_text=_THE_BOARDS
    )

    @classmethod
    def complete(cls, values: dict[str, Any], sources: dict[str, Source]) -> None:
        """Refuse two frequencies: the board may have another divider."""
        refuse_both(values, sources)

    def edges_hz(self, board: Device) -> Fraction | None:
        """Return the frequency of edges that the board is to be set to; None leaves its own."""
        if self.pixel_hz is None:
            return self.clock_hz
        return self.pixel_hz * (self.divider or settings.divider(board))


@shared_fields
class BoardLineClock(BoardClock):
    """The same, and what lines are to the clock."""

    sync: str | None = shared.sync(
        "Set how lines follow the pixel clock.", default=None, default_text=_THE_BOARDS
    )
    gate_edges: int | None = shared.gate_edges(
        "Set how many edges after a burst's first edge lines begin; 0: the pixel clock is not "
        "gated.",
        default=None, default_text=_THE_BOARDS,
    )  # fmt: skip
    clock_out_hz: int | None = shared.clock_out_hz()

    def set_clock(self, board: Device) -> None:
        """Set what is given of the board's clock."""
        settings.set_clock(
            board, self.edges_hz(board), self.sync, self.divider, self.gate_edges,
            self.clock_out_hz,
        )  # fmt: skip


class _Pair(Parsed):
    """Two numbers, as one text or as a pair of Python's."""

    def __init__(self, name: str, between: str, reader: Any, python: str):
        super().__init__(name, reader, f"str | {python}")
        self.between = between

    def judge(self, value: Any) -> Any:
        """Return two numbers that Python has."""
        several = value if isinstance(value, (tuple, list)) else (value,)
        return self.parse(self.between.join(map(arguments.shown, several)))


def _step(text: str) -> tuple[float, int]:
    """Return a step of the frequency: 1000@200 is 1,000 ppm more from edge 200 on."""
    ppm, _, edge = text.partition("@")
    try:
        step = float(ppm), int(edge)
    except ValueError:
        raise UserError(f"{text!r}: expected PPM@EDGE, as 1000@200") from None
    if not (abs(step[0]) <= MOST_PPM and step[1] >= 1):
        raise UserError(f"{text!r}: at most {MOST_PPM} ppm, from edge 1 on")
    return step


def _gate(text: str) -> tuple[int, float]:
    """Return a gate: 512,20 is 512 edges, then a rest of 20 ms, and so on."""
    edges, _, rest_ms = text.partition(",")
    try:
        gate = int(edges), float(rest_ms)
    except ValueError:
        raise UserError(f"{text!r}: expected EDGES,REST_MS, as 512,20") from None
    if not (1 <= gate[0] < 1 << 32 and 0 <= gate[1] <= MOST_REST_MS):
        raise UserError(f"{text!r}: an edge at least, a rest of {MOST_REST_MS} ms at most")
    return gate


def pixel_gate() -> Any:
    """Return the field of the gate of a simulated pixel clock."""
    return option(
        _Pair("EDGES,REST_MS", ",", _gate, "tuple[int, float]"),
        "The clock rests after each EDGES edges, for REST_MS more than the period.",
    )


@shared_fields
class FlawFields(Request):
    """What is wrong with a simulated pixel clock."""

    pixel_ppm: float = option(
        Number(-MOST_PPM, MOST_PPM), "Frequency error of the pixel clock.", default=0.0
    )
    pixel_jitter_us: float = option(
        Number(0, MOST_JITTER_US), "Standard deviation of each clock edge.", default=0.0
    )
    pixel_wander_ppm: float = option(
        Number(0, MOST_PPM), "The frequency swings by this to either side, once in 1,000 edges.",
        default=0.0,
    )  # fmt: skip
    pixel_step_ppm: tuple[float, int] | None = option(
        _Pair("PPM@EDGE", "@", _step, "tuple[float, int]"),
        "The frequency rises from a clock edge on.",
    )
    pixel_drop: int | None = option(Whole(2), "One clock edge in N is missing.")
    pixel_double: int | None = option(Whole(1), "One clock edge in N is doubled.")
    pixel_gate: tuple[int, float] | None = pixel_gate()

    @property
    def flaws(self) -> ClockFlaws:
        """What is wrong besides the frequency."""
        step_ppm, step_edge = self.pixel_step_ppm or (0.0, 0)
        gate_edges, gate_rest_ms = self.pixel_gate or (0, 0.0)
        return ClockFlaws(
            jitter_us=self.pixel_jitter_us,
            wander_ppm=self.pixel_wander_ppm,
            step_ppm=step_ppm,
            step_edge=step_edge,
            drop=self.pixel_drop or 0,
            double=self.pixel_double or 0,
            gate_edges=gate_edges,
            gate_rest_ms=gate_rest_ms,
        )
