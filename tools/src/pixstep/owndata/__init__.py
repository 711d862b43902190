# SPDX-License-Identifier: MIT
"""Lines from a user's own numbers: a text table in, counts per pixel out.

`text` finds the encoding and the lines, `layout` divides them into fields, `numerals` reads
numbers, `table` is the result for one separator and one mark of decimals, `readings` tries all of
these and refuses what can be read in two ways. `naming` and `columns` say what a column holds,
`importing` makes a line of one, `positions` a line of positions, `fitting` finds the nearest line
that a smooth motor can make.
"""

from pixstep.owndata.importing import Imported, Request, import_line

__all__ = ["Imported", "Request", "import_line"]
