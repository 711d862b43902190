# SPDX-License-Identifier: MIT
"""The other step generators' figures and the targets, from data/peers.toml."""

import operator
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_DATA = Path(__file__).resolve().parents[1] / "data" / "peers.toml"
RELATIONS: dict[str, Callable[[float, float], bool]] = {">=": operator.ge, "<=": operator.le}


@dataclass(frozen=True)
class Peer:
    """What one project reaches, in the row's unit; the note says what differs."""

    project: str
    values: tuple[float, ...]
    note: str = ""


@dataclass(frozen=True)
class Goal:
    """One row of the comparison: target, the peers' figures and the best of them in words."""

    id: str
    text: str
    unit: str
    relation: str
    target: tuple[float, ...]
    best: str
    peers: tuple[Peer, ...]

    def met(self, ours: list[float]) -> bool:
        """True if every value of ours keeps its bound."""
        keeps = RELATIONS[self.relation]
        return all(keeps(value, bound) for value, bound in zip(ours, self.target, strict=True))


def goals() -> list[Goal]:
    """Return the rows of the comparison."""
    return [
        Goal(
            **row
            | {
                "target": tuple(row["target"]),
                "peers": tuple(
                    Peer(peer["project"], tuple(peer["values"]), peer.get("note", ""))
                    for peer in row["peers"]
                ),
            }
        )
        for row in _read()["row"]
    ]


def source() -> str:
    """Return where the peers' figures are from."""
    return str(_read()["source"]).strip()


def projects() -> dict[str, str]:
    """Return the peers and what each is."""
    return dict(_read()["projects"])


def _read() -> dict[str, Any]:
    return tomllib.loads(_DATA.read_text(encoding="utf-8"))
