# SPDX-License-Identifier: MIT
"""The outputs of a run: pixels.csv, summary.json and the page a person reads."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Protocol, TypedDict

from pixstep import atomic
from pixstep.errors import FINE, NEGATIVE, REFUSED
from pixstep.lazy import rich
from pixstep.lines import units
from pixstep.simulation import clock_judge
from pixstep.simulation.summary import Load, Summary

NARROWEST, WIDE = 80, 120  # columns of a page, and of one with sentences in its tables
PIXELS_HEADER = "board,axis,pixel,edge_cycle,expected_steps,actual_steps"


@dataclass(frozen=True)
class PixelRow:
    """One row of pixels.csv; a value that the run did not give is None."""

    board: int
    axis: int
    pixel: int
    edge_cycle: int | None
    expected_steps: int | None
    actual_steps: int | None
    load_steps: int | None = None  # only of an axis with a plant

    def text(self, *, loads: bool = False) -> str:
        """Return the row, with the load's column if asked; an unknown value is empty."""
        values = astuple(self)[: None if loads else -1]
        return ",".join("" if value is None else str(value) for value in values)


def write_pixels(path: Path, rows: list[PixelRow]) -> None:
    """Write pixels.csv; with the column load_steps if any axis has a plant."""
    loads = any(row.load_steps is not None for row in rows)
    header = f"{PIXELS_HEADER},load_steps" if loads else PIXELS_HEADER
    atomic.write_text(path, "\n".join([header, *(row.text(loads=loads) for row in rows)]) + "\n")


def exit_status(verdict: str) -> int:
    """Return the exit status of a verdict: pass, fail, or a line that the board refused."""
    return {"pass": FINE, "refused": REFUSED}.get(verdict, NEGATIVE)


class Printer(Protocol):
    """Where a page is printed: rich's console, or what prints as it does."""

    def print(
        self, what: Any, /, *, style: str | None = None, markup: bool | None = None,
        highlight: bool | None = None, soft_wrap: bool | None = None,
    ) -> None:  # fmt: skip
        """Print something."""


class JudgedSummary(TypedDict):
    """A summary that has a verdict."""

    verdict: str
    reasons: list[str]


def print_verdict(console: Printer, summary: JudgedSummary, about: str) -> None:
    """Print the verdict of a run, what was run, and what is wrong."""
    colour = "bold green" if summary["verdict"] == "pass" else "bold red"
    console.print(f"[{colour}]{summary['verdict'].upper()}[/]  {about}")
    for reason in summary["reasons"]:
        console.print(f"  {reason}", style="red", markup=False, highlight=False, soft_wrap=True)


def print_page(console: Printer, summary: Summary, *, details: bool = False) -> None:
    """Print the verdict of a run, with `details` the figures of every interrupt too."""
    print_verdict(console, summary, _headline(summary))
    if summary["refusal"]:
        return
    console.print(_axes_table(summary))
    if details and summary["handlers"]:
        console.print(_handlers_table(summary))
    console.print(_footer(summary), highlight=False, soft_wrap=True)


def print_files(console: Printer, out: Path) -> None:
    """Print where the results of a run are, relative to the current folder if below it."""
    folder = out.resolve()
    if folder.is_relative_to(Path.cwd()):
        folder = folder.relative_to(Path.cwd())
    shown = (path.name for path in out.iterdir() if path.is_file() and path.name[0] != ".")
    names = ", ".join(sorted(shown))
    console.print(f"files in {folder}: {names}", markup=False, highlight=False, soft_wrap=True)


def _headline(summary: Summary) -> str:
    parts = [f"{summary['board']}, {summary['decode']} decoding, {summary['pixel_hz']} Hz"]
    parts += clock_judge.parts(summary)
    if summary["record_every"] > 1:
        parts.append(f"records of every {summary['record_every']} pixels")
    if summary["serial_load"]:
        parts.append(f"serial line saturated ({summary['requests'].get('load', 0)} requests)")
    if summary["requests"].get("without_reply"):
        parts.append(f"{summary['requests']['without_reply']} requests without a reply, repeated")
    return ", ".join(parts)


def _axes_table(summary: Summary) -> rich.table.Table:
    edges = _edges_meaning(summary)
    table = new_table(
        "axis", "steps", "max ticks", "rms ns", "ppm", *(("on edge",) if edges else ()),
        "positions", "late",
    )  # fmt: skip
    for axis in summary["axes"]:
        ends = axis["last_steps_on_edge"] + axis["last_steps_off_edge"]
        made, wanted = axis["steps"], axis["expected_steps"]  # a long move's line stays short
        table.add_row(
            str(axis["axis"]), str(made) if made == wanted else f"{made}/{wanted}",
            units.ticks_text(axis["max_edge_error_ticks"]),
            f"{1000 * axis['rms_edge_error_us']:.1f}",
            f"{axis['rate_error_ppm']:.3f}",
            *((f"{axis['last_steps_on_edge']}/{ends}",) if edges else ()),
            f"{axis['pixels_equal']}/{axis['pixels']}", str(axis["underruns"]),
        )  # fmt: skip
    table.caption = (
        f"edge minus exact instant (max, rms), rate error, {edges}pixels whose expected and "
        f"counted positions equal the reference, underruns"
    )
    table.caption_justify = "left"
    return table


def _edges_meaning(summary: Summary) -> str:
    """Return what it is for a last step to be on its pixel's edge; empty where nothing is.

    A locked line on a clock with jitter, wander or a step ends its pixels where the board expects
    the edges, which is not where they are: how far off is told in figures instead.
    """
    if summary["clock"]["sync"] != "lock":
        return "last steps of pixels on their edge, "
    if not clock_judge.even(summary):
        return ""
    return f"last steps of pixels within {clock_judge.EDGE_TICKS} ticks of the clock's true edge, "


def _handlers_table(summary: Summary) -> rich.table.Table:
    table = new_table("interrupt", "count", "min", "mean", "max cycles", "latest start")
    table.columns[0].justify = "left"
    for row in summary["handlers"]:
        table.add_row(
            row["name"], str(row["count"]), str(row["cycles_min"]), f"{row['cycles_mean']:.1f}",
            str(row["cycles_max"]), str(row["latency_max"]),
        )  # fmt: skip
    return table


def new_console(*, narrowest: int = NARROWEST, **options: Any) -> rich.console.Console:
    """Return where a page is printed: wide enough for its tables, whatever the terminal is.

    A narrow terminal breaks long lines, but a table made to fit it would lose figures.
    """
    console = rich.console.Console(highlight=False, **options)
    console.width = max(console.width, narrowest)
    return console


def new_table(*names: str) -> rich.table.Table:
    """Return a table with right-aligned columns, in the style of every page."""
    table = rich.table.Table(box=rich.box.SIMPLE_HEAD, pad_edge=False)
    for name in names:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def _footer(summary: Summary) -> str:
    lines = [_load_text(axis["axis"], axis["load"]) for axis in summary["axes"] if "load" in axis]
    if clock_judge.parts(summary):
        lines += clock_judge.texts(summary)
    if summary.get("clock_edge_cycle") is not None:
        periods = summary.get("line_zero_periods", 1)
        text = "one pixel period" if periods == 1 else f"{periods} periods of the clock"
        lines.append(
            f"line zero at cycle {summary['line_zero_cycle']}, {text} after the "
            f"clock edge at {summary['clock_edge_cycle']}"
        )
    cpu, interrupts = summary["cpu_share"], summary["interrupt_share"]
    if cpu is not None and interrupts is not None:
        lines.append(
            f"CPU share {100 * cpu:.1f} % while moving: {100 * interrupts:.1f} % interrupts, "
            "the rest decoding and following\n"
            f"stack free {summary['stack_free_bytes']} bytes; simulated "
            f"{summary['realtime_factor']:.2f} times as fast as real time"
        )
    return "\n".join(lines)


def _load_text(axis: int, load: Load) -> str:
    """Return one line on the largest load errors of an axis."""
    worst, pixel = load["max_load_error_steps"], load["max_load_error_pixel"]
    text = f"axis {axis}: load at most {abs(worst)} steps off at a pixel edge"
    text += f" (pixel {pixel})" if pixel else ""
    if load["transitions"]:
        outside, where = load["max_load_error_outside_steps"], load["max_load_error_outside_pixel"]
        text += f", away from the transitions {abs(outside)}" + (
            f" (pixel {where})" if where else ""
        )
    return text
