# SPDX-License-Identifier: MIT
"""What the campaigns of planted defects share: a changed text, and the words of a build's steps."""

import shlex
import subprocess
from pathlib import Path


def swapped(text: str, right: str, wrong: str, where: str) -> str:
    """Return the text with `right`, which must be there exactly once, replaced."""
    if text.count(right) != 1:
        raise ValueError(f"{where}: {right!r} is not there exactly once")
    return text.replace(right, wrong)


def _steps(build: Path, target: str) -> list[str]:
    """Return the commands that make a target of the build, the last of them links it."""
    listed = subprocess.run(
        ["ninja", "-C", str(build), "-t", "commands", target],
        capture_output=True,
        text=True,
        check=True,
    )
    return [step for line in listed.stdout.splitlines() for step in line.split("&&")]


def link_words(build: Path, target: str) -> list[str]:
    """Return the command that links a target of the build."""
    return shlex.split(next(one for one in _steps(build, target) if f"-o {target} " in one))


def compile_words(build: Path, source: Path, target: str) -> list[str]:
    """Return the command that compiles a source for a target, warnings left alone.

    Other programs of the build may compile the same source: with an object of theirs in its place
    the target would stay what it was.
    """
    words = shlex.split(next(one for one in _steps(build, target) if one.endswith(f" {source}")))
    if Path(words[0]).name == "ccache":  # the compiler itself: options follow its name
        del words[0]
    for option in ("-MT", "-MF"):  # the build's own list of what it depends on stays
        at = words.index(option)
        del words[at : at + 2]
    return [word for word in words if word not in ("-Werror", "-MD")]
