# SPDX-License-Identifier: MIT
"""Fifty lines at fifty speeds, each simulated edge by edge, on all processors."""

from concurrent.futures import ProcessPoolExecutor

import pixstep as px


def tried(speed: int) -> px.Run:
    """Simulate a line of so many steps a pixel."""
    line = px.make_line(speed=speed, max_acceleration=60, pixels=24, pixel_hz=300)
    return px.simulate(line, "mega")


if __name__ == "__main__":
    with ProcessPoolExecutor() as pool:
        runs = list(pool.map(tried, range(2, 102, 2)))
    print(max(runs, key=lambda run: run.axes[0].max_edge_error.ticks))
