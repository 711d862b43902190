# SPDX-License-Identifier: MIT
"""The documents as a site: whole, read without network, and what is broken is named."""

import json
import re
import shutil

import pytest

from pixstep import natives
from pixstep.errors import PlainError
from pixstep_dev import site

FETCHED = re.compile(r'(?:src|href)="?(?:https?:)?//[^" >]+\.(?:js|css|woff2?)')


def test_the_documents_are_whole_and_fetch_nothing(tmp_path):
    out = tmp_path / "site"
    out.mkdir()
    (out / "sitemap.xml").write_text("an earlier site")
    assert site.build(out) > 30
    for page in out.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not FETCHED.search(text), page
        assert "unpkg.com" not in text and "```" not in text, page
    found = json.loads((out / "search" / "search_index.json").read_text(encoding="utf-8"))
    assert any("backlash" in one["text"].lower() for one in found["docs"])
    assert (out / "assets" / "iframe-worker.js").is_file()


def test_what_leads_nowhere_is_named(tmp_path):
    root = tmp_path / "clone"
    shutil.copytree(natives.root() / "docs", root / "docs")
    for name in site.BESIDE:
        (root / name).parent.mkdir(exist_ok=True)
        shutil.copy(natives.root() / name, root / name)
    wiring = root / "docs" / "WIRING.md"
    wiring.write_text(wiring.read_text() + "\n[a](NOTHING.md) [b](FLASHING.md#no-such-heading)\n")
    (root / "docs" / "FORGOTTEN.md").write_text("# Not among the contents\n")
    with pytest.raises(PlainError) as raised:
        site.build(tmp_path / "site", root)
    for word in ("NOTHING.md", "#no-such-heading", "FORGOTTEN.md"):
        assert word in str(raised.value)
    assert not (tmp_path / "site").exists()


def test_another_folder_is_not_replaced(tmp_path):
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(PlainError, match="is not empty and no site"):
        site.build(tmp_path)
    assert (tmp_path / "thesis.txt").exists()
