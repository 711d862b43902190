# SPDX-License-Identifier: MIT
"""Rates of a board's serial port: the host knows which of them the board takes."""

import itertools
from fractions import Fraction

import pytest

from pixstep.board import bauds, boards
from pixstep.errors import UserError
from pixstep.simulation.simulated_board import SimulatedBoard

LEAST, MOST = bauds.setting_range()
RATES = range(LEAST, MOST + 1, 100)


def turns(board):
    """Return every two neighbouring rates of which a board makes one."""
    made = [(rate, bauds.is_made(board, rate)) for rate in RATES]
    return [(a[0], b[0]) for a, b in itertools.pairwise(made) if a[1] != b[1]]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_the_board_takes_what_the_host_says_that_it_takes(board):
    edges = turns(board)
    rates = {rate for pair in edges for rate in pair} | {LEAST, 115_200, 500_000, MOST}
    assert len(edges) >= 5
    with SimulatedBoard(board, Fraction(100)) as run:
        for rate in sorted(rates):
            try:
                run.talk_at(rate)
            except UserError as error:
                assert not bauds.is_made(board, rate)
                assert str(error) == bauds.refusal(board, rate)
            else:
                assert bauds.is_made(board, rate)
                assert run.board.setting("baud_100") == rate // 100


def test_a_refusal_names_the_nearest_rates():
    assert bauds.refusal("mega", 740_000) == (
        "the mega cannot make 740000 baud within 2.5 %: 683700 and 975700 would do"
    )
    assert bauds.refusal("m1284", MOST) == (
        "the m1284 cannot make 1000000 baud within 2.5 %: 854700 would do"
    )
    assert bauds.refusal("uno", 115_200) is None


@pytest.mark.parametrize(
    "words", [("limits",), ("line", "check", "line.csv", "--decode", "plain"),
              ("sim", "line.csv", "--decode", "plain", "--out", "run")],
)  # fmt: skip
def test_every_command_that_reckons_with_a_rate_refuses_it(invoke, tmp_path, words):
    (tmp_path / "line.csv").write_bytes(b"     5\r\n" * 8)
    asked = ("--board", "m1284", "--pixel-hz", "100", "--baud", "1000000")
    done = invoke(*words, *asked, status=2)
    assert "--baud: the m1284 cannot make 1000000 baud within 2.5 %" in done.output
    assert not (tmp_path / "run").exists()


def test_a_check_by_no_board_asks_for_no_rate_of_it(invoke, tmp_path):
    (tmp_path / "line.csv").write_bytes(b"     5\r\n" * 8)
    words = ("line", "check", "line.csv", "--decode", "plain", "--pixel-hz", "100")
    invoke(*words, "--baud", "740000")
