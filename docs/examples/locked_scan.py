# SPDX-License-Identifier: MIT
"""A scan on a poor pixel clock, on the board's own time and locked to the clock.

python locked_scan.py: prints both and writes locked_scan.png here.
"""

import pixstep as px

CLOCK_HZ = 1000
DIVIDER = 4  # clock edges of a pixel: at 250 pixels a second accelerations are 16 times gentler

profile = px.make_profile(120, 4, 2)
scan = px.make_line(profile, speed=120, pixels=150, pixel_hz=CLOCK_HZ / DIVIDER)
resonator = px.PixelClock(ppm=3000, jitter_us=3)  # 0.3 % off

own_time = px.simulate(scan, board="uno", divider=DIVIDER, clock=resonator)
locked = px.simulate(scan, board="uno", divider=DIVIDER, sync="lock", clock=resonator)
for name, run in (("own time", own_time), ("locked", locked)):
    kept = run.axes[0].clock
    print(f"{name}: rms {kept.rms_error.ns / 1000:.1f} us, {kept.drift_steps:.1f} steps of drift")
    run.raise_if_failed()
print(f"the board measured {locked.clock.board_offset_ppm:+.0f} ppm")
locked.plot_clock().savefig("locked_scan.png")
