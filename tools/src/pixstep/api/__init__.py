# SPDX-License-Identifier: MIT
"""What `import pixstep` offers, over the packages that do the work.

`machines`: a machine file; `motions`: profiles and lines; `programs`: motion programs; `runs`:
simulated boards and verdicts; `clocks`: their pixel clocks; `bus`: boards on a serial line.
`pixstep/__init__.py` loads each when it is first used.
"""
