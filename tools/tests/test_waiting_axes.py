# SPDX-License-Identifier: MIT
"""Axes that wait for `go` or for their drivers beside axes that run."""

from fractions import Fraction

import pytest

from bench import Bench
from pixstep.bench import lines
from pixstep.board import registers as regs
from pixstep.board.client import Upload

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
        Upload(bench.board, 1, CHAINED).push()
        bench.arm()
        bench.run_until_steps(100)
        bench.board.write(regs.COMMAND_BASE, [2, regs.COMMANDS["arm"], token])
        while bench.state() == "running":
            upload.push()
            bench.sim.run(100_000)
        assert bench.fault() == "none"
        assert bench.state() == "done"
        assert bench.count() == line.total_steps
