# SPDX-License-Identifier: MIT
"""Tables of two axes: circles, play taken up by superimposed transitions, how round they come out.

A table has a record (p1, v1, p2, v2) for each point: positions in counts, velocities in counts a
point. On a board a point is a pixel and a count is a step.
"""
