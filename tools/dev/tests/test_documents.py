# SPDX-License-Identifier: MIT
"""Every command of every document is run and prints what it says, or says what it needs instead."""

import re
import shlex
import subprocess

import pytest
from click.testing import CliRunner

from effort import LONG
from pixstep import natives
from pixstep.cli.main import main
from pixstep_dev.cli.main import main as main_dev
from pixstep_dev.tutorial import blocks, document

# These have tests of their own, which walk them on simulated boards or in a clone.
WALKED = ("README.md", "docs/CONSOLE.md", "docs/TUTORIAL.md")
FOUND = {one.name: one for one in blocks.survey(natives.root())}
HERE = [name for name, one in FOUND.items() if name not in WALKED and one.run + one.long]
OWN = re.compile(r"(?:~/pixstep-env/bin/|tools/)?(pixstep(?:-dev)?)")
SHELL = re.compile(r"[|<>;&`]|^(?!pixstep )")
REFUSES = re.compile(r"^pixstep: |: refused: |: red: ")  # which a status of 0 would belie
LEAST_RUN, LEAST_HERE = 110, 25


def test_every_block_says_what_it_is():
    assert [text for one in FOUND.values() for text in one.complaints] == []


def test_the_count_is_printed():
    done = CliRunner().invoke(main_dev, ["docs", "blocks"])
    print(done.output)
    assert done.exit_code == 0
    run = int(re.search(r"^all: (\d+) run, ", done.output, re.MULTILINE)[1])
    assert run >= LEAST_RUN and sum(FOUND[name].run for name in HERE) >= LEAST_HERE


def run_one(step, folder):
    """Run a step in a folder; return its exit status and what it has printed."""
    command = step.command.replace("\\\n", "")
    if SHELL.search(command):
        done = subprocess.run(
            ["bash", "-c", command], cwd=folder, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout + done.stderr
    done = CliRunner().invoke(main, shlex.split(command)[1:])
    return done.exit_code, done.output


@pytest.mark.parametrize("name", HERE)
@pytest.mark.usefixtures("simulator", "plan_program")
def test_commands_print_what_the_document_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for step in FOUND[name].found.steps:
        if step.long and not LONG:
            continue
        status, printed = run_one(step, tmp_path)
        place = f"{name}:{step.line}: {step.command}"
        assert document.agrees(step.shown, printed.splitlines()), f"{place}\n{printed}"
        said = any(REFUSES.search(line) for line in step.shown)
        assert (status != 0) == said, f"{place}\nexit status {status}"


def exists(words, command):
    """Whether a command line names commands and options that there are."""
    while words and words[0] in getattr(command, "commands", {}):
        command, words = command.commands[words[0]], words[1:]
    known = {option for one in command.params for option in (*one.opts, *one.secondary_opts)}
    given = {word.partition("=")[0] for word in words if word.startswith("--")}
    return given <= known | {"--help", "--version"} and not hasattr(command, "commands")


def own(text):
    """Yield the command lines of pixstep's own programs in a line of a shell."""
    lexer = shlex.shlex(text.replace("\\\n", ""), posix=True, punctuation_chars="|;&<>")
    lexer.whitespace_split = True
    found = None
    for token in [*lexer, ";"]:
        if set(token) <= set("|;&<>"):
            if found:
                yield found[0], found[1:]
            found = None
        elif found is not None:
            found.append(token)
        elif name := OWN.fullmatch(token):
            found = [name[1]]


def test_commands_that_are_not_run_are_commands_that_there_are():
    count = 0
    for one in FOUND.values():
        for item in one.found.not_run:
            for program, words in own(item.command):
                count += 1
                late = words[:1] == ["bench"]  # pixstep-dev's, which pixstep offers too
                command = main if program == "pixstep" and not late else main_dev
                assert exists(words, command), f"{one.name}:{item.line}: {item.command}"
    assert count > 30


def test_what_is_not_there_is_found():
    assert exists(["board", "upload", "a.csv", "--arm"], main)
    assert not exists(["board", "upload", "a.csv", "--armed"], main)
    assert not exists(["board", "uplode"], main)
    assert list(own("tools/pixstep-dev site --out x && pixstep demo")) == [
        ("pixstep-dev", ["site", "--out", "x"]), ("pixstep", ["demo"]),
    ]  # fmt: skip


def test_a_block_that_does_not_say_what_it_is_is_found(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text("# x\n")
    (tmp_path / "docs" / "A.md").write_text(
        "```\npixstep demo\n```\n```text\n$ pixstep demo\n```\n```sh moon\nls\n```\n"
        "```sh hours\nls  # a word\n```\n```console board\n$ pixstep board info\nout\n```\n"
        "<!-- begin generated: x -->\n```\nls\n```\n<!-- end generated: x -->\n"
    )
    (found,) = blocks.survey(tmp_path)
    assert [text.partition(": ")[2] for text in found.complaints] == [
        "a block of unknown kind ''", "commands in a block of text",
        "a block of unknown kind 'sh moon'",
    ]  # fmt: skip
    assert found.not_run == {"hours": 1, "board": 1} and found.run == 0
