# SPDX-License-Identifier: MIT
"""A job on a port, in real time, beside a process that computes: no pixel between its lines."""

import contextlib
import re
import subprocess
import sys

import pytest

import runbench
from sim_terminal import on_terminal

PIXEL_HZ = 30
LINES = 4
HANG_S = 1800


@contextlib.contextmanager
def busy():
    """Let a process keep a processor busy."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        process.kill()
        process.wait(timeout=HANG_S)


def printed(folder, port):
    """Print the job of a folder by the command; return what it says."""
    done = subprocess.run(
        [
            sys.executable, "-m", "pixstep", "job", "run", "a.pxjob", "--accept-amber",
            "--time-gaps", "--port", port, "--timeout", "2",
        ],
        cwd=folder, capture_output=True, text=True, timeout=HANG_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("gated", [False, True])
def test_no_pixel_passes_between_lines_beside_a_busy_process(tmp_path, gated):
    text = runbench.jobbench.MACHINE
    if gated:
        text = text.replace('sync = "lock"', 'sync = "lock"\ngate_edges = 8')
    job = runbench.folder_with_job(tmp_path, lines=LINES, text=text)
    bursts = ("--pixel-gate", f"{job.pixels + 12},400") if gated else ()
    with on_terminal("mega", PIXEL_HZ, *bursts) as (port, _), busy():
        said = printed(tmp_path, port)
    assert f"finished: {LINES} of {LINES} lines" in said
    assert "0 pixels of the clock passed between lines" in said
    assert re.search(r"queued at least [\d.]+ pixels before its turn", said)
