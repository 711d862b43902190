# SPDX-License-Identifier: MIT
"""Lines from a user's own tables: what is taken, what is assumed, what is refused."""

import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from effort import cases
from pixstep import formats
from pixstep.errors import RefusedError, UserError
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import MM, Scale
from pixstep.owndata import ImportRequest, fitting, import_line

SCALE = Scale(Fraction(400), MM)
HZ = Fraction(30)


@pytest.fixture
def load(put):
    """Return a function that imports a text for a plain motor of 400 steps/mm at 30 Hz."""

    def made(text: str, decode: str = PLAIN, **options):
        request = ImportRequest(decode, **({"scale": SCALE, "pixel_hz": HZ} | options))
        return import_line(put(text.encode(), "own.csv"), request)

    return made


@pytest.mark.parametrize(
    ("text", "counts"),
    [
        ("4\n0\n-7\n", (4, 0, -7)),  # whole numbers: steps
        ("4.0e+00\r\n8.0\r\n", (4, 8)),
        ("steps\n4\n8\n", (4, 8)),
        ("pos_mm\n0\n0.01\n0.005\n", (4, -2)),
        ("Position [um]\n10\n15\n", (2,)),  # the first row is line zero
        ("speed (mm/s)\n1.5\n3\n", (20, 40)),
        ("v_um_px\n5\n10\n", (2, 4)),
        ("velocity in steps/px\n5\n10\n", (5, 10)),
        ("pixel,pos_mm\n0,0\n1,0.01\n", (4,)),
        ("edge,pos_mm\n0,0\n1,0.01\n", (4,)),
        ("edge_mm\n0\n0.01\n", None),  # a length, not the number of a row; of what is not said
        ("n_steps\n4\n8\n", (4, 8)),
        ("0\t5\n1\t6\n2\t7\n", (5, 6, 7)),  # numbered rows
        ("pixel;pos_mm\n0;0,0\n1;0,01\n", (4,)),  # decimal commas
        ("# t_s pos_mm\n0.0 0.0\n0.0333333 0.01\n0.0666667 0.02\n", (4, 4)),
        ("# a note\n\n4\n# another\n8\n", (4, 8)),
        ('"steps"\n"4"\n', (4,)),
        ("\ufeffsteps\n4\n", (4,)),
        ("7;0\n8;1\n", None),  # which of the two is not said
        ("px,pos_mm\n7,0\n8,0.01\n", (4,)),  # numbered from anywhere
        ("pos_mm;\n0;\n0.01;\n", (4,)),  # a separator at the end of each line
        ("# pos_mm;\n0;;\n0,01;;\n", (4,)),
        ("pixel,pos_mm,,\n0,0,,\n1,0.01,,\n", (4,)),
        ("\n\npos_mm\n\n0\n# a note\n0.01\n\n\n", (4,)),  # empty lines around the numbers
        ("pixel,pos_mm\n0,0\n\n1,0.01\n", (4,)),  # no number can be missing here
    ],
)
def test_what_is_taken(load, text, counts):
    if counts is None:
        with pytest.raises(UserError, match=r"say what it holds|choose one by column"):
            load(text)
    else:
        assert load(text).line == Line(counts, PLAIN)


def test_savetxt_of_numpy_with_and_without_a_header(tmp_path):
    place = np.linspace(0, 1, 11)
    np.savetxt(tmp_path / "a.txt", place, header="pos_mm")
    np.savetxt(tmp_path / "b.csv", np.c_[np.arange(11) / 30, place], delimiter=",",
               header="t_s,pos_mm", comments="")  # fmt: skip
    np.savetxt(tmp_path / "c.txt", np.diff(place) * 400, fmt="%.3f")
    with pytest.raises(RefusedError, match=r"'40.000' can be read as 40 .* or as 40000 "):
        import_line(tmp_path / "c.txt", ImportRequest(PLAIN))
    for name, decimal in (("a.txt", None), ("b.csv", None), ("c.txt", "point")):
        made = import_line(tmp_path / name, ImportRequest(PLAIN, HZ, scale=SCALE, decimal=decimal))
        assert made.line.counts == (40,) * 10 and made.largest_error_steps < Fraction(1, 10**9)


def test_positions_are_rounded_so_that_errors_never_add_up(load):
    made = load("pos_mm\n" + "".join(f"{k * 0.001:.3f}\n" for k in range(101)))
    assert sum(made.line.counts) == 40 and set(made.line.counts) == {0, 1}
    assert made.largest_error_steps == Fraction(2, 5)
    assert any("at most 0.4 steps from" in text for text in made.assumed)


def test_what_was_assumed_is_said(load):
    made = load("t_ms;x (mm)\n0;0\n33,333;0,5\n")
    assert made.assumed == (
        "fields divided by semicolons, header t_ms, x (mm), decimal commas",
        "column 2 'x (mm)' is the position at each pixel edge in mm, the first one that of line "
        "zero",
        "column 1 't_ms' agrees with 30 Hz",
    )


def test_options_come_before_the_header(load):
    text = "a_mm,b_mm\n0,0\n1,2\n"
    assert load(text, column="b_mm", quantity="position").line.counts == (800,)
    assert load(text, column="1", quantity="speed", unit="um/px").line.counts == (0, 0)
    assert load("pos_mm\n0\n1\n", quantity="position", negative=True).line.counts == (-400,)


def test_a_smooth_motor_going_backwards(load):
    made = load("pos_mm\n1\n0.995\n0.985\n0.98\n", SMOOTH)
    assert made.line == Line((2, 4, 2), SMOOTH, negative=True)
    assert any("backwards: negative for" in text for text in made.assumed)


def test_a_motor_that_is_turned_round_says_when_it_is_not(load):
    fall, rise = "pos_mm\n1\n0.99\n", "pos_mm\n0\n0.01\n"
    for text, negative, option in ((rise, True, ": negative"), (fall, False, ": no_negative")):
        made = load(text, SMOOTH, negative=True)
        assert made.line.negative is negative and made.line.counts == (4,)
        assert any(f"{option} for" in said for said in made.assumed)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("pos_mm\n0\nabc\n", {}, ":3: column 1 'pos_mm': 'abc': not a number"),
        ("pos_mm\n0\nnan\n", {}, ":3: column 1 'pos_mm': 'nan': not a number"),
        ("pos_mm\n0\n1e999\n", {}, ":3: column 1 'pos_mm': '1e999': not a number"),
        ("4\n٤\n", {}, ":2: column 1: '٤': not a number"),
        (
            "1,2\n3\n4,5\n",
            {"decimal": "point"},
            ":2: 1 fields, 2 in the rows before: '3'",
        ),
        ("a,b\n1,2,3\n", {"column": "1"}, ":2: 3 fields, the header has 2"),
        ("", {}, ": no numbers in it"),
        ("# only\n", {}, ": no numbers in it"),
        ("pos_mm\n", {}, ":1: a header, and no numbers after it"),
        ("0.5\n1\n", {}, ":1: column 1: say what it holds: quantity position|speed|steps"),
        ("x\n0\n0.5\n", {}, ":2: column 1 'x': say what it holds"),
        ("steps\n4\n4.5\n", {}, ":3: column 1 'steps': '4.5': not a whole number of steps"),
        ("steps\n4\n16384\n", {}, ":3: column 1 'steps': '16384': 16384 steps in a pixel, the"),
        ("pos_mm\n0\n50\n", {}, ":3: column 1 'pos_mm': '50': 20000 steps in a pixel"),
        ("pos_mm\n0\n", {}, ":2: column 1 'pos_mm': '0': one position is not a motion"),
        ("x_mm,y_mm\n0,0\n1,1\n", {}, ":2: 2 columns (x_mm, y_mm): choose one by column"),
        ("date\n1.2.2024\n2.2.2024\n", {}, ":2: 1 column (date): no numbers to import"),
        ("x_mm,y_mm\n0,0\n1,1\n", {"column": "z"}, ": there is no column 'z': x_mm, y_mm"),
        ("x_mm,y_mm\n0,0\n1,1\n", {"column": "3"}, ": there is no column '3'"),
        ("x,x\n0,0\n1,2\n", {"column": "x"}, ":2: columns 1, 2 are all named 'x': rename them, or"),
        ("t_s,x_mm,t_s\n0,0,0\n1,2,2\n", {}, ":2: columns 1, 3 are all named 't_s'"),
        ("px,x_mm\n0,0\n1,1\n3,3\n", {}, ":4: column 1 'px': '3': rows must be numbered one by"),
        ("px,x_mm\n0,0\n1,1\n1,3\n", {}, ":4: column 1 'px': '1': rows must be numbered one by"),
        ("px,x_mm\n0,0\n2,1\n1,3\n", {}, ":3: column 1 'px': '2': rows must be numbered one by"),
        (
            "px,x_mm\n9,0\n8,1\n",
            {},
            ":3: column 1 'px': '8': rows must be numbered one by one: expected 10",
        ),
        ("px,x_mm\n0.5,0\n1.5,1\n", {}, ":2: column 1 'px': '0.5': not the whole number of a row"),
        ("px,x_mm\n0,0\n,1\n", {}, ":3: column 1 'px': '': not a number"),
        ("pos_mm\n0\n\n0.03\n", {}, ":3: column 1 'pos_mm': an empty line between numbers"),
        ("4\n5\n \n# a note\n6\n\n", {}, ":3: column 1: an empty line between numbers"),
        ("t_s,pos_mm\n0,0\n0.02,1\n", {}, ":2: column 1 't_s': '0': the times are those of 50 Hz"),
        ("t_s,pos_mm\n0,0\n.03,1\n.1,2\n", {}, ":3: column 1 't_s': '.03': times are not even"),
        ("t_s,pos_mm\n1,0\n1,1\n", {}, ":3: column 1 't_s': '1': times must rise"),
        ("t_s,pos_mm\n0,0\n1,1\n", {"pixel_hz": None}, "needs the pixel clock: 1 Hz?"),
        ("v_mm_s\n1\n", {"pixel_hz": None}, "per second needs pixel_hz"),
        ("pos_deg\n0\n1\n", {}, "needs a motor's steps per deg, the motor has 400 steps/mm"),
        ("pos_mm\n0\n1\n", {"scale": None}, ": column 1 'pos_mm': distance 1 mm: needs a motor's"),
        ("pos\n0\n1\n", {"unit": "s"}, ": column 1 'pos': distance '1 s': expected a number of"),
        ("pos_mm\n0\n1\n0\n", {"decode": SMOOTH}, ":4: column 1 'pos_mm': '0': a smooth line has"),
    ],
)
def test_what_is_refused_and_where(load, text, options, message):
    with pytest.raises(UserError) as refused:
        load(text, **options)
    said = str(refused.value)
    assert message in said and "\n" not in said


def test_a_file_that_is_no_text(put, tmp_path):
    for data, message in (
        (b"\x81\n", "not Windows-1252 at byte 0"),
        (b"1\n" * (9 << 20), "larger than"),
    ):
        with pytest.raises(UserError, match=message):
            import_line(put(data, "x.csv"), ImportRequest(PLAIN))
    with pytest.raises(UserError, match="No such file"):
        import_line(tmp_path / "none.csv", ImportRequest(PLAIN))


@settings(max_examples=cases(6, 60), deadline=None, derandomize=True)
@given(
    st.integers(2, 200),
    st.integers(0, 40_000),
    st.lists(st.fractions(-1, 1, max_denominator=50), min_size=200, max_size=200),
)
def test_a_fitted_line_is_one_that_a_smooth_motor_makes(pixels, steps, noise):
    """A soft start and stop, with noise of up to a step as rounding leaves it."""
    share = [Fraction(k, pixels) for k in range(pixels + 1)]
    soft = [steps * (3 * part**2 - 2 * part**3) for part in share]
    top = 3 * steps / (2 * pixels)
    if top > line_check.MAX_COUNT / 2:
        return
    rough = [place + bump for place, bump in zip(soft, noise * 2, strict=False)]
    rough[0] = Fraction(0)
    counts = fitting.fit(rough)
    errors = [item for item in line_check.check(Line(tuple(counts))) if item.severity == "error"]
    assert [item for item in errors if item.name != "oscillates"] == []
    assert len(counts) == pixels
    jump = max(abs(b - 2 * a + c) for a, b, c in zip(soft[1:], soft, soft[2:], strict=False)) \
        if pixels > 1 else 0  # fmt: skip
    assert fitting.largest_error(counts, rough)[0] <= 8 + 2 * jump + top / pixels


def test_the_command_writes_the_line_and_says_what_it_assumed(invoke, put, tmp_path):
    put(b"pos_mm\n0\n1\n3\n4\n", "own.csv")
    invoke("machine", "new", "--board", "mega", "--pixel-hz", "30")
    done = invoke("line", "import", "own.csv", "-o", "line.csv")
    assert "line.csv: 3 pixels, 1600 steps, smooth" in done.stdout
    assert "note: column 1 'pos_mm' is the position at each pixel edge in mm" in done.stderr
    assert formats.read_csv(tmp_path / "line.csv").values == (400, 800, 400)
    told = json.loads(
        invoke("line", "import", "own.csv", "-o", "line.csv", "--json", "--force").stdout
    )
    assert (told["schema"], told["pixels"], told["machine"]) == (1, 3, "machine.toml")
    assert "is the input" in invoke("line", "import", "own.csv", "-o", "own.csv", status=2).stderr


def test_a_line_that_a_smooth_motor_cannot_make_is_not_written(invoke, put, tmp_path):
    put(b"5\n7\n7\n7\n3\n", "own.csv")
    words = ("line", "import", "own.csv", "--decode", "smooth", "-o", "line.csv")
    said = invoke(*words, status=3).stderr
    assert "own.csv: pixel 2: oscillates: " in said and "3 pixels of 7 entered" in said
    assert "(--fit makes the nearest line)" in said and not (tmp_path / "line.csv").exists()
    assert "--fit: the nearest line" in invoke(*words, "--fit").stderr
    checked = invoke("line", "check", "line.csv", "--decode", "smooth")
    assert "refused" not in checked.stdout
