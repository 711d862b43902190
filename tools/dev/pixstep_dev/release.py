# SPDX-License-Identifier: MIT
"""A release in one folder: wheels, the boards' images, the documents, checksums, a page of notes.

Everything is made from one commit, which `pixstep --version` of the wheel names. The images are
those inside the wheel: `pixstep flash` writes the same with the wheel and with the folder's files.
"""

import hashlib
import os
import re
import shutil
import tempfile
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path

from pixstep import natives
from pixstep.board import boards, flash
from pixstep.board.registers import MAP_VERSION
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep.version import __version__
from pixstep_dev import site, wheels
from pixstep_dev.markdown import table

NOTES, SUMS = "NOTES.md", "SHA256SUMS"
_IN_WHEEL = re.compile(r"pixstep/_built/(pixstep-\w+\.hex)")


@dataclass(frozen=True)
class ReleaseSource:
    """What a release is made of."""

    commit: str
    date: str
    seconds: int  # since 1970, of the commit: the time of every file in the wheels


def make(out: Path, progress: Progress = unseen) -> list[Path]:
    """Make the release of this version in a folder that does not exist or is empty.

    Returns its files. Raises UserError where files of the clone differ from its commit, or the
    version has no page in docs/releases.
    """
    if out.exists() and any(out.iterdir()):
        raise UserError(f"{out}: is not empty: a release has a folder of its own")
    words = natives.root() / "docs" / "releases" / f"{__version__}.md"
    if not words.is_file():
        raise UserError(f"{words}: missing: say there what the release is, in a page")
    source = _source()
    with tempfile.TemporaryDirectory(prefix="pixstep-release-") as folder:  # all of it, or nothing
        _fill(Path(folder), source, words.read_text(encoding="utf-8"), progress)
        out.mkdir(parents=True, exist_ok=True)
        for path in Path(folder).iterdir():
            shutil.copy(path, out)
    return sorted(out.iterdir())


def _fill(out: Path, source: ReleaseSource, words: str, progress: Progress) -> None:
    """Make a release's files in an empty folder."""
    os.environ["SOURCE_DATE_EPOCH"] = str(source.seconds)  # the same commit, the same wheels
    made = wheels.build(out, None, lambda share: progress(0.8 * share))
    images = _images(next(path for path in made if path.name.startswith("pixstep-")), out)
    progress(0.8)
    pages = _site(out, source.seconds)
    sums = _sums([*made, *images, pages])
    notes = out / NOTES
    notes.write_text(_notes(source, words, made, images, sums), "utf-8")
    rows = [f"{text}  {name}" for name, text in (sums | _sums([notes])).items()]
    (out / SUMS).write_text("\n".join(rows) + "\n", encoding="utf-8")


def _source() -> ReleaseSource:
    """Return the commit; raises UserError unless the clone is just that."""
    commit = natives.commit()
    if not commit:
        raise UserError(f"{natives.root()}: no clone: a release names its commit")
    if commit.endswith("-dirty"):
        raise UserError("files differ from the commit: commit them first, `git status` lists them")
    words = ["git", "-C", str(natives.root()), "show", "-s", "--date=short", "--format=%cd %ct"]
    date, seconds = natives.run([*words, "HEAD"]).stdout.split()
    return ReleaseSource(commit, date, int(seconds))


def _images(wheel: Path, out: Path) -> list[Path]:
    """Take the boards' images out of the wheel; each must say which board it is for."""
    found = []
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            if inside := _IN_WHEEL.fullmatch(name):
                path = out / inside[1]
                path.write_bytes(archive.read(name))
                found.append(path)
    there = {flash.read_image(path).board for path in found}
    if missing := set(boards.BOARD_NAMES) - there:
        raise UserError(f"{wheel.name}: has no image for {', '.join(sorted(missing))}")
    return sorted(found)


def _site(out: Path, seconds: int) -> Path:
    """Build the documents' site and pack it; every file has the commit's time."""
    name = f"pixstep-site-{__version__}"
    packed = out / f"{name}.zip"
    at = time.gmtime(seconds)[:6]
    with tempfile.TemporaryDirectory(prefix="pixstep-site-") as folder:
        site.build(Path(folder))
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(Path(folder).rglob("*")):
                if path.is_file():
                    entry = zipfile.ZipInfo(f"{name}/{path.relative_to(folder)}", at)
                    archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return packed


def _sums(paths: list[Path]) -> dict[str, str]:
    """Return the SHA-256 of files by their names."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def _notes(
    source: ReleaseSource, words: str, made: list[Path], images: list[Path], sums: dict[str, str]
) -> str:
    """Return the page of notes."""
    wheel_names = " ".join(sorted((path.name for path in made), reverse=True))
    rows = [
        (f"`{image.name}`", flash.read_image(image).version, sums[image.name][:16])
        for image in images
    ]
    return "\n".join(
        [
            f"# pixstep {__version__}\n",
            f"{source.date}, commit {source.commit}, register map {MAP_VERSION}.\n",
            words.strip(),
            "\n## Install\n",
            "On Debian 12 or Ubuntu 24.04, in this folder:\n",
            "```",
            f"sha256sum --check {SUMS}",
            "python3 -m venv ~/pixstep-env",
            f"~/pixstep-env/bin/pip install {wheel_names}",
            "~/pixstep-env/bin/pixstep --version",
            "```\n",
            "`pixstep flash --board mega --port /dev/ttyACM0` writes the image that the wheel "
            "has; it needs avrdude and nothing else. The images are here too, for other "
            "programs:\n",
            table(("file", "firmware", "SHA-256 begins"), rows),
            f"\nThe documents: unpack `pixstep-site-{__version__}.zip`, open `index.html`.\n",
        ]
    )
