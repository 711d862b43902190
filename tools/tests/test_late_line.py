# SPDX-License-Identifier: MIT
"""A line that reaches the queue of one axis too late: whoever follows the lines is told."""

from dataclasses import dataclass, replace

import pytest

import runbench
from pixstep import ops
from pixstep.board import run
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries

LINE = Line((0, 2, 4, 4, 2, 0), PLAIN)
LINE_S = 0.2


def queue(board, axis, line):
    upload = LineUpload(board, axis, queue_entries(line))
    upload.push()
    assert upload.done
    return upload


@dataclass
class Late:
    """Time in which something is done once, too late."""

    world: object
    at_s: float
    act: object

    def now_s(self):
        return self.world.now_s()

    def wait(self, seconds):
        self.world.wait(seconds)
        if self.act and self.now_s() >= self.at_s:
            act, self.act = self.act, None
            act()


@pytest.mark.parametrize("known", [False, True], ids=["by the others", "by what was sent"])
def test_an_axis_that_falls_a_line_behind_is_named(simulator, known):
    del simulator
    behind = replace(LINE, clocked=False)
    with runbench.bus() as link:
        board = link.board()
        ops.board_set(["sync=0"], link=link)
        run.command(board, "enable", [0, 1])
        axes = [1] if known else [0, 1]
        for axis in axes:
            queue(board, axis, LINE)
            upload = queue(board, axis, behind)
        if not known:
            queue(board, 0, behind)
        lines = run.LinesOfBoard(board, axes)
        run.arm_lines(lines)

        if known:  # three were sent, as far as the sender knows
            lines.uploads += [upload] * 3
        at_s = link.world.now_s() + (2.01 if known else 2.2) * LINE_S
        world = Late(link.world, at_s, lambda: queue(board, 1, behind))
        with pytest.raises(BoardError, match="axis 1 ended after 2 of 3 lines: line 3 reached"):
            run.follow([lines], world)
        assert run.states(board, [1])[1] == "loaded"


def test_a_line_that_waits_for_its_turn_is_no_fault(simulator):
    del simulator
    with runbench.bus() as link:
        board = link.board()
        ops.board_set(["sync=1"], link=link)
        run.command(board, "enable", [0, 1])
        for axis in (0, 1):
            queue(board, axis, LINE)
            queue(board, axis, LINE)  # it waits for the clock: it is armed by hand
        lines = run.LinesOfBoard(board, [0, 1])
        run.arm_lines(lines)
        run.follow([lines], link.world)
        assert set(run.states(board, [0, 1]).values()) == {"loaded"}
