# SPDX-License-Identifier: MIT
"""The runner, pixstep-sim, as a process: one command a line in, one answer a line out.

Simulated time moves only by commands.
"""

import contextlib
import json
import os
import re
import selectors
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple, Self

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import AskedText, UserError
from pixstep.lines.units import hz_text
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.summary import Stats

_ANSWER_LIMIT_S = 300  # wall-clock seconds; a longer silence means that the runner hangs
_ARGUMENT = re.compile(r"pixstep-sim: --plant [0-9]+\.([0-9]+): ")  # of a board's axis
_READ_BYTES = 65_536  # at once
_LOGS = ("edges", "clock_log", "pin_log", "serial_log", "vcd", "plant_log", "switch_log")
BOOT_S = 0.05  # from the supply or a reset to a board that answers
POWER_UP_MS = 20  # several boards get their supply within this time, each at a cycle of its own


class SimulatorError(UserError):
    """The runner refused a command, ended or hung."""


class SimPipe:
    """A running pixstep-sim in control mode; use as a context manager.

    Every method raises SimulatorError with the runner's own text if it refuses or ends. After an
    exception the process is ended, never left behind.
    """

    def __init__(self, command: Sequence[object]) -> None:
        self._turn = threading.Lock()
        self._errors = os.fdopen(os.memfd_create("pixstep-sim errors"), "r+b")
        try:
            self._process = subprocess.Popen(
                [str(word) for word in command],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
            )  # fmt: skip
        except OSError as error:
            raise UserError(f"{command[0]}: {error.strerror or error}") from None
        assert self._process.stdin and self._process.stdout
        self._in, self._out = self._process.stdin, self._process.stdout
        self._pending, self._ended = b"", ""
        self._owed = 0  # answers: more than one after a signal has broken off the wait for one
        self._ready = selectors.DefaultSelector()
        self._ready.register(self._out, selectors.EVENT_READ)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def command(self, text: str) -> str:
        """Send one command and return its answer; of several threads one after the other."""
        with self._turn:
            return self._command(text)

    def _command(self, text: str) -> str:
        if self._ended:
            raise SimulatorError(self._ended)
        try:
            self._in.write(text.encode() + b"\n")
            self._in.flush()
            self._owed += 1
        except OSError:
            raise SimulatorError(self._last_words()) from None
        answer = self._answer(text)
        if answer.startswith("error"):
            raise SimulatorError(f"simulator: {text.split(' ')[0]}: {answer[5:].strip(' :')}")
        return answer

    def quit(self) -> None:
        """End the run; all output files are complete afterwards."""
        self.command("quit")
        try:
            status = self._process.wait(timeout=60)
        except subprocess.TimeoutExpired:
            raise SimulatorError("simulator: does not end after quit") from None
        if status:
            raise SimulatorError(self._last_words())

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

    def _answer(self, text: str) -> str:
        """Return the runner's answer to the newest command."""
        while self._pending.count(b"\n") < self._owed:
            if not self._ready.select(_ANSWER_LIMIT_S):
                raise SimulatorError(f"simulator: no answer to {text[:40]!r}")
            data = os.read(self._out.fileno(), _READ_BYTES)
            if not data:
                raise SimulatorError(self._last_words())
            self._pending += data
        *lines, self._pending = self._pending.split(b"\n")
        self._owed = 0
        return lines[-1].decode()

    def _last_words(self) -> str:
        """Return why the process ended, from its error output."""
        self._process.kill()
        self._process.wait()
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        status = self._process.returncode
        signalled = signal.strsignal(-status) if status < 0 else f"exit status {status}"
        last = lines[-1] if lines else signalled or str(status)
        refused = _ARGUMENT.match(last)
        self._ended = f"simulator: ended: {last}"
        if refused:
            self._ended = AskedText(
                "{plant}: axis {axis}: {text}", axis=refused[1], text=last[refused.end() :]
            )
        return self._ended


@dataclass(frozen=True)
class SimOptions:
    """What a run of the simulator is started with."""

    boards: Sequence[tuple[str, Path]]  # (name, image)
    pixel_hz: Fraction
    pixel_ppm: float = 0.0
    pixel_jitter_ns: float = 0.0  # evenly distributed
    flaws: ClockFlaws = field(default_factory=ClockFlaws)
    seed: int = 1
    # Within this time each board gets its supply; None: POWER_UP_MS, a board alone at the start.
    power_up_ms: int | None = None
    # By board from 1 on: how much faster than the first one's, whose cycles are the time of all.
    oscillators_ppm: Mapping[int, float] = field(default_factory=dict)
    edges: Path | None = None
    clock_log: Path | None = None
    pin_log: Path | None = None
    serial_log: Path | None = None
    vcd: Path | None = None
    plants: Mapping[tuple[int, int], str] = field(default_factory=dict)  # knobs by board, axis
    eeproms: Mapping[int, Path] = field(default_factory=dict)  # files by board
    plant_log: Path | None = None
    switch_log: Path | None = None
    extra: Sequence[str] = field(default_factory=tuple)

    @property
    def powered_ms(self) -> int:
        """Return the time after which every board has its supply."""
        if self.power_up_ms is None:
            return POWER_UP_MS if len(self.boards) > 1 else 0
        return self.power_up_ms

    def arguments(self) -> list[str]:
        """Return the runner's command line after the program."""
        words = [part for name, image in self.boards for part in ("--board", f"{name}={image}")]
        words += ["--pixel-hz", hz_text(self.pixel_hz), "--seed", str(self.seed)]
        words += ["--power-up-ms", str(self.powered_ms)] if self.powered_ms else []
        words += ["--pixel-ppm", repr(self.pixel_ppm)] if self.pixel_ppm else []
        jitter_ns = self.pixel_jitter_ns
        words += ["--pixel-jitter-ns", repr(jitter_ns)] if jitter_ns else []
        words += self.flaws.arguments()
        for name in _LOGS:
            if path := getattr(self, name):
                words += [f"--{name.replace('_', '-')}", str(path)]
        for (board, axis), knobs in self.plants.items():
            words += ["--plant", f"{board}.{axis}:{knobs}"]
        for board, ppm in self.oscillators_ppm.items():
            words += ["--oscillator-ppm", f"{board}={ppm!r}"]
        for board, path in self.eeproms.items():
            words += ["--eeprom", f"{board}={path}"]
        return [*words, *self.extra, "--control"]


class PermitOutput(NamedTuple):
    """The permit output of a board: its level, edges so far, cycles of the last and the last rise.

    0 where there was none.
    """

    level: int
    changes: int
    cycle: int
    rise: int


class Simulator(SimPipe):
    """A running pixstep-sim with its boards.

    Boards and axes count from 0. Where a method takes `at`, it happens at this cycle to come
    instead of now. All cycles are those of the first board's oscillator; `tick_hz` of them are a
    second.
    """

    def __init__(self, options: SimOptions, program: Sequence[str | Path] | None = None) -> None:
        super().__init__([*(program or [natives.program("pixstep-sim")]), *options.arguments()])
        self.cycle = 0
        self._powered_s = options.powered_ms / 1000
        first = options.boards[0][0] if options.boards else boards.DEFAULT
        self.tick_hz = boards.load(first).tick_hz

    def run(self, cycles: int) -> int:
        """Let `cycles` pass; return the cycle reached."""
        self.cycle = int(self.command(f"run {cycles}").split()[1])
        return self.cycle

    def cycles(self, seconds: float) -> int:
        """Return a time in cycles."""
        return round(seconds * self.tick_hz)

    def wait_s(self, seconds: float) -> int:
        """Let time pass; return the cycle reached."""
        return self.run(self.cycles(seconds))

    def boot(self) -> None:
        """Give boards the time that they take to start: at the beginning, and after a reset."""
        self.wait_s(BOOT_S + self._powered_s)
        self._powered_s = 0.0

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send bytes on the serial line and return the reply, empty if none came."""
        suffix = "" if timeout_cycles is None else f" {timeout_cycles}"
        answer = self.command(f"tx {data.hex()}{suffix}").split()
        self.cycle = int(answer[2])
        return b"" if answer[1] == "-" else bytes.fromhex(answer[1])

    def clock(self, change: str) -> None:
        """Change the pixel clock, in the words of the runner's command.

        "off" and "on" (the edges between are left out), "hz 100/3" (the next edge one period from
        now), "ppm 200", "jitter NS", "jitter-rms NS", "drop 3", "rest US" (it stands still for so
        long), "gate EDGES US" (EDGES edges, a rest of US, again and again; "gate 0 0" ends that).
        """
        self.command(f"clock {change}")

    def edge(self, board: int, change: str, at: int | None = None) -> None:
        """Change an edge of the pixel clock at this board's pin alone, in the runner's words.

        "miss N" (the Nth to come), "add N THOUSANDTHS" (a false edge follows it so far into the
        period), "double N" (the same at a random 5 to 70 %), "pulse" (a false edge now, or at a
        cycle to come), "jitter NS" (each is displaced by at most so much, evenly distributed).
        """
        self.command(f"edge {board} {change}{_at(at)}")

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

    def stats(self) -> Stats:
        """Return the runner's statistics so far."""
        found: Stats = json.loads(self.command("stats"))
        return found

    def flush(self) -> None:
        """Complete all output files, and write the EEPROM files, up to now."""
        self.command("flush")

    def pin(self, board: int, port: str, bit: int, level: int, at: int | None = None) -> None:
        """Drive an input pin, port "A" to "L", from outside."""
        self.command(f"pin {board} {port} {bit} {level}{_at(at)}")

    def permit(self, board: int) -> PermitOutput:
        """Return the permit output's level and edges."""
        return PermitOutput(*map(int, self.command(f"permit {board}").split()[1:]))

    def supply(self, board: int, change: str, at: int | None = None) -> None:
        """Cut a board's supply, "off", or give it back, "on"; "cycle" does both within a cycle.

        The byte of EEPROM on its way becomes anything, pins float; then RAM is noise and the
        program begins; hangs have ended.
        """
        words = f"cycle {board}" if change == "cycle" else f"power {board} {change}"
        self.command(f"{words}{_at(at)}")

    def reset(self, board: int, cause: str = "external", at: int | None = None) -> None:
        """Reset a board: "external" (the reset pin) or "brownout". RAM and EEPROM are kept."""
        self.command(f"reset {board} {cause}{_at(at)}")


def _at(cycle: int | None) -> str:
    return "" if cycle is None else f" at {cycle}"
