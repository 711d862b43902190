# SPDX-License-Identifier: MIT
"""Runs of jobs as their folders are afterwards, made up: logs and records without boards."""

from pixstep.board.state import Record
from pixstep.jobs import comparison
from pixstep.jobs.machine_copy import MachineCopy
from pixstep.jobs.run_folder import Parts, RunFolder

BEGUN_S = 1_795_748_204.0


class MadeUp:
    """The folder of a run, whose log is written event by event; each line takes its time."""

    def __init__(self, path, job, machine=None):
        self.job, self.folder = job, RunFolder.begin(path, job)
        self.at_s = BEGUN_S
        axes = {
            name: {"unit": 1, "axis": axis, "lines_done": 0, "next_block": 0, "position_steps": 0}
            for axis, name in enumerate(job.motors)
        }
        board = {
            "unit": 1, "kind": "mega", "firmware": "0.2", "bus_timeout_ms": 3000,
            "silence_ms": 7000, "tag": 7, "axes": axes,
        }  # fmt: skip
        self.add(
            "begin", job=job.header.id, lines=job.lines, pixels=job.pixels,
            boards={"main": board}, **self._compared(machine),
        )  # fmt: skip
        self.add("chain", line=1, axes=axes)

    def _compared(self, machine):
        if machine is None:
            return {"comparison": "green", "fields": [], "equal": 0}
        copy = MachineCopy.of(machine.encode(), self.folder.path.parent / "machine.toml")
        rows = comparison.with_machine(self.job, copy)
        shown = [row.told() for row in rows if row.key or row.colour.word != "green"]
        verdict = comparison.verdict(rows).word
        who = {"accepted_by": "anna"} if verdict == "amber" else {}
        return {"comparison": verdict, "fields": shown, "equal": len(rows) - len(shown), **who}

    def add(self, event, **more):
        """Log an event."""
        with self.folder.log() as log:
            log.add({"event": event, **more, "at": self.at_s, "s": self.at_s - BEGUN_S})

    def print(self, *lines):
        """Log that lines were queued and made."""
        for line in lines:
            self.add("queued", line=line)
            self.at_s += float(self.job.pixels / self.job.pixel_hz)
            self.add("done", line=line)

    def finish(self):
        """Log the end."""
        self.add("finished", line=self.job.lines)

    def record(self, lines, found):
        """Write records of lines; `found` gives a pixel's distance and edge error."""
        parts = Parts(self.folder.path)
        for line in lines:
            for motor, run in self.job.runs_of(line).items():
                for pixel, place in enumerate(self.job.expected(line, motor), 1):
                    off, error = found(line, motor, pixel)
                    way = place - run.start_steps
                    parts.take(line, motor, Record(pixel, way, way + off, error))
            parts.write(line)


def finished(path, job):
    """Make the folder of a run that has ended well."""
    made = MadeUp(path, job)
    made.print(*range(1, job.lines + 1))
    made.finish()
    return made
