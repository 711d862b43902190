# SPDX-License-Identifier: MIT
"""One grammar for every command: names of options, helps, exit statuses, JSON."""

import json
import os
import resource
import shlex
import subprocess
import sys

import click
import pytest

from command_tree import FOREIGN, own_commands, walk
from pixstep import natives
from pixstep.cli.command import LazyCommand, OutFileType, OutFolderType, OutPictureType
from pixstep.cli.examples import EXAMPLES
from pixstep.cli.from_operation import SCHEMA
from pixstep.cli.main import main

# One meaning each; a command that has the option at all has it with this kind of value.
MEANINGS = {
    "--axis": "an axis",
    "--backlash": "a number of steps",
    "--board": "a board's name",
    "--decode": "smooth or plain",
    "--force": "a flag",
    "--json": "a flag",
    "--lenient": "a flag",
    "--no-check": "a flag",
    "--out": "a folder",
    "--pixel-hz": "a frequency",
    "--raw": "a flag",
    "-o": "a file to write",
}
# Spellings that mean what another option means.
OTHERWISE = {
    "--smooth": "--decode", "--motor-kind": "--decode", "--plain": "--decode",
    "--overwrite": "--force", "--replace": "--force", "--force-upload": "--no-check",
    "--skip-check": "--no-check", "--draw": "--plot", "--figure": "--plot", "--picture": "--plot",
}  # fmt: skip
WITHOUT_FACTS = {"board log records", "completion"}  # what they print is a file
HELP_LIMIT_S = 0.25


EVERY = [(" ".join(words), command) for words, command in walk() if words != (FOREIGN,)]
COMMANDS = own_commands()
every_command = pytest.mark.parametrize("name", COMMANDS)


def options(command):
    """Yield the options that a help shows."""
    for param in command.params:
        if isinstance(param, click.Option) and not param.hidden:
            yield param


def meaning(option):
    """Return what kind of value an option takes."""
    if option.is_flag:
        return "a flag"
    kind = option.type
    if isinstance(kind, OutFileType):
        return "a file to write"
    if isinstance(kind, OutFolderType):
        return "a folder"
    if isinstance(kind, click.Choice):
        return "smooth or plain" if list(kind.choices) == ["smooth", "plain"] else "a board's name"
    if isinstance(kind, click.IntRange):
        return "an axis" if kind.max == 3 else "a count"
    return {"HZ": "a frequency", "STEPS": "a number of steps"}.get(kind.name, kind.name)


@every_command
def test_an_option_has_one_meaning(name):
    for option in options(COMMANDS[name]):
        for spelling in {*option.opts} & MEANINGS.keys():
            assert meaning(option) == MEANINGS[spelling], f"{name} {spelling}"
        assert not {*option.opts, *option.secondary_opts} & OTHERWISE.keys(), name


@every_command
def test_drawings_and_outputs(name):
    for option in options(COMMANDS[name]):
        if isinstance(option.type, OutPictureType):
            assert "--plot" in option.opts, name
        if "--plot" in option.opts:
            out = any(isinstance(other.type, OutFolderType) for other in options(COMMANDS[name]))
            assert option.is_flag == out, f"{name}: into the folder of --out, or else into a file"
    writes = any(
        isinstance(param.type, (OutFileType, OutFolderType)) for param in COMMANDS[name].params
    )
    assert writes == any("--force" in option.opts for option in options(COMMANDS[name]))


@every_command
def test_facts_come_as_json_too(name):
    has = any("--json" in option.opts for option in options(COMMANDS[name]))
    assert has == (name not in WITHOUT_FACTS)


@every_command
def test_every_option_says_what_it_is(name):
    for option in options(COMMANDS[name]):
        told = option.help or isinstance(option.type, click.Choice) or option.show_default
        assert told or meaning(option) in ("an axis", "smooth or plain"), f"{name} {option.opts}"


def test_every_command_has_examples_and_no_other_has():
    assert set(EXAMPLES) - {"bench"} == set(COMMANDS)


@pytest.mark.parametrize("example", [one for some in EXAMPLES.values() for one in some])
def test_examples_are_command_lines(example, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PIXSTEP_PORT", "/dev/ttyTEST")
    words, command = shlex.split(example), main
    while isinstance(command, click.Group):
        command = command.get_command(None, words.pop(0))
    command.make_context("pixstep", words)  # raises for what the command does not take


def test_groups_and_their_tables_say_the_same():
    for name, command in EVERY:
        for nested, late in getattr(getattr(command, "commands", None), "late", {}).items():
            if nested != "bench":
                assert isinstance(late, LazyCommand)
                said = command.commands[nested].get_short_help_str(500)
                assert late.about == said, f"{name} {nested}"


def test_no_command_has_two_names():
    found = {}
    for name, command in COMMANDS.items():
        assert found.setdefault(id(command), name) == name


@pytest.mark.parametrize("words", ["", "line", "board", "file", "profile", "move", "home"])
def test_help_is_quick(words):
    """Processor time of the process, so that a busy machine does not count."""
    needed = []
    while len(needed) < 10 and min(needed, default=HELP_LIMIT_S) >= HELP_LIMIT_S:
        needed.append(_help_s(words.split()))
    assert min(needed) < HELP_LIMIT_S, f"{min(needed):.2f} s"


def _help_s(words):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-m", "pixstep", *words, "--help"], stdout=subprocess.DEVNULL, check=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_help_imports_nothing_heavy():
    program = (
        "import sys; sys.argv = ['pixstep', '--help']\n"
        "from pixstep.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'rich', 'pymodbus', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_json_has_its_version(pixstep, tmp_path):
    profile = natives.root() / "tools/data/AccProfM39-30Hz-1.PRN"
    made = json.loads(pixstep(
        "line", "make", "--profile", profile, "--speed", 1000, "--pixels", 60, "--pixel-hz", 30,
        "-o", "line.csv", "--json",
    ))  # fmt: skip
    assert (made["schema"], made["pixels"], made["steps"]) == (SCHEMA, 60, 38_836)
    checked = json.loads(pixstep("line", "check", "line.csv", "--decode", "smooth", "--json"))
    assert (checked["schema"], checked["verdict"]) == (SCHEMA, "fine")


def test_old_spelling_of_a_plain_line(invoke, tmp_path):
    profile = natives.root() / "tools/data/AccProfM39-30Hz-1.PRN"
    words = (
        "line",
        "make",
        "--profile",
        profile,
        "--speed",
        1000,
        "--pixels",
        60,
        *("--pixel-hz", 30),
    )
    invoke(*words, "--plain", "-o", "old.csv")
    invoke(*words, "--decode", "plain", "-o", "new.csv")
    assert (tmp_path / "old.csv").read_bytes() == (tmp_path / "new.csv").read_bytes()
    text = invoke(*words, "--plain", "--decode", "smooth", "-o", "x.csv", status=2).stderr
    assert text == "pixstep: --plain and --decode smooth contradict each other\n"


# Exit statuses


def test_each_ending_has_its_status(simulator, invoke, put):
    put(b"    10\r\n" * 4)
    invoke("line", "check", "x.csv", "--decode", "plain")
    invoke("line", "check", "x.csv", "--decode", "smooth", status=3)
    invoke("line", "check", "x.csv", status=2)
    invoke("line", "check", "nowhere.csv", "--decode", "smooth", status=2)
    sim = ("--decode", "smooth", "--board", "uno", "--pixel-hz", 30)
    invoke("sim", "x.csv", *sim, "--out", "run", status=3)
    invoke("sim", "x.csv", *sim, "--no-check", "--out", "run", status=3)
    put(b"   501\r\n  1000\r\n  1000\r\n   501\r\n", "ripple.csv")
    invoke("line", "check", "ripple.csv", "--decode", "smooth", status=1)


# Completion


@pytest.mark.parametrize(
    ("shell", "place"),
    [
        ("bash", "data/bash-completion/completions/pixstep"),
        ("zsh", "data/zsh/site-functions/_pixstep"),
        ("fish", "config/fish/completions/pixstep.fish"),
    ],
)
def test_completion_is_installed_where_the_shell_looks(invoke, tmp_path, monkeypatch, shell, place):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("SHELL", f"/usr/bin/{shell}")
    invoke("completion")
    assert "_PIXSTEP_COMPLETE" in (tmp_path / place).read_text()
    assert "already exists (--force replaces it)" in invoke("completion", status=2).stderr
    monkeypatch.setenv("SHELL", "/bin/tcsh")
    assert invoke("completion", status=2).stderr == (
        "pixstep: which shell? name one: bash, zsh, fish\n"
    )


def completed(words):
    """Return what bash would offer behind some words."""
    done = subprocess.run(
        [sys.executable, "-m", "pixstep"], capture_output=True, text=True, check=True,
        env={**os.environ, "_PIXSTEP_COMPLETE": "bash_complete",
             "COMP_WORDS": " ".join(["pixstep", *words]), "COMP_CWORD": str(len(words))},
    )  # fmt: skip
    return [row.partition(",")[2] for row in done.stdout.splitlines()]


def test_commands_options_and_values_are_completed():
    assert completed(["li"]) == ["limits", "line"]
    assert completed(["line", "ma"]) == ["make"]
    assert completed(["sim", "--dec"]) == ["--decode"]
    assert completed(["sim", "--decode", "s"]) == ["smooth"]
