# SPDX-License-Identifier: MIT
"""Four axes locked to one poor pixel clock: how far from its edges did each of them end?"""

import pixstep as px

clock = px.PixelClock(ppm=300, jitter_us=2, drop=100)  # of 1 kHz, four edges a pixel
lines = [
    px.line([20 + 10 * axis] * 200, decode="plain", pixel_hz=250, name=f"axis {axis}")
    for axis in range(4)
]
run = px.simulate(lines, "mega", sync="lock", divider=4, clock=clock).raise_if_failed()
for axis in run.axes:
    print(axis.line.line.name, axis.clock)
run.plot_clock(3).savefig("axis3.png")
