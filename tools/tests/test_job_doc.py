# SPDX-License-Identifier: MIT
"""docs/JOBS.md: its Python reads the job that its commands make."""

import re
import shlex

from click.testing import CliRunner

from pixstep import natives
from pixstep.cli.main import main

_PYTHON = re.compile(r"```python\n(.*?)```", re.DOTALL)
_MADE = re.compile(r"^\$ pixstep (machine new|job make) (.*)$", re.MULTILINE)
TEXT = (natives.root() / "docs" / "JOBS.md").read_text(encoding="utf-8")


def test_its_python_reads_the_job(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words, options in _MADE.findall(TEXT)[:2]:
        assert not CliRunner().invoke(main, [*words.split(), *shlex.split(options)]).exit_code
    for code in _PYTHON.findall(TEXT):
        exec(compile(code, "JOBS.md", "exec"), {})
    assert capsys.readouterr().out.split() == ["100", "33440"]
