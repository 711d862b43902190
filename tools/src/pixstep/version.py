# SPDX-License-Identifier: MIT
"""The version, which both wheels have and `pixstep --version` prints."""

__version__ = "0.2.0"
