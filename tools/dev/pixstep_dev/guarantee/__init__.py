# SPDX-License-Identifier: MIT
"""Random sets of lines about what a board is guaranteed to follow: `pixstep-dev guarantee`."""
