# SPDX-License-Identifier: MIT
"""The person at the terminal of a self-test."""

import click

from pixstep.board.selftest import FAILED, OK, SKIPPED, SelftestResult

COLOURS = {OK: "green", FAILED: "red", SKIPPED: "yellow"}


class TerminalPerson:
    """Asked on the error stream, so that --json stays clean."""

    def __init__(self, *, as_json: bool):
        self._as_json = as_json

    def agrees(self, question: str, *, default: bool = True) -> bool:
        """Ask for yes or no."""
        return click.confirm(question, default=default, err=True)

    def says(self, text: str) -> None:
        """Tell what to do now."""
        click.echo(text, err=True)

    def sees(self, check: SelftestResult) -> None:
        """Show a check that has ended."""
        if not self._as_json:
            verdict = click.style(f"{check.verdict:<8}", fg=COLOURS[check.verdict])
            click.echo(f"{verdict}{check.name}: {check.text}")
