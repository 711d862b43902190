# SPDX-License-Identifier: MIT
"""Record a run of a board in pixstep-sim, with all its wires, for crosscheck.cjs.

    python record.py RUN BOARD FOLDER        RUN: smooth, saturated, homing, estop or locked

The folder then holds edges.csv, serial.csv, wires.csv and end.txt, the cycle that was reached.
"""

import random
import sys
from fractions import Fraction
from pathlib import Path

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.moves import fast, homing, legs
from pixstep.profiles.generator import LineRequest, generate
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard

SETTLE_S = 0.02
HOMING_HZ = Fraction(500)
LOCK = 2  # of setting `sync`
LOCKED_S = 0.4  # until the board has measured the clock
LOCKED_PX = 300
# Steps a pixel: the M39's profile, up to the speed that a line asks for.
PROFILE = [6 * pixel * (pixel + 1) for pixel in range(1, 20)]


class Recording:
    """A board, its lines and its log files."""

    def __init__(
        self,
        name: str,
        folder: Path,
        pixel_hz: Fraction,
        knobs: dict[int, str],
        clock: tuple[str, ...] = (),
    ) -> None:
        self.folder, self.pixel_hz = folder, pixel_hz
        self.axes = list(range(boards.load(name).axes))
        self.uploads: dict[int, LineUpload] = {}
        folder.mkdir(parents=True, exist_ok=True)
        self.simulated = SimulatedBoard(
            name,
            pixel_hz,
            edges=folder / "edges.csv",
            serial_log=folder / "serial.csv",
            plants={(0, axis): text for axis, text in knobs.items()},
            extra=("--wire-log", str(folder / "wires.csv"), *clock),
        )
        self.simulator, self.board = self.simulated.simulator, self.simulated.board

    def __enter__(self) -> "Recording":
        self.board.set_pixel_hz(self.pixel_hz)
        return self

    def __exit__(self, *_: object) -> None:
        end = self.simulator.wait_s(SETTLE_S)
        self.simulated.finish()
        (self.folder / "end.txt").write_text(f"{end}\n", encoding="ascii")

    def start(self, lines: dict[int, Line]) -> None:
        """Load a line into each of these axes and arm them together."""
        self.board.command("enable", list(lines))
        self.board.command("permit_on", [])
        for axis, line in lines.items():
            self.uploads[axis] = LineUpload(self.board, axis, queue_entries(line))
            self.uploads[axis].push()
        self.board.command("arm", list(lines))

    def done(self) -> bool:
        """Push more of the lines; True once every axis has done its own."""
        for upload in self.uploads.values():
            upload.push()
        states = self.board.axes(len(self.axes))
        ends = [regs.axis_state(states[axis]["axis_state"]) for axis in self.uploads]
        if any(state in ("fault", "refused") for state in ends):
            raise UserError(f"axes are {', '.join(ends)}: {self.board.fault_text()}")
        return all(state == "done" for state in ends)

    def fault(self) -> str:
        """Return the name of the latched fault."""
        return regs.code_name(regs.faults(), self.board.input("fault_code"))


def smooth(name: str, folder: Path) -> None:
    """Record smooth lines with a backlash to take up, another one on every axis."""
    speeds, pixels = ([1000], 60) if name == "uno" else ([700, 600, 500, 400], 30)
    with Recording(name, folder, Fraction(30), {}) as run:
        run.start(
            {
                axis: Line(
                    tuple(generate(PROFILE, LineRequest(speed, pixels, 250)).counts),
                    backlash=250,
                    negative=axis % 2 == 1,
                )
                for axis, speed in enumerate(speeds)
            }
        )
        while not run.done():
            run.simulator.wait_s(0.1)


def saturated(name: str, folder: Path) -> None:
    """Record plain lines that reverse, while requests follow one another without a pause."""
    up = [2, 12, 30, 60, 90, 120]
    stroke = [*up, *[130] * 4, *reversed(up), 0]
    counts = [*stroke, *[-count for count in stroke]] * 2
    with Recording(name, folder, Fraction(100), {}) as run:
        axes = run.axes[:2]
        run.start({axis: Line(tuple(counts[axis:]), PLAIN) for axis in axes})
        load = SerialLoad(run.board, axes, run.uploads)
        while not run.done():
            load.until(run.simulator, run.simulator.cycle + run.simulator.cycles(0.02))


def home(name: str, folder: Path) -> None:
    """Record homings to a switch that is late and bounces: for long, and within the capture."""
    knobs = "home=0,hyst=2,travel=-900..900,start=-480,delay=1500,bounce=6,bounce_ticks=9000"
    profile = fast.Acceleration((2, 20, 50, 70, 110), haps=4)
    axis = 0 if name == "uno" else 2
    with Recording(name, folder, HOMING_HZ, {axis: knobs}) as run:
        run.board.command("enable", [axis])
        run.simulator.wait_s(SETTLE_S)  # the filters see the switches
        request = legs.HomingRequest(axis, 1, slow=2, search_steps=2500, clear_steps=5)
        plan = legs.plan(profile, request, HOMING_HZ)
        for ticks in (9000, 60):
            run.simulator.knobs(0, axis, f"bounce_ticks={ticks}")
            homing.home(run.board, plan, HOMING_HZ, run.simulated.link.world)


STOPPED_PERIOD_CYCLES = 2000  # 80 steps in a pixel of 10 ms


def estop(name: str, folder: Path) -> None:
    """Record emergency stops of moving axes, each contact bouncing in its own way.

    Every period ends at a multiple of STOPPED_PERIOD_CYCLES. The contact has bounced and the stop's
    handler is done before such an end, whatever it had to wait for: with other prescalers it waits
    for something else, and a period more or less would be made.
    """
    rng = random.Random(name)
    pin = next(pin for pin in boards.load(name).pins if pin.signal == "ESTOP")
    counts = (4, 20, *[80] * 20, 20, 4)
    with Recording(name, folder, Fraction(100), {}) as run:
        for _ in range(4):
            run.start({axis: Line(counts[axis:], PLAIN) for axis in run.axes})
            within = map(run.simulator.cycles, (0.1, 0.15))
            trip = run.simulator.cycle + rng.randrange(*within)
            trip += rng.randrange(100, 500) - trip % STOPPED_PERIOD_CYCLES
            for level in (0, 1, 0, 1, 0):
                run.simulator.pin(0, pin.port, pin.bit, level, at=trip)
                trip += rng.randrange(20, 300)
            run.simulator.run(trip - run.simulator.cycle + run.simulator.cycles(SETTLE_S))
            if run.fault() != "estop":
                raise UserError("the emergency stop was not seen")
            run.simulator.pin(0, pin.port, pin.bit, 1)
            run.simulator.wait_s(0.001)
            run.board.command("clear_fault", [])
            run.board.command("discard", run.axes)


def locked(name: str, folder: Path) -> None:
    """Record lines that follow a clock which is off, jitters, misses edges and has false ones."""
    clock = ("--pixel-ppm", "900", "--pixel-jitter-rms-ns", "5000")
    clock += ("--pixel-drop", "37", "--pixel-double", "41")
    rng = random.Random(name)
    with Recording(name, folder, Fraction(500), {}, clock) as run:
        run.board.write_setting("sync", LOCK)
        run.simulator.wait_s(LOCKED_S)
        run.start(
            {
                axis: Line(tuple(rng.randint(4, 20) for _ in range(LOCKED_PX)), PLAIN)
                for axis in run.axes
            }
        )
        while not run.done():
            run.simulator.wait_s(0.02)


RUNS = {
    "smooth": smooth,
    "saturated": saturated,
    "homing": home,
    "estop": estop,
    "locked": locked,
}

if __name__ == "__main__":
    _, wanted, board_name, out = sys.argv
    RUNS[wanted](board_name, Path(out))
