# SPDX-License-Identifier: MIT
"""Runs the steps of a document in one shell, in an empty home folder with the clone in it."""

import contextlib
import os
import shlex
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

from pixstep import natives
from pixstep.errors import UserError
from pixstep.progress import Progress
from pixstep_dev.tutorial import hands
from pixstep_dev.tutorial.document import TutorialStep

CLONE = "pixstep"  # ~/pixstep, as the document has it
_LIMIT_S = 3600  # a guard against hanging, however busy the machine
_LOOK_S = 0.05
_REPLY_S = 2  # under the boards' bus_timeout_ms of 3 s, or one lost reply stops what moves
_KEPT = ("PATH", "UNITY_DIR", "PYTHONPYCACHEPREFIX")  # the last: where byte code is kept

# The status of the last command is given on, so that `echo $?` shows a reader's.
_HEAD = """status() { return "$1"; }
last=0
"""
_STEP = """status "$last"; {{ {command}
}} {stdin}>>{log} 2>&1; last=$?; echo "$last" >{status}
"""
# A window is there when it has printed its first line, or has ended.
_WINDOW = """{{ {{ {command}
}} {stdin}>>{log} 2>&1; touch {ended}; }} &
until [ -s {log} ] || [ -e {ended} ]; do sleep 0.05; done; last=0; echo "$last" >{status}
"""


@dataclass(frozen=True)
class StepOutcome:
    """What a step printed on both streams and its exit status; None if it was not reached."""

    step: TutorialStep
    printed: list[str]
    status: int | None


def walk(
    steps: tuple[TutorialStep, ...], home: Path, logs: Path, progress: Progress
) -> list[StepOutcome]:
    """Run all steps in `home`, which must be empty; `logs` keeps their outputs.

    `progress` is told the share done. Raises UserError if the walk takes longer than _LIMIT_S.
    """
    (home / CLONE).symlink_to(natives.root())
    paths = [logs / f"step-{index}" for index in range(len(steps))]
    script = logs / "walk.sh"
    script.write_text(_HEAD + "".join(map(_lines, steps, paths)), encoding="utf-8")
    typing = hands.Hands(steps, paths)
    work = typing.work()

    def look() -> None:
        next(work, None)
        progress(len(list(logs.glob("*.status"))) / max(1, len(steps)))

    try:
        _run(script, home, look)
    finally:
        typing.close()
    return [_outcome(step, path) for step, path in zip(steps, paths, strict=True)]


def _lines(step: TutorialStep, log: Path) -> str:
    return (_WINDOW if step.window else _STEP).format(
        command=step.command,
        log=shlex.quote(str(log)),
        status=shlex.quote(str(hands.status_of(log))),
        ended=shlex.quote(str(hands.ended_of(log))),
        stdin=f"<{shlex.quote(str(hands.pipe_of(log)))} " if step.typed_to else "",
    )


def _run(script: Path, home: Path, look: Callable[[], None]) -> None:
    """Run the script, looking at it now and then; end whatever it left running."""
    end = time.monotonic() + _LIMIT_S
    shell = subprocess.Popen(
        ["bash", str(script)],
        cwd=home,
        env=_environment(home),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        while not _ended(shell):
            look()
            if time.monotonic() > end:
                raise UserError(f"the walk takes longer than {_LIMIT_S} s")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGTERM)
        shell.wait()


def _ended(shell: subprocess.Popen[bytes]) -> bool:
    with contextlib.suppress(subprocess.TimeoutExpired):
        shell.wait(_LOOK_S)
    return shell.returncode is not None


def _environment(home: Path) -> dict[str, str]:
    """Return a reader's environment: no colours, 80 columns, the fonts' cache where it is."""
    kept = {name: os.environ[name] for name in _KEPT if name in os.environ}
    return kept | {
        "HOME": str(home),
        "LANG": "C.UTF-8",
        "TERM": "dumb",
        # A simulated board that gets little of a busy machine may reply late.
        "PIXSTEP_TIMEOUT": str(_REPLY_S),
        "MPLCONFIGDIR": mpl.get_configdir(),
    }


def _outcome(step: TutorialStep, log: Path) -> StepOutcome:
    status = hands.status_of(log)
    if not status.exists():
        return StepOutcome(step, [], None)
    text = log.read_text(encoding="utf-8", errors="replace")
    return StepOutcome(step, text.splitlines(), int(status.read_text(encoding="ascii")))
