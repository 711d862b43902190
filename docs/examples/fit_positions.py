# SPDX-License-Identifier: MIT
"""A motion of one's own, computed in mm, fitted to what a smooth motor can make, and simulated."""

import numpy as np

import pixstep as px

share = np.linspace(0, 1, 121)  # of a way of 25 mm, at the edges of 120 pixels
places_mm = 25 * share**3 * (10 - 15 * share + 6 * share**2)
stage = px.line_from_positions(
    places_mm, unit="mm", steps_per_unit="400 steps/mm", pixel_hz=30, name="stage"
)
print(stage, *stage.notes, sep="\n")
run = px.simulate(stage, board="mega").raise_if_failed()
print(run.axes[0])
stage.plot().savefig("stage.png")
