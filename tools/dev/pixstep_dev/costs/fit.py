# SPDX-License-Identifier: MIT
"""Costs from what probes have spent: least squares, every cost at least nothing.

The model itself says how often a line has each cost (guarantee_demand() of the C core with one
cost of 1 and all others 0), so that table and model mean the same by every name.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np
from scipy.optimize import nnls  # type: ignore[import-untyped]

from pixstep.board import boards
from pixstep.board.costs import OF_REPLAY
from pixstep.lines.replay import Loop, Replay
from pixstep.lines.units import period_ticks
from pixstep_dev.costs.probes import BETWEEN_PPM, Spent

DECODING = OF_REPLAY[: OF_REPLAY.index("account")]
ACCOUNTS = (
    "account_px", "account_entry", "account_long_entry", "account_curve_px", "account_piece_px",
    "account_train_px",
)  # fmt: skip
ROUNDS = ("round", "edge", "round_locked", "edge_locked", "turn")
# No probe of curves, turns, trains and rounds is reckoned cheaper than by so much: they are of more
# kinds than the table has.
CURVES, LOW = ("curves", "bends", "shifted", "drops"), 0.1
OF_CURVES = (
    "curved_px", "curved_start", "curved_step", "curve_px", "flat_step", "wide_step", "steep_step",
    "slow_step", "moved_tick", "wide_moved_tick", "missed_tick", "short_batch",
)  # fmt: skip
_LEAD_TICKS, _MARKS = 0x20000, 13  # of lines that are locked
_OFTEN = 5  # in a probe
_CROWDS = "crowds"  # probes of trains and long pixels, on one axis and on all
_UNLIKE = ("turns", "rests", "mixed", _CROWDS)  # those that make passes dearer
_BETWEEN = "between"  # those of no more than a step between two edges of the clock
_FEW, _STEEP = "few", "steep"  # those that bend: of few steps a pixel, and from a crawl to fast
_NOTHING = dict.fromkeys(OF_REPLAY, 0.0)


def loop_of(board: str, hz: Fraction, *, locked: bool = False) -> Loop:
    """Return a board's loop, as far as a demand depends on it."""
    kind = boards.load(board)
    return Loop(
        kind.axes,
        kind.all_features,
        float(period_ticks(hz, kind.tick_hz)),
        lead_edges=1 if locked else 0,
    )


def _times(board: str, spent: Spent) -> dict[str, tuple[float, float]]:
    """Return how often the probe's line has each cost: of decoding, of its account."""
    probe = spent.probe
    replay = Replay([probe.line])
    loop = loop_of(board, Fraction(probe.hz), locked=probe.locked)
    return {name: replay.demand(_NOTHING | {name: 1.0}, loop) for name in OF_REPLAY}


def _solve(
    rows: Sequence[Spent], names: Sequence[str], times: Callable[[Spent, str], float],
    value: Callable[[Spent], float], power: float = 1.0,
) -> dict[str, float]:  # fmt: skip
    """Fit the costs by their errors, divided by a power of the value: relative ones with 1."""
    wanted = np.array([max(1.0, value(row)) for row in rows])
    weights = wanted**-power
    table = np.array([[times(row, name) for name in names] for row in rows]) * weights[:, None]
    scale = np.maximum(table.max(axis=0), 1e-12)
    found, _ = nnls(table / scale, wanted * weights)
    return {name: float(cost) for name, cost in zip(names, found / scale, strict=True)}


def fit(board: str, spent: Sequence[Spent]) -> dict[str, float]:
    """Return the costs of decoding, of accounts and of rounds."""
    times = {row.probe.name: _times(board, row) for row in spent}

    def decode(row: Spent, name: str) -> float:
        if name == "call":
            return row.calls
        return _early(board, row) if name == "early" else times[row.probe.name][name][0]

    others = [row for row in spent if not row.probe.name.startswith((_FEW, _STEEP))]
    decoding = _solve(others, DECODING, decode, lambda row: row.decode)
    worst = max(
        row.decode / sum(cost * decode(row, name) for name, cost in decoding.items())
        for row in spent
        if row.probe.name.startswith(CURVES)
    )
    for name in OF_CURVES:
        decoding[name] *= max(1.0, worst / (1 + LOW))

    def account(row: Spent, name: str) -> float:
        if name == "account":
            return row.looks
        return _accounted(row, times[row.probe.name], name)

    # Looks at slow lines, of which most find nothing, would hide what an entry costs; and those at
    # slow trains, which find out as much, what a train's pixel does.
    fast = [row for row in spent if not row.probe.name.startswith(("train", "mixed"))]
    accounts = _solve(fast, ("account", *ACCOUNTS), account, lambda row: row.account, 0.5)
    _raise(decoding, "train_px", spent, (_CROWDS,), decode, lambda row: row.decode, 0.0)
    _raise(decoding, "turned_px", spent, ("turns",), decode, lambda row: row.decode, 0.0)
    _raise(decoding, "crawl_px", spent, (_STEEP,), decode, lambda row: row.decode, 0.0)
    _raise(decoding, "curved_start", spent, (_FEW,), decode, lambda row: row.decode, 0.0)
    _raise(accounts, "account_curve_px", spent, ("bends",), account, lambda row: row.account)
    _raise(accounts, "account_piece_px", spent, ("turns",), account, lambda row: row.account)
    _raise(accounts, "account_train_px", spent, (_CROWDS,), account, lambda row: row.account)
    found = decoding | accounts | _rounds(spent)
    found["round_unlike"] = _round_unlike(board, spent, found)
    return found | {"low": max(0.0, *(row[1] for row in misses(board, spent, found)))}


def _accounted(row: Spent, times: dict[str, tuple[float, float]], name: str) -> float:
    """Return how often the account of a probe's line has a cost while it is looked at.

    Where there are trains any pixel is accounted for while some are among those that are decoded.
    """
    if name != "account_train_px":
        return row.share * times[name][1]
    return row.share * len(row.probe.line.counts) if times["train_step"][0] else 0.0


def _early(board: str, row: Spent) -> float:
    """Return how often the decoder asked for a pixel that had to wait for an edge of the clock.

    Where clocks are fast the marks are full before.
    """
    probe = row.probe
    ticks = float(period_ticks(Fraction(probe.hz), boards.load(board).tick_hz))
    return row.calls if probe.locked and _LEAD_TICKS // ticks + 1 < _MARKS else 0.0


def _raise(
    costs: dict[str, float], name: str, rows: Sequence[Spent], kinds: tuple[str, ...],
    times: Callable[[Spent, str], float], value: Callable[[Spent], float], low: float = LOW,
) -> None:  # fmt: skip
    """Raise a cost until no probe of these kinds that has it often is reckoned lower than that."""
    for row in rows:
        often = times(row, name)
        if row.probe.name.startswith(kinds) and often >= _OFTEN:
            reckoned = sum(cost * times(row, one) for one, cost in costs.items())
            costs[name] += max(0.0, value(row) / (1 + low) - reckoned) / often


def _round_unlike(board: str, spent: Sequence[Spent], costs: dict[str, float]) -> float:
    """Return what a pass costs more of lines of unlike pixels, of those that cost the most.

    So much that none of them is reckoned too low. Passes of lines of like pixels must not pay for
    it.
    """
    return max(
        0.0,
        *(
            (_work(row) - _reckoned(board, row, costs)) / row.passes
            for row in spent
            if row.probe.name.startswith(_UNLIKE)
        ),
    )


def _rounds(spent: Sequence[Spent]) -> dict[str, float]:
    """Return the costs of a round, of the clock's edges in it, and of each call of the decoder.

    Those of lines of unlike pixels are higher: _round_unlike().
    """
    alike = [row for row in spent if not row.probe.name.startswith((*_UNLIKE, _BETWEEN))]
    found = _solve(alike, ROUNDS, _times_round, lambda row: row.rounds)
    worst = max(
        row.rounds / sum(cost * _times_round(row, name) for name, cost in found.items())
        for row in alike
    )
    found = {name: cost * max(1.0, worst / (1 + LOW)) for name, cost in found.items()}
    return found | {"edge_few": _few_between(spent, found["round"])}


def _times_round(row: Spent, name: str) -> float:
    """Return how often a probe had a cost of rounds."""
    if name == "turn":
        return row.calls * row.share * row.probe.axes
    if name.endswith("_locked") != row.probe.locked:
        return 0.0
    return row.passes if name.startswith("round") else row.edges


def _few_between(spent: Sequence[Spent], round_cycles: float) -> float:
    """Return what an edge costs more right before a step than right behind it."""
    found = {
        row.probe.ppm: (row.rounds - row.passes * round_cycles) / row.edges
        for row in spent
        if row.probe.name.startswith(_BETWEEN)
    }
    quick, slow = (found[ppm] for ppm in BETWEEN_PPM)
    return max(0.0, slow - quick)


def misses(board: str, spent: Sequence[Spent], costs: dict[str, float]) -> list[tuple[str, float]]:
    """Return of each probe by how much the main loop's work is reckoned too low, as a share.

    But for those that tell what an edge costs more at times.
    """
    return [
        (row.probe.name, _work(row) / _reckoned(board, row, costs) - 1)
        for row in spent
        if not row.probe.name.startswith(_BETWEEN)
    ]


def _work(row: Spent) -> float:
    """Return the cycles of all axes' decoding and accounts, and of rounds."""
    return (row.share * row.decode + row.account) * row.probe.axes + row.rounds


def _reckoned(board: str, row: Spent, costs: dict[str, float]) -> float:
    """Return them as the costs have them, for as many calls, looks, passes and edges."""
    times = _times(board, row)
    decode = costs["call"] * row.calls + costs["early"] * _early(board, row)
    decode += sum(costs[name] * times[name][0] for name in DECODING)
    account = costs["account"] * row.looks
    account += sum(costs[name] * _accounted(row, times, name) for name in ACCOUNTS)
    rounds = sum(costs[name] * _times_round(row, name) for name in ROUNDS)
    if row.probe.name.startswith(_UNLIKE):
        rounds += costs.get("round_unlike", 0.0) * row.passes
    return (row.share * decode + account) * row.probe.axes + rounds
