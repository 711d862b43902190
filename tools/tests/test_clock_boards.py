# SPDX-License-Identifier: MIT
"""Real images get the pixel clock of a machine file: its divider, its sync, and time to measure."""

from pathlib import Path

import pytest

from console import PORT
from pixstep import formats, natives
from pixstep.board import boards
from test_board_images import Live

pytestmark = pytest.mark.usefixtures("simulator", "machine")
NAMES = ("pixel_hz_num", "divider", "sync")
MACHINE = f"""\
[clock]
pixel = "1 kHz"
divider = 4
sync = "lock"
[boards.main]
kind = "KIND"
port = "{PORT}"
[motors.X]
axis = 0
kind = "smooth"
limits = {{ max_acceleration = "200000 steps/s2" }}
"""


@pytest.fixture(params=boards.BOARD_NAMES)
def name(request):
    """Name each board."""
    return request.param


@pytest.fixture
def machine(tmp_path, monkeypatch, name):
    """Put a machine of this board into the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE.replace("KIND", name))


@pytest.fixture
def live(make_console, name):
    """Return a function that starts the board; it is ended afterwards."""
    started = []

    def start(**options):
        started.append(Live(make_console, (name,), **options))
        return started[-1]

    yield start
    for one in started:
        one.sim.kill()


def settings(one):
    """The settings of the clock that a board has."""
    found = one.json("get", *NAMES)
    return [item["value"] for item in found["boards"][0]["registers"]]


def test_an_upload_waits_until_the_lock_can_begin(live, invoke):
    one = live(hz=1000, pixel_ppm=500)
    invoke("line", "make", "--speed", "4000steps/s", "--length", "400", "-o", "l.csv")
    done = one.json("upload", "l.csv", "--arm")
    assert done["axes"][0]["state"] == "done" and done["axes"][0]["position_steps"] == 400
    assert done["pixel_hz"] == "250/1"
    assert settings(one) == [1000, 4, 2]


def test_a_clock_that_is_not_there_is_said(live, invoke):
    one = live(hz=1)  # so slow that 500 edges of 1 kHz pass between two of it
    invoke("line", "make", "--speed", "4000steps/s", "--length", "400", "-o", "l.csv")
    said = one.err("upload", "l.csv", "--arm")
    assert said.startswith("board 1: no steady pixel clock in 500 edges: ")
    assert said.endswith("came in 0.5 s, set to 1000 Hz")
    one.out("upload", "l.csv")
    said = one.err("start", status=3)
    assert said.endswith("(setting sync), which is not measured yet: set to 1000 Hz")


def test_moves_count_in_pixels_of_the_machine(live):
    one = live(hz=1000)
    formats.write_csv(
        Path("ramp.csv"), [2, 4, 6], formats.ProfileHeader(
            "Mon Oct 12 15:13:35 2009", "ramp", 1, 3, 0, "250"
        )
    )  # fmt: skip
    found = one.json("move", "ramp.csv", "--steps", 100)
    assert found["to_steps"] - found["from_steps"] == 100
    assert found["seconds"] == found["pixels"] / 250
    assert settings(one) == [1000, 4, 1]  # a move needs no clock: nothing is said of the lock
    said = one.err("move", "ramp.csv", "--steps", 100, "--divider", 2, status=3)
    assert "made for 250 Hz, used at 500 Hz" in said
    assert settings(one) == [1000, 4, 1]


def test_homing_counts_in_pixels_of_the_machine(live):
    one = live(hz=1000, plants={(0, 0): "home=900,hyst=8,travel=-2000..4000,start=100"})
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    one.out("set", "divider=9")
    found = one.json("home", profile, "--search", 3000, "--clock-hz", 120, "--decode", "plain")
    assert found["found"] and settings(one) == [120, 4, 1]
