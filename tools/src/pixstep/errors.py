# SPDX-License-Identifier: MIT
"""The one exception that reaches a user as a plain line of text."""


class UserError(Exception):
    """A mistake or a lack that the user can mend; the command ends with exit status 2."""
