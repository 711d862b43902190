# SPDX-License-Identifier: MIT
"""What the package says where something that the build makes is missing."""

import os
import re
import subprocess
import sys

import pytest

from pixstep import natives
from pixstep.errors import UserError
from pixstep.version import __version__


def test_the_simulator_may_be_named(tmp_path, monkeypatch):
    other = tmp_path / "another-name"
    monkeypatch.setenv("PIXSTEP_SIM", str(other))
    with pytest.raises(UserError, match=r"another-name: no such file \(PIXSTEP_SIM\)"):
        natives.program("pixstep-sim")
    assert not natives.have("pixstep-sim")
    other.write_text("")
    assert natives.program("pixstep-sim") == other


def test_what_is_not_built_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("PIXSTEP_ROOT", str(tmp_path))
    monkeypatch.delenv("PIXSTEP_SIM", raising=False)
    for find in (natives.program, natives.image, natives.made):
        with pytest.raises(UserError, match=r"pixstep-sim.* is not built: run tools/setup"):
            find("pixstep-sim")


def run(root):
    """Run the command on a clone that is not built."""
    return subprocess.run(
        [sys.executable, "-m", "pixstep", "flash", "--help"],
        env=os.environ | {"PIXSTEP_ROOT": str(root)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("text", [None, "{", "\x00"])
def test_without_tables_the_command_ends_with_one_line(tmp_path, text):
    place = tmp_path / "build" / "host" / "python" / "tables.json"
    place.parent.mkdir(parents=True)
    if text is not None:
        place.write_text(text)
    done = run(tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith(f"pixstep: {place}") and done.stderr.count("\n") == 1


def test_version_names_commit_and_register_map(invoke, monkeypatch):
    monkeypatch.setattr(natives, "commit", lambda: "0123456789")
    said = invoke("--version").stdout
    assert said == f"pixstep, version {__version__} (commit 0123456789, register map 6)\n"


def test_a_clone_names_its_commit(tmp_path, monkeypatch):
    assert re.fullmatch(r"[0-9a-f]{10,}(-dirty)?", natives.commit())
    monkeypatch.setenv("PIXSTEP_ROOT", str(tmp_path))
    assert natives.commit() == ""
