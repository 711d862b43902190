# SPDX-License-Identifier: MIT
"""pixstep: line files to exact step edges on a motor board, planned, checked and simulated."""

__version__ = "0.1.0"
