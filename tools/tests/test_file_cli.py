# SPDX-License-Identifier: MIT
"""`pixstep file` and the line commands on many lines and on CSB, as a user types them."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

from mutants import HEADER, LINES
from pixstep import formats
from worked import MPOS, PRN, SAMPLE_CSV


@pytest.fixture
def pixstep(invoke):
    """Return a function that runs a command in an empty folder: status, stdout, stderr."""
    return invoke


@pytest.fixture
def many(tmp_path):
    """A CSV of three lines and its CSB."""
    file = formats.of_lines(LINES, HEADER)
    formats.write_motion(tmp_path / "many.csv", file)
    formats.write_motion(tmp_path / "many.csb", replace(file, kind="csb"))
    return tmp_path / "many.csv"


def test_info_says_what_is_in_the_sample(pixstep):
    lines = pixstep("file", "info", SAMPLE_CSV).stdout.splitlines()
    facts = {line[:18].strip(): line[19:] for line in lines[1:]}
    assert lines[0] == str(SAMPLE_CSV)
    assert facts["format"].startswith("CSV file: its first line is 40 columns wide")
    assert facts["line ends"] == "CR LF"
    assert facts["name"] == "4editing1n (profile name)"
    assert facts["HAPs"].startswith("10 (homing acceleration pixels")
    assert facts["line 1"] == "3 of 100 values (truncated), 2 to 5, 11 steps"
    assert facts["other reading"] == "raw: 5 values, 1 to 100, 112 steps"
    assert "truncated, 3 of 100 values of line 1: accepted" in facts["note"]


def test_info_json(pixstep, many):
    facts = json.loads(pixstep("file", "info", many, "--json").stdout)
    assert facts["kind"] == "csv" and facts["line_ends"] == "CR LF"
    assert [line["values"] for line in facts["lines"]] == [len(values) for values in LINES]
    assert facts["lines"][1]["steps"] == sum(abs(value) for value in LINES[1])
    assert facts["bytes"] == many.stat().st_size and len(facts["sha256"]) == 64
    binary = json.loads(pixstep("file", "info", many.with_suffix(".csb"), "--json").stdout)
    assert binary["lines"] == facts["lines"] and binary["header"] == facts["header"]


def test_info_of_a_thousand_lines_is_short(pixstep, tmp_path):
    formats.write_motion(tmp_path / "x.csv", formats.of_lines([[1, 2]] * 1000, HEADER))
    output = pixstep("file", "info", "x.csv").stdout
    assert "980 more lines (--json lists all)" in output and output.count("\n") < 40
    assert "1000 lines, 2000 values, 3000 steps" in output


def test_check_prints_every_finding_in_order(pixstep, tmp_path):
    data = SAMPLE_CSV.read_bytes().replace(b"HAPs:", b"Haps:").replace(b"     4\r", b"   4.0\r")
    (tmp_path / "x.csv").write_bytes(data.replace(b"   100\r\n", b"   100\n"))
    assert pixstep("file", "check", "x.csv", status=3).stdout.splitlines() == [
        "x.csv:3:15: error: 'Haps:': expected 'HAPs:' at column 15",
        "x.csv:6:7: error: '   100' ends with LF, CR LF expected (1 of 9 records)",
        "x.csv:8:5: error: '   4.0' is not an integer right-aligned in 6 columns",
        "x.csv: refused: CSV file",
    ]


def test_check_statuses_and_hint(pixstep):
    assert pixstep("file", "check", MPOS).stdout == f"{MPOS}: fine: CSV file\n"
    output = pixstep("file", "check", SAMPLE_CSV, status=3).stdout
    assert output.endswith("refused: CSV file (--lenient accepts it)\n")
    output = pixstep("file", "check", SAMPLE_CSV, "--lenient", status=1).stdout
    assert "6:4: note: truncated, 3 of 100" in output and "accepted with notes" in output
    pixstep("file", "check", "nowhere.csv", status=2)


def test_check_json(pixstep):
    report = json.loads(pixstep("file", "check", SAMPLE_CSV, "--json", status=3).stdout)
    assert report["verdict"] == "refused" and report["kind"] == "csv"
    (error,) = (item for item in report["findings"] if item["severity"] == "error")
    assert (error["name"], error["line"], error["column"]) == ("truncated", 6, 4)


def test_check_smooth_is_for_profiles(pixstep):
    output = pixstep("file", "check", MPOS, "--decode", "smooth", status=2).stderr
    assert "--decode smooth is for PRN profiles" in output and "line check" in output


@pytest.mark.parametrize("path", [MPOS, SAMPLE_CSV], ids=["bare", "truncated"])
def test_csv_to_csb_and_back_gives_the_same_bytes(pixstep, tmp_path, path):
    pixstep("file", "convert", path, "x.csb", "--lenient")
    pixstep("file", "convert", "x.csb", "back.csv", "--lenient")
    assert (tmp_path / "back.csv").read_bytes() == path.read_bytes()


def test_many_lines_to_csb_and_back(pixstep, many):
    pixstep("file", "convert", many, "x.csb")
    assert (many.parent / "x.csb").read_bytes() == many.with_suffix(".csb").read_bytes()
    pixstep("file", "convert", "x.csb", "back.csv")
    assert (many.parent / "back.csv").read_bytes() == many.read_bytes()


def test_one_line_of_many(pixstep, many):
    pixstep("file", "convert", many, "two.csv", "--line", 2)
    read = formats.read_csv(many.parent / "two.csv")
    assert read.values == tuple(LINES[1]) and read.header == HEADER
    pixstep("file", "convert", many, "bare.csv", "--line", 3, "--drop-header")
    assert (many.parent / "bare.csv").read_bytes() == b"   100\r\n"
    output = pixstep("file", "convert", many, "x.csv", "--line", 4, status=2).stderr
    assert output == f"pixstep: {many}:3:11: holds 3 lines, there is no line 4\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([MPOS, "x.prn"], "--decode plain says that the motor is plain"),
        ([PRN, "x.csb"], "--decode plain says that the motor is plain"),
        (
            ["many.csv", "x.prn", "--decode", "plain"],
            "header would be lost: --drop-header says that it may",
        ),
        (["many.csv", "x.prn", "--decode", "plain", "--drop-header"], "choose one by --line 1..3"),
        (["many.csv", "x.csv", "--drop-header"], "choose one by --line 1..3"),
        (
            ["many.csv", "x.prn", "--decode", "plain", "--drop-header", "--line", 2],
            "value -7 does not fit",
        ),
        ([MPOS, "x.csv", "--haps", 3], "a new header needs --header NAME and --pixel-hz"),
        ([MPOS, "x.csv", "--header", "n"], "a new header needs --header NAME and --pixel-hz"),
        ([MPOS, "x.csv", "--header", "n", "--drop-header"], "the output has no header"),
        ([MPOS, "x.csv", "--header", "n" * 21, "--pixel-hz", 30], "longer than 20 characters"),
        ([MPOS, "x.csv", "--header", "n", "--pixel-hz", 30, "--date", "now"], "ctime"),
        ([PRN, "x.csv", "--decode", "plain", "--line", 1], "neither a header nor lines"),
        ([MPOS, "x.txt"], "which format? --to prn, csv or csb"),
        ([MPOS, "x.csb", "--to", "csv"], "--to csv contradicts the name"),
        ([SAMPLE_CSV, "x.csb"], "(--lenient accepts it)"),
        ([MPOS, "many.csv"], "already exists (--force replaces it)"),
    ],
    ids=str,
)
def test_convert_loses_and_pretends_nothing(pixstep, many, words, message):
    before = sorted(many.parent.iterdir()), many.read_bytes()
    refused = message == "(--lenient accepts it)"  # what is in the file
    done = pixstep("file", "convert", *words, status=3 if refused else 2)
    assert message in done.stderr and done.stderr.count("pixstep: ") == 1
    assert done.stderr.splitlines()[-1].startswith("pixstep: ")
    assert (sorted(many.parent.iterdir()), many.read_bytes()) == before


def test_values_too_wide_for_a_csv_are_refused(pixstep, tmp_path):
    formats.write_prn(tmp_path / "x.PRN", [8, 1_000_000])
    output = pixstep("file", "convert", "x.PRN", "x.csv", "--decode", "plain", status=2).stderr
    assert output == (
        "pixstep: x.csv:2:1: value 1000000 does not fit 6 columns of a CSV: -99999..999999\n"
    )
    assert not (tmp_path / "x.csv").exists()


def test_a_header_is_made_changed_and_dropped(pixstep, tmp_path):
    date = "Mon Oct 12 15:13:35 2009"
    pixstep(
        "file", "convert", MPOS, "x.csv", "--header", "4editing1n", "--haps", 10, "--pixel-hz", 30,
        "--date", date,
    )  # fmt: skip
    read = formats.read_csv(tmp_path / "x.csv")
    assert read.header == replace(HEADER, haps=10)
    assert read.values == formats.read_csv(MPOS).values
    assert (tmp_path / "x.csv").read_bytes()[:168] == SAMPLE_CSV.read_bytes()[:168]
    done = pixstep("file", "convert", "x.csv", "y.csb", "--haps", 7, "--pixel-hz", "30000/1001")
    assert "note: x.csv: header: haps, pixel_hz changed" in done.stderr
    assert "note: x.csv: pixel frequency 30000/1001 Hz is written as 29.97002997" in done.stderr
    assert formats.read_motion(tmp_path / "y.csb").header == replace(
        HEADER, haps=7, pixel_hz="29.97002997"
    )
    done = pixstep("file", "convert", "y.csb", "z.csv", "--drop-header")
    assert "note: y.csb: header '4editing1n' dropped" in done.stderr
    assert (tmp_path / "z.csv").read_bytes() == MPOS.read_bytes()


def test_convert_says_that_line_ends_change(pixstep, tmp_path):
    (tmp_path / "lf.csv").write_bytes(MPOS.read_bytes().replace(b"\r\n", b"\n")[:-1])
    pixstep("file", "convert", "lf.csv", "x.csv", status=3)
    done = pixstep("file", "convert", "lf.csv", "x.csv", "--lenient")
    assert "note: lf.csv: line ends were LF, no newline at the end" in done.stderr
    assert (tmp_path / "x.csv").read_bytes() == MPOS.read_bytes()


@pytest.mark.parametrize(("name", "place"), [("many.csv", "3:11"), ("many.csb", "1:103")])
def test_line_check_of_one_line_of_many(pixstep, many, name, place):
    words = ("line", "check", name, "--decode", "smooth")
    assert pixstep(*words, status=2).stderr == (
        f"pixstep: {name}:{place}: holds 3 lines: choose one by --line 1..3\n"
    )
    assert "fine: 3 pixels, 24 steps" in pixstep(*words, "--line", 1).stdout
    report = json.loads(pixstep(*words, "--line", 2, "--json", status=3).stdout)
    assert report["line"] == 2 and report["pixels"] == 5


@pytest.mark.usefixtures("plan_program")
def test_ticks_of_csv_and_csb_are_the_same(pixstep, many):
    common = ("--decode", "smooth", "--pixel-hz", 30, "--line", 1)
    pixstep("ticks", "many.csv", *common, "-o", "text.csv")
    pixstep("ticks", "many.csb", *common, "-o", "binary.csv")
    text = (many.parent / "text.csv").read_text()
    assert text.count("\n") == 1 + sum(LINES[0])
    assert (many.parent / "binary.csv").read_text() == text


def test_sim_takes_a_line_number_for_each_file(pixstep, many):
    common = ("--board", "mega", "--decode", "smooth", "--pixel-hz", 30, "--out", "run")
    output = pixstep("sim", many, *common, status=2).stderr
    assert "choose one by --line 1..3" in output
    output = pixstep("sim", many, many, *common, "--line", 1, "--line", 2, status=3).stderr
    assert "many.csv line 2: line refused: " in output
    output = pixstep("sim", many, *common, "--line", 1, "--line", 2, status=2).stderr
    assert "--line is given 2 times for 1 line" in output


def test_a_profile_is_no_line(pixstep):
    output = pixstep("line", "check", PRN, "--decode", "smooth", status=3).stderr
    assert "looks like a PRN profile, not like a CSV file or CSB file" in output


def test_the_real_command_refuses_in_one_line(tmp_path):
    (tmp_path / "x.csv").write_bytes(b"     4\r\n    1\xb2\r\n")
    done = subprocess.run(
        [sys.executable, "-m", "pixstep", "file", "info", "x.csv"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 3 and done.stdout == ""
    assert done.stderr == ("pixstep: x.csv:2:6: '    1\\xb2' holds byte 0xB2, which is not ASCII\n")
