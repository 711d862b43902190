# SPDX-License-Identifier: MIT
"""Units in the headers of a user's tables: taken as `--unit` takes them, or refused."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from effort import cases
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN
from pixstep.lines.units import DEGREE, LENGTH_UNITS, MM, Scale
from pixstep.owndata import ImportRequest, columns, import_line

HZ = Fraction(1000)
PER_MM, PER_DEGREE = Scale(Fraction(400), MM), Scale(Fraction(100), DEGREE)
# What people write and `--unit` does not take.
FOREIGN = (
    "mm/sec", "km/h", "rpm", "rad", "rad/s", "mrad", "mil", "micron", "microns", "inch", "inches",
    "ft", "mm/h", "mm/s2", "mm/s²", "mm/s^2", "Hz", "%", "turns", "degrees", "1", "-", "",
)  # fmt: skip
KNOWN = (
    *LENGTH_UNITS,
    *(f"{length}/{per}" for length in LENGTH_UNITS for per in ("px", "s", "ms", "us", "min")),
    "µm", "μm/s", "mm / min",
)  # fmt: skip
HEADS = ("v", "speed", "Velocity", "pos", "x", "Position", "pos_x", "set speed", "steps", "phi", "")
AS_BRACKETS = ("{} [{}]", "{}({})", "{} ({}) set", "{}_[{}]")
AS_WORDS = ("{}_{}", "{} {}", "{}, {}", "{} / {}", "{} in {}", "{}_{}_x")


@pytest.fixture
def load(put):
    """Return a function that imports rows under a header for a plain motor at 1 kHz."""

    def made(header: str, rows: str = "600\n600\n", **options):
        path = put(f"{header}\n{rows}".encode(), "own.csv")
        return import_line(
            path, ImportRequest(PLAIN, **({"scale": PER_MM, "pixel_hz": HZ} | options))
        )

    return made


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("names") / "own.csv"


@pytest.mark.parametrize(
    ("header", "scale", "counts"),
    [
        ("v_mm_min", PER_MM, (4, 4)),
        ("v [mm/min]", PER_MM, (4, 4)),
        ("speed (mm/min)", PER_MM, (4, 4)),
        ("SpeedMmPerMin", PER_MM, (4, 4)),
        ("v_mm_min_x", PER_MM, (4, 4)),
        ("mm_min_speed", PER_MM, (4, 4)),
        ("v [deg/min]", PER_DEGREE, (1, 1)),
        ("v [rev/min]", PER_DEGREE, (360, 360)),
        ("Velocity_°/min", PER_DEGREE, (1, 1)),
        ("v_steps_ms", PER_MM, (600, 600)),
        ("v", PER_MM, (600, 600)),  # no unit at all: steps
        ("v_x", PER_MM, (600, 600)),
        ("speed_1", PER_MM, (600, 600)),
        ("motor_speed_m40", PER_MM, (600, 600)),
        ("vel_actual", PER_MM, (600, 600)),
        ("steps_x", PER_MM, (600, 600)),
    ],
)
def test_speeds(load, header, scale, counts):
    assert load(header, scale=scale).line.counts == counts


@pytest.mark.parametrize(
    ("header", "scale", "steps"),
    [
        ("x [in]", PER_MM, 10160),
        ("pos_in", PER_MM, 10160),
        ("pos [rev]", Scale(Fraction(10), DEGREE), 3600),
        ("x [arcmin]", PER_DEGREE, Fraction(100, 60)),
        ("x_arcsec", PER_DEGREE, Fraction(100, 3600)),
        ("x [°]", PER_DEGREE, 100),
        ("pos°", PER_DEGREE, 100),
        ("pos (x) [mm]", PER_MM, 400),
        ("PosX_um", PER_MM, Fraction(2, 5)),
        ("mm_pos", PER_MM, 400),
        ("x / mm", PER_MM, 400),
        ("Position, mm", PER_MM, 400),
        ("x_mm_actual", PER_MM, 400),
        ("pos", PER_MM, 1),
        ("pos_x", PER_MM, 1),
        ("x_pos", PER_MM, 1),
    ],
)
def test_positions(load, header, scale, steps):
    assert load(header, "0\n1\n", scale=scale).line.counts == (round(steps),)


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("v [mm/sec]", "'mm/sec'"),
        ("[km/h]", "'km/h'"),
        ("v [rpm]", "'rpm'"),
        ("v_rpm", "'rpm'"),
        ("v_rpm_x", "'rpm x'"),
        ("SpeedRpm", "'rpm'"),
        ("rpm_speed", "'rpm'"),
        ("motor RPM speed", "'rpm'"),
        ("Hz speed", "'hz'"),
        ("mrad position", "'mrad'"),
        ("v_mm_sec", "'mm sec'"),
        ("v_mm_s2", "'mm s2'"),
        ("pos [inch]", "'inch'"),
        ("posinch", "'inch'"),
        ("pos [rad]", "'rad'"),
        ("x_mil", "'mil'"),
        ("x [microns]", "'microns'"),
        ("phi [mrad]", "'mrad'"),
        ("# phi [mrad]", "'mrad'"),
        ("phi in mrad", "'mrad'"),
        ("pos_s", "'s'"),
        ("v in s", "'s'"),  # inches per second: v [in/s]
        ("v in px", "'in px'"),
        ("pos_px", "'px'"),
        ("pos_mm [um]", "'mm um'"),
        ("pos mm/rev", "'mm rev'"),
        ("v []", "''"),
        ("pos_left", "'left'"),
    ],
)
def test_what_is_no_unit_is_refused_with_its_words(load, header, words):
    with pytest.raises(UserError) as refused:
        load(header)
    said = str(refused.value)
    place = f"own.csv:2: column 1 {header.removeprefix('# ')!r}: "
    assert f"{place}{words} is not a unit: unit steps|nm|um|" in said
    assert "in|arcsec|arcmin|deg|°|rev, of speeds also those per px|us|ms|s|min" in said
    assert load(header, unit="steps", quantity="speed").line.counts == (600, 600)


@pytest.mark.parametrize("header", ["phi_mrad", "rpm", "M40", "in", "foo [in]", "# phi_mrad"])
def test_a_name_that_leaves_the_quantity_open_is_no_column_of_steps(load, header):
    with pytest.raises(UserError, match=r"say what it holds: .* and unit .*\|in\|.*per px"):
        load(header)
    if "in" not in header:
        assert load(header, quantity="steps").line.counts == (600, 600)
        with pytest.raises(UserError, match="say what it holds"):
            load(header, quantity="position")


def test_a_remark_above_the_numbers_is_no_header(load):
    assert load("# made by hand").line.counts == (600, 600)


@pytest.mark.parametrize("header", ["t [µs]", "t [us]", "t_us", "Time (usec)"])
def test_times_in_microseconds(load, header):
    made = load(f"{header},pos_mm", "0,0\n1000,0.01\n2000,0.02\n")
    assert made.line.counts == (4, 4) and f"column 1 '{header}' agrees with 1000 Hz" in made.assumed


@pytest.mark.parametrize("header", ["t [h]", "time_ns", "t (mm)"])
def test_times_in_what_is_no_time(load, header):
    with pytest.raises(UserError, match="is not a unit of time: expected us, ms, s, min"):
        load(f"{header},pos_mm", "0,0\n1000,0.01\n")


def _outcome(path, header, request):
    """Return exactly what whole numbers under a header become, None if they are refused."""
    path.write_text(f"{header}\n0\n2\n", encoding="utf-8")
    try:
        made = import_line(path, request)
    except UserError:
        return None
    return made.line.counts, made.largest_error_steps


@settings(max_examples=cases(150, 1500), deadline=None, derandomize=True)
@given(st.data())
def test_a_header_with_a_unit_is_as_the_option_or_refused(place, data):
    head = data.draw(st.sampled_from(HEADS))
    unit = data.draw(
        st.sampled_from(KNOWN)
        | st.sampled_from(FOREIGN)
        | st.text("abcdefghijklmnopqrstuvwxyz/%²°µ", min_size=2, max_size=8)
    )
    shapes = AS_BRACKETS if unit not in KNOWN + FOREIGN else AS_BRACKETS + AS_WORDS
    form = data.draw(st.sampled_from(shapes))
    if form in AS_WORDS and unit in ("", "-", "1"):
        return
    scale = Scale(Fraction(3), data.draw(st.sampled_from([MM, DEGREE])))
    header = form.format(head, unit)
    taken = _outcome(place, header, ImportRequest(PLAIN, HZ, scale=scale))
    if unit not in KNOWN:
        assert taken is None, header
        return
    quantity = columns.meaning_of(header).quantity
    option = ImportRequest(PLAIN, HZ, quantity=quantity, unit=unit, scale=scale)
    wanted = _outcome(place, head or "a", option)
    assert taken in (None, wanted), header
    ambiguous = head in ("phi", "", "steps") or (unit == "in" and form == "{}_{}_x")
    if not ambiguous:
        assert taken == wanted, header
