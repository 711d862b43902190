# SPDX-License-Identifier: MIT
"""What the wheels say of themselves: one version, licences that are there, no missing needs."""

import re
import tomllib

import pytest

import pixstep
from pixstep import natives
from pixstep.errors import PlainError
from pixstep_dev import wheels

PACKAGE, SIMULATOR, PROOF = "pyproject.toml", "sim/wheel/pyproject.toml", "tools/dev/pyproject.toml"


def project(place):
    return tomllib.loads(natives.source(place).read_text())


def names(requirements):
    return {re.match(r"[\w-]+", text)[0].lower() for text in requirements}


@pytest.mark.parametrize("place", [SIMULATOR, PROOF])
def test_the_other_packages_are_for_this_version(place):
    assert f"pixstep=={pixstep.__version__}" in project(place)["project"]["dependencies"]


def test_both_wheels_take_their_version_from_the_package():
    for place in (PACKAGE, SIMULATOR):
        read = project(place)
        assert read["project"]["dynamic"] == ["version"]
        source = read["tool"]["scikit-build"]["metadata"]["version"]["input"]
        file = (natives.source(place).parent / source).resolve()
        assert file == natives.source("tools/src/pixstep/version.py")


@pytest.mark.parametrize(
    ("place", "licence", "words"),
    [
        (PACKAGE, "MIT", "MIT License"),
        (SIMULATOR, "GPL-3.0-or-later", "GNU GENERAL PUBLIC LICENSE"),
    ],
)
def test_a_wheel_has_its_licence(place, licence, words):
    read = project(place)
    assert read["project"]["license"]["text"] == licence
    file, *_ = read["tool"]["scikit-build"]["wheel"]["license-files"]  # then those of what is in it
    assert words in (natives.source(place).parent / file).read_text()


def test_the_simulator_says_where_its_sources_are():
    text = natives.source("sim/wheel/README.md").read_text()
    for word in ("libsimavr", "GPL-3.0", "source.tar.gz", "SOURCES.txt"):
        assert word in text


def test_a_clone_installs_all_that_the_package_and_its_extras_need():
    read = project(PACKAGE)["project"]
    needed = names(read["dependencies"])
    for extra in read["optional-dependencies"].values():
        needed |= names(extra)
    pinned = set()
    for part in ("", "-dev", "-clients"):
        place = f"tools/requirements{part}.txt"
        lines = natives.source(place).read_text().splitlines()
        pinned |= {line.partition("==")[0].lower() for line in lines if "==" in line}
    assert needed <= pinned


def test_both_wheels_have_their_project():
    assert set(wheels.PROJECTS) == {"pixstep", "pixstep-sim"}
    for name, place in wheels.PROJECTS.items():
        assert project(f"{place}/pyproject.toml")["project"]["name"] == name


def test_a_build_that_fails_names_its_log(tmp_path, monkeypatch):
    monkeypatch.setattr(wheels, "PROJECTS", {"pixstep-nothing": "docs"})
    with pytest.raises(
        PlainError, match=r"pixstep-nothing: pip failed: .*nothing-\w+\.log says why"
    ):
        wheels.build(tmp_path)
    assert list(tmp_path.iterdir()) == []
