# SPDX-License-Identifier: MIT
"""Every kind of picture: numbers are written one way, time is in pixels and in seconds."""

import re
from pathlib import Path

import pytest

from pixstep import formats, natives, plotting
from worked import PRN

pytestmark = pytest.mark.usefixtures("simulator")

NUMBER = re.compile("\N{MINUS SIGN}?[0-9]{1,3}(\N{THIN SPACE}[0-9]{3})*([.][0-9]+)?")
OTHER_NUMBER = re.compile(r"(?<![\w.])[0-9]{4}|[0-9]k\b|[0-9],[0-9]")
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
        made = ("--speed", 1000, "--pixels", 40, "--pixel-hz", 30, "-o", "line.csv")
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


def assert_written_one_way(name, figure):
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
