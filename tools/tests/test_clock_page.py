# SPDX-License-Identifier: MIT
"""What a run says and draws of its pixel clock."""

from fractions import Fraction

import numpy as np
import pytest
from rich.console import Console

from pixstep.lines.line import PLAIN, Line
from pixstep.simulation import clock_judge, plots, report
from pixstep.simulation.clock_judge import ClockKeeping
from pixstep.simulation.job import LOCK, START, LineExperiment
from pixstep.simulation.pixel_clock import ClockFlaws

LINE = Line((20,) * 60, PLAIN)
EVEN = ClockFlaws(drop=50)
JITTER = ClockFlaws(jitter_us=5)


def kept(errors, off=0):
    """How a line of one axis kept to its clock, its pixel edges being so many ticks late."""
    errors = np.array(errors, dtype=float)
    pixels = np.arange(1, len(errors) + 1)
    return ClockKeeping(
        axis=0, pixels=pixels, errors_ticks=errors, free_ticks=160.0 * pixels,
        off_steps=np.array([0, off]), period=80_000.0, line_speed=20, speed_hz=200.0, first_edge=9,
        lasts_ticks=80_000 + np.diff(errors),
    )  # fmt: skip


def summary(found, sync=LOCK, flaws=JITTER):
    """A run's summary, as far as its page goes."""
    row = {
        "axis": 0, "steps": 1200, "expected_steps": 1200, "max_edge_error_ticks": 0.5,
        "rms_edge_error_us": 0.03, "rate_error_ppm": 0.0, "last_steps_on_edge": 2,
        "last_steps_off_edge": 58, "pixels_equal": 60, "pixels": 60, "underruns": 0,
        "clock": found.summary(),
    }  # fmt: skip
    clock = {"sync": sync, "divider": 1, "flaws": flaws.as_json(), "true_edges": 133,
             "missing_edges": 3, "false_edges": 0, "board_missing": 2, "board_glitches": 1,
             "board_period_ticks": 79_840.3, "board_offset_ppm": 2000.25,
             "board_jitter_ticks": 66.5}  # fmt: skip
    return {"verdict": "pass", "reasons": [], "board": "uno", "decode": PLAIN, "pixel_hz": "200",
            "pixel_ppm": 0.0, "refusal": None, "record_every": 1, "serial_load": False,
            "cpu_share": None, "interrupt_share": None,
            "requests": {}, "tick_hz": 16_000_000, "axes": [row], "clock": clock}  # fmt: skip


def page(told):
    """The page of a run in one line."""
    console = Console(width=80, file=None, force_terminal=False)
    with console.capture() as shown:
        report.print_page(console, told)
    return " ".join(shown.get().split())


def test_one_is_not_plural_and_nothing_is_not_negative():
    found = page(summary(kept([0.01, 0.0075], off=-1)))
    assert "axis 0: 2 pixel edges at most 0.0 ticks" in found
    assert "drift from the first to the last 0.0 ticks = 0 px = 0.00 steps" in found
    assert "at the clock's true edges at most 1 step made too early or too late" in found
    assert "axis 0: 1 pixel edge at most" in page(summary(kept([1])))
    assert "at most 3 steps made too early" in page(summary(kept([1], off=3)))
    assert "at every true edge of the clock exactly the steps made" in page(summary(kept([1])))


def test_what_the_clock_did_and_what_the_board_saw():
    assert (
        "clock: 133 true edges, 3 missing, 0 false; the board counted 2 missing and 1 false from "
        "arming on and measured +2000.2 ppm, mean jitter 4.16 us"
    ) in page(summary(kept([1])))


@pytest.mark.parametrize(
    ("sync", "flaws", "says"),
    [(LOCK, EVEN, "last steps of pixels within 2 ticks of the clock's true edge, pixels"),
     (LOCK, JITTER, None),
     (START, JITTER, "last steps of pixels on their edge, pixels")],
)  # fmt: skip
def test_on_edge_is_told_where_it_means_something(sync, flaws, says):
    """Not of a line that follows a poor clock: where the board puts its edges is nobody's edge."""
    found = page(summary(kept([1]), sync, flaws))
    assert ("2/60" in found) == ("on edge" in found) == (says is not None)
    assert (says or "rate error, pixels whose expected and counted positions") in found


def job(sync, flaws):
    return LineExperiment("uno", {0: LINE}, Fraction(200), sync=sync, flaws=flaws, pixel_ppm=2000)


@pytest.mark.parametrize(
    ("flaws", "name"),
    [(EVEN, "within 2 ticks, as required"), (JITTER, "the clock's own jitter, rms"),
     (ClockFlaws(wander_ppm=9), None)],
)  # fmt: skip
def test_the_drawing_names_its_band_and_wastes_no_room(flaws, name):
    figure = plots.clock(kept([1, 2, -1] * 20), job(LOCK, flaws), "a line")
    free, locked = figure.axes
    assert free.get_ylim()[0] > -0.1 * free.get_ylim()[1] and free.get_ylim()[1] > 160 * 60 / 16
    legend = locked.get_legend()
    assert (legend.get_texts()[0].get_text() if legend else None) == name
    assert [text.get_text() for text in figure.texts[1:]] == [
        "a line; pixel clock +2\N{THIN SPACE}000 ppm"
        + "".join(f", {text}" for text in flaws.texts()).replace(" us", " \N{MICRO SIGN}s")
    ]
    assert locked.get_title("left") + locked.get_title() == (
        "Locked (measured)\nat most 125 ns, rms 88.4 ns"
    )
    assert np.ptp(locked.get_ylim()) > 3000 / 16  # all of it, in ns


def test_a_line_that_is_not_locked_has_one_part():
    (only,) = plots.clock(kept([160] * 500), job(START, EVEN), "a line").axes
    assert only.get_title().startswith("Not locked (measured)\nat most 10.0 \N{MICRO SIGN}s")
    assert only.get_lines()[-1].get_marker() == ""
    assert clock_judge.parts(summary(kept([1]), START, ClockFlaws())) == []
