# SPDX-License-Identifier: MIT
"""Hostile and foreign company on the serial line: mutated frames, a noisy line, other clients."""
