# SPDX-License-Identifier: MIT
"""docs/TUTORIAL.md does what it says: walked in an empty folder; and the walker finds faults."""

import json
import re
import subprocess

import matplotlib.image
import numpy as np
import pytest
from click.testing import CliRunner

from pixstep import natives
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep_dev.cli.main import main as main_dev
from pixstep_dev.tutorial import check, document, pictures, session

TUTORIAL = natives.root() / "docs" / "TUTORIAL.md"
LEAST_STEPS = 30  # a tutorial whose blocks are no longer recognised is shorter


@pytest.fixture(scope="module")
def tutorial():
    return document.parse(TUTORIAL.read_text(encoding="utf-8"))


def block(*lines):
    return "\n".join(["```console", *lines, "```"])


def found_in(tmp_path, text):
    """Return the complaints about a document of its own, without the file's name."""
    path = tmp_path / "DOC.md"
    path.write_text(f"{text}\n", encoding="utf-8")
    return [item.removeprefix(f"{path}:") for item in check.check(path)]


@pytest.mark.usefixtures("plan_program", "simulator")
def test_the_tutorial_is_true(tutorial):
    assert len(tutorial.steps) >= LEAST_STEPS and len(tutorial.pictures) == 2
    assert check.check(TUTORIAL) == []


def test_what_cannot_be_run_exists(tutorial):
    """Targets, presets, scripts, options of commands that need network, root or a board."""
    assert {item.needs for item in tutorial.not_run} == {"network", "board"}
    for item in tutorial.not_run:
        words = item.command.split()
        judge = JUDGES[words[0]]
        assert judge(words[1:]), f"{item.line}: {item.command}"


def _clone(words):
    return words[0] == "clone" and words[-1] == f"~/{session.CLONE}"


def _cmake(words):
    """The build preset exists, and each target of it is one that the images have."""
    presets = json.loads(read("CMakePresets.json"))["buildPresets"]
    flash = re.search(r"add_custom_target\(\s*flash\b", read("cmake/flash.cmake"))
    options = dict(zip(words[1::2], words[2::2], strict=True))
    return (
        words[0] == "--build"
        and options["--preset"] in {preset["name"] for preset in presets}
        and options["--target"] == "flash"
        and flash is not None
    )


def _setup(words):
    return words in ([], ["run"], ["long"]) and "run | all | long) ;;" in read("tools/setup")


def read(path):
    return natives.source(path).read_text(encoding="utf-8")


def _pixstep(words):
    """The command exists, and each of its options; its arguments are files."""
    command = main
    while words and words[0] in getattr(command, "commands", {}):
        command, words = command.commands[words[0]], words[1:]
    known = {option for item in command.params for option in item.opts}
    given = {word for word in words if word.startswith("--")}
    return given <= known and not hasattr(command, "commands")


JUDGES = {
    "git": _clone,
    "cd": lambda words: words == [f"~/{session.CLONE}"],
    "tools/setup": _setup,
    f"~/{session.CLONE}/tools/setup": _setup,
    "tools/build": lambda words: not words and bool(read("tools/build")),
    "cmake": _cmake,
    "stty": lambda words: words[0] == "-F" and words[2:] == ["-hupcl"],
    "export": lambda words: words[0].startswith("PIXSTEP_PORT=/dev/"),
    "pixstep": _pixstep,
}


def test_judges_refuse():
    assert not _cmake(["--build", "--preset", "mega", "--target", "burn"])
    assert not _cmake(["--build", "--preset", "nano", "--target", "flash"])
    assert not _setup(["everything"])
    assert not _pixstep(["flash", "--burn", "now"])
    assert not _pixstep(["board", "uplode", "line.csv"])


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        (["a", "b"], ["a", "b"], True),
        (["a", "b"], ["a", "c"], False),
        (["a"], ["a", "b"], False),
        (["a", "b"], ["a"], False),
        (["a", "...", "d"], ["a", "b", "c", "d"], True),
        (["a", "...", "d"], ["a", "d"], True),
        (["a", "...", "d"], ["a", "b", "c"], False),
        (["took ... s"], ["took 1.5 s"], True),
        (["took ... s"], ["took 1.5", " s"], False),
        (["x.y"], ["xzy"], False),
        (["[0]:    2"], ["[0]:\t2  "], True),
        (["[0]: 2"], ["[0]:\t2"], False),
        ([], [], True),
        ([], ["a"], False),
        (["..."], [], True),
        (["a", "", "b"], ["a", "b"], False),
    ],
)
def test_rule_of_the_dots(shown, printed, same):
    assert document.agrees(shown, printed) is same


def test_parts_of_a_document():
    text = "\n".join([
        "words", "```console", "$ one \\", "    more", "out", "$ two", "```",
        '![p](a.png "b/c.png")', "```sh root", "reboot  # now", "", "# only words", "```",
        "```text", "no command", "```",
    ])  # fmt: skip
    found = document.parse(text)
    assert [(s.line, s.command, s.shown) for s in found.steps] == [
        (3, "one \\\n    more", ("out",)),
        (6, "two", ()),
    ]
    assert found.not_run == (document.NotRun(10, "reboot", "root"),)
    assert found.pictures == (document.Picture(8, "a.png", "b/c.png"),)
    assert found.complaints == ()
    assert found.with_outputs({6: ["new"]}) == text.replace("$ two", "$ two\nnew") + "\n"
    assert found.with_outputs({3: []}) == text.replace("    more\nout", "    more") + "\n"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("```bash\nls\n```", "1: a block of unknown kind 'bash'"),
        ("```sh wings\nfly\n```", "1: a block of unknown kind 'sh wings'"),
        ("```console\nout\n```", "2: output without a command"),
        (block("$ one", "out", "bench> press"), "4: typed at the bench behind the last output"),
        ("![p](a.png)", "1: a.png: no title says what makes it"),
    ],
)
def test_unclear_places_are_found(text, complaint):
    assert document.parse(text).complaints == (complaint,)


def test_faults_are_found(tmp_path):
    text = block(
        "$ mkdir ~/first-line && cd ~/first-line", "$ echo right", "wrong", "$ false", "$ true",
        "$ (exit 3)", "$ echo $?", "3", "$ pwd", ".../home/first-line", "$ nothing 2>/dev/null",
    )  # fmt: skip
    assert found_in(tmp_path, text) == [
        "3: prints something else: echo right\n    right",
        "5: exit status 1, not shown: false",
        "12: exit status 127, not shown: nothing 2>/dev/null",
    ]


def test_steps_behind_an_exit_are_not_reached(tmp_path):
    assert found_in(tmp_path, block("$ exit 0", "$ echo x", "x")) == [
        "2: not reached: exit 0",
        "3: not reached: echo x",
    ]


def test_what_is_left_running_is_ended(tmp_path):
    pid = tmp_path / "pid"
    assert found_in(tmp_path, block(f"$ sleep 250 & echo $! >{pid}")) == []
    state = subprocess.run(
        ["ps", "-o", "stat=", "-p", pid.read_text()], capture_output=True, text=True, check=False
    ).stdout.strip()
    assert state in ("", "Z")


def test_files_of_the_reader_are_written(tmp_path):
    text = f"```toml machine.toml\n[clock]\n\npixel = '$30'\n```\n{block('$ cat machine.toml')}"
    assert found_in(tmp_path, text) == [
        "7: prints something else: cat machine.toml\n    [clock]\n    \n    pixel = '$30'"
    ]


ASKED = (
    r"""$ for n in 1 2; do printf 'Is %d so? [y/N]: ' "$n"; read -r a; echo "said $a"; done""",
)


def test_questions_are_answered(tmp_path):
    said = ("Is 1 so? [y/N]: y", "said y", "...", "Is ... so? [y/N]: n", "said n")
    assert found_in(tmp_path, block(*ASKED, *said)) == []


def test_questions_that_are_not_asked_are_found(tmp_path):
    said = ("Is 1 so? [y/N]: y", "said y", "Is 3 so? [y/N]: y", "said y")
    (complaint,) = found_in(tmp_path, block("$ echo a", "Go? [Y/n]: y"))
    assert complaint == "2: prints something else: echo a\n    a"
    (complaint,) = found_in(tmp_path, block(*ASKED, *said))
    assert complaint.endswith("    said y\n    Is 2 so? [y/N]: said")


# What the hands see of a bench: a first line, then one for each command, behind its time.
BENCH = """```console bench
$ echo ready; while read -r text; do echo "$text" >>typed; echo "   1.000 s  $text"; done
...
```
"""


def test_the_bench_is_worked(tmp_path):
    text = BENCH + block(
        "bench> one", "$ cat typed", "one", "bench> two", "bench> three", "$ tail -n 1 typed",
        "three",
        "$ until grep -q four typed; do sleep 0.1; done; echo seen",
        "bench> until it moves", "bench> four", "seen",
        "$ echo first; until grep -q five typed; do sleep 0.1; done; echo last",
        "first", "bench> five", "last",
    )  # fmt: skip
    assert found_in(tmp_path, text) == []


def test_what_goes_wrong_at_the_bench_is_said(tmp_path):
    lines = ("bench> press all", "$ echo x", "x")
    with pytest.raises(UserError, match="bench> press all: no window of a bench is open"):
        found_in(tmp_path, block(*lines))
    ends = "```console bench\n$ echo ready; read -r text; echo no such command\n...\n```\n"
    with pytest.raises(UserError, match=r"press all: the bench has ended: \['no such command'\]"):
        found_in(tmp_path, ends + block(*lines))


def test_write_refreshes(tmp_path):
    path = tmp_path / "DOC.md"
    picture = TUTORIAL.parent / "tutorial" / "tens.png"
    steps = ["$ mkdir ~/first-line && cd ~/first-line", f"$ cp {picture} made.png", "$ echo new"]
    picture_of = '![p](pictures/shown.png "made.png")'
    path.write_text(f"{block(*steps, 'old', 'older')}\n{picture_of}\n", encoding="utf-8")
    arguments = ["docs", "tutorial", str(path)]
    assert CliRunner().invoke(main_dev, [*arguments, "--check"]).exit_code == 1
    assert not (tmp_path / "pictures").exists()
    assert CliRunner().invoke(main_dev, [*arguments, "--write"]).exit_code == 1
    assert path.read_text(encoding="utf-8") == f"{block(*steps, 'new')}\n{picture_of}\n"
    assert (tmp_path / "pictures" / "shown.png").read_bytes() == picture.read_bytes()
    assert CliRunner().invoke(main_dev, arguments).exit_code == 0


@pytest.fixture
def picture(tmp_path):
    """Return a function that writes a picture of a curve and gives its path."""

    def write(name, shift=0, height=200):
        pixels = np.ones((height, 300, 3))
        for column in range(300):
            pixels[int(20 + column / 3) + shift : int(20 + column / 3) + shift + 2, column] = 0
        matplotlib.image.imsave(tmp_path / name, pixels)
        return tmp_path / name

    return write


def test_pictures(picture, tmp_path):
    shown = picture("shown.png")
    assert pictures.difference(shown, picture("same.png")) == ""
    assert pictures.difference(shown, picture("hair.png", shift=1)) == ""
    assert "% of its pixels differ" in pictures.difference(shown, picture("moved.png", shift=3))
    assert "300 x 200" in pictures.difference(shown, picture("low.png", height=190))
    assert "missing" in pictures.difference(shown, tmp_path / "none.png")
