# SPDX-License-Identifier: MIT
"""Lines on their way to several boards: one board that is lost keeps the others from nothing."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest

from pixstep.board.errors import BoardError
from pixstep.jobs import sender
from pixstep.lines.line import PLAIN, Line


@dataclass
class FakeUpload:
    """A line that is accepted in one go; a board that is lost takes none."""

    board: object
    axis: int
    entries: list
    done: bool = False
    begun: bool = False
    queued_pixels: float = 1.0

    def __post_init__(self):
        if self.board.lost:
            raise BoardError(f"board {self.board.unit}: no reply")
        self.board.lines.append(self.entries[0])

    def require_taken(self):
        assert self.done


@dataclass
class Board:
    """Counts the lines that were begun on it."""

    unit: int
    lost: bool = False
    full: bool = False  # its queue takes nothing now
    lines: list = field(default_factory=list)

    def has(self, feature):
        return feature == "line_divider"


def accept(uploads):
    for item in uploads:
        item.begun = item.done = not item.board.full


@pytest.fixture
def stations(monkeypatch):
    """Return two boards with a motor each."""
    monkeypatch.setattr(sender, "LineUpload", FakeUpload)
    monkeypatch.setattr(sender, "feed", accept)
    return [
        SimpleNamespace(name=name, board=Board(unit), motors={name: 0})
        for unit, name in enumerate("AB", 1)
    ]


def begin(stations):
    """Return a sender of three lines and what it has logged."""
    line = Line((0, 2, 2, 0), PLAIN)
    job = SimpleNamespace(line=lambda number: {one.name: line for one in stations}, lines=3)
    logged = []
    return sender.Sender(job, (1, job.lines), 1, logged.append, gated=False), logged


def test_lines_go_out_as_far_as_they_may_and_are_logged_before(stations):
    found, logged = begin(stations)
    found.send(stations, 2)
    assert (found.begun, found.sent, logged) == (2, 2, [1, 2])
    assert [len(one.board.lines) for one in stations] == [2, 2]
    waits = [entry[0] & 1 << 5 for entry in stations[0].board.lines]
    assert waits[0] and not waits[1]  # the second one follows without a gap


def test_each_line_but_the_last_says_that_another_one_follows(stations):
    found, _ = begin(stations)
    found.send(stations, 3)
    for one in stations:
        assert [bool(entry[0] & 1 << 10) for entry in one.board.lines] == [True, True, False]


def test_no_board_begins_a_line_without_the_boards_before_it(stations):
    found, _ = begin(stations)
    found.send(stations, 1)
    stations[0].board.full = True
    found.send(stations, 2)
    assert not any(item.done for item in found._uploads["B"]) and found.sent == 1
    stations[0].board.full = False
    found.send(stations, 2)
    assert found.sent == 2


@pytest.mark.parametrize("lost", [0, 1])
def test_the_other_board_gets_the_line_that_was_begun(stations, lost):
    found, logged = begin(stations)
    found.send(stations, 1)
    stations[lost].board.lost = True
    with pytest.raises(BoardError, match="no reply"):
        found.send(stations, 2)
    alive = [stations[1 - lost]]
    found.send(alive, 2)
    assert (found.begun, found.sent, logged) == (2, 2, [1, 2])
    assert len(alive[0].board.lines) == 2
