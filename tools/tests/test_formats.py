# SPDX-License-Identifier: MIT
"""Every decision about files, each by the number that the specification gives it."""

import struct
import zlib
from dataclasses import replace
from fractions import Fraction

import pytest
from click.testing import CliRunner

from mutants import HEADER, LINES, sealed
from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.formats import describe
from pixstep.formats.files import examine, recognise
from pixstep.formats.findings import LENIENT, MAX_FINDINGS, WARNING
from pixstep.formats.records import MAX_BYTES
from worked import ACCELERATING, DATA, MPOS, PRN, SAMPLE_CSV

SAMPLE_HEADER = replace(HEADER, haps=10)


def refusal(read, *arguments, **options):
    """Return the text of the error that a reader raises."""
    with pytest.raises(UserError) as caught:
        read(*arguments, **options)
    return str(caught.value)


def found(path, rules=LENIENT):
    """Return what is found in a file as (name, severity, line, column)."""
    return [
        (item.name, item.severity, item.line, item.column)
        for item in examine(path, rules).findings.in_order()
    ]


@pytest.mark.parametrize("path", sorted(DATA.iterdir()), ids=lambda path: path.name)
def test_every_data_file_is_written_back_byte_by_byte(path):
    assert formats.encode(formats.read_any(path, lenient=True)) == path.read_bytes()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"     1\r\n     2\r\n", "CR LF"),
        (b"     1\n     2\n", "LF"),
        (b"     1", "CR LF, no newline at the end"),
        (b"     1\r\n     2\r", "CR LF, no newline at the end"),
        (b"     1\n     2", "LF, no newline at the end"),
        (b"     1\r\n     2\n     3\r\n", "CR LF, LF after 1 record"),
        (b"     1\r\n     2\r\n     3\n", "CR LF, LF after 1 record"),
        (b"     1\n     2\n     3\r\n", "LF, CR LF after 1 record"),
        (b"     1\n     2\n     3\r\n     4\r", "LF, CR LF after 1 record, no newline at the end"),
    ],
)
def test_line_ends_are_kept_and_named(put, data, words):
    path = put(data)
    assert formats.encode(formats.read_any(path, lenient=True)) == data
    assert describe.describe(path)["line_ends"] == words


# 1.2: the meaning of a number depends on motor and file


def test_1_2_first_prn_entry_8():
    """A smooth motor moves 4 steps and ends at speed 8, a plain one moves 8 steps."""
    assert describe.smooth_steps((8,)) == 4
    facts = describe.describe(PRN)
    assert facts["values_mean"]["smooth"] == "speed at the end of the pixel, steps/pixel"
    assert facts["values_mean"]["plain"] == "steps moved in the pixel, which is its speed"
    assert facts["lines"][0]["steps_plain"] == 7374
    # The worked example's 14 whole entries below 1000: its 15 counts without the last, partial one.
    speeds = formats.read_any(PRN).values
    assert describe.smooth_steps(speeds[:14]) == sum(ACCELERATING[:14])


@pytest.mark.parametrize("kind", ["csv", "csb"])
def test_1_2_csv_and_csb_hold_steps_for_every_motor(kind):
    assert describe.VALUES[kind] == ("steps moved in the pixel", "steps moved in the pixel")


def test_1_2_no_meaning_is_converted_unasked(tmp_path):
    """From PRN to CSV the numbers stay right for a plain motor only."""
    target = tmp_path / "out.csv"
    words = ["file", "convert", str(PRN), str(target)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2 and "--decode plain says that the motor is plain" in done.stderr
    assert not target.exists()
    assert CliRunner().invoke(main, [*words, "--decode", "plain"]).exit_code == 0
    assert formats.read_csv(target).values == formats.read_any(PRN).values


# 1.3: PRN


def test_1_3_prn_sample():
    values = "8 16 24 32 38 44 128 172 256 384 512 640 768 896 1024 1152 1280"
    assert formats.read_prn(PRN) == ([int(text) for text in values.split()], [])


def test_1_3_prn_records_are_ten_bytes(tmp_path):
    formats.write_prn(tmp_path / "x.PRN", [8, 99_999_999, 0])
    expected = b"       8\r\n99999999\r\n       0\r\n"
    assert (tmp_path / "x.PRN").read_bytes() == expected and len(expected) == 3 * 10


def test_1_3_prn_lenient_accepts_lf_and_a_missing_final_newline_and_says_so(put):
    path = put(b"       8\n      16", "x.PRN")
    values, notes = formats.read_prn(path, lenient=True)
    assert values == [8, 16]
    assert notes == [
        f"{path}:1:9: LF instead of CR LF after 1 record: accepted",
        f"{path}:2:9: no newline after the last record '      16': accepted",
    ]
    assert f"{path}:1:9: '       8' ends with LF, CR LF expected" in refusal(formats.read_prn, path)


def test_1_3_prn_lenient_accepts_nothing_else(put):
    for record in (b"\t      8", b"      +8", b"      -8", b"        ", b"", b"100000000", b"8"):
        path = put(b"       8\r\n" + record + b"\r\n", "x.PRN")
        assert f"{path}:2:" in refusal(formats.read_prn, path, lenient=True)


@pytest.mark.parametrize("lenient", [False, True])
def test_1_3_six_wide_prn_is_refused_by_name(put, lenient):
    path = put(b"     8\r\n    16\r\n", "AccProfM39-30Hz-1.PRN")
    assert "looks like a CSV profile" in refusal(formats.read_prn, path, lenient=lenient)
    words = ["file", "check", str(path), *(["--lenient"] if lenient else [])]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 3 and "looks like a CSV profile" in done.stdout


def test_1_3_smooth_prn_is_even_above_zero_and_never_falls(put):
    data = b"".join(b"%8d\r\n" % value for value in (0, 8, 8, 15, 12, 20))
    path = put(data, "x.PRN")
    done = CliRunner().invoke(main, ["file", "check", str(path), "--decode", "smooth"])
    assert done.stdout.splitlines() == [
        f"{path}:1:8: error: speed 0: the speeds of a smooth motor are above 0",
        f"{path}:4:7: error: speed 15 of a smooth motor is odd, nearest legal 14 and 16",
        f"{path}:5:7: error: speed falls from 15 to 12",
        f"{path}: refused: PRN profile",
    ]
    assert CliRunner().invoke(main, ["file", "check", str(path)]).exit_code == 0
    assert (
        CliRunner().invoke(main, ["file", "check", str(PRN), "--decode", "smooth"]).exit_code == 0
    )


# 1.3: CSV


def test_1_3_header_columns_of_the_sample():
    lines = SAMPLE_CSV.read_bytes().split(b"\r\n")[:4]
    assert [len(line) for line in lines] == [40] * 4
    read = formats.read_csv(SAMPLE_CSV, raw=True)
    assert read.header == SAMPLE_HEADER
    assert [row.encode() for row in read.header.rows] == lines


def test_1_3_every_header_field_is_read_from_its_columns(put):
    header = formats.ProfileHeader(
        "Sat Feb 29 23:59:60 2020", "a name of 20 columns", 1, 9999, 999_999, "29.97002997"
    )
    path = put(formats.encode(formats.of_lines([[1]], header)))
    rows = path.read_bytes().split(b"\r\n")
    assert rows[0][16:40] == b"Sat Feb 29 23:59:60 2020" and not rows[0][:16].strip()
    assert rows[1] == b"ACCELERATION PROFILEa name of 20 columns"
    assert rows[2] == b"Lines:    1   HAPs:9999    LeadIn:999999"
    assert rows[2][6:11] == b"    1" and rows[2][19:23] == b"9999" and rows[2][34:40] == b"999999"
    assert rows[3] == b"Pixel Frequency              29.97002997"
    read = formats.read_csv(path)
    assert read.header == header and read.header.frequency == Fraction("29.97002997")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "x" * 21}, ":2:21: profile name 'xxxxxxxxxxxxxxxxxxxxx' is longer than 20"),
        ({"name": "m\xfcller"}, ":2:21: 'm\\xfcller': only printable ASCII"),
        ({"name": "a\nb"}, ":2:39:"),
        ({"name": "blank "}, ":2:35: '              blank ': the profile name is not right"),
        ({"name": " blank"}, ":2:21: ' blank'"),
        ({"haps": 10_000}, ":3:20: HAPs '10000' is longer than 4"),
        ({"haps": -1}, ":3:22: '  -1': HAPs is not"),
        ({"lead_in_px": 1_000_000}, ":3:35: LeadIn '1000000' is longer than 6"),
        ({"timestamp": "yesterday"}, ":1:32: "),
        ({"pixel_hz": "0"}, ":4:40: "),
        ({"pixel_hz": "1e3"}, ":4:38: "),
    ],
)
def test_1_3_a_header_that_cannot_be_read_back_is_not_written(tmp_path, change, message):
    path = tmp_path / "x.csv"
    text = refusal(formats.write_csv, path, [1], replace(HEADER, **change))
    assert text.startswith(f"{path}{message}"), text
    assert not list(tmp_path.iterdir())


def test_1_3_data_are_six_columns_and_a_minus_sign_is_legal(put):
    path = put(b"-99999\r\n999999\r\n     0\r\n")
    read = formats.read_csv(path)
    assert read.values == (-99_999, 999_999, 0)
    assert formats.encode(read) == path.read_bytes()


@pytest.mark.parametrize("value", [-100_000, 1_000_000])
def test_1_3_a_value_too_wide_is_not_written(tmp_path, value):
    path = tmp_path / "x.csv"
    text = refusal(formats.write_csv, path, [1, value])
    assert text.startswith(f"{path}:2:1: value {value} does not fit 6 columns of a CSV")
    text = refusal(formats.write_prn, path, [1, 2, -1])
    assert text.startswith(f"{path}:3:1: value -1 does not fit 8 columns of a PRN")
    assert not list(tmp_path.iterdir())


def test_1_3_generated_motion_file_is_one_value_a_pixel():
    read = formats.read_motion(MPOS)
    assert read.values == (0, *ACCELERATING, 1000, 1000, 1000) and read.header is None


def test_a_date_that_no_calendar_has_is_a_warning(put):
    sample = formats.encode(formats.of_lines([[4, 5]], HEADER))
    assert found(put(sample)) == []
    assert found(put(sample.replace(b"Mon Oct 12", b"Tue Oct 12"))) == [
        ("timestamp", WARNING, 1, 17)
    ]
    assert found(put(sample.replace(b"Mon Oct 12", b"Mon Feb 30"))) == [
        ("timestamp", WARNING, 1, 17)
    ]


# 1.12: ambiguities


def test_q1_line_number_then_number_of_values_then_values(put):
    path = put(SAMPLE_CSV.read_bytes().replace(b"   100\r", b"     3\r"))
    read = formats.read_csv(path)
    assert read.values == (2, 4, 5) and read.reading == "blocks"
    assert read.rows == [1, 3, 2, 4, 5]


def test_q1_sample_is_truncated_3_of_100():
    message = f"{SAMPLE_CSV}:6:4: truncated, 3 of 100 values of line 1"
    assert refusal(formats.read_csv, SAMPLE_CSV).startswith(message)
    read = formats.read_csv(SAMPLE_CSV, lenient=True)
    assert read.values == (2, 4, 5) and read.line().declared == 100 and read.line().truncated
    assert f"{message}: accepted" in read.notes
    assert formats.encode(read) == SAMPLE_CSV.read_bytes()


def test_q1_raw_takes_every_row_as_a_value():
    read = formats.read_csv(SAMPLE_CSV, raw=True)
    assert read.values == (1, 100, 2, 4, 5)
    assert formats.encode(read) == SAMPLE_CSV.read_bytes()


def test_q1_many_lines(put):
    path = put(formats.encode(formats.of_lines(LINES, HEADER)))
    read = formats.read_motion(path, strict=True)
    assert [list(block.values) for block in read.blocks] == list(LINES)
    assert read.line(2).values == tuple(LINES[1]) and read.header.lines == 3
    assert formats.encode(read) == path.read_bytes()
    assert f"{path}:3:11: holds 3 lines" in refusal(formats.read_csv, path)
    assert f"{path}:3:11: holds 3 lines, there is no line 4" in refusal(read.line, 4)


@pytest.mark.parametrize(
    ("rows", "lines", "message"),
    [
        ((1, 2, 4, 4, 3, 1, 9), 2, ":9:6: line number 3, 2 expected"),
        ((1, 2, 4, 4, 2, 1, 9), 1, ":9:6: 3 rows more than the 2 values announced for line 1"),
        ((1, 2, 4, 4, 2), 2, ":9:6: truncated: line number 2 without its number of values"),
        ((1, 2, 4, 4, 2, 3, 9), 2, ":10:6: truncated, 1 of 3 values of line 2"),
        ((1, 2, 4, 4), 2, ":3:11: truncated, 1 of 2 lines"),
        ((2, 2, 4, 4), 1, ":5:6: line number 2, 1 expected"),
    ],
)
def test_q1_lines_must_be_as_announced(put, rows, lines, message):
    header = replace(HEADER, lines=lines).rows
    data = "".join(f"{text}\r\n" for text in (*header, *(f"{row:6d}" for row in rows)))
    path = put(data.encode())
    text = refusal(formats.read_motion, path)
    assert text.startswith(f"{path}{message}"), text
    assert formats.read_motion(path, raw=True).values == rows


def test_q1_info_shows_both_readings(put):
    facts = describe.describe(SAMPLE_CSV)
    assert facts["lines"][0] == {
        "line": 1, "values": 3, "announced": 100, "minimum": 2, "maximum": 5, "steps": 11,
    }  # fmt: skip
    assert facts["other_readings"] == ["raw: 5 values, 1 to 100, 112 steps"]
    fragment = put(SAMPLE_CSV.read_bytes()[:168] + b"    10\r\n" * 3)
    facts = describe.describe(fragment)
    assert facts["lines"][0]["values"] == 3 and facts["lines"][0]["steps"] == 30
    assert "numbered blocks: refused" in facts["other_readings"][0]
    assert "line number 10, 1 expected" in facts["other_readings"][0]


def test_q1_rows_without_a_header_that_look_like_a_block_are_pointed_at(put):
    path = put(b"     1\r\n     2\r\n     8\r\n     9\r\n")
    assert formats.read_csv(path).values == (1, 2, 8, 9)
    assert found(path) == [("could_be_blocks", WARNING, 1, 1)]
    for rows in ((1, 3, 8, 9), (2, 2, 8, 9), (1, 0)):
        assert found(put(b"".join(b"%6d\r\n" % row for row in rows))) == []


def test_q2_csb_byte_by_byte():
    sample = formats.read_csv(SAMPLE_CSV, lenient=True)
    data = formats.encode(replace(sample, kind="csb"))
    assert data[:4] == b"CSB1"
    assert data[4:8] == bytes([168, 0, 0, 0])
    assert data[8:176] == SAMPLE_CSV.read_bytes()[:168]
    assert data[176:196] == struct.pack("<5i", 1, 100, 2, 4, 5)
    assert data[196:] == zlib.crc32(data[:196]).to_bytes(4, "little")


def test_q2_csb_smallest_file_written_out(tmp_path):
    path = tmp_path / "x.csb"
    file = replace(formats.of_lines([[4, -7]]), kind="csb")
    formats.write_motion(path, file)
    assert path.read_bytes().hex(" ") == "43 53 42 31 00 00 00 00 04 00 00 00 f9 ff ff ff " + (
        zlib.crc32(path.read_bytes()[:-4]).to_bytes(4, "little").hex(" ")
    )
    assert formats.read_motion(path).values == (4, -7)
    assert "looks like a CSB file, not like a CSV" in refusal(formats.read_csv, path)


@pytest.mark.parametrize(
    "file",
    [
        formats.of_lines([[1, -2, 3]]),
        formats.of_lines([[1, -2, 3]], HEADER),
        formats.of_lines(LINES, HEADER),
        formats.read_csv(SAMPLE_CSV, lenient=True),
        formats.read_csv(SAMPLE_CSV, raw=True),
    ],
    ids=["bare", "one", "many", "truncated", "raw"],
)
def test_q2_csv_and_csb_are_twins(put, file):
    csv = put(formats.encode(file))
    raw = file.reading == "raw"
    csb = put(formats.encode(replace(file, kind="csb")), "x.csb")
    twin = formats.read_motion(csb, lenient=True, raw=raw)
    assert (twin.blocks, twin.header, twin.reading) == (file.blocks, file.header, file.reading)
    assert formats.encode(twin) == csb.read_bytes()
    assert formats.encode(replace(twin, kind="csv")) == csv.read_bytes()


def test_q2_csb_holds_what_a_csv_cannot(put):
    path = put(formats.encode(replace(formats.of_lines([[2**31 - 1]]), kind="csb")), "x.csb")
    read = formats.read_motion(path)
    assert read.values == (2**31 - 1,)
    text = refusal(formats.encode, replace(read, kind="csv"), "out.csv")
    assert text.startswith("out.csv:1:1: value 2147483647 does not fit 6 columns")
    text = refusal(formats.encode, replace(formats.of_lines([[1, 2**31]]), kind="csb"), "o.csb")
    assert text == "o.csb:1:13: value 2147483648 does not fit 32 bits"


def test_q2_damaged_and_foreign_csb_are_refused_by_name(put):
    good = formats.encode(replace(formats.of_lines(LINES, HEADER), kind="csb"))
    for data, message in (
        (b"CSB2" + good[4:], "is not the magic 'CSB1'"),
        (good[:10], "truncated: 10 bytes, a CSB has at least 12"),
        (good[:-1], "the file is damaged or cut short"),
        (good + b"\0", "the file is damaged or cut short"),
    ):
        assert message in refusal(formats.read_motion, put(data, "x.csb"), lenient=True)


def test_q2_wrong_lengths_are_refused_even_with_a_right_checksum(put):
    header = formats.encode(formats.of_lines([[1]], HEADER))[:168]
    row = struct.pack("<i", 7)
    for body, message in (
        (struct.pack("<I", 42) + header[:42] + row, ":1:5: header text of 42 bytes, 0 or 168"),
        (
            struct.pack("<I", 168) + header[:84],
            ":1:93: truncated: header text of 168 bytes announced",
        ),
        (struct.pack("<I", 0) + row + b"\0", ":1:9: 5 bytes of data are not a whole number"),
        (struct.pack("<I", 0), ":1:9: no values"),
        (struct.pack("<I", 168) + header, ":1:177: no values"),
        (struct.pack("<I", 168) + header.replace(b"\r\n", b"\n\r") + row, ":1:49: '\\n\\r' after"),
        (struct.pack("<I", 168) + header.replace(b"HAPs", b"haps") + row, ":1:107: 'haps:': exp"),
    ):
        path = put(sealed(b"CSB1" + body), "x.csb")
        assert refusal(formats.read_motion, path).startswith(f"{path}{message}"), message


def test_q4_haps_are_leading_entries_usable_in_homing(put):
    facts = describe.describe(SAMPLE_CSV)
    assert facts["header"]["HAPs"] == {
        "value": 10, "meaning": "homing acceleration pixels: leading entries usable in homing",
    }  # fmt: skip
    enough = put(formats.encode(formats.of_lines([[4, 12]], HEADER)))
    assert HEADER.haps == 2 and found(enough) == []
    few = put(formats.encode(formats.of_lines([[4, 12], [4]], HEADER)))
    assert found(few) == [("haps", WARNING, 3, 23)]
    assert formats.read_motion(few).notes == (
        f"{few}:3:23: HAPs 2 are more than the 1 value of a line",
    )


def test_q5_lead_in_zero_is_the_configured_one():
    field = describe.describe(SAMPLE_CSV)["header"]["LeadIn"]
    assert field["value"] == 0
    assert field["meaning"].startswith("constant-speed pixels before the first image pixel; 0: as")


def test_q12_negative_backlash_is_refused(tmp_path):
    done = CliRunner().invoke(
        main,
        ["line", "check", str(MPOS), "--decode", "smooth", "--backlash", "-1"],
    )
    assert done.exit_code == 2 and "-1 is not in the range x>=0" in done.stderr


def test_q13_values_above_99999999_are_refused(put):
    path = put(b"99999999\r\n100000000\r\n", "x.PRN")
    message = f"{path}:2:1: '100000000' is above 99999999, the most that 8 columns hold"
    for lenient in (False, True):
        assert refusal(formats.read_prn, path, lenient=lenient) == message


# Recognition, bounds


@pytest.mark.parametrize(
    ("data", "kind", "why"),
    [
        (PRN.read_bytes(), "prn", "17 of the first 17 records are numbers in 8 columns"),
        (MPOS.read_bytes(), "csv", "19 of the first 19 records are numbers in 6 columns"),
        (SAMPLE_CSV.read_bytes(), "csv", "its first line is 40 columns wide, as a header is"),
        (SAMPLE_CSV.read_bytes()[1:], "csv", "its first line is text, as a header is"),
        (b"CSB9....", "csb", "begins with 'CSB9'"),
        (b"    8\r\n    16\r\n", "csv", "1 of the first 2 records are numbers in 6 columns"),
        (b"8\r\n16\r\n", None, "'8' is 1 columns wide: neither"),
    ],
)
def test_formats_are_recognised_by_content(data, kind, why):
    recognised = recognise(data)
    assert recognised.kind == kind and recognised.why.startswith(why)


def test_a_name_that_says_another_format_is_found(put):
    for name, status, lenient_status in (("x.csb", 3, 1), ("x.PRN", 3, 3), ("x.txt", 0, 0)):
        path = put(MPOS.read_bytes(), name)
        assert CliRunner().invoke(main, ["file", "check", str(path)]).exit_code == status
        done = CliRunner().invoke(main, ["file", "check", str(path), "--lenient"])
        assert done.exit_code == lenient_status, done.output


def test_a_huge_record_makes_a_short_message(put):
    for record in (b"1" * 1_000_000, b" " * 1_000_000, b"\xff" * 1_000_000, b"a" * 1_000_000):
        for kind in (b"       8\r\n", b"     8\r\n", SAMPLE_CSV.read_bytes()[:42]):
            path = put(kind + record + b"\r\n")
            text = refusal(formats.read_any, path)
            assert text.startswith(f"{path}:2:") and text.isascii() and "\n" not in text
            assert len(text) < len(str(path)) + 500


def test_absurd_size_is_refused_by_name(put):
    path = put(b"     8\r\n" * (MAX_BYTES // 8 + 1))
    assert refusal(formats.read_any, path) == (
        f"{path}:1:1: larger than 16777216 bytes (16 MiB): no profile or line file is so large"
    )


def test_findings_are_bounded(put):
    path = put(b"     8\r\n" + b"       x\r\n" * 3000)
    examined = examine(path)
    assert len(examined.findings.found) == MAX_FINDINGS
    assert examined.findings.found[-1].message == "stopped after 1000 findings"


def test_a_path_of_odd_characters_stays_one_line(tmp_path):
    path = tmp_path / "a\nb.csv"
    path.write_bytes(b"x\r\n")
    text = refusal(formats.read_any, path)
    assert "\n" not in text and "a\\nb.csv" in text
