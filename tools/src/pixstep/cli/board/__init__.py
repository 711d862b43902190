# SPDX-License-Identifier: MIT
"""`pixstep board`: real boards, and the simulator's through its pseudo terminal."""
