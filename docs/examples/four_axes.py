# SPDX-License-Identifier: MIT
"""Four axes that start on one pixel clock edge: two smooth, two plain; one of them reverses.

python four_axes.py: prints a row an axis and writes four_axes.png here.
"""

import sys

import numpy as np

import pixstep as px

PIXEL_HZ = 50
PIXELS = 40


def main() -> None:
    """Make four lines, run them at once, draw them."""
    scan = px.make_line(
        px.make_profile(600, 80, 40), speed=600, pixels=PIXELS, pixel_hz=PIXEL_HZ, backlash=60
    )
    focus = px.make_line(px.make_profile(100, 20, 10), speed=100, pixels=PIXELS, pixel_hz=PIXEL_HZ)

    # Plain motors have one speed in each pixel: whole steps, signed. Rounding the positions, and
    # not the speeds, keeps the rounding from adding up.
    place = np.round(150 * np.sin(np.linspace(0, 2 * np.pi, PIXELS + 1))).astype(int)
    tilt = px.line(np.diff(place), decode="plain", pixel_hz=PIXEL_HZ, name="tilt")
    feed = px.line([12] * PIXELS, decode="plain", pixel_hz=PIXEL_HZ, name="feed")

    run = px.simulate([scan, focus, tilt, feed], board="mega")
    for axis in run.axes:
        print(f"axis {axis.axis}: {axis.verdict}, {axis.steps} steps, worst {axis.max_edge_error}")
    run.plot_motion().savefig("four_axes.png")
    run.raise_if_failed()


if __name__ == "__main__":
    try:
        main()
    except px.PlainError as error:
        sys.exit(f"four_axes.py: {error}")
