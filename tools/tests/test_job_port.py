# SPDX-License-Identifier: MIT
"""A job on a port, in real time, beside a process that computes: no pixel between its lines."""

import contextlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

import runbench
from sim_terminal import on_terminal

PIXEL_HZ = 30
LINES = 4
HANG_S = 1800
TRIES = 5
LOOK_S = 0.02


@contextlib.contextmanager
def busy():
    """Let a process keep a processor busy."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        process.kill()
        process.wait(timeout=HANG_S)


def waited_ns(process):
    """Return how long a process has waited for a processor so far, all its threads together."""
    total = 0
    for path in Path(f"/proc/{process.pid}/task").glob("*/schedstat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            total += int(path.read_text(encoding="ascii").split()[1])
    return total


def printed(folder, port, board):
    """Print the job of a folder by the command, on a board that is a process.

    Return its status, what it says, and how many seconds this machine kept both from running.
    """
    words = [
        sys.executable, "-m", "pixstep", "job", "run", "a.pxjob", "--accept-amber", "--time-gaps",
        "--port", port, "--timeout", "2",
    ]  # fmt: skip
    before_ns, waits_ns = waited_ns(board), [0]
    with subprocess.Popen(
        words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        while True:
            try:
                said, _ = process.communicate(timeout=LOOK_S)
                break
            except subprocess.TimeoutExpired:
                waits_ns.append(waited_ns(process) + waited_ns(board) - before_ns)
    return process.returncode, said, max(waits_ns) / 1e9


def is_gapless(status, said):
    """Return whether a job was printed without a pixel between lines."""
    whole = f"finished: {LINES} of {LINES} lines" in said
    gapless = "0 pixels of the clock passed between lines" in said
    queued = re.search(r"queued at least [\d.]+ pixels before its turn", said)
    return status == 0 and whole and gapless and queued is not None


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("gated", [False, True])
def test_no_pixel_passes_between_lines_beside_a_busy_process(tmp_path, gated):
    """A line lies ahead in the queues: only who cannot run for so long may be late.

    What comes of a try in which this machine kept the command and the board waiting for less is
    the command's own doing. Other tries tell nothing, and are made again.
    """
    text = runbench.jobbench.MACHINE
    if gated:
        text = text.replace('sync = "lock"', 'sync = "lock"\ngate_edges = 8')
    tries = []
    for number in range(TRIES):
        folder = tmp_path / str(number)
        folder.mkdir()
        job = runbench.folder_with_job(folder, lines=LINES, text=text)
        bursts = ("--pixel-gate", f"{job.pixels + 12},400") if gated else ()
        with on_terminal("mega", PIXEL_HZ, *bursts) as (port, board), busy():
            status, said, waited_s = printed(folder, port, board)
        if is_gapless(status, said):
            return
        tries.append(f"{said}(this machine kept both waiting for {waited_s:.2f} s)")
        assert waited_s >= job.pixels / PIXEL_HZ, tries[-1]
    pytest.fail(f"this machine was too busy in all of {TRIES} tries: {tries[-1]}")
