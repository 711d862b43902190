# SPDX-License-Identifier: MIT
"""A machine with three motors, and jobs made for it."""

import math
import random
import shutil
from itertools import pairwise
from pathlib import Path

from pixstep import formats, natives
from pixstep.jobs import making
from pixstep.jobs.assembly import ImagePlace, MotorStroke
from pixstep.jobs.header import SourceTable
from pixstep.jobs.making import AskedImage, JobOptions
from pixstep.lines import units
from pixstep.lines.units import SPEED
from pixstep.machine.files import MachineFile
from pixstep.profiles import generator

PROFILE = "AccProfM39-30Hz-1.PRN"
MACHINE = """\
[clock]
pixel = "30 Hz"
divider = 1
sync = "lock"

[line]
lead_in = 4
pixels = 80

[boards.main]
kind = "mega"
port = "/dev/ttyACM0"
unit = 1

[motors.M39]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
direction = "+"
backlash = "250 steps"
profiles.line = "AccProfM39-30Hz-1.PRN"
profiles.move = "move.csv"
profiles.home = "home.csv"
limits.max_speed = "1200 steps/px"

[motors.M40]
axis = 1
kind = "plain"
steps_per_unit = "12.5 steps/deg"
limits.max_speed = "200 steps/px"
limits.max_acceleration = "60 steps/px2"
limits.start_stop = "60 steps/px"
profiles.line = "turn.PRN"

[motors.M41]
axis = 2
kind = "plain"
steps_per_unit = "400 steps/mm"
limits.max_speed = "100 steps/px"
limits.max_acceleration = "20 steps/px2"
limits.start_stop = "20 steps/px"
"""
HEADER = formats.ProfileHeader("Thu Nov 26 12:00:00 2026", "M39", 1, 3, 0, "30")


def write_machine(folder, text=MACHINE):
    """Write the machine file with its profiles into a folder; return the machine."""
    folder = Path(folder)
    shutil.copy(natives.example(PROFILE), folder)
    formats.write_prn(folder / "turn.PRN", [10, 25, 60, 110, 160])
    formats.write_csv(folder / "move.csv", [4, 12, 20, 28])
    formats.write_csv(folder / "home.csv", [2, 4, 6, 8], HEADER)
    (folder / "machine.toml").write_text(text)
    return MachineFile.load(folder / "machine.toml")


def image(lines=4, pixels=30, lead_in=8, **more):
    """Return an image of some size."""
    return making.ImageGeometry(lines, pixels, lead_in, more.pop("lead_out", lead_in), **more)


def speed(text="1000"):
    """Return a speed."""
    return units.parse(text, SPEED)


def make(machine, of=None, asked=None, **motions):
    """Return the job of an image: M39 scans, M41 steps, M40 turns, unless said otherwise."""
    wanted = {"scans": {"M39": speed()}, "steps": {"M41": 40}, "turns": {"M40": 400}, **motions}
    return making.of_image(machine, AskedImage(of or image(), **wanted), asked or JobOptions()).job


def large(machine, lines=1000, pixels=500):
    """Return a job of lines that differ: one shape of M39, others each time."""
    chance = random.Random(44)
    speeds, _ = formats.read_prn(machine.path.parent / PROFILE)
    asked = generator.LineRequest(1000, pixels, 250)
    along = tuple(generator.generate(speeds, asked).counts)
    strokes = {
        "M39": [MotorStroke(along, number % 2 == 1) for number in range(lines)],
        "M40": [MotorStroke(_swing(chance, pixels)) for _ in range(lines)],
        "M41": [MotorStroke(_swing(chance, pixels)) for _ in range(lines)],
    }
    places = [ImagePlace(25)] * lines
    return making.of_lines(machine, strokes, places, SourceTable(kind="lines"), JobOptions()).job


def _swing(chance, pixels):
    """Return the counts of a motor that swings and comes back."""
    phase, far = 6 * chance.random(), 200 + 200 * chance.random()
    places = [
        round(far * math.sin(phase + pixel / 30) * math.sin(math.pi * pixel / pixels) ** 2)
        for pixel in range(pixels + 1)
    ]
    return tuple(after - before for before, after in pairwise(places))
