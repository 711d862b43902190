# SPDX-License-Identifier: MIT
"""Lines on simulated boards: `simctl` drives the runner, `simrun` runs, `judge` judges."""
