# SPDX-License-Identifier: MIT
"""Help of every command is cheap: it loads nothing that takes long to load."""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from pixstep.cli import late
from pixstep.cli.main import main
from pixstep.lazy import lazy

# The help of all commands in one process; a module counts for the first command that loads it.
ASK = """
import json, sys
from click import Context, Group
from click.testing import CliRunner
from pixstep.cli.main import main

def leaves(command, *words):
    yield words
    if isinstance(command, Group):
        for name in command.list_commands(Context(command)):
            yield from leaves(command.commands[name], *words, name)

loaded = {}
for words in leaves(main):
    before = set(sys.modules)
    done = CliRunner().invoke(main, [*words, "--help"])
    assert done.exit_code == 0 and done.output.startswith("Usage: "), (words, done.output)
    loaded[" ".join(words)] = sorted(set(sys.modules) - before)
print(json.dumps(loaded))
"""
SLOW = {
    "_cffi_backend", "asyncio", "cffi", "matplotlib", "numpy", "pydantic", "pymodbus", "rich",
    "serial", "tomlkit",
}  # fmt: skip


def help_lines() -> list[str]:
    return CliRunner().invoke(main, ["--help"]).output.splitlines()


def test_help_of_every_command_loads_nothing_slow():
    done = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True)
    loaded = json.loads(done.stdout)
    assert {"line make", "board settings diff", "home sim", "machine show"} < loaded.keys()
    assert len(loaded) > 50 and any(loaded.values())  # all commands; and each loads its own module
    slow = {
        words: found
        for words, modules in loaded.items()
        if (found := sorted({name.partition(".")[0] for name in modules} & SLOW))
    }
    assert slow == {}


def offered() -> set[str]:
    """Return the first words of the lines that help indents: options and commands."""
    return {text.split()[0] for text in help_lines() if text.startswith("  ")}


def test_what_is_not_installed_is_not_offered(monkeypatch):
    assert {"bench", "demo"} < offered()
    monkeypatch.setattr(late, "_PACKAGE", "pixstep_of_nobody")
    monkeypatch.setattr(late.BENCH, "_module", "pixstep_of_nobody.cli.bench")
    assert "demo" in offered() and "bench" not in offered()
    done = CliRunner().invoke(main, ["bench", "--help"])
    assert done.exit_code == 2
    assert done.output.startswith("pixstep: bench is part of pixstep-dev")
    assert done.output.endswith("it is not installed (a clone has it)\n")


def test_a_lazy_module_is_the_module():
    sys.modules.pop("xml.sax", None)
    xml = lazy("xml")
    assert "xml.sax" not in sys.modules
    assert xml.sax is sys.modules["xml.sax"]
    with pytest.raises(AttributeError, match="module 'xml' has no attribute 'nothing'"):
        _ = xml.nothing
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        _ = lazy("no_such_module").anything
