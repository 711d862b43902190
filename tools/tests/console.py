# SPDX-License-Identifier: MIT
"""`pixstep board` on a line without a port: fakes, or the simulator's control pipe."""

import json

import pytest
from click.testing import CliRunner

from pixstep.board import connection
from pixstep.board.connection import Connection
from pixstep.board.transport import SimClient
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
        monkeypatch.setattr(connection, "open_port", self._open)

    def _open(self, options, say=None):
        self.options.append(options)
        return Connection(self.client, self.world, options.port)

    def run(self, *words, status=0, say=""):
        """Run a command and return its result; its status must be the one given."""
        done = CliRunner().invoke(main, ["board", *map(str, words)], input=say)
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        assert done.exit_code == status, f"{done.exit_code}: {done.output}"
        return done

    def out(self, *words, status=0, say=""):
        """Run a command and return what it printed on the output."""
        return self.run(*words, status=status, say=say).stdout

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
