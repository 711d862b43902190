# SPDX-License-Identifier: MIT
"""Reversals inside a plain line: the play is taken up by a transition laid over the motion."""
