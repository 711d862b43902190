# SPDX-License-Identifier: MIT
"""Lines of one board from its settings to their last pixel, on any link.

run = BoardRun(link)
run.set_up(Fraction(30), [0])
run.load({0: line})
run.arm()
in_time = run.follow()
"""

from collections.abc import Mapping
from fractions import Fraction

from pixstep.board import clockstate, orders
from pixstep.board import registers as regs
from pixstep.board.errors import IMPOSSIBLE, BoardError
from pixstep.board.link import Link
from pixstep.board.upload import Upload, feed, pause_s, said_divider
from pixstep.lines.line import Line
from pixstep.lines.runs import queue_entries

ENDS = frozenset({"done", "fault", "refused"})
# Between two polls of the status, which costs the board little; and between two looks at all that
# it says of its axes, which keeps the board from its steps for some 30,000 cycles.
_POLL_PIXELS, _POLL_S, _POLL_LEAST_S = 4, 0.1, 0.05
_LOOK_S = 0.25
_MEASURING_EDGES = 3000  # of a clock however bad, after which a board that can has measured it
_SLOWEST = 1.06  # the longest pixel that a lock to the clock may make, and a little more
_START_PIXELS, _START_S = 10, 0.5  # from arming to the last pixel there is this much to spare


class Watch:
    """What is done while lines are followed: nothing but waiting, unless a subclass does more."""

    @property
    def look_s(self) -> float:
        """Seconds between two looks at the axes."""
        return _LOOK_S

    def seen(self, registers: Mapping[int, Mapping[str, int]]) -> None:
        """Take what a look has read of each axis."""

    def rest(self, run: "BoardRun", begun_s: float) -> None:
        """Let time pass until the next poll; the last one began at `begun_s`."""
        left_s = begun_s + run.poll_s - run.link.world.now_s()
        if left_s > 0:
            run.link.world.wait(left_s)


class BoardRun:
    """One board and the lines that it runs; every method raises BoardError as `Board` does."""

    def __init__(self, link: Link, unit: int = 1) -> None:
        self.link = link
        self.board = link.board(unit)
        self.axes: list[int] = []
        self.uploads: dict[int, Upload] = {}
        self.deadline_s = 0.0
        self._clock_s = self._period_s = 0.0
        self._pixels = 0
        self._divider: int | None = None  # that lines say

    @property
    def poll_s(self) -> float:
        """Seconds from one poll to the next."""
        poll_s = max(_POLL_LEAST_S, min(_POLL_PIXELS * self._period_s, _POLL_S))
        return pause_s(self.uploads.values(), self._period_s, poll_s)

    def set_up(self, pixel_hz: Fraction, axes: list[int], **settings: int) -> None:
        """Set the pixel clock and some settings by name, enable the axes.

        Setting `divider` goes with the lines, if the board takes it so.
        """
        self.axes = sorted(axes)
        self._clock_s = float(1 / pixel_hz)
        self._period_s = settings.get("divider", 1) * self._clock_s
        self._divider = said_divider(self.board, settings.get("divider"))
        if self._divider is not None:
            del settings["divider"]
        self.board.set_pixel_hz(pixel_hz)
        for name, value in settings.items():
            self.board.write_setting(name, value)
        self.board.command("enable", self.axes)

    def load(self, lines: Mapping[int, Line]) -> None:
        """Queue every line, or as much of it as the queue holds.

        Raises LineRefusedByBoardError if the board refuses one.
        """
        self.uploads = {}
        self._pixels = max(line.pixels for line in lines.values())
        for axis, line in sorted(lines.items()):
            self.uploads[axis] = Upload(self.board, axis, queue_entries(line, self._divider))
            self.uploads[axis].push()
            state = regs.axis_state(self.board.axis(axis)["axis_state"])
            if state == "refused":
                raise self.board.refusal(axis)
            if state != "loaded":
                raise BoardError(f"axis {axis}: {state} after the upload, not loaded")

    def await_clock(self) -> None:
        """Wait until the board has measured the pixel clock: what a locked line begins with."""
        clockstate.await_measured(self.board, self.link.world, self._clock_s, _MEASURING_EDGES)

    def arm(self) -> None:
        """Arm all loaded axes at once: their lines start on one pixel clock edge.

        Raises LineRefusedByBoardError for lines that are too fast together.
        """
        try:
            orders.arm(self.board, sorted(self.uploads))
        except BoardError as error:
            if error.code == IMPOSSIBLE:
                self._raise_too_fast()
            raise
        lasts_s = (self._pixels + _START_PIXELS) * self._period_s * _SLOWEST + _START_S
        self.deadline_s = self.link.world.now_s() + lasts_s

    def _raise_too_fast(self) -> None:
        for axis in sorted(self.uploads):
            refusal = self.board.refusal(axis)
            if refusal.name == "too_fast_together":
                raise refusal from None

    def states(self) -> dict[int, str]:
        """Return the state of each axis by name."""
        return {axis: regs.axis_state(found["axis_state"]) for axis, found in self._look().items()}

    def follow(self, watch: Watch | None = None) -> bool:
        """Poll and stream until every axis is at its end; False if that takes too long."""
        watch = watch or Watch()
        while True:
            begun_s = self.link.world.now_s()
            found = self._look()
            watch.seen(found)
            if all(regs.axis_state(axis["axis_state"]) in ENDS for axis in found.values()):
                return True
            if self.link.world.now_s() > self.deadline_s:
                return False
            self._poll(watch, begun_s)

    def _poll(self, watch: Watch, begun_s: float) -> None:
        """Poll and stream until it is time for a look again, or something has come to its end."""
        look_s = begun_s + watch.look_s
        while True:
            feed(self.uploads.values())
            watch.rest(self, begun_s)
            begun_s = self.link.world.now_s()
            if begun_s >= look_s or not self.board.moving():
                return

    def _look(self) -> dict[int, dict[str, int]]:
        """Return the registers of each axis, read in one request."""
        found = self.board.axes(self.axes[-1] + 1)
        return {axis: found[axis] for axis in self.axes}
