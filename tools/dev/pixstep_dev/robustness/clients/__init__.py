# SPDX-License-Identifier: MIT
"""Conformance: what independent Modbus clients get from a board, case by case."""
