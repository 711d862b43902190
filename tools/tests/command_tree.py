# SPDX-License-Identifier: MIT
"""The console's commands, as tests walk them: a new one is tried by itself."""

import click

from pixstep.cli.main import main

FOREIGN = "bench"  # comes from another package when it is called


def walk(command=main, words=()):
    """Yield every command and group with the words that call it."""
    yield words, command
    if isinstance(command, click.Group):
        for name in command.list_commands(None):
            yield from walk(command.get_command(None, name), (*words, name))


def commands(group=main):
    """Return every command of a group that is no group, by its words after those of the group."""
    return {
        " ".join(words): command
        for words, command in walk(group)
        if not isinstance(command, click.Group)
    }


def own_commands():
    """Return the commands of this package."""
    found = commands()
    found.pop(FOREIGN, None)
    return found
