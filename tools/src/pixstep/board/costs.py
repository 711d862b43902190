# SPDX-License-Identifier: MIT
"""What an image costs its board, in cycles: measured by `pixstep-dev costs`, kept in the package.

The names are those of struct guarantee_costs (tools/native/core/guarantee.h). A request
is there up to an interlude, and as a `whole` in which a single axis takes no edge of the clock.
Requests that bring line data have costs of their own: `data_` of a line that does not turn,
`turning_` of one that does. `low` is by what share the table reckons the main
loop's work too low in that probe of an image where it does so most.
"""

import json
from dataclasses import asdict, dataclass, fields
from functools import cache
from pathlib import Path

PATH = Path(__file__).resolve().parents[1] / "data" / "costs.json"


@dataclass(frozen=True)
class Costs:
    """Cycles of the main loop, interrupts excluded, and of the interrupts."""

    call: float
    even_px: float
    even_step: float
    even_changed: float
    train_px: float
    train_step: float
    single_px: float
    single_step: float
    curved_px: float
    curved_start: float
    curved_step: float
    piece_px: float
    piece_step: float
    curve_px: float
    shifted_px: float
    turned_px: float
    flat_step: float
    wide_step: float
    steep_step: float
    slow_step: float
    moved_tick: float
    wide_moved_tick: float
    missed_tick: float
    short_batch: float
    zero_px: float
    pump: float
    locked_px: float
    early: float
    account: float
    account_px: float
    account_entry: float
    account_long_entry: float
    account_curve_px: float
    account_piece_px: float
    account_train_px: float
    edge: float
    round: float
    edge_locked: float
    round_locked: float
    turn: float
    request: float
    whole: float
    data_request: float
    data_whole: float
    turning_request: float
    turning_whole: float
    request_byte: float
    step_isr: float
    train_isr: float
    edge_isr: float
    byte_isr: float
    other_isr_share: float
    low: float


NAMES = tuple(field.name for field in fields(Costs))
DATA, TURNING, MARGIN = "data_", "turning_", "low"
REQUEST, WHOLE = "request", "whole"
SHARES = ("other_isr_share", MARGIN)
OF_REPLAY = tuple(name for name in NAMES if not name.startswith((DATA, TURNING, MARGIN)))


def of(board: str) -> Costs:
    """Return the costs of a board's image."""
    return table()[board]


def of_replay(board: str, *, streamed: bool, turning: bool = False) -> dict[str, float]:
    """Return them as a replay takes them.

    `streamed`: line data come while the board moves, and some are of a line that is `turning`.
    """
    known = asdict(of(board))
    kinds = ["", *([DATA] if streamed else []), *([TURNING] if streamed and turning else [])]
    longest = {name: max(known[kind + name] for kind in kinds) for name in (REQUEST, WHOLE)}
    return {name: known[name] for name in OF_REPLAY} | longest


@cache
def table() -> dict[str, Costs]:
    """Return the costs of every board, as they were measured."""
    rows = json.loads(PATH.read_text(encoding="utf-8"))
    return {board: Costs(**row) for board, row in rows.items()}
