# SPDX-License-Identifier: MIT
"""Files made for one pixel frequency and used at another: a warning, or a refusal if faster."""

from fractions import Fraction

import pytest

from pixstep import formats, natives
from pixstep.errors import UserError
from pixstep.profiles.origin import OtherFrequency

PROFILE = "AccProfM39-30Hz-1.PRN"
WARNED = "made for 30 Hz, used at "


@pytest.fixture
def files(tmp_path):
    """Put the 30 Hz profile, a line with a 30 Hz header and a move's profile into the folder."""
    data = natives.root() / "tools" / "data"
    (tmp_path / PROFILE).write_bytes((data / PROFILE).read_bytes())
    header = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "line", 1, 0, 0, "30")
    formats.write_csv(tmp_path / "line.csv", [0, 4, 8, 4, 0], header)
    formats.write_csv(tmp_path / "move.csv", [1, 2, 3], header)
    return tmp_path


MAKE = ("line", "make", "--profile", PROFILE, "--speed", "1000", "--pixels", "60", "-o", "new.csv")
CHECK = ("line", "check", "line.csv", "--decode", "smooth", "--backlash", "2")
MOVE = ("move", "make", "move.csv", "--steps", "20", "-o", "new.csv")
SHOW = ("line", "show", "line.csv", "--decode", "smooth", "--backlash", "2")
TICKS = ("ticks", "line.csv", "--decode", "smooth", "--backlash", "2", "-o", "new.csv")


@pytest.mark.parametrize("words", [MAKE, CHECK, MOVE])
def test_faster_is_refused_before_anything_is_written(files, invoke, words):
    said = invoke(*words, "--pixel-hz", "300", status=3).stderr
    assert f"{WARNED}300 Hz: its accelerations per second are 100 times as high" in said
    assert said.count("\n") == 1 and not (files / "new.csv").exists()


@pytest.mark.parametrize("words", [MAKE, CHECK, MOVE, SHOW, TICKS])
@pytest.mark.parametrize("hz", ["20", "30.3"])
def test_slower_and_hardly_faster_are_warnings(files, invoke, plan_program, words, hz):
    assert f"{WARNED}{hz} Hz" in invoke(*words, "--pixel-hz", hz).stderr


@pytest.mark.parametrize("words", [SHOW, TICKS, ("profile", "check", PROFILE),
                                   ("profile", "show", PROFILE),
                                   ("move", "show", "move.csv", "--steps", "20")])  # fmt: skip
def test_looking_at_it_is_a_warning(files, invoke, plan_program, words):
    assert f"{WARNED}300 Hz" in invoke(*words, "--pixel-hz", "300").stderr


@pytest.mark.parametrize("words", [MAKE, CHECK, MOVE, SHOW, TICKS])
def test_the_same_frequency_says_nothing(files, invoke, plan_program, words):
    assert "made for" not in invoke(*words, "--pixel-hz", "30Hz").stderr


def test_the_simulation_refuses(files, invoke, simulator):
    words = ("sim", "line.csv", "--board", "uno", "--decode", "smooth", "--backlash", "2")
    more = ("--pixel-hz", "60", "--out", "run")
    assert f"{WARNED}60 Hz" in invoke(*words, *more, status=3).stderr
    assert f"note: line.csv: {WARNED}60 Hz" in invoke(*words, *more, "--no-check").stderr


def test_a_renamed_profile_and_a_changed_header_are_taken(files, invoke):
    (files / PROFILE).rename(files / "mine.PRN")
    words = [word.replace(PROFILE, "mine.PRN") for word in MAKE]
    assert "made for" not in invoke(*words, "--pixel-hz", "300").stderr
    invoke("file", "convert", "line.csv", "fast.csv", "--pixel-hz", "300")
    words = [word.replace("line.csv", "fast.csv") for word in CHECK]
    assert "made for" not in invoke(*words, "--pixel-hz", "300").stderr


def test_the_machines_clock_does_not_hide_the_header(files, invoke):
    invoke("machine", "new", "--board", "mega", "--pixel-hz", "50")
    shown = invoke(*SHOW)
    assert "made for" not in shown.stderr and "240" in shown.stdout  # 8 steps/px at 30 Hz
    assert f"{WARNED}50 Hz" in invoke(*CHECK, status=3).stderr


def test_frequencies_that_look_alike_are_told_apart():
    text = OtherFrequency("x", Fraction(30000, 1001), Fraction(29970029970, 10**9)).text
    assert "made for 30000/1001 Hz, used at 2997002997/100000000 Hz" in text
    with pytest.raises(UserError, match="rename it if"):
        OtherFrequency("x", Fraction(30), Fraction(31), by_name=True).refuse_faster()
