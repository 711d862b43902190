# SPDX-License-Identifier: MIT
"""Lines from a user's own numbers: a text table in, counts per pixel out.

`layout` finds the encoding and divides lines into fields, `table` is the result for one separator
and one mark of decimals, `readings` tries all of these and refuses what can be read in two ways.
`columns` says what a column holds, `importing` makes a line of one, `fitting` finds the nearest one
that a smooth motor can make.
"""

from pixstep.owndata.importing import Imported, ImportRequest, import_line

__all__ = ["ImportRequest", "Imported", "import_line"]
