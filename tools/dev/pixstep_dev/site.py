# SPDX-License-Identifier: MIT
"""The documents as a site with search, built by mkdocs-material; a broken link is an error.

The documents are laid out as they are in the clone, so that the links that work there work here. A
document that the site's contents do not name, a link to nothing and an anchor that no heading has
are errors.
"""

import importlib.util
import logging
import re
import shutil
import tempfile
from pathlib import Path

from pixstep import natives
from pixstep.errors import PlainError, UserError

_CONFIG = "tools/site/mkdocs.yml"
_STYLE = "tools/site/pixstep.css"
# What lets the search work on a page opened as a file; of tools/setup.
_KIND = re.compile(r"^```(\w+) .*$", re.MULTILINE)
_WORKER = "build/deps/site/node_modules/iframe-worker/shim/index.js"
# Beside docs/: what the documents link to.
BESIDE = ("README.md", "DESIGN.md", "CHANGELOG.md", "LICENSE", "fuzz/CAMPAIGN.md",
           "sim/README.md", "sim/control.h")  # fmt: skip


class SiteError(PlainError):
    """The site could not be built: its documents are not whole."""


class _Complaints(logging.Handler):
    """Keeps what mkdocs warns of."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one warning."""
        self.said.append(record.getMessage())


def build(out: Path, root: Path | None = None) -> int:
    """Build the site of the clone at `root` into a folder that is replaced; return its pages.

    Raises SiteError, whose message has all complaints, if a link leads nowhere.
    """
    if importlib.util.find_spec("mkdocs") is None or not natives.source(_WORKER).is_file():
        raise UserError("what builds the site is not installed: run tools/setup")
    if out.exists() and any(out.iterdir()) and not (out / "sitemap.xml").exists():
        raise UserError(f"{out}: is not empty and no site: give another folder")
    with tempfile.TemporaryDirectory(prefix="pixstep-site-") as folder:
        source, made = Path(folder) / "source", Path(folder) / "site"
        _lay_out(root or natives.root(), source)
        complaints = _run(source, made)
        if complaints:
            raise SiteError("\n".join(("the documents are not whole:", *complaints)))
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(made, out)
    return len(list(out.rglob("*.html")))


def _lay_out(root: Path, source: Path) -> None:
    """Copy the documents and what they link to."""
    shutil.copytree(root / "docs", source / "docs")
    for name in BESIDE:
        place = source / name
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(root / name, place)
    for path in source.rglob("*.md"):  # what a block is for stands behind its language
        text = _KIND.sub(r"```\1", path.read_text(encoding="utf-8"))
        path.write_text(text, encoding="utf-8")
    (source / "assets").mkdir()
    shutil.copy(natives.source(_WORKER), source / "assets" / "iframe-worker.js")
    shutil.copy(natives.source(_STYLE), source / "assets")


def _run(source: Path, out: Path) -> list[str]:
    """Run mkdocs; return what it complains of."""
    from mkdocs import config as configuration  # takes half a second to load
    from mkdocs.commands import build as command
    from mkdocs.exceptions import MkDocsException

    log = logging.getLogger("mkdocs")
    complaints = _Complaints()
    log.addHandler(complaints)
    before = log.propagate
    log.propagate = False
    try:
        config = configuration.load_config(
            str(natives.source(_CONFIG)), docs_dir=str(source), site_dir=str(out), strict=True
        )
        config.plugins.on_startup(command="build", dirty=False)
        command.build(config)
        config.plugins.on_shutdown()
    except MkDocsException as error:
        return complaints.said or [str(error)]
    finally:
        log.propagate = before
        log.removeHandler(complaints)
    return complaints.said
