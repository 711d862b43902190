# SPDX-License-Identifier: MIT
"""The table of costs: measured, written, compared."""

from dataclasses import asdict
from pathlib import Path

from pixstep import atomic
from pixstep.board import boards, costs
from pixstep.board.costs import NAMES, PATH
from pixstep_dev.costs import bus, fit, probes

TOLERANCE = 0.02
LEAST = 2.0  # cycles


def measure(board: str) -> dict[str, float]:
    """Measure the costs of a board's image."""
    spent = probes.run_all(board, probes.of_board(board))
    found = fit.fit(board, spent) | interrupts(board, spent) | bus.costs(board)
    return {name: round(found[name], 6 if name in costs.SHARES else 1) for name in NAMES}


def stale(board: str, found: dict[str, float]) -> list[str]:
    """Return in which costs the table does not fit what was found."""
    known = asdict(costs.of(board))
    return [
        f"{board}: {name} costs {found[name]:g}, the table has {known[name]:g}"
        for name in NAMES
        if abs(found[name] - known[name]) > _allowed(name, known[name])
    ]


def _allowed(name: str, known: float) -> float:
    return TOLERANCE if name == costs.MARGIN else max(LEAST, TOLERANCE * known)


def interrupts(board: str, spent: list[probes.Spent]) -> dict[str, float]:
    """Return the costs of interrupts by the handlers' own counts."""
    timer = f"TIMER{boards.load(board).timers[0]}_OVF"
    trains = [
        row.handlers[timer]["cycles_mean"] for row in spent if row.probe.name.startswith("train")
    ]
    edges = [
        handler["cycles_mean"]
        for row in spent
        for name, handler in row.handlers.items()
        if name.endswith("_CAPT")
    ]
    singles = [
        row.handlers[timer]["cycles_mean"] for row in spent if row.probe.name.startswith("even")
    ]
    clock = [
        handler["cycles_sum"] / row.cycles
        for row in spent
        for name, handler in row.handlers.items()
        if name == "TIMER0_OVF"
    ]
    return {
        "step_isr": max(singles),
        "train_isr": max(trains),
        "edge_isr": max(edges),
        "other_isr_share": max(clock),
    }


def write(found: dict[str, dict[str, float]], path: Path = PATH) -> None:
    """Write the table in the place of the one that is there."""
    with atomic.rules(atomic.WriteRules(force=True)):  # that is what was asked for
        atomic.write_json(path, found)
