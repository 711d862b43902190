# SPDX-License-Identifier: MIT
"""What surrounds a command: terminals of other encodings, matplotlib's choice, long values, `/`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import MOST_CHARACTERS, one_line

ASCII = {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}
MACHINE = """\
clock.pixel = "30 Hz"
boards.main.kind = "uno"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "100 steps/°"
limits.max_speed = "2°/s"
limits.max_acceleration = "9°/s²"
"""


def run(*words, status=0, **environment):
    """Run a command in a process of its own; return what it printed, as bytes."""
    done = subprocess.run(
        [sys.executable, "-m", "pixstep", *words], capture_output=True, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip
    assert done.returncode == status, done.stderr
    assert b"Traceback" not in done.stderr
    return done.stdout + done.stderr


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Stand in a folder with a line and a machine file that says degrees."""
    monkeypatch.chdir(tmp_path)
    formats.write_csv(tmp_path / "line.csv", [2, 4, 4, 2])
    (tmp_path / "machine.toml").write_text(MACHINE, encoding="utf-8")
    return tmp_path


def test_a_terminal_that_knows_ascii_only(here):
    """What it lacks is written otherwise: a degree sign and superscripts are spelt."""
    text = run("machine", "show", **ASCII)
    assert text.isascii() and b"?" not in text
    wrong = run("limits", "--max-speed", "1µparsec/s", status=2, PYTHONIOENCODING="ascii")
    assert wrong.isascii() and b"1uparsec/s" in wrong


def test_every_help_on_a_terminal_that_knows_ascii_only():
    for words in ([], ["line"], ["trajectory", "show"], ["board", "watch"], ["plan"]):
        done = CliRunner(charset="ascii").invoke(main, [*words, "--help"])
        assert done.exit_code == 0 and done.stdout_bytes.isascii(), words


def test_a_name_that_is_no_text_is_printed_as_it_is(here):
    name = os.fsdecode(b"no\xff.toml")
    assert b"pixstep: no\xff.toml: No such file" in run("limits", "--machine", name, status=2)


def test_a_backend_that_matplotlib_does_not_know(here):
    words = ("line", "show", "line.csv", "--decode", "plain", "--plot", "a.png")
    run(*words, MPLBACKEND="Qt4Agg")
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")


def test_no_folder_is_made_at_the_root(here, invoke):
    words = ("line", "show", "line.csv", "--decode", "plain", "--plot")
    for place in ("/pixstep-none/a.png", "/pixstep-none/deep/a.png"):
        text = invoke(*words, place, status=2).stderr
        assert text.startswith(f"pixstep: {place}: there is no folder /pixstep-none, and none is")
    assert not Path("/pixstep-none").exists()
    invoke(*words, "new/deep/a.png")
    assert Path("new/deep/a.png").is_file()


def test_a_value_cannot_move_the_cursor_or_fill_the_screen():
    assert one_line("a\x1b[31mb\n  c") == "a\\x1b[31mb c"
    long = one_line("x" * 9999)
    assert len(long) <= MOST_CHARACTERS + 5 and " ... " in long


def test_a_key_that_is_an_escape_is_shown(here, invoke):
    (here / "bad.toml").write_text(MACHINE + '"\\u001b[31m" = 3\n', encoding="utf-8")
    assert "\\x1b[31m = 3: unknown key" in invoke("machine", "check", "bad.toml", status=3).stdout


# One mistake has one exit status, wherever it is found.

UNKNOWN_KEY = MACHINE + "colour = 3\n"
BAD_NUMBER = MACHINE.replace("axis = 0", "axis = 'no'")


@pytest.mark.parametrize("content", [UNKNOWN_KEY, BAD_NUMBER], ids=["unknown key", "bad number"])
@pytest.mark.parametrize(
    "words",
    [
        ("machine", "check"),
        ("machine", "show"),
        ("limits",),
        ("line", "show", "line.csv"),
        ("sim", "line.csv"),
        ("board", "info"),
    ],
    ids=" ".join,
)
def test_a_wrong_machine_file_is_refused_everywhere(here, invoke, content, words):
    (here / "machine.toml").write_text(content, encoding="utf-8")
    text = invoke(*words, status=3)
    assert "machine.toml:" in text.output


@pytest.mark.usefixtures("simulator")
def test_a_wrong_knob_is_named_with_its_axis_and_what_is_right(here, invoke):
    words = ("sim", "line.csv", "--machine", "none", "--decode", "plain", "--board", "uno",
             "--pixel-hz", 30, "--out", "run", "--plant")  # fmt: skip
    text = invoke(*words, "play=abc", status=2).stderr
    assert text == "pixstep: --plant: axis 0: play='abc': expected steps, 0 or more\n"


def test_a_usage_error_is_one_line_with_a_hint(invoke):
    assert invoke("line", "chek", status=2).stderr == (
        "pixstep: no such command 'chek': did you mean check? "
        "(`main line --help` shows what is right)\n"
    )
    assert invoke("--nonsense", status=2).stderr.count("\n") == 1
