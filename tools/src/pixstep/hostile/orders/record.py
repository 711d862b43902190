# SPDX-License-Identifier: MIT
"""A campaign as a part of docs/ORDERS.md: how often which pair was tried, at what speeds."""

from collections import Counter

from pixstep.hostile.orders.campaign import Outcome
from pixstep.lines.rational import TIMER_HZ


def name(outcome: Outcome) -> str:
    """Return the name of the part."""
    return f"orders-{outcome.plan.board}"


def markdown(outcome: Outcome) -> str:
    """Return the part: figures, speeds, faults, pairs."""
    plan = outcome.plan
    hours = outcome.cycles / TIMER_HZ / 3600
    lines = [
        f"{outcome.trials:,} trials on the {plan.board} from seed {plan.seed}, "
        f"{hours:.1f} simulated hours, {outcome.failed:,} failed.",
        "",
        "| line, steps/s up to | trials |",
        "| --: | --: |",
        *[f"| {top:,} | {number:,} |" for top, number in sorted(outcome.speeds.items())],
        "",
        "| fault seen | trials |",
        "| --- | --: |",
        *[f"| `{fault}` | {number:,} |" for fault, number in sorted(outcome.faults.items())],
        "",
        *_pairs(outcome.pairs),
    ]
    return "\n".join(lines) + "\n"


def _pairs(pairs: Counter) -> list[str]:
    """Return a table of first command by row, next command by column; coils count as commands."""
    merged: Counter = Counter()
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
