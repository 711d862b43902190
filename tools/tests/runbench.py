# SPDX-License-Identifier: MIT
"""Jobs that run on simulated boards: machines, boards that know their place, who pauses when."""

from contextlib import contextmanager
from fractions import Fraction

import jobbench
from pixstep import natives, ops
from pixstep.jobs.job import Job
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

_SIDE = """\
[boards.side]
kind = "uno"
port = "/dev/ttyACM0"
unit = 2

[motors.M39]
board = "main"
"""
TWO = (
    jobbench.MACHINE.replace("[motors.M39]\n", _SIDE)
    .replace("[motors.M40]\n", '[motors.M40]\nboard = "main"\n')
    .replace("[motors.M41]\naxis = 2", '[motors.M41]\nboard = "side"\naxis = 0')
)


def folder_with_job(folder, lines=4, pixels=6, text=jobbench.MACHINE, **more):
    """Write a machine and a job of few short lines into a folder; return the job."""
    machine = jobbench.write_machine(folder, text)
    of = jobbench.image(lines, pixels, more.pop("lead_in", 4))
    motions = {"turns": {}, **more}
    made = jobbench.make(machine, of, **motions)
    made.write(folder / "a.pxjob")
    return Job.read(folder / "a.pxjob")


@contextmanager
def bus(*kinds, **more):
    """Yield a bus with simulated boards."""
    boards = [(kind, natives.image(kind)) for kind in kinds or ("mega",)]
    with SimLink(SimOptions(boards, Fraction(30), **more)) as found:
        yield found


def run(folder, link, **more):
    """Print the job of a folder."""
    return ops.job_run(
        folder / "a.pxjob", folder=folder / "a.pxrun", machine=folder / "machine.toml", link=link,
        **{"accept_amber": True, **more},
    )  # fmt: skip


def resume(folder, link, **more):
    """Go on with the run of a folder."""
    return ops.job_resume(
        folder / "a.pxrun", machine=folder / "machine.toml", link=link,
        **{"accept_amber": True, **more},
    )  # fmt: skip


class Hook:
    """Calls `act` before the simulator's command number `at`, or each, of those with a word."""

    def __init__(self, simulator, at, act, word="tx"):
        self.count, self.at, self.act, self.word = 0, at, act, word
        self._command = simulator.command
        simulator.command = self

    def __call__(self, text):
        if text.startswith(self.word):
            self.count += 1
            if self.at in (None, self.count):
                self.act()
        return self._command(text)


def replaced(job, header):
    """Return a job with another header."""
    return Job(header, job.copies, job.runs, job.shapes, job.path)
