# SPDX-License-Identifier: MIT
"""What pixstep is tried with: lines made at random, frames and bytes that are wrong on purpose.

The product's tests and pixstep_dev both use this package; it uses neither.
"""
