# SPDX-License-Identifier: MIT
"""Exceptions of the interface that know more than their text."""

from pixstep.errors import RefusedError
from pixstep.lines.line_check import Finding


class LineRefusedError(RefusedError):
    """A check refuses a line; `findings` are its errors, each with name and pixel."""

    def __init__(self, message: str, findings: tuple[Finding, ...] = ()) -> None:
        super().__init__(message)
        self.findings: tuple[Finding, ...] = findings
        """The errors of the check."""
