# SPDX-License-Identifier: MIT
"""Readers as strict as the formats, every refusal naming file, line and value."""

import pytest

from pixstep import formats
from pixstep.errors import UserError
from worked import MPOS, PRN, SAMPLE_CSV

HEADER = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "4editing1n", 1, 10, 0, "30")


@pytest.fixture
def put(put):
    """Return a function that writes bytes and returns the path."""
    return lambda data, name="x.PRN": put(data, name)


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
        (b"     8\r\n    16\r\n", ":1:1: '     8' looks like a CSV profile"),
        (SAMPLE_CSV.read_bytes(), "looks like a CSV profile"),
        (b"       8\n", ":1:9: '       8' ends with LF, CR LF expected"),
        (b"       8", ":1:9: '       8' has no CR LF after it"),
        (b"       8\r", ":1:10: '       8\\r' has no CR LF after it"),
        (b"       8\r       9\r\n", ":1:9: '       8\\r       9' holds a CR that no LF follows"),
        (b"       8\r\r\n", ":1:9: '       8\\r' holds a CR that no LF follows"),
        (b"      +8\r\n", ":1:7: '      +8' has a sign, values are unsigned"),
        (b"      -8\r\n", ":1:7: '      -8' has a sign, values are unsigned"),
        (b"\t      8\r\n", ":1:1: '\\t      8' holds a tab"),
        (b"       8\r\n        \r\n", ":2:1: empty record '        '"),
        (b"       8\r\n\r\n", ":2:1: empty record ''"),
        (b"100000000\r\n", ":1:1: '100000000' is above 99999999"),
        (b"       8\r\n      16 \r\n", ":2:9: '      16 ' is 9 columns wide, not 8"),
        (b"       8\r\n     16\r\n", ":2:8: '     16' is 7 columns wide, not 8"),
        (b"       8\r\n       8\r\n    16\r\n", ":3:7: '    16' is 6 columns wide, not 8: looks"),
        (b"8       \r\n", ":1:2: '8       ' is not right-aligned"),
        (b"     8.0\r\n", ":1:7: '     8.0' is not an unsigned decimal integer"),
        (b"       8\r\n     x16\r\n", ":2:6: '     x16'"),
        (b"00000008\r\n", ":1:1: '00000008' has a leading zero"),
        (b"", ":1:1: the file is empty"),
        (b"      \xb28\r\n", ":1:7: '      \\xb28' holds byte 0xB2, which is not ASCII"),
        (b"       8\r\n\x1a", ":2:1: '\\x1a' holds byte 0x1A, the end-of-file mark of DOS"),
        (b"CSB1\x00\x00", "looks like a CSB file, not like a PRN profile"),
    ],
)
def test_bad_prn_is_refused(put, data, message):
    path = put(data)
    with pytest.raises(UserError) as caught:
        formats.read_prn(path)
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{path}:")


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
    assert len(read.values) == 19 and sum(read.values) == 7418
    assert read.values[:4] == (0, 4, 12, 20) and read.header is None and read.notes == ()


def test_sample_csv_is_truncated():
    with pytest.raises(UserError, match=r"sample\.csv:6:4: truncated, 3 of 100 values of line 1"):
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


def damaged(old: bytes, new: bytes) -> bytes:
    """Return the sample CSV with a part of it replaced, which must be there."""
    sample = SAMPLE_CSV.read_bytes()
    assert old in sample
    return sample.replace(old, new)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"       8\r\n", ":1:1: '       8' looks like a PRN profile"),
        (b"     8\r\n   1.5\r\n", ":2:5: '   1.5' is not an integer right-aligned in 6 columns"),
        (b"     8\r\n\t    9\r\n", ":2:1: '\\t    9' holds a tab"),
        (b"     8\r\n\r\n", ":2:1: empty record ''"),
        (b"     8\r\n     9 \r\n", ":2:7: '     9 ' is 7 columns wide, not 6"),
        (b"8     \r\n", ":1:2: '8     ' is not right-aligned"),
        (b"    +8\r\n", ":1:5: '    +8' has a sign, only a minus sign is legal"),
        (b"     8\r\n   --8\r\n", ":2:5: '   --8' is not an integer"),
        (b"     8\r\n     -\r\n", ":2:6: '     -' is a sign without a number"),
        (b"     8\r\n    -0\r\n", ":2:5: '    -0' has a leading zero"),
        (b"     8\r\n    08\r\n", ":2:5: '    08' has a leading zero"),
        (b"     8\r\n1000000\r\n", ":2:1: '1000000' is above 999999"),
        (b"     8,\r\n", ":1:7: '     8,' is 7 columns wide, not 6"),
        (damaged(b"Lines:    1", b"Lines:    2"), ":3:11: truncated, 1 of 2 lines"),
        (damaged(b"Lines:    1", b"Lines:    0"), ":3:11: '    0': at least 1 line"),
        (damaged(b"Lines:    1", b"Lines:1    "), ":3:7: '1    ': Lines is not a right-aligned"),
        (damaged(b"Lines:    1", b"Lines:   -1"), ":3:10: '   -1': Lines is not a right-aligned"),
        (damaged(b"Lines:    1", b"Lines:   01"), ":3:10: '   01': Lines is not a right-aligned"),
        (damaged(b"HAPs:  10", b"HAPs:1 10"), ":3:20: '1 10': HAPs is not a right-aligned"),
        (damaged(b"LeadIn:     0", b"LeadIn:      "), ":3:35: '      ': LeadIn is not"),
        (damaged(b"Lines:", b"Line :"), ":3:1: 'Line :': expected 'Lines:' at column 1"),
        (damaged(b"HAPs:", b"Haps:"), ":3:15: 'Haps:': expected 'HAPs:' at column 15"),
        (damaged(b"LeadIn:", b"Leadin:"), ":3:28: 'Leadin:': expected 'LeadIn:' at column 28"),
        (damaged(b"1   HAPs", b"1 . HAPs"), ":3:13: ' . ': columns 12 to 14 must be blank"),
        (damaged(b"10    LeadIn", b"10.   LeadIn"), ":3:24: '.   ': columns 24 to 27 must"),
        (damaged(b"PROFILE", b"PROF1LE"), ":2:1: 'ACCELERATION PROF1LE': expected"),
        (damaged(b" Mon Oct", b"xMon Oct"), ":1:16: '               x': columns 1 to 16 must"),
        (damaged(b"2009\r", b"2009 \r"), ":1:41: header line"),
        (damaged(b"Mon Oct", b"Moo Oct"), ":1:17: 'Moo Oct 12 15:13:35 2009': expected a ctime"),
        (damaged(b"      30\r", b"    30.x\r"), ":4:37: '                     30.x': pixel freq"),
        (damaged(b"      30\r", b"       0\r"), ":4:40: '                        0': pixel freq"),
        (
            damaged(b"editing1n\r", b"editing1 \r"),
            ":2:31: '          4editing1 ': the profile name is not",
        ),
        (damaged(b"editing1n\r", b"edit\xefng1n\r"), ":2:36:"),
        (SAMPLE_CSV.read_bytes()[:84], ":2:1: the header has 4 lines, only 2 here"),
        (SAMPLE_CSV.read_bytes()[:168], ":4:41: no values"),
        (SAMPLE_CSV.read_bytes()[:176], ":5:6: truncated: line number 1 without its number of"),
        (SAMPLE_CSV.read_bytes()[:184], ":6:4: truncated, 0 of 100 values of line 1"),
        (damaged(b"   100\r", b"     2\r"), ":9:6: 1 row more than the 2 values announced"),
        (damaged(b"   100\r", b"     0\r"), ":6:6: number of values 0, at least 1 expected"),
        (damaged(b"   100\r", b"    -3\r"), ":6:5: number of values -3, at least 1 expected"),
        (damaged(b"     1\r", b"     7\r"), ":5:6: line number 7, 1 expected"),
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
