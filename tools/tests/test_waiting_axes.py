# SPDX-License-Identifier: MIT
"""Axes that wait for `go`, for their drivers or for their rest."""

from fractions import Fraction

import pytest

from bench import Bench
from effort import TRIED_BOARDS
from pixstep.board import registers as regs
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep_trials import lines
from test_bus import ALL, UNIT, Master, frame

pytestmark = pytest.mark.usefixtures("simulator")
HZ = Fraction(100)
# A plain line that does not wait for the clock.
CHAINED = [(1, 0), (0, 0), (3, 2), (2, 0)]


@pytest.mark.parametrize(("token", "settle_ms"), [(9, 0), (0, 1000)])
def test_a_line_that_is_held_back_takes_no_time_from_one_that_runs(token, settle_ms):
    line = lines.at_peak(lines.count_at(30_000, HZ), HZ, 0.5)
    with Bench("mega", [0], hz=HZ) as bench:
        bench.board.write_setting("enable_settle_ms", settle_ms)
        upload = bench.load(line)
        LineUpload(bench.board, 1, CHAINED).push()
        bench.arm()
        bench.run_until_steps(100)
        bench.board.write(regs.COMMAND_BASE, [2, regs.COMMANDS["arm"], token])
        while bench.state() == "running":
            upload.push()
            bench.sim.run(100_000)
        assert bench.fault() == "none"
        assert bench.state() == "done"
        assert bench.count() == line.total_steps


@pytest.mark.parametrize("board", TRIED_BOARDS)
def test_what_is_queued_right_behind_a_stop_is_kept_or_refused(board):
    entries = queue_entries(Line((3, 3), PLAIN))
    answers = set()
    with Bench(board, hz=5) as bench:
        master = Master(bench.sim, board)
        master.change(1_000_000, "N")
        for turn in range(12):
            bench.load(Line((1,) * 50, PLAIN))
            bench.arm()
            bench.run_until_steps(bench.count() + 1)
            bench.sim.run(6000 * turn)
            words = [bench.board.axis(0)["next_block"], 0, *(word for e in entries for word in e)]
            queue = frame(UNIT, 16, (0x1000, len(words)), 2 * len(words), words)
            master.send(frame(ALL, 16, (0x0100, 2), 4, (1, regs.COMMANDS["stop"])))
            answer = master.ask(queue)
            bench.sim.run(800_000)
            assert bench.state() == ("loaded" if answer[0] == 16 else "empty")
            answers.add(answer[:2])
            bench.board.command("discard", [0])
    assert answers <= {bytes([16, 0x10]), bytes([0x90, 6])}
