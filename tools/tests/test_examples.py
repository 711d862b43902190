# SPDX-License-Identifier: MIT
"""The scripts and the notebook of docs/examples run as they stand, in an empty folder."""

import runpy
from fractions import Fraction
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from pixstep import natives
from pixstep.api.bus import Bus
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
PNG = b"\x89PNG\r\n\x1a\n"
pytestmark = pytest.mark.usefixtures("simulator")


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("name", "said", "drawn"),
    [
        ("own_profile", ["pass: "], ["own_profile.png", "edge_errors.png"]),
        ("four_axes", [f"axis {axis}: pass, " for axis in range(4)], ["four_axes.png"]),
        ("locked_scan", ["own time: rms 10", "locked: rms 1."], ["locked_scan.png"]),
    ],
)
def test_scripts(name, said, drawn, capsys):
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    printed = capsys.readouterr().out.splitlines()
    for begin, line in zip(said, printed, strict=False):
        assert line.startswith(begin)
    assert len(printed) >= len(said)
    assert sorted(path.name for path in Path().iterdir()) == sorted(drawn)
    assert all(Path(file).read_bytes().startswith(PNG) for file in drawn)


@pytest.mark.parametrize("name", ["own_profile", "four_axes", "locked_scan"])
def test_scripts_say_that_the_simulator_is_missing(name, monkeypatch):
    monkeypatch.setenv("PIXSTEP_SIM", "/none/pixstep-sim")
    with pytest.raises(SystemExit, match=rf"{name}\.py: /none/pixstep-sim: no such file"):
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")


def test_drive_board(capsys):
    names = runpy.run_path(str(EXAMPLES / "drive_board.py"))
    with Bus(SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(30)))) as bus:
        names["drive"](bus)
    assert capsys.readouterr().out.splitlines() == [
        "mega on the simulator, pixel clock 30 Hz",
        "there: done, position 40 steps",
        "back: done, position 0 steps",
    ]


def test_drive_board_says_what_is_wrong(monkeypatch):
    main = runpy.run_path(str(EXAMPLES / "drive_board.py"))["main"]
    monkeypatch.setattr("sys.argv", ["drive_board.py", "/dev/there-is-none"])
    with pytest.raises(SystemExit, match=r"drive_board\.py: .*there is no such port"):
        main()


def test_notebook():
    notebook = nbformat.read(EXAMPLES / "first_line.ipynb", as_version=4)
    nbformat.validate(notebook)
    kept = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs for cell in kept), "keep no output: it is large and grows stale"
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    shown = [output for cell in kept for output in cell.outputs]
    pictures = [output for output in shown if "image/png" in output.get("data", {})]
    texts = "".join(output.get("text", "") for output in shown)
    assert len(pictures) == 3
    assert "pass 0." in texts and "5 reverses_inside_pixel" in texts
