# SPDX-License-Identifier: MIT
"""What the cycles of a view went into: handlers, decoding, following, looking for work."""

from typing import Any

from pixstep.board import boards

# enum cpu_section of firmware/hal/cpu.h, in order.
SECTIONS = ("start", "smooth", "plain", "ledger", "serial", "round", "interlude")
DECODING = ("smooth", "plain")
_PASS = "serial"  # entered once in every pass of the main loop, and after
_INSIDE = "interlude"


def decoding(view: dict[str, Any]) -> int:
    """Return the cycles of decoding in a view, interrupts excluded."""
    return sum(view["sections"][SECTIONS.index(name)] for name in DECODING)


def following(view: dict[str, Any]) -> int:
    """Return the cycles of following the step interrupts, interrupts excluded."""
    return int(view["sections"][SECTIONS.index("ledger")])


def longest(stats: dict[str, Any], section: str) -> int:
    """Return the longest stay in a section, with those it calls, by a board's statistics."""
    return int(stats["section_longest"][SECTIONS.index(section)])


def passes(view: dict[str, Any]) -> int:
    """Return how often the main loop went round."""
    entries = dict(zip(SECTIONS, view["section_entries"], strict=True))
    return int(entries[_PASS] - entries[_INSIDE])


def pass_cycles(view: dict[str, Any]) -> float:
    """Return the mean cycles of one pass of the main loop, interrupts excluded."""
    return float((view["cycles"] - view["interrupt_cycles"]) / max(1, passes(view)))


def step_handlers(view: dict[str, Any], board: str, axis: int = 0) -> list[dict[str, Any]]:
    """Return the handlers of an axis' timer that ran in a view, capture excepted."""
    timer = f"TIMER{boards.load(board).timers[axis]}_"
    return [
        row
        for name, row in view["handlers"].items()
        if name.startswith(timer) and not name.endswith("CAPT")
    ]


def step_cycles(view: dict[str, Any], board: str, axis: int = 0) -> float:
    """Return the handler cycles of an axis' timer for each of its steps."""
    total = sum(row["cycles_sum"] for row in step_handlers(view, board, axis))
    return float(total / max(1, view["steps"]))


def latest_start(view: dict[str, Any], board: str, axes: int) -> int:
    """Return the longest wait of any axis' step interrupt in a view, cycles."""
    rows = [row for axis in range(axes) for row in step_handlers(view, board, axis)]
    return max((row["latency_max"] for row in rows), default=0)
