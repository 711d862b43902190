# SPDX-License-Identifier: MIT
"""Our figures beside the peers' and the targets."""

from collections.abc import Callable
from typing import Any

from pixstep_dev.bench import peers
from pixstep_dev.bench.figure import FigureColumn, failures, key
from pixstep_dev.bench.peers import Goal

_HEADLINE_HZ = 30.0  # pixel clock of the rates that are compared, the printer's
_RAMP_HZ = 100.0  # where the line's counts are the ramp itself

Figures = dict[str, list[dict[str, Any]]]


def compare(measured: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each goal: ours (None if not measured), target, met, peers."""
    rows = []
    for goal in peers.goals():
        ours = _OURS[goal.id](measured["figures"])
        rows.append(
            {
                "id": goal.id,
                "figure": goal.text,
                "unit": goal.unit,
                "ours": ours,
                "relation": goal.relation,
                "target": list(goal.target),
                "met": None if ours is None else goal.met(ours),
                "best": goal.best,
                "peers": {
                    peer.project: {"values": list(peer.values), "note": peer.note}
                    for peer in goal.peers
                },
            }
        )
    return rows


def _some(figures: Figures, name: str, **wanted: object) -> list[dict[str, Any]]:
    """Return the rows of a figure with these values."""
    rows = figures.get(name, [])
    return [row for row in rows if all(row[k] == value for k, value in wanted.items())]


def _largest(rows: list[dict[str, Any]], *names: str) -> list[float] | None:
    """Return the largest magnitude of each key over the rows, None without rows."""
    return [max(abs(row[name]) for row in rows) for name in names] if rows else None


def _rate(board: str, axes: int, motion: str) -> Callable[[Figures], list[float] | None]:
    """Return the reader of one clean rate; with a hole below it is not a clean rate."""

    def read(figures: Figures) -> list[float] | None:
        rows = _some(figures, "rates", board=board, axes=axes, motion=motion, hz=_HEADLINE_HZ)
        return [row["steps_per_s"] for row in rows] or None

    return read


def _share(figures: Figures) -> list[float] | None:
    rows = _some(figures, "share", board="uno", motion="constant")
    return [100 * row["share"] for row in rows] or None


def _overload(figures: Figures) -> list[float] | None:
    rows = figures.get("overload")
    return [len(failures(rows))] if rows else None


_OURS: dict[str, Callable[[Figures], list[float] | None]] = {
    "constant_uno": _rate("uno", 1, "constant"),
    "smooth_uno": _rate("uno", 1, "smooth"),
    "constant_mega": _rate("mega", 4, "constant"),
    "smooth_mega": _rate("mega", 4, "smooth"),
    "step_interrupt": lambda f: _largest(_some(f, "handlers", step=True), "cycles_per_step"),
    "share_uno": _share,
    "ramp": lambda f: _largest(_some(f, "ramp", hz=_RAMP_HZ), "ramp_max_us", "ramp_rms_us"),
    "rate_error": lambda f: _largest(_some(f, "accuracy"), "rate_error_ppm"),
    "interval_error": lambda f: _largest(
        _some(f, "accuracy", serial_load=True), "interval_error_ticks"
    ),
    "overload": _overload,
    "ram_uno": lambda f: _largest(_some(f, "sizes", board="uno"), "ram_left_bytes"),
}


def number(value: float) -> str:
    """Return a value with three places that count, or whole."""
    return f"{value:,.0f}" if value == int(value) or value >= 1000 else f"{value:,.3g}"


def _values(values: list[float]) -> str:
    return " / ".join(number(value) for value in values)


def _target(row: dict[str, Any]) -> str:
    return f"{row['relation']} {_values(row['target'])}"


def _ours(row: dict[str, Any]) -> str:
    return "-" if row["ours"] is None else _values(row["ours"])


def _met(row: dict[str, Any]) -> str:
    return {None: "not measured", True: "met", False: "missed"}[row["met"]]


def _peer(name: str) -> FigureColumn:
    def text(row: dict[str, Any]) -> str:
        peer = row["peers"].get(name)
        if peer is None:
            return "-"
        note = f"({peer['note']})" if peer["note"] else ""
        return f"{_values(peer['values'])} {note}".strip()

    return FigureColumn(name, text)


def columns() -> tuple[FigureColumn, ...]:
    """Return the columns of the comparison: ours, the target, the best of the peers."""
    return (
        key("figure", "figure", left=True),
        key("unit", "unit", left=True),
        key("peers' best", "best"),
        FigureColumn("target", _target),
        FigureColumn("pixstep", _ours),
        FigureColumn("", _met, left=True),
    )


def peer_columns() -> tuple[FigureColumn, ...]:
    """Return the columns of the peers one by one."""
    unit = key("unit", "unit", left=True)
    return (key("figure", "figure", left=True), unit, *(_peer(name) for name in peers.projects()))


def about() -> str:
    """Return what the comparison compares."""
    return (
        f"The others' figures: {peers.source()}. Ours: rates at the printer's pixel clock of "
        f"{_HEADLINE_HZ:g} Hz, the ramp at {_RAMP_HZ:g} Hz; the worse board where both are meant."
    )


def goal(name: str) -> Goal:
    """Return a goal by its id."""
    return next(one for one in peers.goals() if one.id == name)
