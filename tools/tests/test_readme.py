# SPDX-License-Identifier: MIT
"""README: its first session works as typed in a fresh clone; its first screen says what it is."""

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
    """The word that people search for, one picture, and no figure that TIMING.md prints."""
    first = README.read_text(encoding="utf-8").partition("## Two commands")[0]
    assert "stepper" in first.split("\n\n")[1]
    assert first.count("![") == 1 and "docs/ramp.png" in first
    assert "**For you**" in first and "**Not for you**" in first
    for unit in ("kHz", "steps/s", "cycles", "baud"):
        assert unit not in first
