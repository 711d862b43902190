# SPDX-License-Identifier: MIT
"""Print jobs: make one, look into it, compare it with the machine."""
