# SPDX-License-Identifier: MIT
"""A campaign as a part of docs/ORDERS.md: how often which pair was tried, at what speeds."""

from collections import Counter
from typing import Any

from pixstep.board import boards
from pixstep_dev.robustness.orders import rests
from pixstep_dev.robustness.orders.campaign import OrdersOutcome


def name(outcome: OrdersOutcome | rests.RestsOutcome) -> str:
    """Return the name of the part."""
    board = outcome.plan.board
    if isinstance(outcome, rests.RestsOutcome):
        return f"rests-{board}"
    return "orders-together" if outcome.plan.together else f"orders-{board}"


def markdown(outcome: OrdersOutcome | rests.RestsOutcome) -> str:
    """Return the part: figures, speeds, faults, pairs."""
    if isinstance(outcome, rests.RestsOutcome):
        return rests.text(outcome).replace("\n  ", "\n") + "\n"
    plan = outcome.plan
    hours = outcome.cycles / boards.load(plan.board).tick_hz / 3600
    lines = [
        f"{outcome.trials:,} trials on the {plan.board} from seed {plan.seed}, "
        f"{hours:.1f} simulated hours, {outcome.failed:,} failed.",
        "",
        *_counted("line, steps/s up to", outcome.speeds),
        *_counted("fault seen", outcome.faults),
    ]
    lines += _counted("axes that started", outcome.started) if plan.together else []
    lines += _pairs(outcome.pairs)
    return "\n".join(lines) + "\n"


def _counted(what: str, counts: Counter[Any]) -> list[str]:
    rows = [f"| {key if isinstance(key, str) else f'{key:,}'} | {counts[key]:,} |"
            for key in sorted(counts)]  # fmt: skip
    return [f"| {what} | trials |", "| --- | --: |", *rows, ""]


def _pairs(pairs: Counter[tuple[str, str]]) -> list[str]:
    """Return a table of first command by row, next command by column; coils count as commands."""
    merged: Counter[tuple[str, str]] = Counter()
    for (first, second), number in pairs.items():
        merged[first.removeprefix("coil "), second.removeprefix("coil ")] += number
    names = sorted({name for pair in merged for name in pair})
    return [
        f"| then | {' | '.join(names)} |",
        f"| --- |{' --: |' * len(names)}",
        *[
            f"| {first} | {' | '.join(f'{merged[first, second]:,}' for second in names)} |"
            for first in names
        ],
    ]
