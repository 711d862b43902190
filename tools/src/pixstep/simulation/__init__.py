# SPDX-License-Identifier: MIT
"""Experiments on simulated boards: `simulator` drives the runner, `job` runs, `judge` judges."""
