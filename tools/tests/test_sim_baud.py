# SPDX-License-Identifier: MIT
"""`pixstep sim --baud`: lines with a count of their own in each pixel, as fast as they are sent."""

import json
import random

import pytest

PIXELS = 700  # the queues hold some 370


@pytest.fixture
def lines(tmp_path):
    """Return the files of four plain lines of random counts."""
    rng = random.Random(3)
    names = []
    for axis in range(4):
        path = tmp_path / f"axis{axis}.csv"
        counts = [rng.randint(1, 20) for _ in range(PIXELS)]
        path.write_bytes(b"".join(b"%6d\r\n" % count for count in counts))
        names.append(path)
    return names


def words(lines, *more):
    # Beyond what is guaranteed: so many counts a second.
    fixed = ("--decode", "plain", "--board", "mega", "--out", "run", "--beyond")
    return ("sim", *lines, *fixed, *more)


@pytest.mark.usefixtures("simulator")
def test_four_axes_of_own_counts_at_a_kilohertz(lines, tmp_path, invoke):
    invoke(*words(lines, "--pixel-hz", "1000", "--baud", "250000"))
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["verdict"] == "pass"
    assert [axis["pixels_equal"] for axis in summary["axes"]] == 4 * [PIXELS]


@pytest.mark.usefixtures("simulator")
def test_a_line_too_slow_for_the_counts_is_named(lines, invoke):
    done = invoke(*words(lines, "--pixel-hz", "1000", "--baud", "38400"), status=1)
    assert "fault starved" in done.output


def test_a_rate_that_the_setting_cannot_hold(lines, invoke):
    done = invoke(*words(lines[:1], "--pixel-hz", "100", "--baud", "115250"), status=2)
    assert "--baud: 115250: a multiple of 100 is wanted" in done.output


@pytest.mark.usefixtures("simulator")
def test_a_slow_serial_line_reads_fewer_records_and_none_too_late(lines, tmp_path, invoke):
    invoke(*words(lines, "--pixel-hz", "80", "--baud", "9600"))
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["verdict"] == "pass"
    assert summary["record_every"] > 1
