# SPDX-License-Identifier: MIT
"""Robustness: mutated frames, a noisy line, foreign clients, cut supplies, emergency stops."""
