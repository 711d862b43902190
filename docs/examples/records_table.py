# SPDX-License-Identifier: MIT
"""Drive a board, watch it, and have its per-pixel records as a table of pandas or Arrow.

A real board: `with px.connect("/dev/ttyACM0") as bus: board = bus.board()`.
"""

import pixstep as px

with px.simulated_board("mega", pixel_hz=250) as board:
    scan = px.make_line(speed=40, max_acceleration=10, pixels=500, pixel_hz=250, name="scan")
    with board.start(scan, axis=0) as motion:
        while not motion.done:
            (axis,) = motion.status()
            print(f"pixel {axis.pixel} of {axis.pixels}, {axis.position_steps} steps")
    (records,) = motion.records()
print(records)
table = records.to_dataframe()
print(table[["pixel", "actual_steps"]] if hasattr(table, "iloc") else table.schema)
