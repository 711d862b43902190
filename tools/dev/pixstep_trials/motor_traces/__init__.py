# SPDX-License-Identifier: MIT
"""An ideal stepper, and traces of a real motor record above it that a model is held against."""
