# SPDX-License-Identifier: MIT
"""The exceptions that reach a user as a plain line of text, and the exit statuses of commands."""

FINE = 0
NEGATIVE = 1  # a verdict that is not fine: a failed run, warnings, a difference, a board in trouble
MISUSE = 2
REFUSED = 3  # by a check, before anything is done, or by a board


class PlainError(Exception):
    """Ends a command with its text as one line and with the exit status `status`."""

    status = NEGATIVE


class UserError(PlainError):
    """A mistake or a lack that the user can mend."""

    status = MISUSE


class RefusedError(UserError):
    """A check refuses what a file holds."""

    status = REFUSED
