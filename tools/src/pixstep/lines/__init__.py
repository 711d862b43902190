# SPDX-License-Identifier: MIT
"""A line as the controller sees it: counts, checks, exact instants, runs, planned ticks."""
