# SPDX-License-Identifier: MIT
"""Walk a document: complaints about all that is not as it says, or a document that is."""

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from pixstep import atomic
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep_dev.tutorial import document, pictures, session

_STATUS = "echo $?"
FOLDER = "first-line"  # of the walk, in the home folder: titles of pictures are relative to it


@dataclass(frozen=True)
class Walk:
    """A walked document: what is wrong, and what would put it right."""

    complaints: list[str]
    outputs: dict[int, list[str]]  # by the line of the step
    stale: dict[Path, bytes]  # pictures to write


def check(path: Path, progress: Progress = unseen) -> list[str]:
    """Walk a document; return complaints as 'file:line: what'."""
    return _walk(path, _read(path), progress).complaints


def refresh(path: Path, progress: Progress = unseen) -> list[str]:
    """Walk a document and rewrite what differs; return the complaints that are left to a person.

    An output that differs is put in whole, to be shortened by hand.
    """
    found = _read(path)
    walked = _walk(path, found, progress)
    if walked.outputs:
        atomic.write_text(path, found.with_outputs(walked.outputs))
    for picture, data in walked.stale.items():
        atomic.write_bytes(picture, data)
    return walked.complaints


def _read(path: Path) -> document.Document:
    try:
        return document.parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def _walk(path: Path, found: document.Document, progress: Progress) -> Walk:
    if not found.steps:
        raise UserError(f"{path}: no session to walk: its first block must begin with ```console")
    if shutil.which("mbpoll") is None and any("mbpoll" in step.command for step in found.steps):
        raise UserError("mbpoll is missing: tools/setup installs it")
    with tempfile.TemporaryDirectory(prefix="pixstep-walk-") as scratch:
        home, logs = Path(scratch) / "home", Path(scratch) / "logs"
        home.mkdir()
        logs.mkdir()
        outcomes = session.walk(found.steps, home, logs, progress)
        said, outputs = _compare(outcomes)
        seen, stale = _look(path.parent, found, home / FOLDER)
    complaints = [f"{path}:{text}" for text in (*found.complaints, *said, *seen)]
    return Walk(complaints, outputs, stale)


def _compare(outcomes: list[session.StepOutcome]) -> tuple[list[str], dict[int, list[str]]]:
    """Return complaints about outputs and exit statuses, and the outputs that differ."""
    complaints, outputs = [], {}
    following = [*(item.step.command for item in outcomes[1:]), ""]
    for item, after in zip(outcomes, following, strict=True):
        step = item.step
        if item.status is None:
            complaints.append(f"{step.line}: not reached: {step.command}")
        elif item.status and after != _STATUS:
            complaints.append(f"{step.line}: exit status {item.status}, not shown: {step.command}")
        if item.status is not None and not document.agrees(step.shown, item.printed):
            printed = "\n".join(f"    {line}" for line in document.plain(item.printed))
            complaints.append(f"{step.line}: prints something else: {step.command}\n{printed}")
            outputs[step.line] = document.plain(item.printed)
    return complaints, outputs


def _look(
    docs: Path, found: document.Document, folder: Path
) -> tuple[list[str], dict[Path, bytes]]:
    """Return complaints about pictures, and what stale ones should be."""
    complaints: list[str] = []
    stale: dict[Path, bytes] = {}
    for picture in found.pictures:
        shown, made = docs / picture.shown, folder / picture.made
        if text := pictures.difference(shown, made):
            complaints.append(f"{picture.line}: {picture.shown}: {text}")
            if made.is_file():
                stale[shown] = made.read_bytes()
        if made.is_file() and made.stat().st_size > pictures.MAX_BYTES:
            complaints.append(f"{picture.line}: {picture.made}: {made.stat().st_size} bytes")
    return complaints, stale
