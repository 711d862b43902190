# SPDX-License-Identifier: MIT
"""A whole job in the simulator, before the glass: every board, motor and line, cycle by cycle.

cuts          a job in blocks of chained lines, each named by its content, packed for whoever
              simulates it; what a verdict depends on besides the job: versions and sums
work          a block simulated: all boards in one run; edges written, rows given back
judge         the verdict on each line of a chain, its seams included
crews         processes here, or those of a Dask cluster
folder        where rows are kept, and by that what is finished
campaign      all blocks, each once
"""
