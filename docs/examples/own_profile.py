# SPDX-License-Identifier: MIT
"""An acceleration profile of your own by numpy, a line, a simulated board, figures.

python own_profile.py: prints the verdict and writes own_profile.png and edge_errors.png here.
"""

import sys

import numpy as np

import pixstep as px

PIXEL_HZ = 30
TOP_SPEED = 1000  # steps/pixel: 30,000 steps/s at 30 Hz
RAMP_PIXELS = 20


def main() -> None:
    """Make the profile and its line, check it, run it, draw it."""
    # The speed at the end of each pixel of the ramp: half a cosine, so that it begins and ends
    # gently.
    phase = np.arange(1, RAMP_PIXELS + 1) / RAMP_PIXELS
    speeds = TOP_SPEED * (1 - np.cos(np.pi * phase)) / 2

    # A smooth motor has even speeds at the pixel edges: the nearest ones are taken.
    profile = px.Profile.nearest(speeds, name="cosine", pixel_hz=PIXEL_HZ)
    line = px.make_line(profile, speed=TOP_SPEED, pixels=60)
    line.check("uno").raise_if_refused()  # by the same check as the board's own

    run = px.simulate(line, board="uno")
    axis = run.axes[0]
    print(f"{run.verdict}: {axis.steps} steps, largest edge error {axis.max_edge_error}")
    print(f"half of the edges are within {np.median(np.abs(axis.edge_errors_ticks)):.2f} ticks")
    run.plot_motion().savefig("own_profile.png")
    run.plot_edge_errors().savefig("edge_errors.png")
    run.raise_if_failed()


if __name__ == "__main__":
    try:
        main()
    except px.PlainError as error:
        sys.exit(f"own_profile.py: {error}")
