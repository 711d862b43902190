# SPDX-License-Identifier: MIT
"""The five short scripts of docs/examples, each run as a user runs it: a file, an empty folder."""

import subprocess
import sys
from pathlib import Path

import pytest

import pixstep as px

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
MOST_LINES = 19
pytestmark = pytest.mark.usefixtures("simulator")


def run(name, folder, *words):
    """Run a script in a folder; return the lines that it prints."""
    script = EXAMPLES / f"{name}.py"
    assert len(script.read_text().splitlines()) <= MOST_LINES
    done = subprocess.run(
        [sys.executable, script, *words], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def test_own_positions_with_a_fit(tmp_path):
    stage, note, axis = run("fit_positions", tmp_path)
    assert stage == "<MotionLine stage: smooth, 120 pixels at 30 Hz, 10,000 steps>"
    assert note.startswith("fitted: at most 0.") and "mm from the positions" in note
    assert axis.startswith("<AxisRun axis 0: pass, 10,000 of 10,000 steps, edges within 0.")
    assert (tmp_path / "stage.png").is_file()


def test_four_axes_locked(tmp_path):
    lines = run("four_locked", tmp_path)
    assert len(lines) == 4 and (tmp_path / "axis3.png").is_file()
    assert all("200 pixels compared: rms " in line for line in lines)


def test_records_of_a_simulated_board_as_a_table(tmp_path):
    seen = run("records_table", tmp_path)
    assert "<AxisRecords board 1 axis 0: " in "".join(seen)
    shown = [line for line in seen if line.startswith("pixel ")]
    places = [int(line.split()[1]) for line in shown if "of 500" in line]
    assert places == sorted(places) and 0 < places[len(places) // 2] < 500


def test_fifty_lines_in_a_pool(tmp_path):
    assert run("many_lines", tmp_path) == ["<Run pass, 1 axis of a mega at 300 Hz>"]


def test_a_folder_of_files(tmp_path):
    files = tmp_path / "printer"
    files.mkdir()
    px.line([2, 6, 8, 6, 2]).write(files / "a.csv")
    px.line([4] * 30).write(files / "b.CSV")
    (files / "c.csv").write_text("no numbers\n")
    (files / "d.txt").write_text("not of the printer\n")
    found = run("convert_folder", tmp_path, "printer", "converted")
    assert found[0] == "<Converted converted/a.CSB: csb, 5 values>"
    assert found[1] == "<Converted converted/b.CSB: csb, 30 values>"
    assert found[2].startswith("left out: printer/c.csv:1")
    assert px.read_line(tmp_path / "converted" / "b.CSB").counts == (4,) * 30
    assert sorted(path.name for path in (tmp_path / "converted").iterdir()) == ["a.CSB", "b.CSB"]
