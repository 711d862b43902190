# SPDX-License-Identifier: MIT
"""A fly scan of two axes with bluesky and scanspec, on a simulated Mega with a poor pixel clock.

python fly_scan.py: prints how the run has ended and writes fly_scan.png here.
"""

import sys
import tempfile
from pathlib import Path

from bluesky import RunEngine
from bluesky.plans import fly
from scanspec.specs import Linspace

import pixstep as px

MACHINE = """
[clock]
pixel = 200
sync = "lock"
[boards.mega]
kind = "mega"
[motors.height]
axis = 0
kind = "smooth"
steps_per_unit = "3200 steps/mm"
limits = { max_acceleration = "25 mm/s2" }
[motors.angle]
axis = 1
kind = "smooth"
steps_per_unit = "200 steps/deg"
limits = { max_acceleration = "400 deg/s2" }
"""


def main() -> None:
    """Make the lines of a helical scan, fly them, draw what was flown."""
    file = Path(tempfile.mkdtemp()) / "machine.toml"
    file.write_text(MACHINE, encoding="utf-8")
    machine = px.Machine.load(file)
    spec = 0.02 @ Linspace("height", 0, 6, 121).zip(Linspace("angle", 0, 96, 121))
    lines = px.fly.lines_from_scanspec(
        spec, {"height": machine["height"], "angle": machine["angle"]}
    )
    documents = []
    engine = RunEngine()
    engine.subscribe(lambda name, document: documents.append((name, document)))
    clock = px.PixelClock(ppm=400, wander_ppm=60, jitter_us=3)
    with px.simulated_board("mega", pixel_hz=200, clock=clock) as board:
        for line in lines.values():  # to where the lines begin
            board.move(line.start_steps, profile=px.Profile((4, 8)), motor=line.motor).wait()
        engine(fly([px.fly.LineFlyer(board, list(lines.values()))]))
    stop = documents[-1][1]
    print(f"{stop['exit_status']}: {stop['num_events']['fly']} pixels")
    px.fly.plot(documents).savefig("fly_scan.png")


if __name__ == "__main__":
    try:
        main()
    except px.PlainError as error:
        sys.exit(f"fly_scan.py: {error}")
