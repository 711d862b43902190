# SPDX-License-Identifier: MIT
"""Lines from a user's own numbers: a text table in, counts per pixel out.

`layout` finds the encoding and divides lines into fields, `table` is the result for one separator
and one mark of decimals, `readings` tries all of these and refuses what can be read in two ways.
`columns` says what a column holds, `importing` makes a line of one.
"""

from pixstep.owndata.importing import Imported, Request, import_line

__all__ = ["Imported", "Request", "import_line"]
