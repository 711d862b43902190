# SPDX-License-Identifier: MIT
"""Run a line on a board: python drive_board.py /dev/ttyACM0

Without a board, let the simulator lend one a serial port, in real time, and give its name instead
(the simulator prints it; everything is done as with a board):

    build/host/bin/pixstep-sim --pixel-hz 30 --pty \\
        --board mega=build/mega/firmware/pixstep-mega.elf
"""

import sys

import pixstep as px


def drive(bus: px.Bus) -> None:
    """Run a short line on axis 0 of the first board, and the same way back."""
    board = bus.board(1)
    print(f"{board.kind} on {bus.port}, pixel clock {float(board.pixel_hz):g} Hz")
    there = px.line([2, 6, 8, 8, 8, 6, 2], pixel_hz=board.pixel_hz, name="there")
    back = px.line(there.counts, pixel_hz=board.pixel_hz, negative=True, name="back")
    for line in (there, back):
        board.check(line).raise_if_refused()  # by the board's own limits; `run` does so as well
        (axis,) = board.run(line, axis=0)
        print(f"{line.line.name}: {axis.state}, position {axis.position_steps} steps")


def main() -> None:
    """Open the port that the command line names."""
    if len(sys.argv) != 2:
        sys.exit("drive_board.py: expected one argument, the serial port, as /dev/ttyACM0")
    try:
        with px.connect(sys.argv[1]) as bus:
            drive(bus)
    except px.PlainError as error:
        sys.exit(f"drive_board.py: {error}")


if __name__ == "__main__":
    main()
