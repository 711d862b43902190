# SPDX-License-Identifier: MIT
"""What the campaigns of planted defects share: a changed text, and the words of a build's steps."""

import json
import shlex
import subprocess
from pathlib import Path


def swapped(text: str, right: str, wrong: str, where: str) -> str:
    """Return the text with `right`, which must be there exactly once, replaced."""
    if text.count(right) != 1:
        raise ValueError(f"{where}: {right!r} is not there exactly once")
    return text.replace(right, wrong)


def compile_words(build: Path, source: Path) -> list[str]:
    """Return the command that compiles a source for the program itself, warnings left alone."""
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    words = next(
        shlex.split(one["command"])
        for one in commands
        if Path(one["file"]) == source and "/host_tests/" not in one["command"]
    )
    return [word for word in words if word != "-Werror"]


def link_words(build: Path, target: str) -> list[str]:
    """Return the command that links a target of the build."""
    listed = subprocess.run(
        ["ninja", "-C", str(build), "-t", "commands", "-s", target],
        capture_output=True,
        text=True,
        check=True,
    )
    steps = listed.stdout.strip().splitlines()[-1].split("&&")
    return shlex.split(next(step for step in steps if f"-o {target}" in step))
