# SPDX-License-Identifier: MIT
"""Every command that writes files, collected from the commands themselves: what it may do to them.

A new command with an output fails here until CALLS says how it is called.
"""

import contextlib
import os
import resource
import shutil
import threading
from dataclasses import dataclass

import click
import numpy as np
import pytest

import reportbench
from command_tree import FOREIGN, commands, walk
from pixstep import formats, natives, ops, plotting
from pixstep.cli.command import Command, OutFileType, OutFolderType
from pixstep.jobs.job import Job

PRN, FAST = (
    natives.root() / "tools/data" / name
    for name in ("AccProfM39-30Hz-1.PRN", "AccProf-fast-move.csv")
)
LINE = ("line.csv", "--decode", "plain")
AT_30 = ("--pixel-hz", 30)
PROFILE = ("--top-speed", 20, "--max-acceleration", 4, "--max-jerk", 4, "--name", "x", *AT_30)
TABLE = ("table.csv", "--play", 2, "--transition", 2, "--bandwidth", "none")
MILL = """\
clock.pixel = "100 Hz"
boards.main.kind = "uno"
motors.X = { axis = 0, kind = "plain", limits.max_acceleration = 9 }
"""
# How each command is called, without the output that is tried and with the others that it needs.
CALLS = {
    "board log records -o": ("board", "log", "records"),
    "board run --records": ("board", "run", "go.pmc", "--machine", "bus.toml"),
    "board settings export FILE": ("board", "settings", "export"),
    "board start --records": ("board", "start", "--wait"),
    "board trajectory --records": ("board", "trajectory", *TABLE),
    "board upload --records": ("board", "upload", *LINE, "--arm"),
    "completion -o": ("completion", "bash"),
    "demo --out": ("demo",),
    "file convert OUT": ("file", "convert", "line.csv", "--to", "csv"),
    "home sim --out": ("home", "sim", FAST, "--board", "uno", *AT_30, "--plant", "home=2000,hyst=8,"
                       "travel=-500..4000,start=123,delay=8000"),
    "job export --out": ("job", "export", "print.pxjob"),
    "job make -o": ("job", "make", "--image-size", "9x2", "--scan", "X=8", "--machine",
                    "mill.toml"),
    "job report -o": ("job", "report", "print.pxrun"),
    "job show-config --out": ("job", "show-config", "print.pxjob"),
    "job simulate --out": ("job", "simulate", "print.pxjob"),
    "line compensate --plot": ("line", "compensate", "line.csv", "--play", 2, "--max-acceleration",
                               9, "--start-stop", 9, "-o", "{other}"),
    "line compensate -o": ("line", "compensate", "line.csv", "--play", 2, "--max-acceleration", 9,
                           "--start-stop", 9),
    "line import -o": ("line", "import", "own.csv", "--decode", "plain"),
    "line make -o": ("line", "make", "--profile", PRN, "--speed", 1000, "--pixels", 60, *AT_30),
    "line show -o": ("line", "show", *LINE),
    "machine new -o": ("machine", "new", "--board", "uno", *AT_30),
    "move make -o": ("move", "make", FAST, "--steps", 900, *AT_30),
    "move show --plot": ("move", "show", FAST, "--steps", 900, *AT_30),
    "move sim --out": ("move", "sim", FAST, "--steps", 900, *AT_30, "--board", "uno"),
    "plan --out": ("plan", "go.pmc", "--machine", "mill.toml"),
    "profile make --csv": ("profile", "make", *PROFILE, "-o", "{other}"),
    "profile make -o": ("profile", "make", *PROFILE[:-4], *AT_30),
    "profile repair -o": ("profile", "repair", "line.csv"),
    "trajectory circle -o": ("trajectory", "circle", "--radius", 900, "--points", 64),
    "trajectory compensate -o": ("trajectory", "compensate", *TABLE),
    "trajectory export -o": ("trajectory", "export", "table.csv"),
    "trajectory import -o": ("trajectory", "import", "table.csv"),
    "trajectory show --plot": ("trajectory", "show", *TABLE),
    "trajectory sim --out": ("trajectory", "sim", *TABLE, "--board", "mega", *AT_30),
    "profile show -o": ("profile", "show", PRN),
    "sim --out": ("sim", *LINE, *AT_30, "--board", "uno"),
    "watch --page": ("watch", "print.pxrun"),
    "ticks -o": ("ticks", *LINE, *AT_30),
}  # fmt: skip


@dataclass(frozen=True)
class Output:
    """An output of a command."""

    words: tuple[str, ...]
    param: click.Parameter

    @property
    def option(self):
        """The words before the path."""
        argument = isinstance(self.param, click.Argument)
        return () if argument else (min(self.param.opts, key=len),)

    def __str__(self):
        return " ".join([*self.words, *(self.option or (self.param.human_readable_name,))])

    @property
    def folder(self):
        return isinstance(self.param.type, OutFolderType)

    @property
    def picture(self):
        return "plot" in self.param.opts[0] or "--plot" in self.param.opts


OUTPUTS = [
    Output(words, param)
    for words, command in walk()
    for param in command.params
    if isinstance(param.type, (OutFileType, OutFolderType))
]
FILES = [output for output in OUTPUTS if not output.folder]
FOLDERS = [output for output in OUTPUTS if output.folder]
every_file = pytest.mark.parametrize("output", FILES, ids=str)
every_folder = pytest.mark.parametrize("output", FOLDERS, ids=str)


def draw_quickly(monkeypatch):
    """Write noise for every figure: how pictures are written is tried, not how they look.

    The noise takes more than a pipe holds, as a real picture does.
    """
    write = plotting.write
    noise = plotting.figure((2, 2))
    noise.set_layout_engine("none")
    noise.figimage(np.random.default_rng(1).random((200, 200, 4)))
    monkeypatch.setattr(plotting, "write", lambda _, path, **options: write(noise, path, **options))


@pytest.fixture
def call(plan_program, simulator, invoke, one, tmp_path, monkeypatch):
    """Return a function that calls a command with a path for its output."""
    shutil.rmtree(tmp_path)
    (tmp_path / "work").mkdir(parents=True)
    draw_quickly(monkeypatch)
    monkeypatch.chdir(tmp_path / "work")
    formats.write_csv(tmp_path / "work" / "line.csv", [2, 4, 4, 2])
    (tmp_path / "work" / "mill.toml").write_text(MILL)
    (tmp_path / "work" / "bus.toml").write_text(MILL.replace("uno", "mega"))
    (tmp_path / "work" / "go.pmc").write_text("TS0 TA9 TM90 X40")
    ops.job_make(image_size="9x2", scan="X=8", output="print.pxjob", machine="mill.toml")
    reportbench.finished(tmp_path / "work" / "print.pxrun", Job.read(tmp_path / "work/print.pxjob"))
    (tmp_path / "work" / "own.csv").write_text("steps\n2\n4\n4\n2\n")
    points = [f"{min(k, 9 - k)},{k}\n" for k in range(10)]
    (tmp_path / "work" / "table.csv").write_text("".join(["p1,p2\n", *points]))

    def run(output, path, *more, status=0):
        number = len(list((tmp_path).iterdir()))
        other = tmp_path / f"other{number}.csv"
        words = [str(word).format(other=other) for word in CALLS[str(output)]]
        monkeypatch.setenv("PIXSTEP_PORT", "/dev/ttyTEST")
        if words[:2] == ["board", "start"]:
            one.finish("disarm")
            one.out("upload", "line.csv", "--decode", "plain")
        return invoke(*words, *output.option, path, *more, status=status)

    return run


@contextlib.contextmanager
def no_room():
    """Let no file grow."""
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)


def last_line(text):
    """Return the error of a command: its last line, the only one of its kind."""
    rows = text.splitlines()
    assert sum(row.startswith("pixstep: ") for row in rows) == 1, text
    return rows[-1].removeprefix("pixstep: ")


def tree(folder):
    """Return what is in a folder, with its content."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_output_is_tried():
    assert sorted(map(str, OUTPUTS)) == sorted(CALLS)


def test_every_command_is_of_the_class_that_guards_outputs():
    for words, command in commands().items():
        if words != FOREIGN:  # comes from another package when it is called
            assert isinstance(command, Command), words


def test_every_option_that_writes_says_so_by_its_type():
    for words, command in commands().items():
        for param in command.params:
            about = (getattr(param, "help", None) or "").lower()
            named = {"-o", "--output", "--out", "--csv"} & set(param.opts)
            if isinstance(param.type, click.Path) and (named or "write" in about.split()[:4]):
                assert isinstance(param.type, (OutFileType, OutFolderType)), (words, param.name)


@every_file
def test_an_existing_file_is_replaced_by_force_only(call, output, tmp_path):
    name = "out.png" if output.picture else "out.csv"
    call(output, name)
    made = (tmp_path / "work" / name).read_bytes()
    assert made
    (tmp_path / "work" / name).write_text("mine")
    before = tree(tmp_path)
    text = call(output, name, status=2).stderr
    assert last_line(text) == f"{name}: already exists (--force replaces it)"
    assert tree(tmp_path) == before
    call(output, name, "--force")
    assert (tmp_path / "work" / name).read_bytes()[:8] == made[:8]


@every_file
def test_a_dash_is_the_standard_output(call, output, tmp_path):
    done = call(output, "-")
    assert done.stdout and not (tmp_path / "work" / "-").exists()
    name = "out.png" if output.picture else "out.csv"
    call(output, name)
    assert (
        done.stdout_bytes[:8] == (tmp_path / "work" / name).read_bytes()[:8]
    )  # jobs tell the time


@every_file
def test_a_fifo_a_device_and_a_link_stay_what_they_are(call, output, tmp_path):
    suffix = ".png" if output.picture else ".csv"
    pipe, link = tmp_path / f"pipe{suffix}", tmp_path / f"link{suffix}"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    call(output, pipe)
    reader.join(60)
    assert got and got[0] and pipe.is_fifo()
    link.symlink_to(f"real{suffix}")
    call(output, link)
    assert link.is_symlink() and (tmp_path / f"real{suffix}").read_bytes()
    call(output, "/dev/null")
    text = call(output, "/dev/full", status=2).stderr
    assert last_line(text) == "/dev/full: No space left on device"


@every_file
def test_an_unwritable_place_is_one_line(call, output, tmp_path):
    suffix = ".png" if output.picture else ".csv"
    before = tree(tmp_path)
    for place in (f"line.csv/x{suffix}", f"/proc/x{suffix}", "x" * 255 + suffix):
        assert last_line(call(output, place, status=2).stderr).startswith(f"{place}: ")
        assert tree(tmp_path) == before


@every_file
def test_a_full_disk_is_one_line(call, output, tmp_path):
    name = "out.png" if output.picture else "out.csv"
    before = tree(tmp_path)
    with no_room():
        text = call(output, name, status=2).stderr
    assert "File too large" in last_line(text)
    assert tree(tmp_path) == before


@every_folder
def test_a_folder_of_the_users_is_left_alone(call, output, tmp_path):
    out = tmp_path / "work" / "out"
    out.mkdir()
    names = {"trajectory": "summary.json", "plan": "report.json", "export": "X.csv",
             "show-config": "machine.toml", "simulate": "simulation.json"}  # fmt: skip
    first = names.get(output.words[-1], names.get(output.words[0], "edges.csv"))
    for name in (first, "edges.csv", "notes.txt"):
        (out / name).write_text("mine")
    before = tree(tmp_path)
    text = call(output, "out", status=2).stderr
    said = f"out/{first}: already exists and is not as an earlier run"
    if output.words[-1] == "simulate":
        said = "out: is the folder of no simulation"
    assert last_line(text).startswith(said)
    assert tree(tmp_path) == before


@every_folder
def test_a_folder_that_cannot_be_written_is_one_line(call, output, tmp_path):
    before = tree(tmp_path)
    for place in ("line.csv/x", "/proc/x", "x" * 256):
        assert last_line(call(output, place, status=2).stderr).startswith(f"{place}: ")
    if output.words[-1] == "simulate":
        return  # it keeps what is finished, and goes on from there
    with no_room():
        text = call(output, "full", status=2).stderr
    wanted = ("simulator: ended: File size limit exceeded", "full/line.csv: File too large",
              "full/X.csv: File too large", "full/machine.toml: File too large")  # fmt: skip
    assert last_line(text) in wanted
    assert tree(tmp_path) == before and not (tmp_path / "work" / "full").exists()


@pytest.mark.parametrize(
    "output", [one for one in FILES if "line.csv" in CALLS[str(one)] and not one.picture], ids=str
)
def test_an_input_is_never_written(call, output, tmp_path):
    before = tree(tmp_path)
    for more in ((), ("--force",)):
        text = call(output, "./line.csv", *more, status=2).stderr
        assert last_line(text) == "line.csv: is the input: name another file for the output"
    assert tree(tmp_path) == before


def test_an_input_in_the_results_folder_is_never_written(call, tmp_path):
    work = tmp_path / "work"
    (work / "line.csv").rename(work / "edges.csv")
    words = ("sim", "edges.csv", "--decode", "plain", *AT_30, "--board", "uno")
    (output,) = [one for one in FOLDERS if str(one) == "sim --out"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(CALLS, "sim --out", words)
        text = call(output, ".", "--force", status=2).stderr
    assert last_line(text) == "edges.csv: is the input: name another file for the output"
