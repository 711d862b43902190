# SPDX-License-Identifier: MIT
"""A line carries the backlash that it was made with: no other one is taken in silence."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

import jobbench
import pixstep as px
from console import Console
from pixstep import formats, natives, ops
from pixstep.errors import UserError
from pixstep.formats.header import ProfileHeader
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

WORDS = ("--speed", 1000, "--pixels", 60)
OWN = "line.csv: its own backlash of 250 steps is taken; machine.toml has {}"


@pytest.fixture
def line(pixstep, tmp_path):
    """Return the command line in a folder with a line that was made for a backlash of 250."""
    jobbench.write_machine(tmp_path)
    pixstep("line", "make", "--motor", "M39", *WORDS, "-o", "line.csv")
    return pixstep


def set_play(folder, text):
    """Give the machine another play."""
    changed = jobbench.MACHINE.replace('"250 steps"', f'"{text}"')
    (Path(folder) / "machine.toml").write_text(changed)


def test_a_line_that_takes_play_up_says_how_much(line, tmp_path):
    header = formats.read_csv(tmp_path / "line.csv").header
    assert header.backlash == 250 and header.frequency == 30
    assert (tmp_path / "line.csv").read_text().startswith("Backlash:   250 ")
    line("line", "make", "--motor", "M39", *WORDS, "--backlash", 0, "--header", "x", "-o", "0.csv")
    assert formats.read_csv(tmp_path / "0.csv").header.backlash == 0
    line("line", "make", "--motor", "M39", *WORDS, "--backlash", 0, "-o", "bare.csv")
    bare = formats.read_csv(tmp_path / "bare.csv")
    assert bare.header is None and bare.values[0] == 4


@pytest.mark.parametrize("today", ["100 steps", "0 steps"])
@pytest.mark.parametrize("words", [("line", "check"), ("sim",)])
def test_the_lines_own_backlash_comes_before_the_machines(line, tmp_path, today, words, simulator):
    set_play(tmp_path, today)
    more = ("--board", "mega", "--out", "run") if words[0] == "sim" else ()
    data = line(*words, "line.csv", "--motor", "M39", "--sync", "start", *more)
    assert OWN.format(today.removesuffix(" steps")) in data.replace(str(tmp_path) + "/", "")
    if words[0] == "sim":
        summary = json.loads((tmp_path / "run" / "summary.json").read_text())
        assert summary["verdict"] == "pass"
        counts = formats.read_csv(tmp_path / "line.csv").values
        assert summary["axes"][0]["steps"] == sum(counts) + 250


def test_the_same_backlash_needs_no_word(line):
    assert "backlash" not in line("line", "check", "line.csv", "--motor", "M39")


def test_what_the_caller_says_is_taken_and_said(line):
    told = line("line", "check", "line.csv", "--motor", "M39", "--backlash", 100)
    assert "line.csv: made for a backlash of 250 steps, 100 is taken as asked" in told
    done = ops.line_check("line.csv", decode="smooth", backlash=100)
    assert done["backlash"] == 100 and any("made for a backlash" in note for note in done.notes)
    assert ops.line_check("line.csv", decode="smooth")["backlash"] == 250


def test_a_file_of_others_says_nothing_and_that_is_said(line, tmp_path):
    values = formats.read_csv(tmp_path / "line.csv").values
    formats.write_csv(tmp_path / "other.csv", list(values))
    told = line("line", "check", "other.csv", "--motor", "M39")
    assert "does not say the backlash that it was made for: the 250 steps of machine.toml" in told
    told = line("line", "check", "other.csv", "--decode", "smooth", "--machine", "none", status=1)
    assert "does not say how much: none is taken up" in told
    told = line("line", "check", "other.csv", "--motor", "M39", "--backlash", 250)
    assert "does not say" not in told


def test_lines_without_take_up_get_no_note(line, tmp_path):
    formats.write_csv(tmp_path / "plain.csv", [0, 5, 0])
    formats.write_csv(tmp_path / "none.csv", [2, 4, 2])
    for name, kind in (("plain.csv", "plain"), ("none.csv", "smooth")):
        told = line("line", "check", name, "--decode", kind, "--machine", "none")
        assert "backlash" not in told


def test_upload_takes_the_lines_own(line, tmp_path, monkeypatch, simulator):
    """The machine says 100 today: 250 are sent, and the motor makes 250 more than its counts."""
    set_play(tmp_path, "100 steps")
    steps = sum(formats.read_csv(tmp_path / "line.csv").values)
    boards = [("mega", natives.image("mega"))]
    with SimLink(SimOptions(boards, Fraction(30))) as link:
        done = ops.board_upload(
            "line.csv", arm=True, link=link, machine="machine.toml", motor="M39", sync="start"
        )
        assert done["axes"][0]["steps"] == steps + 250
        assert done["axes"][0]["position_steps"] == steps + 250
        assert any("its own backlash of 250" in note for note in done.notes)
        console = Console(monkeypatch, link.simulator, link.world)
        told = console.run("upload", "line.csv", "--motor", "M39", "--backlash", 90)
        assert "250 steps, 90 is taken as asked" in told.stderr


def test_a_header_keeps_its_backlash_in_every_format(line, tmp_path):
    line("file", "convert", "line.csv", "line.csb", "--to", "csb")
    line("file", "convert", "line.csb", "again.csv", "--to", "csv", "--lead-in", 3)
    again = formats.read_csv(tmp_path / "again.csv").header
    assert (again.backlash, again.lead_in_px) == (250, 3)
    data = json.loads(line("file", "info", "line.csv", "--json"))
    assert data["header"]["Backlash"]["value"] == 250


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Backlash:  25x ", "columns 1 to 16 must be blank, or have 'Backlash:'"),
        ("Backlash:250    ", "columns 1 to 16 must be blank, or have 'Backlash:'"),
        ("Backlash:    -3 ", "columns 1 to 16 must be blank, or have 'Backlash:'"),
        ("Spiel:      250 ", "columns 1 to 16 must be blank, or have 'Backlash:'"),
        ("Backlash:       ", "columns 1 to 16 must be blank, or have 'Backlash:'"),
    ],
)
def test_a_wrong_backlash_in_a_header(line, tmp_path, text, said):
    data = (tmp_path / "line.csv").read_text()
    (tmp_path / "x.csv").write_text(f"{text:16}"[:16] + data[16:])
    told = line("line", "check", "x.csv", "--motor", "M39", status=3)
    assert "x.csv:1:1: " in told and said in told
    header = ProfileHeader("Thu Nov 26 12:00:00 2026", "x", 1, 0, 0, "30", 1_000_000)
    with pytest.raises(UserError, match="longer than 6"):
        formats.write_csv(tmp_path / "y.csv", [1], header)


def test_python_reads_the_lines_own(line, tmp_path):
    set_play(tmp_path, "100 steps")
    read = px.read_line("line.csv", motor=px.Machine.load("machine.toml")["M39"])
    assert read.line.backlash == 250
    assert any("its own backlash of 250 steps is taken; motor M39 has 100" in n for n in read.notes)
    assert px.read_line("line.csv", decode="smooth").line.backlash == 250
    read = px.read_line("line.csv", decode="smooth", backlash=90)
    assert read.line.backlash == 90 and any("90 is taken as asked" in note for note in read.notes)


def test_an_odd_profile_of_the_smooth_motor_is_refused_by_its_name(pixstep, tmp_path):
    """The printer's M39 is smooth: nobody has to say so."""
    for name, status in (("AccProfM39-30Hz-1.PRN", 3), ("AccProfM40-30Hz-1.PRN", 0), ("x.PRN", 0)):
        formats.write_prn(tmp_path / name, [3, 8, 15])
        told = pixstep("file", "check", name, status=status)
        assert ("speed 3 of a smooth motor is odd" in told) == (status == 3)
    assert "fine" in pixstep("file", "check", "AccProfM39-30Hz-1.PRN", "--decode", "plain")
