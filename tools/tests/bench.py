# SPDX-License-Identifier: MIT
"""A simulated board under direct command, for tests of what a whole run never does."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from pixstep.board import registers as regs
from pixstep.board.upload import LineUpload
from pixstep.lines.runs import queue_entries
from pixstep.lines.units import period_ticks
from pixstep.simulation import verdict
from pixstep.simulation.logs import read_edges
from pixstep.simulation.simulated_board import SimulatedBoard

QUIET_S = 0.05
_POLL_S = 0.002


class Bench:
    """One board with its axes enabled; use as a context manager."""

    def __init__(
        self, board, axes=(0,), hz=Fraction(100), edges: Path | None = None, plants=None, extra=()
    ):
        self.name, self.axes, self.hz, self.edges_path = board, list(axes), Fraction(hz), edges
        self.options = {"edges": edges, "plants": plants or {}, "extra": extra}

    def __enter__(self):
        self.run = SimulatedBoard(self.name, self.hz, **self.options)
        self.sim, self.board, self.world = self.run.simulator, self.run.board, self.run.link.world
        try:
            self.run.set_up(self.hz, self.axes)
        except BaseException:
            self.sim.kill()
            raise
        return self

    def __exit__(self, *_):
        self.sim.kill()

    @property
    def pixel_ticks(self):
        """Whole ticks of the pixel period."""
        return int(period_ticks(self.hz, self.sim.tick_hz))

    def load(self, line, axis=0):
        """Upload as much of a line as the queue takes."""
        upload = LineUpload(self.board, axis, queue_entries(line))
        upload.push()
        return upload

    def arm(self):
        self.board.command("arm", self.axes)

    def state(self, axis=0):
        return regs.AXIS_STATES[self.board.axis(axis)["axis_state"]]

    def fault(self):
        return regs.code_name(regs.faults(), self.board.input("fault_code"))

    def count(self, axis=0):
        """Rising STEP edges so far."""
        return int(self.sim.command(f"counts 0 {axis}").split()[1])

    def until(self, done, seconds=3):
        """Let time pass in short stretches until done() holds."""
        limit = self.sim.cycle + int(seconds * self.sim.tick_hz)
        while not done():
            assert self.sim.cycle < limit, f"still {[self.state(axis) for axis in self.axes]}"
            self.sim.wait_s(_POLL_S)

    def run_until_steps(self, steps, axis=0):
        self.until(lambda: self.count(axis) >= steps)

    def run_until_fault(self):
        self.until(lambda: self.board.input("fault_code"))
        return self.fault()

    def assert_rest(self):
        """No edge follows, and every axis counts the edges that it made."""
        before = [self.count(axis) for axis in self.axes]
        self.sim.wait_s(QUIET_S)
        assert [self.count(axis) for axis in self.axes] == before
        positions = [self.board.axis(axis)["position_steps"] for axis in self.axes]
        assert positions == [self.sim.steps(0, axis) for axis in self.axes]

    def pass_line(self, line, axis=0):
        """Run a line to its end and require the verdict of its edges alone to be a pass."""
        before = self.count(axis)
        self.load(line, axis)
        self.board.command("arm", [axis])
        self.until(lambda: self.state(axis) == "done")
        self.assert_rest()
        self.sim.command("flush")
        made = read_edges(self.edges_path).axis(0, axis)
        start = made.rising[before - 1] + 1 if before else 0
        later = replace(
            made,
            step_cycles=made.step_cycles[2 * before :],
            step_levels=made.step_levels[2 * before :],
            direction_cycles=made.direction_cycles[made.direction_cycles > start],
            direction_levels=made.direction_levels[made.direction_cycles > start],
        )
        found = verdict.judge_axis(
            line, period_ticks(self.hz, self.sim.tick_hz), later, tick_hz=self.sim.tick_hz
        )
        assert found.reasons == []
        assert found.steps == line.total_steps
