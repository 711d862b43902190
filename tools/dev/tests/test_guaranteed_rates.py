# SPDX-License-Identifier: MIT
"""README, `limits` and `line check` tell the same guaranteed rates."""

import json
from fractions import Fraction

import pytest
from click.testing import CliRunner

from pixstep import natives
from pixstep.board import boards, guarantee
from pixstep.cli.main import main

COLUMNS = {
    ("constant", 30): 2, ("smooth", 30): 3, ("constant", 100): 4, ("smooth", 100): 5,
}  # fmt: skip
ROWS = [(board.name, axes) for board in boards.all_boards() for axes in range(1, board.axes + 1)]


def of_readme(board, axes, column):
    """Return the guaranteed rate and the highest clean one of a cell."""
    text = natives.source("README.md").read_text(encoding="utf-8")
    row = next(row for row in text.splitlines() if row.startswith(f"| `{board}` | {axes} |"))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    return [int(text.replace(",", "")) for text in cells[column].split(" / ")]


def called(*words):
    result = CliRunner().invoke(main, list(words))
    return result.exit_code, result.output


@pytest.mark.parametrize(("board", "axes"), ROWS)
@pytest.mark.parametrize("hz", [30, 100])
def test_readme_limits_and_line_check_agree(board, axes, hz, tmp_path):
    words = ("--board", board, "--axes", str(axes), "--pixel-hz", str(hz), "--json")
    _, told = called("limits", *words)
    rates = {row["motion"]: row["max_rate_steps_s"] for row in json.loads(told)["guaranteed"]}
    for motion in ("constant", "smooth"):
        promised, clean = of_readme(board, axes, COLUMNS[motion, hz])
        assert promised == rates[motion] <= clean
        line = guarantee.line_at(motion, promised // hz, Fraction(hz))
        file = tmp_path / f"{motion}.csv"
        file.write_bytes(b"".join(f"{count:6d}\r\n".encode() for count in line.counts))
        decode = "plain" if motion == "constant" else "smooth"
        status, checked = called("line", "check", str(file), "--decode", decode, *words)
        assert (status, json.loads(checked)["findings"]) == (0, [])
