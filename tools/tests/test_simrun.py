# SPDX-License-Identifier: MIT
"""A whole run against the test double: upload, arming, records, files, verdict, seeded defects."""

import json
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import fake_runner
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.simulator import SimulatorError
from worked import worked_line

FAKE = [sys.executable, fake_runner.__file__]
HZ = Fraction(30)


def fake_job(lines, **changes):
    options = {"board": "mega", "pixel_hz": HZ, "image": Path("none.elf"), "program": FAKE}
    return LineExperiment(lines=lines, **{**options, **changes})


@pytest.fixture(autouse=True)
def source_path(monkeypatch):
    """Let the double import the package as pytest does."""
    monkeypatch.setenv("PYTHONPATH", fake_runner.PATH)
    monkeypatch.delenv("DEFECT", raising=False)


@pytest.mark.parametrize("backlash", [0, 250])
def test_worked_example_passes(tmp_path, backlash):
    line = worked_line(backlash, pixels=40)
    judged = simulate(fake_job({0: line}), tmp_path)
    assert judged.summary["reasons"] == []
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["verdict"] == "pass"
    (axis,) = summary["axes"]
    assert axis["steps"] == line.total_steps and axis["pixels_equal"] == 40
    assert 0 < axis["max_edge_error_ticks"] < 1
    pixels = (tmp_path / "pixels.csv").read_text().splitlines()
    assert pixels[0] == "board,axis,pixel,edge_cycle,expected_steps,actual_steps"
    assert len(pixels) == 41 and pixels[-1].endswith(f",{line.total_steps},{line.total_steps}")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        ".pixstep-results", "clock.csv", "edges.csv", "pixels.csv", "summary.json",
    ]  # fmt: skip


def test_four_axes_share_line_zero(tmp_path):
    lines = {
        0: worked_line(250, pixels=33),
        1: Line((3, -3, 0, 40, 40), PLAIN),
        2: Line((4, 12, 12 + 4, 16, 12, 4), negative=True),
        3: Line((0, 0, 0), PLAIN),
    }
    judged = simulate(fake_job(lines), tmp_path)
    assert judged.summary["reasons"] == []
    zeros = {found.line_zero_cycle for found in judged.axes}
    assert len(zeros - {None}) == 1


@pytest.mark.parametrize(
    ("defect", "reason"),
    [
        ("moved", "edges are a tick or more off, first step 41"),
        ("missing", "steps instead of"),
        ("doubled", "steps instead of"),
        ("drift", "a tick or more off"),
        ("late", "cycles off one pixel period after a clock edge"),
        ("table", "pixels differ, first 3"),
    ],
)
def test_seeded_defects_are_found(tmp_path, monkeypatch, defect, reason):
    monkeypatch.setenv("DEFECT", defect)
    judged = simulate(fake_job({0: worked_line(250, pixels=34)}), tmp_path)
    assert not judged.passed
    assert any(reason in text for text in judged.summary["reasons"]), judged.summary["reasons"]


def test_lost_replies_lose_and_double_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("DEFECT", "lost reply")
    judged = simulate(fake_job({0: worked_line(250, pixels=40)}), tmp_path)
    assert judged.summary["reasons"] == []


def test_serial_load_gives_the_same_edges(tmp_path):
    line = worked_line(250, pixels=40)
    simulate(fake_job({0: line}), tmp_path / "quiet")
    judged = simulate(fake_job({0: line}, serial_load=True), tmp_path / "loaded")
    assert judged.summary["requests"]["load"] > 20
    quiet = (tmp_path / "quiet" / "edges.csv").read_bytes()
    assert (tmp_path / "loaded" / "edges.csv").read_bytes() == quiet


def test_a_refused_line_names_the_error_and_moves_nothing(tmp_path):
    judged = simulate(fake_job({0: Line((10, 10, 10, 10))}), tmp_path)
    assert judged.summary["verdict"] == "refused" and not judged.passed
    assert judged.summary["refusal"] == {
        "axis": 0, "name": "oscillates", "pixel": 1, "step_edges": 0,
    }  # fmt: skip


def test_a_dying_simulator_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setenv("DEFECT", "dies")
    with pytest.raises(SimulatorError, match="ended: simavr: out of luck"):
        simulate(fake_job({0: worked_line(0, pixels=60)}), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_axis_that_the_board_has_not(tmp_path):
    with pytest.raises(UserError, match="axis 1: the uno has 1"):
        simulate(fake_job({1: worked_line(0)}, board="uno"), tmp_path)


def test_period_out_of_the_boards_range(tmp_path):
    with pytest.raises(UserError, match="must be 1024 to 16777215 ticks"):
        simulate(fake_job({0: worked_line(0)}, pixel_hz=Fraction(1, 2)), tmp_path)
