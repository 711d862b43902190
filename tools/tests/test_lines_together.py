# SPDX-License-Identifier: MIT
"""`line check` of several lines: each by its own rule, file and motor, with its own findings."""

import json
from pathlib import Path

import pytest

TURNS, RISES = [20, -20, 20], [2, 4, 2]
MACHINE = """clock.pixel = 30
boards.main.kind = "mega"
motors.X = { axis = 0, kind = "plain", limits.max_acceleration = "17 steps/px2" }
motors.Y = { axis = 1, kind = "plain", limits.max_acceleration = "39 steps/px2" }
"""
BOARD = ("--board", "mega", "--pixel-hz", "30")


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, counts in (("turns.csv", TURNS), ("rises.csv", RISES)):
        Path(name).write_bytes(b"".join(b"%6d\r\n" % count for count in counts))


def test_each_line_has_its_rule_and_the_refused_one_is_named(invoke):
    words = ("line", "check", "rises.csv", "turns.csv", *BOARD)
    kinds = ("--decode", "smooth", "--decode", "smooth")
    told = invoke(*words, *kinds, status=3)
    assert "rises.csv: fine: 3 pixels" in told.stdout
    assert "turns.csv: pixel 2: error negative_count" in told.stdout
    assert "turns.csv: refused" in told.stdout
    data = json.loads(invoke(*words, *kinds, "--json", status=3).stdout)
    (other,) = data["beside"]
    assert (data["file"], data["verdict"], data["findings"]) == ("rises.csv", "refused", [])
    assert (other["file"], other["verdict"], other["decode"]) == ("turns.csv", "refused", "smooth")
    assert [one["name"] for one in other["findings"]] == ["negative_count"]
    data = json.loads(invoke(*words, "--decode", "smooth", "--decode", "plain", "--json").stdout)
    assert [data["decode"], data["beside"][0]["decode"]] == ["smooth", "plain"]
    assert (data["verdict"], data["beside"][0]["steps"]) == ("fine", 60)


def test_lines_of_one_file_are_told_by_their_numbers(invoke):
    made = ("--speed", 4, "--pixels", 12, "--max-acceleration", 2, "--lines", 2, "--pixel-hz", 30)
    invoke("line", "make", *made, "-o", "two.csv")
    words = ("line", "check", "two.csv", "two.csv", "--decode", "smooth")
    said = invoke(*words, "--line", 1, "--pixel-hz", 30, status=2).stderr
    assert said == "pixstep: 2 files, --board: uno has 1 axis: 0\n"
    told = invoke(*words, "--line", 2, "--line", 1).stdout
    assert told.startswith("two.csv line 2: fine: ") and "\ntwo.csv line 1: fine: " in told


def test_what_the_time_refuses_is_said_of_the_line_that_is_late(invoke):
    Path("fast.csv").write_bytes(b"".join(b"%6d\r\n" % (1 + k * k % 7) for k in range(3000)))
    words = ("line", "check", "rises.csv", "fast.csv", "--board", "mega", "--pixel-hz", 1000)
    words += ("--decode", "plain", "--baud", 9600)
    data = json.loads(invoke(*words, "--json", status=3).stdout)
    assert [one["name"] for one in data["findings"]] == []
    assert [one["name"] for one in data["beside"][0]["findings"]] == ["beyond_guarantee"]
    assert "fast.csv: pixel" in invoke(*words, status=3).stdout


def test_fewer_axes_than_files_are_refused(invoke):
    words = ("line", "check", "rises.csv", "turns.csv", *BOARD, "--decode", "plain")
    assert "--axes 1: 2 files" in invoke(*words, "--axes", "1", status=2).stderr
    assert "fine" in invoke(*words, "--axes", "3").stdout
    assert "--decode is given 3 times for 2 lines" in (
        invoke(*words, "--decode", "plain", "--decode", "plain", status=2).stderr
    )


def test_each_line_is_judged_by_its_motor(invoke):
    Path("machine.toml").write_text(MACHINE, encoding="utf-8")
    words = ("line", "check", "rises.csv", "turns.csv")
    one = invoke(*words, status=2).stderr
    assert "2 lines for 1 motor of machine.toml: give --motor once for each line" in one
    told = invoke(*words, "--motor", "X", "--motor", "Y").stdout
    assert "turns.csv: fine" in told
    told = invoke(*words, "--motor", "Y", "--motor", "X", status=3).stdout
    assert "turns.csv: pixel 1: error acceleration: acceleration 20 is above 19" in told
    one = ("--motor", "X", "--motor", "Y", "--max-acceleration", "30")
    assert "acceleration -40 is above 30" in invoke(*words, *one, status=3).stdout


def test_what_would_judge_nothing_is_refused_and_a_plain_line_has_a_jerk(invoke):
    words = ("line", "check", "turns.csv", "--decode", "plain")
    said = invoke(*words, "--start-stop", "5", status=2).stderr
    assert said == (
        "pixstep: --start-stop: needs --max-acceleration, which judges starts and stops beyond it\n"
    )
    said = invoke("line", "check", "rises.csv", "--decode", "smooth", "--start-stop", 5, status=2)
    assert "--start-stop: is for plain lines" in said.stderr
    told = invoke(*words, "--start-stop", 5, "--max-acceleration", 15, status=3).stdout
    assert "acceleration 20 is above 15" in told
    assert "fine" in invoke(*words, "--start-stop", 20, "--max-acceleration", 15).stdout
    told = invoke(*words, "--jerk-warn", "59", status=1).stdout
    assert "pixel 2: warning jerk: the acceleration changes by 60" in told
    assert "pixel 1" not in told
