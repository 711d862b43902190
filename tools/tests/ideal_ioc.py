# SPDX-License-Identifier: MIT
"""`pixstep ioc` with ideal steppers in place of boards: python ideal_ioc.py FOLDER ioc ...

IDEAL_HOME is where the home switches are, in steps; far away unless it says so. Each step of each
motor goes to FOLDER/MOTOR.edges, a line `time_s position` each, at the end.
"""

import contextlib
import os
import sys
from pathlib import Path

from ideal_drive import IdealDrive, Stepper
from pixstep.__main__ import run
from pixstep.operations import ioc


@contextlib.contextmanager
def ideal(folder, machine, port, log, *, simulate):
    """Yield ideal drives."""
    del port, log, simulate
    home = float(os.environ.get("IDEAL_HOME", "1e8"))
    drives = {name: IdealDrive(Stepper(home=home)) for name in machine.motors}
    try:
        yield drives
    finally:
        for name, drive in drives.items():
            rows = (f"{time_s:.6f} {steps}\n" for time_s, steps in drive.motor.edges)
            (folder / f"{name}.edges").write_text("".join(rows))


if __name__ == "__main__":
    place = Path(sys.argv.pop(1))
    ioc.opened = lambda *given, **more: ideal(place, *given, **more)
    run()
