# SPDX-License-Identifier: MIT
"""docs/MACHINE.md: its commands print what it says they print."""

import re
import shlex

from click.testing import CliRunner

from pixstep import natives
from pixstep.cli.main import main

_BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)


def sessions() -> list[tuple[str, list[str]]]:
    """Return the command lines of the document and the lines below each."""
    text = (natives.root() / "docs" / "MACHINE.md").read_text(encoding="utf-8")
    parts = "".join(_BLOCK.findall(text)).split("$ pixstep ")[1:]
    return [(part.split("\n")[0], part.rstrip("\n").split("\n")[1:]) for part in parts]


def shown(printed: list[str], wanted: list[str]) -> bool:
    """True if the lines are those wanted, where "..." stands for any number of lines."""
    if not wanted:
        return not printed
    if wanted[0] == "...":
        return any(shown(printed[k:], wanted[1:]) for k in range(len(printed) + 1))
    return bool(printed) and printed[0] == wanted[0] and shown(printed[1:], wanted[1:])


def test_the_commands_print_what_the_document_says(tmp_path, monkeypatch, simulator):
    monkeypatch.chdir(tmp_path)
    for command, wanted in sessions():
        done = CliRunner().invoke(main, shlex.split(command))
        printed = [line.rstrip() for line in (done.stdout or done.stderr).rstrip("\n").split("\n")]
        assert shown(printed, wanted), (command, done.output)
    assert len(sessions()) == 8
