# SPDX-License-Identifier: MIT
"""What an image costs its board, measured in the simulator: `pixstep-dev costs`."""
