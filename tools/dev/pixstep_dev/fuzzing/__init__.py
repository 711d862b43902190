# SPDX-License-Identifier: MIT
"""Fuzzing the serial line's side of the firmware: runs, corpus, record, planted defects."""
