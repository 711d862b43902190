# SPDX-License-Identifier: MIT
"""How the text of a user's table is read: encodings, separators, decimals, thousands, quotes."""

from fractions import Fraction

import pytest

from pixstep.errors import RefusedError
from pixstep.lines.line import PLAIN
from pixstep.lines.units import MM, Scale
from pixstep.owndata import ImportRequest, import_line

SCALE, HZ = Scale(Fraction(400), MM), Fraction(30)
STEPS = "pixel;steps\r\n0;4\r\n1;8\r\n"


@pytest.fixture
def load(put):
    """Return a function that imports a file for a plain motor of 400 steps/mm at 30 Hz."""

    def made(data: bytes | str, **options):
        data = data if isinstance(data, bytes) else data.encode()
        return import_line(put(data, "own.csv"), ImportRequest(PLAIN, HZ, scale=SCALE, **options))

    return made


@pytest.mark.parametrize(
    ("data", "counts"),
    [
        ("sep=;\r\npixel;pos_mm\r\n0;0,00\r\n1;0,01\r\n2;0,03\r\n", (4, 8)),
        ('"sep=,"\r\nsteps\r\n4\r\n', (4,)),
        ("sep=\t\r\npos_mm\r\n0,5\r\n0,75\r\n", (100,)),
        ("pixel;steps;;;\r\n0;4;;;\r\n1;8;;;\r\n;;;;\r\n;;;;\r\n", (4, 8)),
        (";;\n;pixel;steps\n;0;4\n;1;8\n;;\n", (4, 8)),  # the table begins in column B
        ("pixel\tsteps\t\n0\t4\t\n1\t8\t\n\t\t\n", (4, 8)),
        ("pixel;steps;remark\n0;4;\n1;8;turn\n", (4, 8)),
        ("pixel;steps;remark\n0;4;\n1;8;\n", (4, 8)),
        (STEPS.encode("utf-16"), (4, 8)),
        (STEPS.encode("utf-16-le"), (4, 8)),
        (b"\xfe\xff" + STEPS.encode("utf-16-be"), (4, 8)),
        (STEPS.encode("utf-16-be"), (4, 8)),
        (STEPS.encode("utf-32"), (4, 8)),
        (STEPS.encode("utf-8-sig"), (4, 8)),
        ("Position [µm]\n0\n5\n".encode("cp1252"), (2,)),
        ("steps\r4\r8\r", (4, 8)),
        ('pixel;"pos\n[mm]"\n0;0\n1;0,01\n', (4,)),
        ('"pixel,steps"\n"0,4"\n"1,8"\n', (4, 8)),  # each line in quotes
        ('"pixel","pos_mm"\n"0","0,00"\n"1","0,01"\n', (4,)),
        ("pixel,steps\n0,4\n1,\u22124\n", (4, -4)),
        ("pixel;steps\n0;4\n1;\x964\n".encode("latin-1"), (4, -4)),  # the dash of Windows
        ("pixel\tpos_mm\n0\t0,25\n1\t0,5\n", (100,)),
        ("pos_mm\n0,5\n0,75\n", (100,)),
        ("pos_mm\n1.000,5\n1.000,75\n", (100,)),
        ("pos_mm\n1'000.5\n1'000.75\n", (100,)),
        ("pos_mm\n1\u202f000,5\n1\u202f000,75\n", (100,)),
        ("pixel;pos_um\n0;0\n1;1 000,0\n", (400,)),
        ('pixel,pos_um\n0,0\n1,"1,000.0"\n', (400,)),
        ("pos_mm\n0.125\n1.125\n", (400,)),  # no number of thousands begins with 0
        ("t_ms\tpos_mm\n0,000\t1.000\n33,333\t1.001\n", (400,)),  # the times tell
        (",steps\n0,4\n1,8\n", (4, 8)),  # an index without a name
        ("t [ms]  x [mm]\n0 0\n33.333 0.25\n", (100,)),
    ],
)
def test_what_is_read(load, data, counts):
    assert load(data).line.counts == counts


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            "0,0\n1,5\n2,5\n3,0\n",
            ":1: '0,0' can be read as 2 columns 0 | 0 (separator comma), or as 0 (decimal ",
        ),
        (
            "1,000\n2,000\n3,000\n",
            ":1: '1,000' can be read as 2 columns 1 | 0 (separator comma), or as 1000 (decimal "
            "point separator none), or as 1 (decimal comma)",
        ),
        (
            "pos_mm\n1.000\n2.000\n",
            ":2: '1.000' can be read as 1 (decimal point), or as 1000 (decimal comma)",
        ),
        (
            "pixel;pos_mm\n0;1.000\n1;2.000\n",
            ":2: '0;1.000' can be read as 2 columns 0 | 1 (decimal point), or as 2 columns 0 | "
            "1000 (decimal comma)",
        ),
        ("1 000\n2 000\n", "2 columns 1 | 0 (separator blank), or as 1000 (separator none)"),
        ("0,5\n1,5\n2\n3,5\n", "can be read as 0.5 (decimal comma), or as 2 columns 0 | 5"),
        ("pixel,steps\n0,4\n1,8\n2\n3,4\n", ":4: 1 fields, 2 in the rows before: '2'"),
        ("pos_mm\n0,5\n1.500\n2,5\n", ":3: column 1 'pos_mm': '1.500': thousands or decimals, bes"),
        ("pos_um\n1,500.0\n2000.0\n", ":3: column 1 'pos_um': '2000.0': thousands or decimals"),
        ("pixel;steps\n0;4\n;\n1;8\n", ":3: an empty row between numbers: expected the numbers of"),
        ("steps\n4\n#DIV/0!\n8\n", ":3: column 1 'steps': '#DIV/0!': not a number"),
        ("steps\n4\n####\n8\n", ":3: column 1 'steps': '####': not a number"),
        ("nan\n4\n8\n", ":1: 'nan': not a number"),  # no name of a column
        ("#N/A;#N/A\n0;4\n1;8\n", ":1: '#N/A': not a number"),
        ("sep=;\n;;\n", "own.csv: no numbers in it"),
        ('steps\n"4\n8\n', ":2: a quote in this line is never closed"),
        ("sep=:\n0:4\n", ":1: sep=:: expected one of ; | ,, or a tab"),
        (b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!\0", "own.csv: a spreadsheet's own file (.xlsx"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "own.csv: a spreadsheet's own file (.xlsx"),
        (b"steps\n4\0\n8\n4\n4\n4\n", "own.csv: no text: a zero at byte 7"),
        (b"\xef\xbb\xbfsteps\xff\n4\n", ": not UTF-8 at byte 8"),
    ],
)
def test_what_is_refused(load, data, message):
    with pytest.raises(RefusedError) as refused:
        load(data)
    assert message in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("options", "counts"),
    [
        ({"separator": "comma"}, (0, 5, 5, 0)),
        ({"column": "2"}, (0, 5, 5, 0)),
        ({"column": "1", "separator": "comma"}, (0, 1, 2, 3)),
        ({"decimal": "comma", "quantity": "position", "unit": "mm"}, (600, 400, 200)),
        ({"separator": "none", "quantity": "position", "unit": "mm"}, (600, 400, 200)),
    ],
)
def test_the_options_choose(load, options, counts):
    assert load("0,0\n1,5\n2,5\n3,0\n", **options).line.counts == counts


def test_what_was_understood_is_said(load):
    data = "pixel;pos_um\r\n0;0,0\r\n1;1.000,0\r\n".encode("utf-16")
    assert load(data).assumed[0] == (
        "fields divided by semicolons, header pixel, pos_um, decimal commas, marks of thousands, "
        "UTF-16-LE"
    )
    assert load("steps\n4\n").assumed[0] == "one column, header steps"


def test_the_command_refuses_and_takes_the_options(invoke, put, tmp_path):
    put(b"1,000\r\n2,000\r\n", "own.csv")
    words = ("line", "import", "own.csv", "--decode", "plain", "-o", "line.csv")
    assert "own.csv:1: '1,000' can be read as" in invoke(*words, status=3).stderr
    assert not (tmp_path / "line.csv").exists()
    invoke(*words, "--decimal", "point", "--separator", "none")
    assert (tmp_path / "line.csv").read_text().split() == ["1000", "2000"]
