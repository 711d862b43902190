# SPDX-License-Identifier: MIT
"""The runner's control pipe: one command a line in, one line out; time moves only by commands."""

import contextlib
import json
import os
import selectors
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError
from pixstep.lines.rational import hz_text

_ANSWER_LIMIT_S = 300  # wall-clock seconds; a longer silence means that the runner hangs


class SimulatorError(UserError):
    """The runner refused a command, ended or hung."""


@dataclass(frozen=True)
class SimOptions:
    """What a run of the simulator is started with."""

    boards: Sequence[tuple[str, Path]]  # (name, image)
    pixel_hz: Fraction
    pixel_ppm: float = 0.0
    pixel_jitter_ns: float = 0.0
    seed: int = 1
    edges: Path | None = None
    clock_log: Path | None = None
    serial_log: Path | None = None
    vcd: Path | None = None
    plants: Mapping[tuple[int, int], str] = field(default_factory=dict)  # knobs by board, axis
    plant_log: Path | None = None
    switch_log: Path | None = None
    extra: Sequence[str] = field(default_factory=tuple)

    def arguments(self) -> list[str]:
        """Return the runner's command line after the program."""
        words = [part for name, image in self.boards for part in ("--board", f"{name}={image}")]
        words += ["--pixel-hz", hz_text(self.pixel_hz), "--seed", str(self.seed)]
        if self.pixel_ppm:
            words += ["--pixel-ppm", repr(self.pixel_ppm)]
        if self.pixel_jitter_ns:
            words += ["--pixel-jitter-ns", repr(self.pixel_jitter_ns)]
        for option, path in (
            ("--edges", self.edges),
            ("--clock-log", self.clock_log),
            ("--serial-log", self.serial_log),
            ("--vcd", self.vcd),
            ("--plant-log", self.plant_log),
            ("--switch-log", self.switch_log),
        ):
            if path:
                words += [option, str(path)]
        for (board, axis), knobs in self.plants.items():
            words += ["--plant", f"{board}.{axis}:{knobs}"]
        return [*words, *self.extra, "--control"]


class Simulator:
    """A running pixstep-sim in control mode; use as a context manager.

    Every method raises SimulatorError with the runner's own text if it refuses or ends. After an
    exception the process is ended, never left behind.
    """

    def __init__(self, options: SimOptions, program: Sequence[str | Path] | None = None) -> None:
        command = [*(program or [natives.program("pixstep-sim")]), *options.arguments()]
        try:
            self._process = subprocess.Popen(
                [str(word) for word in command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
            )
        except OSError as error:
            raise UserError(f"{command[0]}: {error.strerror or error}") from None
        self._pending = b""
        self._ready = selectors.DefaultSelector()
        self._ready.register(self._process.stdout, selectors.EVENT_READ)
        self.cycle = 0

    def __enter__(self) -> "Simulator":
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def command(self, text: str) -> str:
        """Send one command and return its answer."""
        try:
            self._process.stdin.write(text.encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            raise SimulatorError(self._last_words()) from None
        answer = self._answer(text)
        if answer.startswith("error"):
            raise SimulatorError(f"simulator: {text.split(' ')[0]}: {answer[5:].strip(' :')}")
        return answer

    def run(self, cycles: int) -> int:
        """Let `cycles` pass; return the cycle reached."""
        self.cycle = int(self.command(f"run {cycles}").split()[1])
        return self.cycle

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send bytes on the serial line and return the reply, empty if none came."""
        suffix = "" if timeout_cycles is None else f" {timeout_cycles}"
        answer = self.command(f"tx {data.hex()}{suffix}").split()
        self.cycle = int(answer[2])
        return b"" if answer[1] == "-" else bytes.fromhex(answer[1])

    def steps(self, board: int, axis: int) -> int:
        """Return the signed steps that an axis has made."""
        return int(self.command(f"steps {board} {axis}").split()[1])

    def count(self, board: int, axis: int) -> int:
        """Return the rising STEP edges that an axis has made."""
        return int(self.command(f"counts {board} {axis}").split()[1])

    def plant(self, board: int, axis: int) -> tuple[int, int]:
        """Return where motor and load of an axis are, in the plant's steps."""
        motor, load = self.command(f"plant {board} {axis}").split()[1:3]
        return int(motor), int(load)

    def knobs(self, board: int, axis: int, text: str) -> None:
        """Change knobs of an axis' plant, "start=40,delay=16000"; the others stay as they are."""
        self.command(f"knobs {board} {axis} {text}")

    def mark(self) -> None:
        """Begin the handlers' counts, means and extremes in `stats` anew."""
        self.command("mark")

    def stats(self) -> dict:
        """Return the runner's statistics so far."""
        return json.loads(self.command("stats"))

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
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._ready.close()
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            with contextlib.suppress(OSError):
                pipe.close()

    def _answer(self, text: str) -> str:
        """Return the next line of the runner."""
        while b"\n" not in self._pending:
            if not self._ready.select(_ANSWER_LIMIT_S):
                raise SimulatorError(f"simulator: no answer to {text[:40]!r}")
            data = os.read(self._process.stdout.fileno(), 65_536)
            if not data:
                raise SimulatorError(self._last_words())
            self._pending += data
        line, self._pending = self._pending.split(b"\n", 1)
        return line.decode()

    def _last_words(self) -> str:
        """Return why the process ended, from its error output."""
        self._process.kill()
        _, errors = self._process.communicate()
        lines = errors.decode(errors="replace").strip().splitlines()
        return f"simulator: ended: {lines[-1] if lines else self._process.returncode}"
