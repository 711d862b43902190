# SPDX-License-Identifier: MIT
"""Readers as strict as the formats, every refusal naming file, line and value."""

import pytest

from pixstep import formats
from pixstep.errors import UserError
from worked import MPOS, PRN, SAMPLE_CSV

HEADER = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "4editing1n", 1, 10, 0, "30")


@pytest.fixture
def put(tmp_path):
    """Return a function that writes bytes and returns the path."""

    def write(data: bytes, name: str = "x.PRN"):
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write


def test_sample_prn():
    values, notes = formats.read_prn(PRN)
    assert values == [
        8,
        16,
        24,
        32,
        38,
        44,
        128,
        172,
        256,
        384,
        512,
        640,
        768,
        896,
        1024,
        1152,
        1280,
    ]
    assert notes == []


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"     8\r\n    16\r\n", "looks like a CSV profile"),
        (SAMPLE_CSV.read_bytes(), "looks like a CSV profile"),
        (b"       8\n", "CR LF expected"),
        (b"       8", "CR LF"),
        (b"      +8\r\n", "sign"),
        (b"      -8\r\n", "sign"),
        (b"\t      8\r\n", "tab"),
        (b"       8\r\n        \r\n", ":2: empty record"),
        (b"       8\r\n\r\n", ":2: empty record"),
        (b"100000000\r\n", "above 99999999"),
        (b"       8\r\n      16 \r\n", ":2:"),
        (b"8       \r\n", "right-aligned"),
        (b"     8.0\r\n", "not an unsigned decimal integer"),
        (b"       8\r\n     x16\r\n", ":2:"),
        (b"", "empty"),
        (b"      \xb28\r\n", "not ASCII"),
    ],
)
def test_bad_prn_is_refused(put, data, message):
    path = put(data)
    with pytest.raises(UserError) as caught:
        formats.read_prn(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_lenient_prn_says_what_it_tolerated(put):
    values, notes = formats.read_prn(put(b"       8\n      16"), lenient=True)
    assert values == [8, 16]
    assert any("LF" in note for note in notes)
    assert any("no newline" in note for note in notes)


def test_missing_file_is_one_line():
    with pytest.raises(UserError, match=r"nowhere\.PRN: No such file"):
        formats.read_prn("nowhere.PRN")


def test_bare_csv():
    read = formats.read_csv(MPOS)
    assert read.values[:4] == (0, 4, 12, 20) and read.header is None and read.notes == ()


def test_sample_csv_is_truncated():
    with pytest.raises(UserError, match="truncated, 3 of 100"):
        formats.read_csv(SAMPLE_CSV)
    read = formats.read_csv(SAMPLE_CSV, raw=True)
    assert read.values == (1, 100, 2, 4, 5)
    assert read.header == HEADER


def test_csv_round_trip(tmp_path):
    path = tmp_path / "line.csv"
    counts = [0, 5, -7, 32767, 0]
    formats.write_csv(path, counts)
    assert path.read_bytes() == b"     0\r\n     5\r\n    -7\r\n 32767\r\n     0\r\n"
    assert list(formats.read_csv(path).values) == counts
    formats.write_csv(path, counts, HEADER)
    read = formats.read_csv(path)
    assert list(read.values) == counts and read.header == HEADER
    assert path.read_bytes().startswith(SAMPLE_CSV.read_bytes()[:168])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"       8\r\n", "looks like a PRN profile"),
        (b"     8\r\n   1.5\r\n", ":2:"),
        (b"     8\r\n\t    9\r\n", "tab"),
        (b"     8\r\n\r\n", "empty record"),
        (b"8     \r\n", "right-aligned"),
        (b"    +8\r\n", "right-aligned"),
        (b"     8,\r\n", "columns wide"),
        (SAMPLE_CSV.read_bytes().replace(b"Lines:    1", b"Lines:    2"), "2 lines"),
        (SAMPLE_CSV.read_bytes().replace(b"Lines:", b"Line :"), "'Lines:' at column 1"),
        (SAMPLE_CSV.read_bytes().replace(b"2009\r", b"2009 \r"), "41 columns"),
        (SAMPLE_CSV.read_bytes().replace(b"Mon Oct", b"Moo Oct"), "ctime"),
        (SAMPLE_CSV.read_bytes()[:84], "only 2"),
        (SAMPLE_CSV.read_bytes()[:168], "no values"),
        (SAMPLE_CSV.read_bytes().replace(b"   100\r", b"     2\r"), "1 rows more"),
        (SAMPLE_CSV.read_bytes().replace(b"     1\r", b"     7\r"), "line number 7"),
    ],
)
def test_bad_csv_is_refused(put, data, message):
    with pytest.raises(UserError) as caught:
        formats.read_csv(put(data, "x.csv"))
    assert message in str(caught.value)


def test_csv_with_lf_is_noted(put):
    read = formats.read_csv(put(b"     1\n     2\n"))
    assert read.values == (1, 2) and "LF" in read.notes[0]


def test_value_too_wide_to_write(tmp_path):
    with pytest.raises(UserError, match="6 columns"):
        formats.write_csv(tmp_path / "x.csv", [1_000_000])
    assert not list(tmp_path.iterdir())
