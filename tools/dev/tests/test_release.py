# SPDX-License-Identifier: MIT
"""A release: one commit, whole, checksums that hold; one version everywhere."""

import hashlib
import os
import re
import zipfile

import pytest

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import PlainError
from pixstep.version import __version__
from pixstep_dev import release, site, wheels

PLATFORM = "manylinux_2_17_x86_64"


@pytest.fixture
def parts(monkeypatch):
    """Wheels with this build's images, a site of one page, a clone without differences."""

    def build(out, machine, progress):
        made = [out / f"pixstep-{__version__}-cp311-abi3-{PLATFORM}.whl",
                out / f"pixstep_sim-{__version__}-py3-none-{PLATFORM}.whl"]  # fmt: skip
        with zipfile.ZipFile(made[0], "w") as archive:
            for name in boards.BOARD_NAMES:
                archive.write(natives.hex_image(name), f"pixstep/_built/pixstep-{name}.hex")
        made[1].write_bytes(b"simulator")
        return made

    def pages(out):
        page = out / "index.html"
        page.write_text("<html>")
        hours.append(len(hours))  # each build leaves another time
        os.utime(page, (1e9 + 3600 * len(hours),) * 2)
        return 1

    hours = []

    monkeypatch.setattr(wheels, "build", build)
    monkeypatch.setattr(site, "build", pages)
    monkeypatch.setattr(natives, "commit", lambda: "0123456789")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")  # what a release sets is taken back


@pytest.mark.usefixtures("parts")
def test_all_is_there_and_the_sums_hold(tmp_path):
    out = tmp_path / "release"
    names = {path.name for path in release.make(out)}
    assert names == {path.name for path in out.iterdir()}
    assert {f"pixstep-{name}.hex" for name in boards.BOARD_NAMES} < names
    assert f"pixstep-site-{__version__}.zip" in names
    rows = dict(reversed(row.split()) for row in (out / release.SUMS).read_text().splitlines())
    assert set(rows) == names - {release.SUMS}
    for name, said in rows.items():
        assert hashlib.sha256((out / name).read_bytes()).hexdigest() == said
    notes = (out / release.NOTES).read_text()
    assert "commit 0123456789, register map" in notes and "pip install pixstep_sim-" in notes
    assert len(notes.splitlines()) < 60, "a page"


@pytest.mark.usefixtures("parts")
def test_one_commit_makes_the_same_bytes(tmp_path):
    sums = []
    for name in ("one", "two"):
        release.make(tmp_path / name)
        sums.append((tmp_path / name / release.SUMS).read_text())
    assert sums[0] == sums[1]


@pytest.mark.usefixtures("parts")
def test_a_clone_that_differs_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(natives, "commit", lambda: "0123456789-dirty")
    with pytest.raises(PlainError, match="differ from the commit"):
        release.make(tmp_path / "release")
    monkeypatch.setattr(natives, "commit", lambda: "")
    with pytest.raises(PlainError, match="names its commit"):
        release.make(tmp_path / "release")
    assert not (tmp_path / "release").exists()


@pytest.mark.usefixtures("parts")
def test_a_release_that_fails_leaves_nothing(tmp_path, monkeypatch):
    def fails(out):
        raise PlainError("a link leads nowhere")

    monkeypatch.setattr(site, "build", fails)
    with pytest.raises(PlainError, match="leads nowhere"):
        release.make(tmp_path / "release")
    assert not (tmp_path / "release").exists()


@pytest.mark.usefixtures("parts")
def test_a_folder_with_files_is_refused(tmp_path):
    (tmp_path / "mine").write_text("")
    with pytest.raises(PlainError, match="is not empty"):
        release.make(tmp_path)


@pytest.mark.usefixtures("parts")
def test_a_version_without_its_page_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(release, "__version__", "9.9.9")
    with pytest.raises(PlainError, match=r"9\.9\.9\.md: missing"):
        release.make(tmp_path / "release")


def test_the_firmware_has_the_packages_version():
    text = natives.source("firmware/config.h").read_text(encoding="utf-8")
    major, minor = re.findall(r"#define CONFIG_VERSION_(?:MAJOR|MINOR) (\d+)", text)
    assert __version__.startswith(f"{major}.{minor}.")
