# SPDX-License-Identifier: MIT
"""A profile file under all its readings: rows or block, smooth or plain."""

import json

import pytest
from click.testing import CliRunner

from pixstep import formats
from pixstep.cli.main import main
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.line_check import Limits
from pixstep.profiles import origin, readings
from worked import ACCELERATING, PRN, SAMPLE_CSV

HEADER = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "mine", 1, 3, 0, "30")


def states(path, motor=None, limits=None, *, raw=False):
    """(form, decode, sound) of every reading, and the exit status."""
    found = readings.check(readings.load(path, raw=raw), motor, limits or Limits())
    return [(r.rows.form, r.decode, r.sound) for r in found], readings.exit_status(found)


def names_of(path, decode, limits=None):
    """Names and entries of the findings of the adopted reading."""
    found = readings.check(readings.load(path), None, limits or Limits())
    (reading,) = [r for r in found if r.decode == decode and r.rows.adopted]
    return [(item.name, item.pixel) for item in reading.findings]


def csv(tmp_path, values, header=None):
    path = tmp_path / "a.csv"
    formats.write_csv(path, list(values), header)
    return path


def prn(tmp_path, speeds):
    path = tmp_path / "a.PRN"
    formats.write_prn(path, list(speeds))
    return path


def test_constant_counts_are_sound_only_plainly(tmp_path):
    path = csv(tmp_path, [10] * 4)
    assert states(path) == ([("rows", SMOOTH, False), ("rows", PLAIN, True)], 1)
    assert states(path, SMOOTH)[1] == 1
    assert states(path, PLAIN) == ([("rows", PLAIN, True)], 0)
    assert names_of(path, SMOOTH) == [("oscillates", 1)]


def test_a_smooth_profile_is_sound_both_ways(tmp_path):
    path = csv(tmp_path, [*ACCELERATING, 1000], HEADER)
    found, status = states(path)
    assert found[:2] == [("block", SMOOTH, True), ("block", PLAIN, True)] and status == 0


def test_the_truncated_sample_is_refused_and_its_rows_shown():
    found, status = states(SAMPLE_CSV)
    assert status == 2
    assert found == [("block", "", False), ("rows", SMOOTH, False), ("rows", PLAIN, False)]
    read = readings.load(SAMPLE_CSV)
    assert "truncated, 3 of 100" in read.rows[0].problem
    assert read.rows[1].values == (1, 100, 2, 4, 5)


def test_raw_rows_that_fit_a_block_are_ambiguous(tmp_path):
    path = csv(tmp_path, [1, 3, 10, 20, 40])
    assert states(path)[1] == 1
    headed = csv(tmp_path, [10, 20, 40], HEADER)
    assert states(headed)[1] == 0
    found, status = states(headed, raw=True)
    assert status == 1 and found[0][0] == "rows"


def test_prn_means_speeds_for_a_smooth_motor(tmp_path):
    assert states(PRN, SMOOTH) == ([("prn", SMOOTH, True)], 0)
    odd = prn(tmp_path, [8, 15, 24])
    assert states(odd, SMOOTH) == ([("prn", SMOOTH, False)], 2)
    assert states(odd, PLAIN) == ([("prn", PLAIN, True)], 0)
    assert states(odd) == ([("prn", SMOOTH, False), ("prn", PLAIN, True)], 1)
    assert names_of(prn(tmp_path, [8, 15, 6, 0]), SMOOTH) == [
        ("speed", 2), ("speed", 3), ("speed", 4),
    ]  # fmt: skip
    assert states(prn(tmp_path, [8, 6]))[1] == 2


def test_limits_of_both_readings():
    assert states(PRN, SMOOTH, Limits(1280, 128, jerk_warning=128))[1] == 0
    assert states(PRN, SMOOTH, Limits(1280, 126))[1] == 2
    assert states(PRN, SMOOTH, Limits(1278))[1] == 2
    assert states(PRN, SMOOTH, Limits(jerk_warning=127))[1] == 1
    assert names_of(PRN, PLAIN, Limits(max_acceleration=100))[0] == ("acceleration", 10)
    assert ("jerk", 7) in names_of(PRN, PLAIN, Limits(jerk_warning=50))


def test_the_change_to_constant_speed_counts(tmp_path):
    path = csv(tmp_path, [10, 40])  # speeds 20, 60: the last acceleration is 40
    assert names_of(path, SMOOTH, Limits(jerk_warning=39)) == [("jerk", 3)]
    assert names_of(path, SMOOTH, Limits(jerk_warning=40)) == []


def test_a_whole_line_is_no_profile(tmp_path):
    path = csv(tmp_path, [5, 10, 10, 5])
    assert names_of(path, SMOOTH) == [("falls", 4)]
    assert names_of(path, PLAIN) == [("falls", 4)]
    assert states(path)[1] == 2


def test_haps_beyond_the_values(tmp_path):
    path = csv(tmp_path, [5, 10], HEADER)
    assert names_of(path, SMOOTH) == [("haps", 0)]
    assert states(path)[1] == 1


def test_names():
    named = origin.parse_name(PRN)
    assert (named.motor, named.pixel_hz, named.variant, named.decode) == ("M39", 30, "1", SMOOTH)
    assert origin.parse_name(PRN.with_name("AccProfM40-29.97Hz-x2.csv")).decode == PLAIN
    assert origin.parse_name(SAMPLE_CSV) is None


def run(*words, status=0):
    done = CliRunner().invoke(main, ["profile", "check", *map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert done.exit_code == status, done.output
    return done.output


def test_command(tmp_path):
    path = csv(tmp_path, [10] * 4)
    output = run(path, status=1)
    assert "decoded as smooth: fails" in output and "entry 1: error oscillates" in output
    assert "sound only when decoded as plain (fast moves)" in output
    assert "pixstep profile repair" in output
    assert "fine" in run(path, "--decode", "plain")
    report = json.loads(run(path, "--json", status=1))
    assert [r["state"] for r in report["readings"]] == ["fails", "fine"]
    assert report["verdict"] == "warnings"


def test_command_takes_motor_and_frequency_from_the_name():
    assert "plain" not in run(PRN, "--max-acceleration", "115200steps/s2")
    output = run(PRN, "--max-acceleration", "115199steps/s2", status=3)
    assert "acceleration 128 is above 127" in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([SAMPLE_CSV.with_name("no.csv")], "No such file"),
        ([PRN, "--max-jerk", "0.5"], "at least 1 steps/px3"),
        ([PRN, "--max-jerk", "5Hz"], "expected a number of steps/px3 or steps/s3"),
    ],
)
def test_misuse(words, message):
    assert message in run(*words, status=2)


@pytest.mark.parametrize("option", ["--max-speed", "--max-acceleration", "--max-jerk"])
def test_a_limit_that_is_too_little_names_its_option(invoke, option):
    limits = ("limits", "--board", "mega", "--pixel-hz", "1 kHz", "--max-speed", "400")
    said = invoke(*limits, option, "0", status=2).stderr
    assert said.startswith(f"pixstep: {option}: 0 is 0 steps/px") and said.count("\n") == 1
