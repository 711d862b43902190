# SPDX-License-Identifier: MIT
"""docs/JOBS.md: its commands print what it says they print, its Python reads a job."""

import re
import shlex

from click.testing import CliRunner

from pixstep import natives
from pixstep.cli.main import main

_BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)
_PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)
TEXT = (natives.root() / "docs" / "JOBS.md").read_text(encoding="utf-8")


def shown(printed: list[str], wanted: list[str]) -> bool:
    """True if the lines are those wanted; "..." stands for any number of lines, or a line's end."""
    if not wanted:
        return not printed
    if wanted[0] == "...":
        return any(shown(printed[k:], wanted[1:]) for k in range(len(printed) + 1))
    begin, dots, _ = wanted[0].partition("...")
    fits = printed and (printed[0].startswith(begin) if dots else printed[0] == wanted[0])
    return bool(fits) and shown(printed[1:], wanted[1:])


def test_the_commands_print_what_the_document_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    parts = "".join(_BLOCK.findall(TEXT)).split("$ pixstep ")[1:]
    for part in parts:
        command, *wanted = part.rstrip("\n").split("\n")
        done = CliRunner().invoke(main, shlex.split(command))
        printed = [line.rstrip() for line in done.stdout.rstrip("\n").split("\n")]
        assert shown(printed, wanted), (command, done.output)
    assert len(parts) == 8
    for code in _PYTHON.findall(TEXT):
        exec(compile(code, "JOBS.md", "exec"), {})
    assert capsys.readouterr().out.split() == ["100", "33440"]
