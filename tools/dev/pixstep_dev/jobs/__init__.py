# SPDX-License-Identifier: MIT
"""Campaigns of print jobs on the real images: seams between lines, dead hosts, lost boards.

`press` is the machine and its job, `passes` tells from the edges on the pins which lines were
printed.
"""
