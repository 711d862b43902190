# SPDX-License-Identifier: MIT
"""Acceleration profiles and the lines made from them: make, generate, check, repair, draw."""
