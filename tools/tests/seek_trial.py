# SPDX-License-Identifier: MIT
"""One random seek on a simulated board, beside lines and commands, and what must be true of it."""

import random
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from bench import Bench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import Line
from pixstep.lines.units import period_ticks
from pixstep.simulation import verdict
from pixstep.simulation.logs import read_edges
from pixstep_trials.cases import Bounds, smooth_case

SEEK, SEEK_OPEN, DOWN, START, END = 0x81, 0x181, (3, 0), 0x01, (2, 0)
HZ = (Fraction(30), Fraction(100), Fraction(30000, 1001))
MOST_STEPS_PER_S = 20_000
FILTERS_US = (200, 1000, 4000)
AHEAD_TICKS = 0x20000
OWN_FAULTS = ("home_not_found", "home_stuck", "limit_minus", "limit_plus")
INTERRUPT_TICKS = 640  # until the capture is read, with the interrupts of more bounces between
SLACK_S = 0.01  # rounds of the main loop, a frame being served
REFUSED = {"settings": 6, "second": 4, "zero": 4, "disable": 4, "disarm": 4, "clear_fault": 4}
ZERO = 8
COMMANDS = ("none", "none", "none", "poll", "stop", "stop_other", *REFUSED)


@dataclass
class Trial:
    """What is asked of the board."""

    board: str
    seed: int
    rng: random.Random = field(init=False)

    def __post_init__(self):
        self.rng = rng = random.Random(f"seek {self.board} {self.seed}")
        table = boards.load(self.board)
        axes, self.tick_hz = table.axes, table.tick_hz
        self.hz = rng.choice(HZ)
        self.pixel = period_ticks(self.hz, self.tick_hz)
        self.slack_ticks = round(SLACK_S * self.tick_hz)
        self.others_bounds = Bounds(min_interval_ticks=1200, max_pixels=16, tick_hz=self.tick_hz)
        self.axis = rng.randrange(axes)
        others = [axis for axis in range(axes) if axis != self.axis]
        self.others = sorted(rng.sample(others, rng.randint(0, len(others))))
        self.lines = {axis: self._line() for axis in self.others}
        self.sign = rng.choice((1, -1))
        self.filter_us = rng.choice(FILTERS_US)
        self.high, self.inverted = rng.random() < 0.5, rng.random() < 0.5
        self.ramp = self._ramp()
        self.hold_px = rng.randint(1, 30)
        self.distance = rng.randint(6, int(1.2 * self.top_steps()) + 7)
        self.limit = rng.random() < 0.15 and not self.high
        self.command = rng.choice(COMMANDS)
        self.command_ticks = rng.randint(0, int(12 * self.pixel))

    def _line(self) -> Line:
        while (case := smooth_case(self.rng, self.others_bounds)).pixel_hz != self.hz:
            pass
        return case.line

    def _ramp(self):
        top = max(2, int(MOST_STEPS_PER_S / self.hz))
        ramp = sorted(self.rng.randint(0, top) for _ in range(self.rng.randint(1, 8)))
        return [*ramp[:-1], max(1, ramp[-1])]

    def top_steps(self):
        """Return the steps up to the down mark."""
        return sum(self.ramp) + self.hold_px * self.ramp[-1]

    @property
    def filter_ticks(self):
        """Return the filter's time in ticks."""
        return self.filter_us * self.tick_hz // 1_000_000

    @property
    def pin_rises(self):
        """The home pin goes high when the axis has gone the distance."""
        return (self.sign > 0) == self.high

    @property
    def opening(self):
        """The board calls that opening."""
        return self.pin_rises != self.inverted

    def entries(self):
        """Return the seek as queue entries."""
        up = [(self.sign * count, 1) for count in self.ramp]
        down = [(self.sign * count, 1) for count in reversed(self.ramp[:-1])]
        hold = (self.sign * self.ramp[-1], self.hold_px)
        word = SEEK_OPEN if self.opening else SEEK
        return [(word, 0), (0, 0), *up, hold, DOWN, *down, END]

    def totals(self):
        """Return the steps of the seek for every pixel behind which it may slow down."""
        pixels = self.ramp + [self.ramp[-1]] * self.hold_px
        down = self.ramp[-2::-1]
        totals, made = {0}, 0
        for count in pixels:
            made += count
            rest = next((at for at, less in enumerate(down) if less < count), len(down))
            totals.add(made + sum(down[rest:]))
        return totals | {made + sum(down)}

    def knobs(self):
        """Return the mechanics: the switch changes behind `distance` steps."""
        rng, bounce = self.rng, self.rng.choice((0, 0, 2, 8))
        home = self.distance if self.sign > 0 else 5 - self.distance
        text = f"home={home},hyst=5,start=0,active={'high' if self.high else 'low'}"
        text += f",over=1000000,delay={rng.choice((0, 0, rng.randint(1, 40_000)))}"
        if bounce:
            most = self.filter_us * 16 * 9 // 10
            ticks = rng.choice((most, max(bounce, round(most ** rng.random()))))
            text += f",bounce={bounce},bounce_ticks={ticks},seed={self.seed}"
        if self.limit:
            at = max(1, self.distance // 2)
            text += f",travel={-at}..{at}"
        return f"0.{self.axis}:{text}"


class Run:
    """A trial on the board."""

    def __init__(self, trial, folder):
        self.trial, self.path = trial, folder / f"{trial.board}{trial.seed}.csv"
        self.switch_path = folder / f"{trial.board}{trial.seed}.switches.csv"
        axes = sorted([trial.axis, *trial.others])
        self.bench = Bench(
            trial.board,
            axes,
            trial.hz,
            self.path,
            extra=("--plant", trial.knobs(), "--switch-log", self.switch_path),
        )
        self.stopped, self.zeroed = set(), False

    def go(self):
        """Run it; return how it ended and the tick difference of the captured edge, if any."""
        with self.bench as bench:
            self._set_up()
            self._arm()
            bench.sim.run(self.trial.command_ticks)
            self._give_command()
            bench.until(self._over, 20)
            if self.zeroed:
                return "zeroed", None
            bench.assert_rest()
            bench.sim.command("flush")
            return self._judge()

    def _write(self, name, value):
        self.bench.board.write_setting(name, value)

    def _set_up(self):
        trial, bench = self.trial, self.bench
        self._write("input_filter_us", trial.filter_us)
        self._write("inputs_inverted", int(trial.inverted))
        bench.sim.run(bench.sim.tick_hz // 20 + trial.rng.randint(0, 200_000))
        for axis, line in trial.lines.items():
            bench.load(line, axis)
        seek = LineUpload(bench.board, trial.axis, trial.entries())
        seek.push()
        assert seek.done, bench.state(trial.axis)

    def _arm(self):
        trial, bench = self.trial, self.bench
        groups = [[axis] for axis in (trial.axis, *trial.others)]
        trial.rng.shuffle(groups)
        for group in groups:
            bench.sim.run(trial.rng.randint(0, int(3 * trial.pixel)))
            try:
                bench.board.command("arm", group)
            except BoardError as error:
                assert error.code == 4 and bench.fault() in OWN_FAULTS, bench.fault()

    def _give_command(self):
        trial, board = self.trial, self.bench.board
        name = trial.command
        moving = self.bench.state(trial.axis) == "running"
        if name == "poll":
            for _ in range(40):
                board.inputs()
                board.axes(len(self.bench.axes))
        elif name in ("stop", "stop_other"):
            axis = trial.rng.choice(trial.others or [trial.axis]) if "_" in name else trial.axis
            self.stopped.add(axis)
            board.command("stop", [axis])
        elif name in REFUSED and moving:
            self._refused(name)

    def _refused(self, name):
        board, axis = self.bench.board, self.trial.axis
        try:
            if name == "settings":
                self._write("input_filter_us", 5000)
            elif name == "second":
                board.command("arm", [axis])
            else:
                self._command(name, axis)
        except BoardError as error:
            assert error.code == REFUSED[name], (name, error)
            return
        # It came to rest meanwhile.
        assert self.bench.state(axis) != "running", f"{name} was taken by an axis that moves"
        self.zeroed = name == "zero"

    def _command(self, name, axis):
        number = ZERO if name == "zero" else regs.COMMANDS[name]
        self.bench.board.write(regs.COMMAND_BASE, [1 << axis, number])

    def _over(self):
        return all(self.bench.state(axis) not in ("armed", "running") for axis in self.bench.axes)

    def _judge(self):
        trial, board = self.trial, self.bench.board
        state = board.inputs()
        fault = regs.code_name(regs.faults(), state["fault_code"])
        log = read_edges(self.path)
        rising = log.axis(0, trial.axis).rising
        for axis in trial.others:
            if axis not in self.stopped:
                line = trial.lines[axis]
                found = verdict.judge_axis(
                    line,
                    trial.pixel,
                    log.axis(0, axis),
                    tick_hz=trial.tick_hz,
                    stopped=fault != "none",
                )
                assert found.reasons == [], (axis, found.reasons)
        answer = self.bench.sim.command(f"switches 0 {trial.axis}").split()
        changed = int(answer[7])
        if trial.limit and fault.startswith("limit"):
            return self._limit(fault)
        if trial.axis in self.stopped and not state["trip_code"] and fault == "none":
            return "stopped", None
        if fault != "none":
            self._not_found(fault, rising, changed)
            return fault, None
        if trial.command == "clear_fault" and not state["trip_code"]:
            most = max(trial.totals())
            # The fault that was cleared ended the seek: its limit in the middle, or no switch.
            assert trial.limit or len(rising) == most, (len(rising), most)
            assert len(rising) <= most, (len(rising), most)
            return "cleared", None
        return self._tripped(state, rising, changed)

    def _limit(self, fault):
        trial, bench = self.trial, self.bench
        assert fault == ("limit_plus" if trial.sign > 0 else "limit_minus")
        before = bench.sim.steps(0, trial.axis)
        bench.board.command("clear_fault", bench.axes)
        away = LineUpload(bench.board, trial.axis, [(START, 0), (0, 0), (-trial.sign * 2, 4), END])
        away.push()
        bench.board.command("arm", [trial.axis])
        bench.until(self._over)
        assert bench.fault() == "none"
        assert bench.sim.steps(0, trial.axis) == before - trial.sign * 8
        return "limit", None

    def _not_found(self, fault, rising, changed):
        trial = self.trial
        assert fault == ("home_stuck" if trial.opening else "home_not_found"), fault
        assert len(rising) == max(trial.totals())
        if len(rising) >= trial.distance:  # it changed as the axis came to rest
            late = 2 * trial.filter_ticks + trial.slack_ticks + int(trial.pixel)
            assert changed > rising[-1] - late, "a switch that changed in time was not seen"

    def _tripped(self, state, rising, changed):
        trial = self.trial
        if trial.axis in self.stopped:
            assert len(rising) <= max(trial.totals())
        else:
            assert len(rising) in trial.totals(), (len(rising), trial.totals())
            self._stopped_soon(rising, changed)
        assert state["trip_axis"] == trial.axis
        assert state["trip_code"] == (2 if trial.opening else 1)
        if self._bounced_at_once(changed):
            found = trial.sign * state["trip_position_steps"]
            first, last = np.searchsorted(rising, (changed, changed + INTERRUPT_TICKS), "right")
            assert first <= found <= last, (state, first, last)
            return "bounced", None
        steps = trial.sign * int(np.count_nonzero(rising <= changed))
        assert state["trip_position_steps"] == steps, (state["trip_position_steps"], steps)
        self._command("zero", trial.axis)
        position = self.bench.board.axis(trial.axis)["position_steps"]
        assert position == trial.sign * len(rising) - steps
        return "tripped", (changed - state["trip_ticks"]) % (1 << 32)

    def _bounced_at_once(self, changed):
        """The hardware holds the newest edge until its interrupt comes: it may be the next one."""
        level = str(int(self.trial.pin_rises))
        rows = (row.split(",") for row in self.switch_path.read_text().split()[1:])
        again = [int(row[0]) for row in rows if row[3].lower() == "home" and row[4] == level]
        return any(changed < cycle <= changed + INTERRUPT_TICKS for cycle in again)

    def _stopped_soon(self, rising, changed):
        trial = self.trial
        limit = trial.filter_ticks + AHEAD_TICKS + (len(trial.ramp) + 1) * trial.pixel
        bounce = trial.filter_ticks
        assert rising[-1] - changed <= limit + bounce + trial.slack_ticks
