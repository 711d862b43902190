# SPDX-License-Identifier: MIT
"""The search for patterns that fail closest to what is guaranteed."""

from dataclasses import replace

import pytest

from effort import cases
from pixstep.board import boards, guarantee
from pixstep_dev.guarantee import search
from pixstep_dev.guarantee.search import NEVER, Close, Pattern

BURSTS = Pattern(
    "mega", (10, 10, 1, -1, -10, -10, -1, 1), False, 4, 0, 300, "start", 1, False, 115_200
)


def test_the_guaranteed_clock_of_a_pattern_is_found_to_two_per_cent():
    highest = search._highest(BURSTS)
    assert highest is not None
    assert highest.accepted()
    assert not replace(highest, hz=round(highest.hz * 1.03)).accepted()


def test_a_clock_that_is_accepted_above_others_that_are_not_is_found(monkeypatch):
    accepted = (*range(250, 301), 350, 351, 352, 353, 450)
    monkeypatch.setattr(Pattern, "accepted", lambda self: self.hz in accepted)
    highest = search._highest(BURSTS)
    assert highest is not None
    assert 350 <= highest.hz <= 353


def test_a_pattern_that_is_accepted_and_fails_is_a_complaint(monkeypatch):
    monkeypatch.setattr(guarantee, "first_late", lambda *_: None)  # everything is accepted
    close = search._beyond(replace(BURSTS, hz=1200))
    assert close.share == 1
    assert "decoder_late" in close.end
    monkeypatch.setattr(search, "ProcessPoolExecutor", _InPlace)
    monkeypatch.setattr(search, "search", lambda *_: [close])
    found = search.run(1, names=("mega",))
    assert found.complaints == [f"{close.pattern}: {close.end}"]


class _InPlace:
    def __init__(self, _processes: int) -> None: ...

    def __enter__(self):
        return self

    def __exit__(self, *_: object) -> None: ...

    map = staticmethod(map)


def test_patterns_that_do_not_fail_are_told_as_such():
    assert search.Closest([Close(BURSTS, NEVER)]).rows[0].startswith(" none mega, 4 axes")
    assert search.Closest([Close(BURSTS, 1.05)]).rows[0].startswith(" 105% mega, 4 axes")


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_no_pattern_of_a_search_fails_where_it_is_accepted(board):
    found = search.search(board, cases(3, 80), 11)
    assert found
    assert [one for one in found if one.share <= 1] == []
