# SPDX-License-Identifier: MIT
"""`pixstep bench`: every figure of speed, in CPU cycles and edges, from the real images.

`drive` runs lines and opens windows on the statistics, `trial` says how a run ended; one module
for each figure has its tasks and its table; `figures` lists them, `run` does them on all cores.
"""
