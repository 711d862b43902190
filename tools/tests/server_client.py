# SPDX-License-Identifier: MIT
"""A client of a server as a process of its own, to be killed: `server_client.py WHAT PORT`.

`stream` runs lines, one after the other, reads their records, and prints "running" for each; `read`
reads registers without pause, `wish` tries to write. Each prints "begun" when its first request is
done.
"""

import contextlib
import sys
from fractions import Fraction

from pixstep.board import orders, recording, run, settings, upload
from pixstep.board.errors import BoardError, BusTakenError
from pixstep.board.link import WallClock
from pixstep.board.port import Port
from pixstep.lines.line import PLAIN, Line
from pixstep.server import remote

COUNTS = [1 + index // 5 % 5 for index in range(20_000)]  # far more than a queue holds


def stream(board, pixel_hz):
    settings.set_clock(board, Fraction(pixel_hz), "start", 1, 0)
    while True:
        lines = run.LinesOfBoard(board, [0])
        try:
            with recording.recorded(lines, lambda _: None), run.stopped_on_failure([lines]):
                lines.uploads += upload.begin(board, {0: Line(COUNTS, PLAIN)})
                run.arm_queued(lines)
                say("running")
                run.follow([lines], WallClock())
        except BoardError:
            if board.fault_name():  # this computer was too busy for the stream
                say(board.fault_name())
                orders.clear_fault(board)


def read(board):
    while True:
        with contextlib.suppress(BoardError):  # on a busy computer a simulated board may be late
            board.axes(4)
            board.inputs()


def wish(board):
    while True:
        with contextlib.suppress(BusTakenError, BoardError):
            board.write_setting("idle_off_ms", 0)


def say(text):
    print(text, flush=True)


def main(what, port, *more):
    board = remote.open_bus(Port(port)).board(1)
    board.input("status")
    say("begun")
    {"stream": stream, "read": read, "wish": wish}[what](board, *more)


if __name__ == "__main__":
    main(*sys.argv[1:])
