# SPDX-License-Identifier: MIT
"""What an image costs its board, in cycles: measured by `pixstep-dev costs`, kept in the package.

The names are those of struct guarantee_costs (tools/native/core/guarantee.h), and `data_request`
and `turning_request` the longest requests that bring line data, of a line that does not turn and of
one that does, and `low` by what share the table reckons the main
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
    even_begun: float
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
    piece_more: float
    shifted_px: float
    turned_px: float
    crawl_px: float
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
    edge_few: float
    round_unlike: float
    turn: float
    request: float
    data_request: float
    turning_request: float
    request_byte: float
    step_isr: float
    train_isr: float
    edge_isr: float
    byte_isr: float
    other_isr_share: float
    low: float


NAMES = tuple(field.name for field in fields(Costs))
_DATA, _TURNING, MARGIN = "data_request", "turning_request", "low"
SHARES = ("other_isr_share", MARGIN)
OF_REPLAY = tuple(name for name in NAMES if name not in (_DATA, _TURNING, MARGIN))


def of(board: str) -> Costs:
    """Return the costs of a board's image."""
    return table()[board]


def of_replay(board: str, *, streamed: bool, turning: bool = False) -> dict[str, float]:
    """Return them as a replay takes them.

    `streamed`: line data come while the board moves, and some are of a line that is `turning`.
    """
    known = asdict(of(board))
    longest = [known["request"]]
    longest += [known[_DATA]] if streamed else []
    longest += [known[_TURNING]] if streamed and turning else []
    return {name: known[name] for name in OF_REPLAY} | {"request": max(longest)}


@cache
def table() -> dict[str, Costs]:
    """Return the costs of every board, as they were measured."""
    rows = json.loads(PATH.read_text(encoding="utf-8"))
    return {board: Costs(**row) for board, row in rows.items()}
