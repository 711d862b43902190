# SPDX-License-Identifier: MIT
"""Every option and argument of every command is fed wrong values: one line, its status, no file.

The commands are walked, so that a new option is tried by itself. What stands beside it on the
command line is the example of the command's help.
"""

import shlex
import shutil

import click
import pytest
from click.testing import CliRunner

import reportbench
from command_tree import own_commands
from console import PORT
from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep import formats, natives, ops
from pixstep.board import link
from pixstep.board.link import SerialLink
from pixstep.board.modbus import SimClient
from pixstep.cli.command import OutFileType, OutFolderType, OutPictureType
from pixstep.cli.examples import EXAMPLES
from pixstep.cli.main import main
from pixstep.errors import MISUSE, REFUSED
from pixstep.jobs.job import Job

DATA = natives.root() / "tools/data"
MACHINE = """\
clock.pixel = "30 Hz"
boards.main.kind = "mega"
line.motor = "X"
motors.X = { axis = 0, kind = "plain", limits.max_acceleration = 600 }
motors.Y = { axis = 1, kind = "plain", limits.max_acceleration = 600, limits.max_speed = 900 }
motors.Z = { axis = 2, kind = "plain", limits.max_acceleration = 600 }
"""
# Texts that commands read by themselves, by option or argument.
TEXTS = {
    "--port": ("/dev/nowhere",),
    "--machine": ("nowhere.toml", "broken.toml"),
    "--motor": ("nobody",),
    "--prefix": ("a b",),
    "--plant": ("play=abc", "nonsense", "colour=red"),
    "--encoder": ("/no/such/program",),
    "--bauds": ("abc", "17"),
    "--scheduler": ("nonsense", "tcp://127.0.0.1:1"),
    "--skip": ("nonsense",),
    "--of": ("nobody",),
    "--still": ("nobody",),
    "--column": ("nonsense", "77"),
    "--unit": ("parsec",),
    "--header": ("a name that is longer than the header of a printer's file",),
    "--variant": ("a b",),
    "--name": ("a name that is longer than the header of a printer's file",),
    "--date": (),  # any text, cut to the room that a header has
    "[NAME]...": ("nonsense",),
    "NAME=VALUE...": ("nonsense=3", "dir_setup_us=abc", "dir_setup_us=9999999", "dir_setup_us"),
}
# Stopping needs no machine file: one that cannot be read is noted. `start` looks first at what is
# loaded, and fake boards have nothing.
GOES_ON = (
    ("board stop", "--machine"),
    ("board start", "--records"),
    ("serve", "--socket"),  # it is made
    ("ioc", "--state"),  # it is made
    ("job run", "--folder"),  # so is this
    ("job simulate", "--edges"),
)
# A profile may be made for any motor.
OWN_TEXTS = {("profile make", "--motor"): ("a/b",)}
REFUSED_CONTENT = ("broken.toml",)  # what the file says is wrong, not the command line
NUMBERS = ("abc", "", "1e999", "nan", "\x1b[31m" * 100)


COMMANDS = own_commands()


def typed(param):
    """Return a parameter as it is typed, or as help names it."""
    if isinstance(param, click.Option):
        return max(param.opts, key=len)
    return param.human_readable_name


def wrong_values(words, param):
    """Return values that a parameter must not take."""
    kind = param.type
    if isinstance(kind, OutPictureType):
        return ("picture.txt", "line.csv/x.png", "/no-such-folder/x.png")
    if isinstance(kind, OutFileType):
        return ("line.csv/x.csv", "/no-such-folder/x.csv")
    if isinstance(kind, OutFolderType):
        return ("line.csv", "/no-such-folder")
    if param.name == "link":
        return ("line.csv", "nowhere/x")
    if isinstance(kind, click.Path):
        return ("nowhere.csv", "folder")
    if isinstance(kind, click.Choice):
        return ("nonsense", "")
    if kind.name == "text":
        if (words, typed(param)) in OWN_TEXTS:
            return OWN_TEXTS[words, typed(param)]
        return TEXTS[typed(param)] if param.name != "file" else ("nowhere.toml", "folder")
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        beyond = ((kind.min, -1), (kind.max, 1))
        return (*NUMBERS, *(str(end + step) for end, step in beyond if end is not None))
    return NUMBERS


def cases():
    """Yield every command with one of its parameters."""
    for words, command in COMMANDS.items():
        for param in command.params:
            if not getattr(param, "is_flag", False) and (words, typed(param)) not in GOES_ON:
                yield pytest.param(words, param, id=f"{words} {typed(param)}")


def with_value(words, command, param, value):
    """Return the command line of the example with a value for one parameter."""
    line = shlex.split(EXAMPLES[words][0])
    if any(typed(other) == "--force" for other in command.params):
        line += ["--force"]
    if words == "board simulate" and typed(param) != "--script":
        line += ["--script", "quit.txt"]  # it would go on for ever if it took the value
    if isinstance(param, click.Option):
        return [*line, f"{typed(param)}={value}"]
    *groups, name = words.split()
    above = click.Context(main, info_name="pixstep")
    for group in groups:
        above = click.Context(command, parent=above, info_name=group)
    context = command.make_context(name, line[len(groups) + 1 :], parent=above)
    old = context.params[param.name]
    if old == ():
        return [*line, value]
    old = old[0] if isinstance(old, tuple) else old
    if str(old) in line:
        return [value if word == str(old) else word for word in line]
    return [*line, value]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the files that the examples name."""
    made = tmp_path_factory.mktemp("wrong") / "work"
    made.mkdir()
    (made / "folder").mkdir()
    for name in ("AccProfM39-30Hz-1.PRN", "AccProf-fast-move.csv"):
        shutil.copy(DATA / name, made)
    shutil.copy(DATA / "AccProf-fast-move.csv", made / "fast.csv")
    formats.write_csv(made / "line.csv", [0, 250, 500, 500, 250])
    for name in ("ideal.csv", "tens.csv"):
        formats.write_csv(made / name, [4, 12, 8])
    (made / "positions.csv").write_text("index,position steps\n0,0\n1,2\n2,4\n3,4\n")
    (made / "mine.csv").write_text("p1,p2\n" + "".join(f"{k},{k}\n" for k in range(9)))
    CliRunner().invoke(main, ["trajectory", "circle", "--radius", "9999",
                              "-o", str(made / "circle.trj")])  # fmt: skip
    (made / "square.pmc").write_text("TS0 TA9 TM90 X40")
    (made / "mine.toml").write_text("[settings]\ndir_setup_us = 20\n")
    (made / "quit.txt").write_text("quit\n")
    (made / "machine.toml").write_text(MACHINE)
    motors = {"scan": "X=200", "step": "Y=40", "machine": made / "machine.toml"}
    ops.job_make(image_size="9x2", output=made / "print.pxjob", **motors)
    reportbench.MadeUp(made / "print.pxrun", Job.read(made / "print.pxjob")).print(1)
    (made / "broken.toml").write_text(MACHINE.replace("mega", "mgea"))
    return made


@pytest.fixture
def bus(monkeypatch, folder):
    """Stand in the folder, with a fake board on the port."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PIXSTEP_PORT", PORT)
    world = FakeWorld()
    line = FakeLine(world, *(FakeBoard(world, unit, "mega") for unit in (1, 2)))
    opened = link.open_port

    def open_port(options, *more):
        if options.name != PORT:
            return opened(options, *more)
        return SerialLink(SimClient(line, retries=1), PORT, world)

    monkeypatch.setattr(link, "open_port", open_port)


def tree(folder):
    """Return what is in a folder, with its content."""
    return {path: path.is_dir() or path.read_bytes() for path in folder.rglob("*")}


def complaint(done, value, param):
    """Return what is wrong with how a command takes a wrong value; nothing if it is right."""
    wanted = REFUSED if value in REFUSED_CONTENT else MISUSE
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return repr(done.exception)
    if done.exit_code != wanted:
        return f"status {done.exit_code}, wanted {wanted}"
    rows = [row for row in done.stderr.splitlines() if not row.startswith("note: ")]
    if len(rows) != 1 or not rows[0].startswith("pixstep: ") or done.stdout:
        return "not one line"
    if len(done.stderr) > 600 or "\x1b" in done.stderr:
        return "not a line to read"
    named = [text for text in (value.partition("=")[0], typed(param)) if text]
    if not any(text in done.stderr for text in named):
        return "names neither the value nor the option"
    return ""


@pytest.mark.usefixtures("bus", "simulator", "plan_program")
@pytest.mark.parametrize(("words", "param"), list(cases()))
def test_a_wrong_value_is_one_line(words, param, folder):
    before = tree(folder)
    found = []
    for value in wrong_values(words, param):
        line = with_value(words, COMMANDS[words], param, value)
        done = CliRunner().invoke(main, line)
        wrong = complaint(done, value, param)
        if wrong:
            found.append(f"{shlex.join(line)}: {wrong}: {done.stdout[:200]}{done.stderr[:900]}")
        if tree(folder) != before:
            found.append(f"{shlex.join(line)}: wrote something")
            for path in tree(folder).keys() - before.keys():
                shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    assert not found, "\n".join(found)
