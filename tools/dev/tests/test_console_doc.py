# SPDX-License-Identifier: MIT
"""docs/CONSOLE.md is true: its session is walked on simulated boards, no command is left out."""

import pytest

from pixstep import natives
from pixstep.cli.main import board
from pixstep_dev.tutorial import check, document

CONSOLE = natives.source("docs/CONSOLE.md")
LEAST_STEPS = 30


@pytest.mark.usefixtures("simulator", "mbpoll")
def test_the_session_is_true():
    found = document.parse(CONSOLE.read_text(encoding="utf-8"))
    assert len(found.steps) >= LEAST_STEPS
    assert check.check(CONSOLE) == []


def test_every_command_is_in_the_table():
    text = CONSOLE.read_text(encoding="utf-8").rpartition("## All commands")[2]
    for name, command in board.commands.items():
        row = next((row for row in text.split("\n") if f"`{name}" in row), "")
        assert row, name
        missing = [nested for nested in getattr(command, "commands", {}) if nested not in text]
        assert not missing, name
