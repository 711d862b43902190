# SPDX-License-Identifier: MIT
"""The commands as a user types them: outputs, exit statuses, one-line errors."""

import json

import pytest

from pixstep import formats
from worked import ACCELERATING, PRN


def make(pixstep, *more, status=0):
    return pixstep(
        "line", "make", "--profile", PRN, "--speed", 1000, "--pixels", 60, "--pixel-hz", 30,
        "-o", "line.csv", *more, status=status,
    )  # fmt: skip


def put(path, counts):
    formats.write_csv(path, counts)
    return path


def test_make(pixstep, tmp_path):
    output = make(pixstep, "--backlash", 250)
    counts = list(formats.read_csv(tmp_path / "line.csv").values)
    assert counts[:17] == [0, *ACCELERATING, 1000] and len(counts) == 60
    assert "image from pixel 17" in output and "30000 steps/s" in output


def test_make_with_header_round_trips(pixstep, tmp_path):
    make(pixstep, "--header", "mine", "--lead-in", 3)
    read = formats.read_csv(tmp_path / "line.csv")
    assert read.header.name == "mine" and read.header.lead_in_px == 3
    assert len(read.values) == 60
    assert "fine" in pixstep("line", "check", "line.csv", "--decode", "smooth")


def test_make_refusals_are_one_line(pixstep, tmp_path):
    output = make(pixstep, "--speed", 1001, status=2)
    assert output.count("\n") == 1 and "nearest legal 1000 and 1002" in output
    assert not (tmp_path / "line.csv").exists()
    assert "No such file" in pixstep(
        "line", "make", "--profile", "no.PRN", "--speed", 2, "--pixels", 9, "--pixel-hz", 30,
        "-o", "x.csv", status=2,
    )  # fmt: skip


def test_check_exit_statuses(pixstep, tmp_path):
    good = put(tmp_path / "good.csv", [4, 12, 8])
    ripple = put(tmp_path / "ripple.csv", [501, 1000, 1000, 501])
    hazard = put(tmp_path / "hazard.csv", [10, 10, 10, 10])
    pixstep("line", "check", good, "--decode", "smooth")
    pixstep("line", "check", ripple, "--decode", "smooth", status=1)
    output = pixstep("line", "check", hazard, "--decode", "smooth", status=3)
    assert "pixel 1: error oscillates" in output and "put 5 before" in output
    pixstep("line", "check", hazard, "--decode", "plain")
    pixstep("line", "check", hazard, "--decode", "plain", "--backlash", 3, status=3)


def test_check_json(pixstep, tmp_path):
    hazard = put(tmp_path / "hazard.csv", [10, 10, 10, 10])
    report = json.loads(pixstep("line", "check", hazard, "--decode", "smooth", "--json", status=3))
    (found,) = report["findings"]
    assert report["verdict"] == "refused"
    assert (found["name"], found["pixel"], found["amplitude"], found["repair"]) == (
        "oscillates", 1, 10, [5],
    )  # fmt: skip


def test_misuse_is_status_two(pixstep, tmp_path):
    good = put(tmp_path / "good.csv", [4, 12, 8])
    pixstep("ticks", good, "--decode", "smooth", "--pixel-hz", "x", "-o", "t.csv", status=2)
    pixstep("line", "check", good, status=2)
    output = pixstep(
        "sim", good, good, "--board", "uno", "--decode", "smooth", "--pixel-hz", 30,
        "--out", "run", status=2,
    )  # fmt: skip
    assert "axis 1: the uno has 1" in output


def test_sim_uploads_nothing_that_the_host_refuses(pixstep, tmp_path):
    hazard = put(tmp_path / "hazard.csv", [10, 10, 10, 10])
    output = pixstep(
        "sim", hazard, "--board", "mega", "--decode", "smooth", "--pixel-hz", 30,
        "--out", "run", status=3,
    )  # fmt: skip
    assert "line refused: oscillates at pixel 1" in output
    assert not (tmp_path / "run").exists()


@pytest.mark.usefixtures("plan_program")
def test_ticks(pixstep, tmp_path):
    make(pixstep, "--backlash", 250)
    common = ("line.csv", "--decode", "smooth", "--pixel-hz", "30", "--backlash", 250)
    told = pixstep("ticks", *common, "-o", "ticks.csv")
    rows = (tmp_path / "ticks.csv").read_text().splitlines()
    assert told == f"ticks.csv: {len(rows) - 1} steps\n"
    assert rows[0] == "step,tick" and len(rows) == 1 + sum(
        formats.read_csv(tmp_path / "line.csv").values, 250
    )
    told = pixstep("ticks", *common, "--pixels", "-o", "pixels.csv")
    rows = (tmp_path / "pixels.csv").read_text().splitlines()
    assert told == f"pixels.csv: {len(rows) - 1} pixel edges\n"
    assert rows[16] == "16,8533333,4668"


@pytest.mark.usefixtures("plan_program")
def test_ticks_of_a_refused_line(pixstep, tmp_path):
    hazard = put(tmp_path / "hazard.csv", [10, 10, 10, 10])
    output = pixstep(
        "ticks", hazard, "--decode", "smooth", "--pixel-hz", 30, "-o", "t.csv", status=3
    )
    assert "line refused: oscillates at pixel 1" in output
    assert not (tmp_path / "t.csv").exists()


def test_line_check_and_file_check_agree_on_line_ends(invoke, tmp_path):
    (tmp_path / "lf.csv").write_text("     4\n    12\n     8\n")
    words = ("line", "check", "lf.csv", "--decode", "smooth")
    for done in (
        invoke(*words, status=3).stderr,
        invoke("file", "check", "lf.csv", status=3).stdout,
    ):
        assert "ends with LF, CR LF expected" in done and "(--lenient accepts it)" in done
    done = invoke(*words, "--lenient", "--json")
    assert json.loads(done.stdout)["verdict"] == "fine"
    assert "LF instead of CR LF" in done.stderr


def test_make_names_the_odd_profile_entry(pixstep, tmp_path):
    (tmp_path / "odd.PRN").write_bytes(b"".join(b"%8d\r\n" % value for value in (8, 15, 24)))
    output = pixstep(
        "line", "make", "--profile", "odd.PRN", "--speed", 20, "--pixels", 9, "--pixel-hz", 30,
        "-o", "line.csv", status=3,
    )  # fmt: skip
    assert output.count("\n") == 1
    assert "odd.PRN:2: speed 15 is odd, nearest legal 14 and 16" in output
    assert not (tmp_path / "line.csv").exists()
