# SPDX-License-Identifier: MIT
"""README: its first session works as typed in a fresh clone; its first screen says what it is."""

import re
import shlex
import shutil

import pytest

from pixstep import natives

README = natives.root() / "README.md"
DATA = natives.root() / "tools/data"
FIRST = (
    "mkdir -p build/session && cd build/session && cp ../../tools/data/Acc* . && "
    "PATH=$PATH:$PWD/../../tools"
)


def session():
    """Return the commands of the block that the page says works as typed."""
    block = README.read_text(encoding="utf-8").partition("```console\n")[2].partition("```")[0]
    return [row.removeprefix("$ ") for row in block.splitlines()]


@pytest.mark.usefixtures("simulator", "plan_program")
def test_the_session_works_as_typed(invoke, tmp_path):
    first, *commands = session()
    assert first == FIRST
    for path in DATA.glob("Acc*"):
        shutil.copy(path, tmp_path)
    assert len(commands) > 9
    for command in commands:
        program, *words = shlex.split(command)
        assert program == "pixstep"
        invoke(*words)
    assert (tmp_path / "run" / "summary.json").is_file()
    assert not (tmp_path / "machine.toml").exists()


def test_the_first_screen_says_what_it_is():
    """The word that people search for, one picture, four yes, three no, and no figure of speed."""
    first = README.read_text(encoding="utf-8").partition("\n## ")[0]
    assert "stepper controller" in first.split("\n\n")[1]
    assert first.count("![") == 1 and "docs/comparison.svg" in first
    yes, no = first.partition("**For you if**")[2].split("**Not for you if**")
    assert yes.count("\n* ") == 4 and no.count("\n* ") == 3
    assert len(first.splitlines()) < 30
    for unit in ("kHz", "steps/s", "cycles", "baud"):
        assert unit not in first


def test_each_promise_has_a_link_to_what_proves_it():
    text = (
        README.read_text(encoding="utf-8").partition("## Five promises\n")[2].partition("\n## ")[0]
    )
    promises = re.findall(r"^\d\. .*?(?=^\d\. |\n\n\[|\Z)", text, re.MULTILINE | re.DOTALL)
    assert len(promises) == 5
    for promise in promises:
        (place,) = re.findall(r"\]\(([\w./]+)\)", promise)
        assert (natives.root() / place).is_file()


def test_wire_and_flash_are_commands_that_there_are(invoke):
    block = README.read_text(encoding="utf-8").partition("## Wire and flash")[2].split("```")[1]
    block = block.removeprefix("sh board\n")
    variable, *commands = block.strip().splitlines()
    assert variable.startswith("export PIXSTEP_PORT=") and len(commands) == 3
    for row in commands:
        program, *words = shlex.split(row, comments=True)
        named = [word for word in words if word.startswith("--")]
        help_text = invoke(*words[: 1 if words[0] == "flash" else 2], "--help").stdout
        assert program == "pixstep" and all(option in help_text for option in named)
