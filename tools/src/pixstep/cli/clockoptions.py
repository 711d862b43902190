# SPDX-License-Identifier: MIT
"""Options on the pixel clock: how many of its edges a pixel has, and how a simulated one strays."""

from typing import TypedDict

import click

from pixstep.board import gating
from pixstep.board import registers as regs
from pixstep.cli.options import HZ
from pixstep.cli.quantities import Decorated, FiniteRange
from pixstep.profiles.madefor import MOST_EDGES
from pixstep.simulation.clockflaws import (
    MOST_JITTER_US,
    MOST_PPM,
    MOST_REST_MS,
    ClockFlaws,
)

divider_option = click.option(
    "--divider", type=click.IntRange(1, MOST_EDGES), metavar="M", default=1, show_default=True,
    help="Edges of the pixel clock in a pixel: --pixel-hz is the frequency of the edges.",
)  # fmt: skip
sync_option = click.option(
    "--sync", type=click.Choice(list(regs.SYNCS)), default="start", show_default=True,
    help="Lines ignore the pixel clock, begin on an edge of it, or follow it to their end.",
)  # fmt: skip
board_sync_option = click.option(
    "--sync", type=click.Choice(list(regs.SYNCS)),
    help="Set what lines are to the pixel clock.  [default: the board's]",
)  # fmt: skip
gate_edges_option = click.option(
    "--gate-edges", type=click.IntRange(0, gating.MOST_EDGES), metavar="N", default=0,
    show_default=True,
    help="The pixel clock is gated: line zero is N edges behind the first one of a burst.",
)  # fmt: skip
board_gate_edges_option = click.option(
    "--gate-edges", type=click.IntRange(0, gating.MOST_EDGES), metavar="N",
    help="Set how many edges behind a burst's first one lines begin; 0: the pixel clock is not "
    "gated.  [default: the board's]",
)  # fmt: skip


def board_clock_options(command: Decorated) -> Decorated:
    """Add the options for the pixel clock that a board is set to."""
    command = click.option(
        "--divider", type=click.IntRange(1, MOST_EDGES), metavar="M",
        help="Set the clock edges of a pixel.  [default: the board's]",
    )(command)  # fmt: skip
    return click.option(
        "--pixel-hz", type=HZ,
        help="Set the frequency of the pixel clock's edges.  [default: the board's]",
    )(command)  # fmt: skip


class _Step(click.ParamType[tuple[float, int], tuple[float, int] | str]):
    """A step of the frequency: 1000@200 is 1,000 ppm more from edge 200 on."""

    name = "PPM@EDGE"

    def convert(
        self,
        value: tuple[float, int] | str,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[float, int]:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, tuple):
            return value
        ppm, _, edge = value.partition("@")
        try:
            step = float(ppm), int(edge)
        except ValueError:
            self.fail(f"{value!r}: expected PPM@EDGE, as 1000@200", param, ctx)
        if not (abs(step[0]) <= MOST_PPM and step[1] >= 1):
            self.fail(f"{value!r}: at most {MOST_PPM} ppm, from edge 1 on", param, ctx)
        return step


class _Gate(click.ParamType[tuple[int, float], tuple[int, float] | str]):
    """A gate: 512,20 is 512 edges, then a rest of 20 ms, and so on."""

    name = "EDGES,REST_MS"

    def convert(
        self,
        value: tuple[int, float] | str,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[int, float]:
        """Parse the text; a bad one is a usage error."""
        if isinstance(value, tuple):
            return value
        edges, _, rest_ms = value.partition(",")
        try:
            gate = int(edges), float(rest_ms)
        except ValueError:
            self.fail(f"{value!r}: expected EDGES,REST_MS, as 512,20", param, ctx)
        if not (1 <= gate[0] < 1 << 32 and 0 <= gate[1] <= MOST_REST_MS):
            self.fail(
                f"{value!r}: an edge at least, a rest of {MOST_REST_MS} ms at most", param, ctx
            )
        return gate


gate_option = click.option(
    "--pixel-gate", type=_Gate(),
    help="The clock rests after so many edges, for so long besides the period, and so on.",
)  # fmt: skip


class FlawOptions(TypedDict):
    """What the options of `clock_flaw_options` give."""

    pixel_ppm: float
    pixel_jitter_us: float
    pixel_wander_ppm: float
    pixel_step_ppm: tuple[float, int] | None
    pixel_drop: int | None
    pixel_double: int | None
    pixel_gate: tuple[int, float] | None


def clock_flaw_options(command: Decorated) -> Decorated:
    """Add the options for what is wrong with a simulated pixel clock, its frequency first."""
    command = gate_option(command)
    for name, kind, default, text in (
        ("--pixel-double", click.IntRange(1), None, "One clock edge of so many is doubled."),
        ("--pixel-drop", click.IntRange(2), None, "One clock edge of so many is missing."),
        ("--pixel-step-ppm", _Step(), None, "The frequency rises from a clock edge on."),
        ("--pixel-wander-ppm", FiniteRange(0, MOST_PPM), 0.0,
         "The frequency swings so far to either side, once in 1,000 edges."),
        ("--pixel-jitter-us", FiniteRange(0, MOST_JITTER_US), 0.0,
         "Standard deviation of each clock edge."),
        ("--pixel-ppm", FiniteRange(-MOST_PPM, MOST_PPM), 0.0,
         "Frequency error of the pixel clock."),
    ):  # fmt: skip
        command = click.option(name, type=kind, default=default, help=text)(command)
    return command


def clock_flaws(options: FlawOptions) -> ClockFlaws:
    """Return what was asked for."""
    step_ppm, step_edge = options["pixel_step_ppm"] or (0.0, 0)
    gate_edges, gate_rest_ms = options["pixel_gate"] or (0, 0.0)
    return ClockFlaws(
        jitter_us=options["pixel_jitter_us"],
        wander_ppm=options["pixel_wander_ppm"],
        step_ppm=step_ppm,
        step_edge=step_edge,
        drop=options["pixel_drop"] or 0,
        double=options["pixel_double"] or 0,
        gate_edges=gate_edges,
        gate_rest_ms=gate_rest_ms,
    )
