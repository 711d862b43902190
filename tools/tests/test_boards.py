# SPDX-License-Identifier: MIT
"""What is read of firmware/hal/boards: a board more needs no change of a list."""

import os
import subprocess
import sys

import pytest

from pixstep import formats, natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.errors import UserError

NAMES = "from pixstep.board import boards; print(*boards.BOARD_NAMES, boards.load('nano').axes)"


@pytest.fixture
def clone(tmp_path):
    """Return a folder that holds the board files alone, and a function that adds one."""
    folder = tmp_path / "firmware" / "hal" / "boards"
    folder.mkdir(parents=True)
    for name in boards.BOARD_NAMES:
        text = natives.source(f"firmware/hal/boards/{name}.def").read_text()
        (folder / f"{name}.def").write_text(text)
    return folder


def listed(folder):
    root = folder.parents[2]
    words = [sys.executable, "-c", NAMES]
    environment = os.environ | {"PIXSTEP_ROOT": str(root)}
    return subprocess.run(words, env=environment, capture_output=True, text=True, check=False)


def fourth(folder, **changes):
    """Write a board like the Mega with another name and number, and constants changed."""
    text = (folder / "mega.def").read_text()
    for name, value in {"NAME": '"nano"', "ID": 9, **changes}.items():
        old = next(row for row in text.split("\n") if row.startswith(f"#define BOARD_{name} "))
        text = text.replace(old, f"#define BOARD_{name} {value}" if value is not None else "")
    (folder / "nano.def").write_text(text)


def test_a_file_more_is_a_board_more(clone):
    fourth(clone)
    done = listed(clone)
    assert done.stdout.split() == [*boards.BOARD_NAMES, "nano", "4"], done.stderr


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"CPU_HZ": None}, "BOARD_CPU_HZ is missing"),
        ({"CPU_HZ": "fast"}, "BOARD_CPU_HZ is not a number"),
        ({"AXES": 3}, "BOARD_AXES is 3, 4 rows BOARD_AXIS"),
    ],
)
def test_a_wrong_file_is_named(clone, changes, text):
    fourth(clone, **changes)
    done = listed(clone)
    assert done.returncode and f"nano.def: {text}" in done.stderr


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
