# SPDX-License-Identifier: MIT
"""What goes wrong on the real images: named, without a step more, every step counted."""

import json
import random
from fractions import Fraction

import pytest
from click.testing import CliRunner

from bench import QUIET_S, Bench
from pixstep import formats
from pixstep.board import boards
from pixstep.board.errors import BoardError
from pixstep.cli.main import main
from pixstep.lines.line import PLAIN, Line
from pixstep_trials import lines

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = boards.BOARD_NAMES
LONG = Line((40,) * 60, PLAIN)
SHORT = Line((4, 16, 24, 24, 20, 8, 0))
# 45,000 steps/s at 30 Hz, every pixel accelerating or braking: one axis does that, four cannot.
TOO_FAST_FOR_FOUR = lines.at_peak(1500, Fraction(30), 0.3)


@pytest.mark.parametrize("phase", range(12))
def test_four_axes_too_fast_for_the_mega_are_decoder_late(phase):
    """The decoder is in the middle of a round when a ring runs dry: no phase may lose a step."""
    with Bench("mega", range(4), 30) as bench:
        bench.sim.run(phase * 5000)
        for axis in bench.axes:
            bench.load(TOO_FAST_FOR_FOUR, axis)
        bench.arm()
        assert bench.run_until_fault() == "decoder_late"
        bench.assert_rest()
        assert {bench.state(axis) for axis in bench.axes} == {"fault"}


@pytest.mark.parametrize("board", BOARDS)
def test_no_pixel_clock_while_armed(board):
    with Bench(board) as bench:
        bench.sim.command("clock off")
        bench.load(LONG)
        bench.arm()
        assert bench.run_until_fault() == "pixel_clock_missing"
        bench.assert_rest()
        assert bench.count() == 0


@pytest.mark.parametrize("loss", ["clock off", "clock drop 1"])
@pytest.mark.parametrize("board", BOARDS)
def test_pixel_clock_lost_while_running(board, loss):
    with Bench(board) as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(400)
        bench.sim.command(loss)
        assert bench.run_until_fault() == "pixel_clock_missing"
        bench.assert_rest()
        assert 400 <= bench.count() < 400 + 4 * 40


REFUSED = [
    ([10, 10, 10], 0, "oscillates"),
    ([4, 3], 0, "reverses_inside_pixel"),
    ([0, 4, 8, 4, 0], 9, "backlash_over_speed"),
    ([4, 12], 0, "ends_moving"),
    ([4, 0, 4], 0, "zero_while_moving"),
    ([4500, 9000, 4500], 0, "too_fast"),
    ([4, 8, 4], 4, "backlash_no_room"),
]


@pytest.mark.parametrize(("counts", "backlash", "name"), REFUSED)
@pytest.mark.parametrize("board", BOARDS)
def test_the_board_refuses_by_itself(tmp_path, board, counts, backlash, name):
    formats.write_csv(tmp_path / "line.csv", counts)
    words = [
        "sim", tmp_path / "line.csv", "--board", board, "--decode", "smooth", "--pixel-hz", 30,
        "--backlash", backlash, "--no-check", "--out", tmp_path / "run", "--json",
    ]  # fmt: skip
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exit_code != 0
    summary = json.loads(done.stdout)
    assert summary["verdict"] == "refused"
    assert summary["refusal"]["name"] == name
    assert summary["refusal"]["step_edges"] == 0
    assert ",STEP," not in (tmp_path / "run" / "edges.csv").read_text()


@pytest.mark.parametrize("board", BOARDS)
def test_a_refused_line_is_discarded_and_the_next_one_runs(tmp_path, board):
    with Bench(board, edges=tmp_path / "edges.csv") as bench:
        with pytest.raises(BoardError, match="oscillates at pixel 1"):
            bench.load(Line((10, 10, 10)))
        assert bench.state() == "refused"
        with pytest.raises(BoardError):
            bench.arm()
        bench.assert_rest()
        bench.board.command("discard", [0])
        bench.pass_line(SHORT)


@pytest.mark.parametrize("board", BOARDS)
def test_a_repeated_block_is_taken_once_and_a_wrong_one_refused(tmp_path, board):
    with Bench(board, edges=tmp_path / "edges.csv") as bench:
        block, entries = bench.load(SHORT).last
        before = bench.board.axis(0)
        data = b"".join(entries)
        bench.board.write_packed(0, block, data)
        assert bench.board.axis(0) == before
        for wrong in (block + 2, block - 1):
            with pytest.raises(BoardError) as refusal:
                bench.board.write_packed(0, wrong, data)
            assert refusal.value.code == 3
        assert bench.board.axis(0) == before
        bench.arm()
        bench.until(lambda: bench.state() == "done")
        bench.assert_rest()
        assert bench.count() == SHORT.total_steps


@pytest.mark.parametrize("board", BOARDS)
def test_stop_then_another_line(tmp_path, board):
    with Bench(board, edges=tmp_path / "edges.csv") as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(500)
        bench.board.command("stop", [0])
        bench.assert_rest()
        assert bench.fault() == "none" and bench.state() == "empty"
        assert 500 <= bench.count() < LONG.total_steps
        bench.pass_line(SHORT)


@pytest.mark.parametrize("board", BOARDS)
def test_position_is_exact_wherever_a_run_is_cut_off(board):
    chance = random.Random(f"stop {board}")
    for line in (LONG, Line((300,) * 30, PLAIN), Line((20, 60, 120, *([160] * 10), 120, 60, 20))):
        for _ in range(5):
            with Bench(board) as bench:
                bench.load(line)
                bench.arm()
                bench.run_until_steps(chance.randint(30, 1200))
                bench.sim.run(chance.randint(1, 600))
                bench.board.command("stop", [0])
                bench.assert_rest()  # position and edges agree
                assert 30 <= bench.count() < line.total_steps


@pytest.mark.parametrize("board", BOARDS)
def test_clear_fault_then_another_line(tmp_path, board):
    with Bench(board, edges=tmp_path / "edges.csv") as bench:
        bench.load(LONG)
        bench.arm()
        bench.run_until_steps(300)
        bench.sim.command("clock off")
        assert bench.run_until_fault() == "pixel_clock_missing"
        with pytest.raises(BoardError):
            bench.arm()
        bench.assert_rest()
        bench.sim.command("clock on")
        bench.board.command("clear_fault", [0])
        assert bench.fault() == "none" and bench.state() == "empty"
        bench.pass_line(SHORT)


def test_after_decoder_late_four_axes_run_again():
    slower = Line((4, 12, 24, 40, 52, 56, 50, 38, 22, 10, 4), PLAIN)
    with Bench("mega", range(4), 30) as bench:
        for axis in bench.axes:
            bench.load(TOO_FAST_FOR_FOUR, axis)
        bench.arm()
        assert bench.run_until_fault() == "decoder_late"
        bench.board.command("clear_fault", bench.axes)
        made = [bench.count(axis) for axis in bench.axes]
        for axis in bench.axes:
            bench.load(slower, axis)
        bench.arm()
        bench.until(lambda: all(bench.state(axis) == "done" for axis in bench.axes))
        bench.sim.wait_s(QUIET_S)
        assert [bench.count(axis) - old for axis, old in enumerate(made)] == [312] * 4
