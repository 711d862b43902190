# SPDX-License-Identifier: MIT
"""`pixstep board` on a line without a port: fakes, or the simulator's control pipe."""

import json

import pytest
from click.testing import CliRunner

from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep import formats
from pixstep.board import link
from pixstep.board.link import SerialLink
from pixstep.board.modbus import SimClient
from pixstep.cli.main import main

PORT = "/dev/ttyTEST"


class Console:
    """Commands of `pixstep board` on one line; `say` is what is typed at prompts."""

    def __init__(self, monkeypatch, pipe, world, retries=1):
        self.client = SimClient(pipe, retries=retries)
        self.client.place = f"{PORT} (115200 baud, 8E1)"
        self.world = world
        self.options = []
        monkeypatch.setenv("PIXSTEP_PORT", PORT)
        monkeypatch.setattr(link, "open_port", self._open)

    def _open(self, options, say=None, first=lambda _: None):
        self.options.append(options)
        found = SerialLink(self.client, options.name, self.world)
        first(found)
        return found

    def run(self, *words, status=0, say=""):
        """Run a command and return its result; its status must be the one given."""
        done = self.finish(*words, say=say)
        assert done.exit_code == status, f"{done.exit_code}: {done.output}"
        return done

    def finish(self, *words, say=""):
        """Run a command and return its result, whatever its status; an exception is raised."""
        done = CliRunner().invoke(main, ["board", *map(str, words)], input=say)
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return done

    def out(self, *words, status=0, say=""):
        """Run a command and return what it printed on the output."""
        return self.run(*words, status=status, say=say).stdout

    def ended(self, *words, status=130):
        """Run a command that a signal ends and return its one line on the error stream."""
        return self.err(*words, status=status)

    def err(self, *words, status=1):
        """Run a command that fails and return its one line on the error stream."""
        text = self.run(*words, status=status).stderr
        assert text.count("\n") == 1, text
        assert text.startswith("pixstep: ")
        return text.removeprefix("pixstep: ").rstrip()

    def json(self, *words, status=0, say=""):
        """Run a command with --json and return what it printed."""
        return json.loads(self.out(*words, "--json", status=status, say=say))


@pytest.fixture
def make_console(monkeypatch, tmp_path):
    """Return a function that makes a Console on a pipe, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda pipe, world, **options: Console(monkeypatch, pipe, world, **options)


class Rig:
    """A line with fake boards and the console on it."""

    def __init__(self, make, *kinds):
        self.world = FakeWorld()
        self.boards = [FakeBoard(self.world, unit, kind) for unit, kind in enumerate(kinds, 1)]
        self.line = FakeLine(self.world, *self.boards)
        self.console = make(self.line, self.world)
        self.board = self.boards[0]

    def __getattr__(self, name):
        return getattr(self.console, name)


@pytest.fixture
def one(make_console):
    return Rig(make_console, "mega")


@pytest.fixture
def two(make_console):
    return Rig(make_console, "mega", "uno")


def put(counts, name="line.csv"):
    """Write a line file into the present folder and return its name."""
    formats.write_csv(name, counts)
    return name
