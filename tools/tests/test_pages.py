# SPDX-License-Identifier: MIT
"""What a person sees first: pages of runs, gathered findings, legends beside the curves."""

import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from clock import TICK_HZ
from pixstep import formats, plotting
from pixstep.board import boards, registers
from pixstep.board.device import Device
from pixstep.cli.main import main
from pixstep.lines import exact
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import period_ticks
from pixstep.simulation import logs, plots, report
from pixstep.simulation.pixel_clock import ClockFlaws
from worked import worked_line

SWEEP = tuple(n * way for way in (1, -1) for n in (2, 4, 6, 8, 10, 12, 10, 8, 6, 4, 2)) * 2


def exact_trace(line: Line) -> plots.Trace:
    """Return the trace of a board that makes every edge at its exact instant."""
    period = period_ticks(Fraction(30), TICK_HZ)
    rising = np.round(exact.instants(line, period)).astype(np.int64)
    changes = np.flatnonzero(np.diff(exact.directions(line), prepend=1))
    made = logs.AxisEdges(
        step_cycles=rising,
        step_levels=np.ones(len(rising), dtype=np.int64),
        direction_cycles=rising[changes] - 1,
        direction_levels=np.arange(1, len(changes) + 1) % 2,
    )
    assert made.directions().tolist() == list(exact.directions(line))
    pixels = [
        report.PixelRow(0, 0, pixel, None, steps, steps)
        for pixel, steps in enumerate(exact.expected_positions(line), start=1)
    ]
    return plots.Trace(line, period, TICK_HZ, 0, made, pixels, "test")


@pytest.mark.parametrize("name", ["motion", "edge_error", "positions"])
@pytest.mark.parametrize("line", [Line(SWEEP, PLAIN), worked_line(250)], ids=[PLAIN, SMOOTH])
def test_no_legend_lies_over_a_curve(name, line):
    with plotting.styled():
        figure = getattr(plots, name)(exact_trace(line))
        figure.canvas.draw()
    found = [axes for axes in figure.axes if axes.get_legend()]
    assert found
    for axes in found:
        legend = axes.get_legend().get_window_extent()
        assert legend.y0 >= axes.get_window_extent().y1
        assert figure.bbox.x0 <= legend.x0 and legend.x1 <= figure.bbox.x1
        assert axes.get_title(loc="left")
        assert axes._left_title.get_window_extent().x1 < legend.x0


def test_equal_findings_of_neighbours_are_one_line(tmp_path):
    path = tmp_path / "line.csv"
    formats.write_csv(path, [10, 10, 10, 0, 10, 10])
    arguments = ["line", "check", str(path), "--decode", "plain", "--max-speed", "9"]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 3
    places = [text.split(": ")[1] for text in done.output.splitlines()[:-1] if "speed" in text]
    assert places == ["pixels 1 to 3", "pixels 5 to 6"]


def test_axes_of_a_board_in_words():
    assert boards.axes_text("uno") == "uno has 1 axis: 0"
    assert boards.axes_text("mega") == "mega has 4 axes: 0 to 3"


def test_a_refusal_shows_its_reason_and_no_table_of_nothing():
    summary = {
        "verdict": "refused", "reasons": ["axis 0: too_fast"], "refusal": {"name": "too_fast"},
        "board": "uno", "decode": SMOOTH, "pixel_hz": "300", "pixel_ppm": 0, "requests": {},
        "clock": {"sync": "start", "divider": 1, "flaws": ClockFlaws().as_json()},
        "record_every": 1, "serial_load": False,
    }  # fmt: skip
    console = Console(width=80, record=True)
    report.print_page(console, summary)
    assert console.export_text().splitlines() == [
        "REFUSED  uno, smooth decoding, 300 Hz",
        "  axis 0: too_fast",
    ]


@pytest.mark.parametrize("columns", ["0", "20", "60", "none"])
def test_a_narrow_terminal_loses_no_figure(columns, monkeypatch):
    words = ["limits", "--board", "mega", "--pixel-hz", "200"]
    monkeypatch.setenv("COLUMNS", "80")
    wide = CliRunner().invoke(main, words).output
    monkeypatch.setenv("COLUMNS", columns)
    assert CliRunner().invoke(main, words).output == wide
    assert "least steps/s2" in wide and "\N{HORIZONTAL ELLIPSIS}" not in wide


def test_a_run_says_where_its_files_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "run"
    folder.mkdir()
    for name in ("summary.json", "edges.csv"):
        (folder / name).touch()
    console = Console(width=80, record=True)
    report.print_files(console, folder)
    assert console.export_text() == "files in run: edges.csv, summary.json\n"


def test_a_fault_is_said_with_its_meaning_and_its_cure(monkeypatch):
    state = {"fault_code": 2, "fault_axis": 0, "fault_pixel": 9, "fault_argument": 0}
    board = Device.__new__(Device)
    monkeypatch.setattr(board, "inputs", lambda: state)
    assert board.fault_text() == (
        "fault decoder_late on axis 0 at pixel 9: the next interval was not decoded in time. "
        + registers.faults()[2].cure
    )
    state |= {"fault_code": 3, "fault_argument": 7}
    assert "next interval (underruns of this axis since reset: 7). Lower" in board.fault_text()
    state |= {"fault_code": 99}
    assert board.fault_text() == "fault code 99 on axis 0 at pixel 9, argument 7"


def test_commands_start_without_the_plotting_library():
    code = "import sys, pixstep.cli.main; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
