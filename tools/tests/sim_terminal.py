# SPDX-License-Identifier: MIT
"""A simulated board behind a pseudo terminal, in a process of its own and in real time."""

import contextlib
import subprocess

from pixstep import natives

_HANG_S = 1800


@contextlib.contextmanager
def on_terminal(board, pixel_hz, *more):
    """Yield the terminal's name and the process, which ends with the block.

    `more` are further options of the simulator.
    """
    process = subprocess.Popen(
        [
            natives.program("pixstep-sim"), "--board", f"{board}={natives.image(board)}",
            "--pixel-hz", str(pixel_hz), *more, "--pty",
        ],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        yield process.stdout.readline().strip(), process
    finally:
        process.terminate()
        process.wait(timeout=_HANG_S)
        process.stdout.close()
