# SPDX-License-Identifier: MIT
"""Runs the simulator on the test images: a session of its control protocol, or one run."""

import csv
import itertools
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

SIM = os.environ.get("PIXSTEP_SIM", "pixstep-sim")
# The folder of each board's images: PIXSTEP_<BOARD>_IMAGES.
IMAGES = {
    name.removeprefix("PIXSTEP_").removesuffix("_IMAGES").lower(): folder
    for name, folder in os.environ.items()
    if name.startswith("PIXSTEP_") and name.endswith("_IMAGES")
}
RESULT_ADDRESS = 0x600
# A guard against a simulator that hangs, however busy the machine; no verdict.
HANG_S = 1800
GPIOR2 = 0x4B


def image(board, name):
    """NAME=IMAGE of a test image, as --board wants it."""
    return f"{board}={Path(IMAGES[board]) / f'sim_{name}.elf'}"


def call(*arguments):
    """One run of the simulator from its command line."""
    return subprocess.run(
        [SIM, *arguments], check=False, capture_output=True, text=True, timeout=HANG_S
    )


class Session:
    """pixstep-sim --control with one board or several."""

    def __init__(self, *boards, options=()):
        command = [SIM, "--control", *options]
        for board in boards:
            command += ["--board", board]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait(timeout=HANG_S)

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().strip()

    def run(self, cycles):
        return self.ask(f"run {cycles}")

    def results(self, count, board=0):
        """The first `count` words of the image's results."""
        answer = self.ask(f"peek {board} {RESULT_ADDRESS} {2 * count}")
        data = bytes.fromhex(answer.removeprefix("mem "))
        return [data[i] | data[i + 1] << 8 for i in range(0, len(data), 2)]


def read_edges(path):
    """Rows (cycle, board, axis, signal, level) of an edges file."""
    with Path(path).open(newline="") as file:
        rows = csv.DictReader(file)
        return [
            (
                int(r["cycle"]),
                int(r["board"]),
                int(r["axis"]),
                r["signal"],
                int(r["level"]),
            )
            for r in rows
        ]


def read_switches(path, board=0, axis=0):
    """Rows (cycle, switch, level) of one axis in a switch log."""
    with Path(path).open(newline="") as file:
        rows = [
            r for r in csv.DictReader(file) if (r["board"], r["axis"]) == (f"{board}", f"{axis}")
        ]
    return [(int(r["cycle"]), r["switch"], int(r["level"])) for r in rows]


def rising(edges, axis=0, board=0):
    return [e[0] for e in edges if e[1:] == (board, axis, "STEP", 1)]


def falling(edges, axis=0, board=0):
    return [e[0] for e in edges if e[1:] == (board, axis, "STEP", 0)]


def differences(cycles):
    return [b - a for a, b in itertools.pairwise(cycles)]


class SimTest(unittest.TestCase):
    """A test with a scratch folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_edges(self, board_image, cycles, options=()):
        """The edges of one board's run of so many cycles."""
        path = self.folder / "edges.csv"
        with Session(board_image, options=["--edges", str(path), *options]) as sim:
            self.assertEqual(sim.run(cycles), f"ok {cycles}")
        return read_edges(path)
