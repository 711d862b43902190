# SPDX-License-Identifier: MIT
"""The script and the notebook of docs/examples that fly, as they stand, in an empty folder."""

import os
import runpy
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
pytestmark = pytest.mark.usefixtures("simulator")


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_script(capsys):
    runpy.run_path(str(EXAMPLES / "fly_scan.py"), run_name="__main__")
    assert capsys.readouterr().out == "success: 524 pixels\n"
    assert [path.name for path in Path().iterdir()] == ["fly_scan.png"]
    assert Path("fly_scan.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_notebook(monkeypatch):
    # The kernel is a process of its own: it finds what this one was told of (client_runs.py).
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    notebook = nbformat.read(EXAMPLES / "fly_scan.ipynb", as_version=4)
    nbformat.validate(notebook)
    kept = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs for cell in kept), "keep no output: it is large and grows stale"
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    shown = [output for cell in kept for output in cell.outputs]
    pictures = [output for output in shown if "image/png" in output.get("data", {})]
    texts = "".join(
        output.get("text", "") + output.get("data", {}).get("text/plain", "") for output in shown
    )
    assert len(pictures) == 1
    assert "'exit_status': 'success'" in texts and "'num_events': {'fly': 524}" in texts
    assert "height 19680.0 steps, pins 19680\n" in texts
    assert "a line has no gaps" in texts and "0.0125 s are 2.5 pixels at 200 Hz" in texts
