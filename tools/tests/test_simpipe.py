# SPDX-License-Identifier: MIT
"""The pipe to a runner that writes more to its error output than a pipe holds."""

import sys

import pytest

from pixstep.simulation.simulator import SimPipe, SimulatorError

MUCH = 1_000_000  # bytes; a pipe holds 65,536
RUNNER = f"""
import sys
for line in sys.stdin:
    sys.stderr.write("x" * {MUCH} + chr(10) + "the last word" + chr(10))
    sys.stderr.flush()
    if "die" in line:
        sys.exit(1)
    print("ok", line.strip(), flush=True)
"""


@pytest.fixture
def pipe():
    with SimPipe([sys.executable, "-c", RUNNER]) as found:
        yield found


def test_a_runner_that_says_much_is_not_held_up(pipe):
    """A runner whose error output nobody reads would stop in its first write, for ever."""
    for number in range(3):
        assert pipe.command(f"go {number}").endswith(f"go {number}")


def test_its_last_words_are_kept(pipe):
    pipe.command("go")
    with pytest.raises(SimulatorError, match=r"ended: the last word$"):
        pipe.command("die")


def test_an_answer_that_a_signal_broke_off_is_none_of_the_next_command(pipe, monkeypatch):
    def interrupted(_seconds):
        monkeypatch.undo()
        raise KeyboardInterrupt

    monkeypatch.setattr(pipe._ready, "select", interrupted)
    with pytest.raises(KeyboardInterrupt):
        pipe.command("go 1")
    assert pipe.command("go 2").endswith("go 2")
    assert pipe.command("go 3").endswith("go 3")


def test_a_closed_error_output_is_no_end():
    runner = "import os, sys\nos.close(2)\nfor line in sys.stdin: print('ok', flush=True)"
    with SimPipe([sys.executable, "-c", runner]) as pipe:
        for _ in range(3):
            assert pipe.command("go").startswith("ok")
