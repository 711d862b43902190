# SPDX-License-Identifier: MIT
"""The runner as a process: one command a line in, one answer a line out."""

import contextlib
import os
import re
import selectors
import signal
import subprocess
import threading
from collections.abc import Sequence
from typing import Self

from pixstep.errors import UserError

_ANSWER_LIMIT_S = 300  # wall-clock seconds; a longer silence means that the runner hangs
_ARGUMENT = re.compile(r"pixstep-sim: (--plant) [0-9]+\.([0-9]+): ")  # of a board's axis
_READ_BYTES = 65_536  # at once, and as much of the runner's error output is kept


class SimulatorError(UserError):
    """The runner refused a command, ended or hung."""


class SimPipe:
    """A running pixstep-sim in control mode; use as a context manager.

    Every method raises SimulatorError with the runner's own text if it refuses or ends. After an
    exception the process is ended, never left behind.
    """

    def __init__(self, command: Sequence[object]) -> None:
        self._turn = threading.Lock()
        try:
            self._process = subprocess.Popen(
                [str(word) for word in command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
        except OSError as error:
            raise UserError(f"{command[0]}: {error.strerror or error}") from None
        assert self._process.stdin and self._process.stdout and self._process.stderr
        self._in, self._out = self._process.stdin, self._process.stdout
        self._errors = self._process.stderr
        self._pending, self._said, self._ended = b"", b"", ""
        self._ready = selectors.DefaultSelector()
        for pipe in (self._out, self._errors):
            self._ready.register(pipe, selectors.EVENT_READ, pipe)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def command(self, text: str) -> str:
        """Send one command and return its answer; of several threads one after the other."""
        with self._turn:
            return self._command(text)

    def quit(self) -> None:
        """End the run; all output files are complete afterwards."""
        self.command("quit")
        try:
            status = self._process.wait(timeout=60)
        except subprocess.TimeoutExpired:
            raise SimulatorError("simulator: does not end after quit") from None
        if status:
            raise SimulatorError(f"simulator: ended with status {status}")

    def kill(self) -> None:
        """End the process if it still runs, and close its pipes."""
        self._ended = self._ended or "simulator: has been ended"
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._ready.close()
        for pipe in (self._in, self._out, self._errors):
            with contextlib.suppress(OSError):
                pipe.close()

    def _command(self, text: str) -> str:
        if self._ended:
            raise SimulatorError(self._ended)
        try:
            self._in.write(text.encode() + b"\n")
            self._in.flush()
        except OSError:
            raise SimulatorError(self._last_words()) from None
        answer = self._answer(text)
        if answer.startswith("error"):
            raise SimulatorError(f"simulator: {text.split(' ')[0]}: {answer[5:].strip(' :')}")
        return answer

    def _answer(self, text: str) -> str:
        """Return the next line of the runner."""
        while b"\n" not in self._pending:
            ready = self._ready.select(_ANSWER_LIMIT_S)
            if not ready:
                raise SimulatorError(f"simulator: no answer to {text[:40]!r}")
            for pipe in (key.data for key, _ in ready):
                self._take(pipe is self._out, os.read(pipe.fileno(), _READ_BYTES))
        line, self._pending = self._pending.split(b"\n", 1)
        return line.decode()

    def _take(self, answers: bool, data: bytes) -> None:
        """Take what the runner has written: answers, or the error output.

        Nobody looks at the error output of a runner that goes on, but a full pipe would stop it.
        """
        if answers and not data:
            raise SimulatorError(self._last_words())
        if answers:
            self._pending += data
        elif data:
            self._said = (self._said + data)[-_READ_BYTES:]
        else:
            self._ready.unregister(self._errors)

    def _last_words(self) -> str:
        """Return why the process ended, from its error output."""
        self._process.kill()
        _, errors = self._process.communicate()
        lines = (self._said + errors).decode(errors="replace").strip().splitlines()
        last = lines[-1] if lines else self._status()
        refused = _ARGUMENT.match(last)
        self._ended = (
            f"{refused[1]}: axis {refused[2]}: {last[refused.end() :]}"
            if refused
            else f"simulator: ended: {last}"
        )
        return self._ended

    def _status(self) -> str:
        """Return in words how the process ended: its exit status, or the signal's description."""
        status = self._process.returncode
        return f"exit status {status}" if status >= 0 else signal.strsignal(-status) or str(status)
