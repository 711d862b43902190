# SPDX-License-Identifier: MIT
"""The report of a run: one HTML file that needs no network."""
