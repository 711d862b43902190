# SPDX-License-Identifier: MIT
"""Motion programs: blended moves of several motors, planned to counts per pixel."""
