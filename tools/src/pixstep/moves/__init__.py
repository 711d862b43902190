# SPDX-License-Identifier: MIT
"""Moves by a CSV acceleration profile: fast moves of exactly N steps, and homing on a switch."""
