# SPDX-License-Identifier: MIT
"""Every kind of picture: numbers are written one way, time is in pixels and in seconds."""

import math
import re
from itertools import pairwise
from pathlib import Path

import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from pixstep import formats, natives, plotting
from worked import PRN

pytestmark = pytest.mark.usefixtures("simulator")

NUMBER = re.compile("\N{MINUS SIGN}?[0-9]{1,3}(\N{THIN SPACE}[0-9]{3})*([.][0-9]+)?")
OTHER_NUMBER = re.compile(r"(?<![\w.])[0-9]{4}|[0-9]k\b|[0-9],[0-9]")
ODD_NUMBER = re.compile("[0-9]e[+-]?[0-9]|(?<![0-9.])[-\N{MINUS SIGN}]0(?![.0-9])|[0-9] us\\b")
LEAST_CONTRAST = 4.5
FAST = natives.root() / "tools/data/AccProf-fast-move.csv"
SWITCH = "home=2000,hyst=8,travel=-500..4000,start=123,delay=8000"
SMOOTH = ("line.csv", "--decode", "smooth", "--pixel-hz", 30)
MOVE = (FAST, "--steps", -40_000, "--pixel-hz", 30)
PICTURES = {
    "line show": (("line", "show", *SMOOTH, "--plot", "a.png"), 1),
    "profile show": (("profile", "show", PRN, "--plot", "a.png"), 1),
    "move show": (("move", "show", *MOVE, "--plot", "a.png"), 1),
    "line compensate": (
        ("line", "compensate", "turns.csv", "--play", 4, "--max-acceleration", 10,
         "--start-stop", 10, "--pixel-hz", 30, "-o", "made.csv", "--plot", "a.png"), 1,
    ),
    "a run with a load": (
        ("sim", *SMOOTH, "--board", "uno", "--plant", "play=3", "--out", "a", "--plot"), 4,
    ),
    "a locked line": (
        ("sim", *SMOOTH, "--board", "uno", "--sync", "lock", "--pixel-ppm", -9000,
         "--pixel-jitter-us", 20, "--out", "a", "--plot"), 4,
    ),
    "a fast move": (("move", "sim", *MOVE, "--board", "mega", "--out", "a", "--plot"), 1),
    "a homing": (
        ("home", "sim", FAST, "--board", "mega", "--pixel-hz", 100, "--plant", SWITCH,
         "--out", "a", "--plot"), 1,
    ),
}  # fmt: skip


@pytest.fixture
def drawn(monkeypatch, pixstep):
    """Return a function that runs a command and returns the figures that it would have written.

    They are laid out, so that every text is known, and not painted: that takes most of the time,
    and `test_every_output` and `test_profile_show` write the files.
    """
    found = []

    def noted(made, path, **_options):
        made.draw_without_rendering()
        found.append((path.name, made))
        return path

    def run(*words):
        made = ("--speed", 1000, "--pixels", 40, "--pixel-hz", 30, "-o", "line.csv", "--force")
        pixstep("line", "make", "--profile", PRN, *made)
        formats.write_csv(Path("turns.csv"), (0, 5, 10, 5, 0, -5, -10, -10, -5, 0))
        pixstep(*words)
        return dict(found)

    monkeypatch.setattr(plotting, "write", noted)
    return run


def labels(figure):
    """Return the texts of all ticks that are shown, by the label of their axis."""
    for axes in figure.findobj(lambda item: hasattr(item, "get_xaxis")):
        for axis in (axes.xaxis, axes.yaxis):
            if axes.axison and axis.get_visible():
                yield axis.get_label_text(), [text.get_text() for text in axis.get_ticklabels()]


def contrast(colour, other="white"):
    """Return the contrast of two colours as WCAG 2 defines it, 1 to 21."""
    low, high = sorted(_luminance(to_rgb(one)) for one in (colour, other))
    return (high + 0.05) / (low + 0.05)


def _luminance(rgb):
    parts = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def texts(figure):
    """Return the texts that are shown."""
    found = figure.findobj(Text)
    return [text for text in found if text.get_visible() and text.get_text().strip()]


def assert_can_be_read(name, figure):
    """Every text stands out from white, no title lies over another one, no figure is odd."""
    for text in texts(figure):
        assert contrast(text.get_color()) >= LEAST_CONTRAST, (name, text.get_text())
        assert not ODD_NUMBER.search(text.get_text()), (name, text.get_text())
    titles = [
        (title.get_text(), title.get_window_extent())
        for axes in figure.axes
        for title in (axes.title, axes._left_title, axes._right_title)
        if title.get_text()
    ]
    for index, (text, box) in enumerate(titles):
        for other, its in titles[index + 1 :]:
            assert not box.overlaps(its), (name, text, other)


def test_colours_stand_out():
    for name in ("INK", "QUIET", "WARM", "MADE", "BOARD"):
        assert contrast(getattr(plotting, name)) >= LEAST_CONTRAST, name
    for name in ("INK", "QUIET", "MADE", "BOARD"):
        assert contrast(getattr(plotting, name), plotting.BAND) >= LEAST_CONTRAST, name


def assert_written_one_way(name, figure):
    assert_can_be_read(name, figure)
    shown = list(labels(figure))
    for axis, texts in shown:
        assert all(NUMBER.fullmatch(text) for text in texts if text), (name, axis, texts)
    named = " ".join(axis for axis, _ in shown)
    assert "pixels after " in named and "seconds after " in named, (name, named)
    for item in figure.findobj(lambda item: hasattr(item, "get_text")):
        assert not OTHER_NUMBER.search(item.get_text()), (name, item.get_text())


@pytest.mark.parametrize(("words", "count"), PICTURES.values(), ids=PICTURES)
def test_numbers_and_times_are_written_one_way(drawn, words, count):
    figures = drawn(*words)
    assert len(figures) == count
    for name, figure in figures.items():
        assert_written_one_way(name, figure)


def test_several_axes_have_one_figure_together(drawn):
    figures = drawn(
        "sim", "turns.csv", "turns.csv", "--decode", "plain", "--pixel-hz", 300,
        "--board", "mega", "--out", "a", "--plot",
    )  # fmt: skip
    assert len(figures) == 7
    assert {"axis0-motion.png", "axis1-motion.png", "axis1-positions.png"} < figures.keys()
    for name, figure in figures.items():
        assert_written_one_way(name, figure)
    together = figures["motion.png"]
    assert [axes.get_ylabel() for axes in together.axes] == ["steps/s", "ticks"] * 2


def test_without_a_frequency_there_are_no_seconds(drawn):
    figures = drawn("line", "show", "line.csv", "--decode", "smooth", "--plot", "a.png")
    named = " ".join(axis for axis, _ in labels(figures["a.png"]))
    assert "pixels after line zero" in named and "seconds" not in named


@pytest.mark.parametrize(
    ("places", "texts"),
    [
        ((-20_000, 0, 1e6), ["\u221220\u2009000", "0", "1\u2009000\u2009000"]),
        ((-0.25, -1e-18, 0.25), ["\u22120.25", "0.00", "0.25"]),
        ((0.0, 0.1, 0.2, 0.30000000000000004), ["0.0", "0.1", "0.2", "0.3"]),
        ((), []),
    ],
)
def test_ticks_have_the_decimals_of_the_finest(places, texts):
    assert plotting.Numbers().format_ticks(places) == texts


MACHINE = """\
clock.pixel = "100 Hz"
boards.main.kind = "mega"
line.motor = "X"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits.max_acceleration = "250 mm/s2"
[motors.Y]
axis = 1
kind = "plain"
steps_per_unit = "2.5 nm/step"
limits.max_acceleration = 9
"""


def units(figure):
    """Return the labels of the scales on the right."""
    return [
        axis.get_label_text()
        for axes in figure.findobj(lambda item: hasattr(item, "get_yaxis"))
        for axis in (axes.yaxis,)
        if axis.get_label_position() == "right" and axis.get_label_text()
    ]


def test_lengths_stand_beside_steps_where_the_scale_is_known(drawn):
    Path("machine.toml").write_text(MACHINE)
    turns = ("turns.csv", "--decode", "plain")
    assert units(drawn("line", "show", *turns, "--plot", "a.png")["a.png"]) == [
        "mm/s", "mm/s\N{SUPERSCRIPT TWO}", "m/s\N{SUPERSCRIPT THREE}", "\N{MICRO SIGN}m",
    ]  # fmt: skip
    figures = drawn("sim", *turns, "--motor", "Y", "--out", "a", "--plot")
    assert units(figures["motion.png"]) == ["\N{MICRO SIGN}m/s", "nm"]
    assert "nm" in units(figures["positions.png"])


def test_without_a_scale_there_are_no_lengths(drawn):
    figures = drawn("sim", *SMOOTH, "--board", "uno", "--machine", "none", "--out", "a", "--plot")
    assert not units(figures["motion.png"])


def test_a_plan_shows_the_programmed_path_its_direction_and_limits_in_force(drawn):
    Path("machine.toml").write_text(MACHINE.replace("2.5 nm/step", "2.5 um/step"))
    Path("go.pmc").write_text("TS0 TA100 TM400 INC X5\nY5\nX-5\nY-5\n")
    figures = drawn("plan", "go.pmc", "--out", "a", "--plot")
    for name, figure in figures.items():
        assert_can_be_read(name, figure)
    (axes,) = figures["path.png"].axes
    handles, names = axes.get_legend_handles_labels()
    assert names == ["programmed", "planned, at the pixel edges", "start"]
    corners = [tuple(map(float, place)) for place in handles[0].get_xydata().round(6)]
    assert corners == [(0, 0), (5, 0), (5, 5), (0, 5), (0, 0)]
    assert len([text for text in axes.texts if text.arrow_patch]) == 6
    speed, acceleration, *_ = figures["motion.png"].axes
    assert (speed.get_ylabel(), acceleration.get_ylabel()) == (
        "X, mm/s", "mm/s\N{SUPERSCRIPT TWO}",
    )  # fmt: skip
    assert figures["motion.png"].legends
    drawn_mm_s2 = max(abs(acceleration.lines[0].get_ydata()))
    assert drawn_mm_s2 <= 250 * (1 + 1e-9)


def test_the_larger_start_lies_below_the_curve(drawn):
    """A gentle ramp reaches its speed late: the inset has to wait for it, or is left out."""
    rise = [round(500 * (1 - math.cos(math.pi * k / 20))) * 2 for k in range(1, 21)]
    speeds = [0, *rise, *[rise[-1]] * 20, *rise[::-1][1:], 0]
    counts = [(one + other) // 2 for one, other in pairwise(speeds)]
    Path("line2.csv").write_text("".join(f"{count:6d}\r\n" for count in counts), newline="")
    line = ("line2.csv", "--decode", "smooth", "--pixel-hz", 30)
    figures = drawn("sim", *line, "--board", "mega", "--beyond", "--out", "a", "--plot")
    speed = figures["motion.png"].axes[0]
    (inset,) = speed.child_axes
    box = inset.get_tightbbox()
    for place in speed.transData.transform(speed.lines[0].get_xydata()):
        assert not box.contains(*place)
