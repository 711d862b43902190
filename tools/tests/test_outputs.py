# SPDX-License-Identifier: MIT
"""Where outputs go: links, devices, the standard output; what is refused, and what stays."""

import hashlib
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from pixstep import atomic, formats, outfolder
from pixstep.errors import MOST_CHARACTERS, UserError

COUNTS = [2, 4, 4, 2]
LONG = 255  # the longest name of a file


@pytest.fixture
def line(tmp_path):
    """Return a line file in the present folder."""
    formats.write_csv(tmp_path / "line.csv", COUNTS)
    return tmp_path / "line.csv"


def ticks(line, *output):
    """Return the words of a command that writes a file."""
    return ("ticks", line, "--decode", "plain", "--pixel-hz", 30, "-o", *output)


def profile(*more):
    return (
        "profile", "make", "--top-speed", 20, "--max-acceleration", 4, "--max-jerk", 4,
        "--pixel-hz", 30, *more,
    )  # fmt: skip


@pytest.fixture
def planned(plan_program, invoke, line, tmp_path):
    """Return what `ticks` writes for the line."""
    invoke(*ticks(line, "plain.csv"))
    return (tmp_path / "plain.csv").read_bytes()


def test_a_dash_is_the_standard_output(planned, invoke, line, tmp_path):
    done = invoke(*ticks(line, "-"))
    assert done.stdout.encode() == planned
    assert done.stderr == "-: 12 steps\n" and not (tmp_path / "-").exists()


def test_the_standard_output_by_its_device(planned, line, tmp_path):
    with (tmp_path / "shell.csv").open("wb") as shell:
        done = subprocess.run(
            [sys.executable, "-m", "pixstep", *map(str, ticks(line, "/dev/stdout"))],
            stdout=shell, stderr=subprocess.PIPE, text=True, check=True,
        )  # fmt: skip
    assert (tmp_path / "shell.csv").read_bytes() == planned
    assert done.stderr == "/dev/stdout: 12 steps\n"


def test_a_standard_output_that_is_closed(planned, line):
    words = ["bash", "-c", 'exec "$@" >&-', "-", sys.executable, "-m", "pixstep"]
    done = subprocess.run(
        [*words, *map(str, ticks(line, "-"))], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (2, "pixstep: -: the standard output is closed\n")


@pytest.mark.parametrize("words", [("limits", "--board", "uno", "--pixel-hz", "30"), ("--help",)])
def test_a_standard_output_without_room(words):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "pixstep", *words],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "pixstep: No space left on device\n")


def test_a_link_stays_and_its_file_is_written(planned, invoke, line, tmp_path):
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to("real.csv")
    text = invoke(*ticks(line, "link.csv"), status=2).stderr
    assert text == "pixstep: link.csv: already exists (--force replaces it)\n"
    assert (tmp_path / "real.csv").read_text() == "old"
    invoke(*ticks(line, "link.csv"), "--force")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_bytes() == planned
    (tmp_path / "new.csv").symlink_to("made.csv")
    invoke(*ticks(line, "new.csv"))
    assert (tmp_path / "new.csv").is_symlink()
    assert (tmp_path / "made.csv").read_bytes() == planned


def test_a_fifo_is_written_to(planned, invoke, line, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    got = []
    reader = threading.Thread(target=lambda: got.append((tmp_path / "pipe").read_bytes()))
    reader.start()
    invoke(*ticks(line, "pipe"))
    reader.join()
    assert got == [planned] and (tmp_path / "pipe").is_fifo()


def test_a_device_is_written_to(planned, invoke, line):
    invoke(*ticks(line, "/dev/null"))
    assert os.stat("/dev/null").st_mode & 0o170000 == 0o020000  # noqa: PTH116
    text = invoke(*ticks(line, "/dev/full"), status=2).stderr
    assert text == "pixstep: /dev/full: No space left on device\n"


def test_a_file_keeps_its_rights(planned, invoke, line, tmp_path):
    (tmp_path / "mine.csv").write_text("old")
    (tmp_path / "mine.csv").chmod(0o640)
    invoke(*ticks(line, "mine.csv"), "--force")
    assert (tmp_path / "mine.csv").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize(
    ("target", "reason"),
    [
        ("line.csv/x.csv", "Not a directory"),
        ("/proc/x.csv", "No such file or directory\n"),
        ("x" * (LONG - 3) + ".csv", "File name too long"),
        ("x" * 5000, "File name too long"),
        ("link.csv", "is a link to /nowhere/x.csv, whose folder is not there"),
    ],
)
def test_what_the_system_refuses_is_one_line(planned, invoke, line, tmp_path, target, reason):
    (tmp_path / "link.csv").symlink_to("/nowhere/x.csv")
    before = sorted(tmp_path.iterdir())
    text = invoke(*ticks(line, target), status=2).stderr
    assert text.count("\n") == 1
    if len(target) < MOST_CHARACTERS - 100:
        assert text.startswith(f"pixstep: {target}: {reason}")
    else:
        assert text.startswith(f"pixstep: {target[:100]}") and text.endswith(f"x: {reason}\n")
    assert sorted(tmp_path.iterdir()) == before


def test_the_folder_itself_is_no_file(planned, invoke, line, tmp_path):
    assert "is a directory" in invoke(*ticks(line, "."), status=2).stderr
    with pytest.raises(UserError, match="is a folder: nothing can be written there"):
        atomic.write_text(tmp_path, "x")


def test_the_longest_name_is_taken(planned, invoke, line, tmp_path):
    name = "x" * (LONG - 4) + ".csv"
    invoke(*ticks(line, name))
    assert (tmp_path / name).read_bytes() == planned


def test_a_limit_of_file_size_is_one_line(planned, line, tmp_path):
    words = map(str, ticks(line, "big.csv"))
    before = sorted(tmp_path.iterdir())
    done = subprocess.run(
        ["bash", "-c", 'ulimit -f 0; exec "$@"', "-", sys.executable, "-m", "pixstep", *words],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "pixstep: big.csv: File too large\n")
    assert sorted(tmp_path.iterdir()) == before


def test_of_two_outputs_none_is_written_if_one_is_refused(invoke, tmp_path):
    (tmp_path / "file").write_text("mine")
    for csv in ("file/x.csv", "y" * (LONG - 3) + ".csv", "/dev/full"):
        text = invoke(*profile("-o", "made.PRN", "--csv", csv, "--name", "x"), status=2).stderr
        assert text.startswith(f"pixstep: {csv}: ") and text.count("\n") == 1
        assert [path.name for path in tmp_path.iterdir()] == ["file"]
    text = invoke(*profile("-o", "a.csv", "--csv", "./a.csv"), status=2).stderr
    assert text == "pixstep: a.csv: -o and --csv are the same file\n"


def test_two_outputs(invoke, tmp_path):
    invoke(*profile("-o", "made.PRN", "--csv", "made.csv"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["made.PRN", "made.csv"]


def test_json_and_the_output_do_not_share_a_stream(invoke):
    text = invoke(*profile("-o", "-", "--json"), status=2).stderr
    assert "--json and the output both go to the standard output" in text


@pytest.mark.parametrize("name", ["line.csv", "./line.csv", "link.csv"])
@pytest.mark.parametrize(
    "words",
    [
        ("ticks", "line.csv", "--decode", "plain", "--pixel-hz", 30),
        ("line", "compensate", "line.csv", "--play", 2, "--max-acceleration", 9,
         "--start-stop", 9),
        ("profile", "repair", "line.csv"),
    ],
)  # fmt: skip
def test_an_input_is_never_written(plan_program, invoke, line, tmp_path, words, name):
    before = line.read_bytes()
    (tmp_path / "link.csv").symlink_to("line.csv")
    text = invoke(*words, "-o", name, status=2).stderr
    shown = name.removeprefix("./")
    assert text == f"pixstep: {shown}: is the input: name another file for the output\n"
    assert line.read_bytes() == before


def test_convert_writes_to_the_standard_output(invoke, line, tmp_path):
    invoke("file", "convert", line, "made.csb")
    done = invoke("file", "convert", line, "-", "--to", "csb")
    assert done.stdout_bytes == (tmp_path / "made.csb").read_bytes()
    assert not (tmp_path / "-").exists()


# Folders of results


def sim(line, out, *more, name="sim"):
    return (
        name, line, "--decode", "plain", "--pixel-hz", 100, "--board", "uno", "--out", out, *more
    )  # fmt: skip


def test_a_run_replaces_its_own_files_and_leaves_the_others(simulator, invoke, line, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    (out / "holiday-motion.png").write_text("mine")
    invoke(*sim(line, "out", "--vcd"))
    first = (out / "edges.csv").read_bytes()
    invoke(*sim(line, "out"))
    assert (out / "edges.csv").read_bytes() == first
    assert not (out / "run.vcd").exists()  # of the earlier run
    assert (out / "notes.txt").read_text() == "mine"
    assert (out / "holiday-motion.png").read_text() == "mine"


@pytest.mark.parametrize("name", ["edges.csv", "summary.json", "motion.png", "run.vcd"])
def test_a_file_of_the_users_is_not_replaced(simulator, invoke, line, tmp_path, name):
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text("mine")
    text = invoke(*sim(line, "out"), status=2).stderr
    assert text.startswith(f"pixstep: out/{name}: already exists and is not as an earlier run left")
    assert [path.name for path in out.iterdir()] == [name]
    assert (out / name).read_text() == "mine"


def test_a_link_of_the_users_is_not_followed(simulator, invoke, line, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "edges.csv").symlink_to("../precious")
    assert "already exists" in invoke(*sim(line, "out"), status=2).stderr


def test_only_what_was_written_is_a_runs_own(tmp_path):
    with outfolder.of_run(tmp_path, ("a", "b")) as folder:
        (folder / "a").write_text("made")
    (tmp_path / "b").write_text("mine")
    with pytest.raises(UserError, match="b: already exists"), outfolder.of_run(tmp_path, ("b",)):
        raise AssertionError("not reached")
    assert (tmp_path / "b").read_text() == "mine"
    with outfolder.of_run(tmp_path, ("a",)):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b"]


def test_a_result_that_the_user_edited_stays(tmp_path):
    with outfolder.of_run(tmp_path, ("a",)) as folder:
        (folder / "a").write_text("made")
    (tmp_path / "a").write_text("made, and a remark of mine")
    refusal = pytest.raises(UserError, match="not as an earlier run left it")
    with refusal, outfolder.of_run(tmp_path, ("a",)):
        raise AssertionError("not reached")
    rules = atomic.rules(atomic.WriteRules(force=True))
    with rules, outfolder.of_run(tmp_path, ("a",)) as folder:
        (folder / "a").write_text("new")
    assert (tmp_path / "a").read_text() == "new"


def test_what_appears_during_a_run_stays(tmp_path):
    refusal = pytest.raises(UserError, match="already exists")
    with refusal, outfolder.of_run(tmp_path, ("a", "b")) as folder:
        (folder / "a").write_text("made")
        (folder / "b").write_text("made")
        (tmp_path / "b").write_text("mine")
    assert [path.name for path in tmp_path.iterdir()] == ["b"]
    assert (tmp_path / "b").read_text() == "mine"


def test_a_run_that_fails_leaves_the_folder_as_it_was(tmp_path):
    out = tmp_path / "out"
    with pytest.raises(ZeroDivisionError), outfolder.of_run(out, ("a",)) as folder:
        (folder / "a").write_text(str(1 / 0))
    assert not out.exists()
    with outfolder.of_run(out, ("a",)) as folder:
        (folder / "a").write_text("made")
    with pytest.raises(ZeroDivisionError), outfolder.of_run(out, ("a",)) as folder:
        (folder / "a").write_text(str(1 / 0))
    assert (out / "a").read_text() == "made"
    assert sorted(path.name for path in out.iterdir()) == [outfolder.MARK, "a"]


def test_a_mark_names_files_of_its_folder_only(tmp_path):
    (tmp_path / "mine").write_text("mine")
    total = hashlib.sha256(b"mine").hexdigest()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / outfolder.MARK).write_text(f"{total}  ../mine\n")
    with pytest.raises(UserError), outfolder.of_run(tmp_path / "out", ("../mine",)):
        raise AssertionError("not reached")
    assert (tmp_path / "mine").read_text() == "mine"


KILLED = """
import os, sys
from pathlib import Path
from pixstep import atomic, outfolder
with outfolder.of_run(Path("out"), ("a",)) as folder, atomic.replacing(Path("out/x")):
    (folder / "a").write_text("half")
    os.kill(os.getpid(), 9)
"""


def test_what_a_killed_run_leaves_is_removed_by_the_next(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert subprocess.run([sys.executable, "-c", KILLED], check=False).returncode == -9
    left = [path.name for path in (tmp_path / "out").iterdir()]
    assert len(left) == 2 and all(name.startswith(atomic.UNFINISHED) for name in left)
    with outfolder.of_run(Path("out"), ("a",)) as folder:
        own = [path.name for path in (tmp_path / "out").iterdir()]
        assert own == [folder.name]
        atomic.write_text(Path("out/x"), "whole")  # leaves the folder of a run that goes on
        (folder / "a").write_text("made")
    assert sorted(path.name for path in Path("out").iterdir()) == [outfolder.MARK, "a", "x"]


@pytest.mark.parametrize(
    ("out", "reason"),
    [
        ("line.csv/out", "Not a directory"),
        ("/proc/x", "No such file or directory"),
        ("x" * 300, "File name too long"),
    ],
)
def test_a_folder_that_cannot_be(simulator, invoke, line, out, reason):
    text = invoke(*sim(line, out), status=2).stderr
    assert text.startswith(f"pixstep: {out}: {reason}") and text.count("\n") == 1
