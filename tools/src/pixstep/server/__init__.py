# SPDX-License-Identifier: MIT
"""One process that owns a bus, and how others reach it: docs/SERVER.md."""
