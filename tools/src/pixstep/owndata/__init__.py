# SPDX-License-Identifier: MIT
"""Lines from a user's own numbers: a text table in, counts per pixel out.

`table` reads rows and fields, `columns` says what a column holds, `importing` makes a line of one,
`fitting` finds the nearest line that a smooth motor can make.
"""

from pixstep.owndata.importing import Imported, Request, import_line

__all__ = ["Imported", "Request", "import_line"]
