# SPDX-License-Identifier: MIT
"""The boards that the package knows, and what commands make of their differences."""

import pytest

from pixstep import formats
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.errors import UserError


def test_an_unknown_board_is_refused():
    with pytest.raises(UserError, match="unknown board 'nano': one of uno, mega, "):
        boards.load("nano")


def test_numbers_and_counts_of_axes():
    table = {board.name: (board.id, board.axes, board.tick_hz) for board in boards.all_boards()}
    assert table["uno"] == (1, 1, 16_000_000)
    assert table["mega"] == (2, 4, 16_000_000)
    assert table["m1284"] == (3, 2, 20_000_000)
    assert {number: name for name, (number, *_) in table.items()} == regs.BOARD_IDS
    assert list(regs.AXIS_COUNTS) == sorted({axes for _, axes, _ in table.values()})


@pytest.mark.usefixtures("plan_program")
def test_commands_count_ticks_by_the_board(invoke, tmp_path):
    line = tmp_path / "line.csv"
    formats.write_csv(line, [100, 100])
    for board, ticks in (("uno", 160_000), ("m1284", 200_000)):
        words = (line, "--decode", "plain", "--pixel-hz", 100, "--board", board)
        invoke("ticks", *words, "--pixels", "-o", "t.csv", "--force")
        assert line.with_name("t.csv").read_text().split()[1] == f"1,{ticks},100"
        invoke("line", "check", *words, "--min-interval", ticks // 100)
        text = invoke("line", "check", *words, "--min-interval", ticks // 100 + 1, status=3).output
        assert f"a step every {ticks / 100:.1f} ticks" in text
