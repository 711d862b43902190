# SPDX-License-Identifier: MIT
"""Everything that one can ask of pixstep, said once: the commands and Python are made of it.

An operation is a frozen request whose fields say what they are (`request`), one method from the
request to a `Result`, and that result as data and as text. `catalog` lists them, `perform` runs one
from what a caller gave and what the machine file says; `python` makes functions of them, which
`pixstep.ops` has.
"""
