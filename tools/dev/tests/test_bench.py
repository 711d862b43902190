# SPDX-License-Identifier: MIT
"""The bench's logic on made-up figures and the test double, then a short real run."""

import json
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path

import pytest
from click.testing import CliRunner

import fake_runner
from clock import TICK_HZ
from pixstep import natives
from pixstep.board import boards
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import period_ticks
from pixstep_dev.bench import (
    accuracy,
    clocks,
    compare,
    decode,
    figures,
    overload,
    peers,
    ramp,
    rates,
    run,
    sections,
    stretch,
    tables,
)
from pixstep_dev.bench.drive import BenchRun, RunWindow, drive
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_dev.bench.search import LONG_S, Search
from pixstep_dev.bench.trial import CLEAN, FAULT, MUTE, REFUSED, WRONG, BenchTrial, judge
from pixstep_trials import lines
from worked import worked_line

FAKE = (sys.executable, fake_runner.__file__)
HZ = Fraction(30)


@pytest.fixture
def fake(monkeypatch):
    """Return a function that runs a line on the test double and says how it ended."""
    monkeypatch.setenv("PYTHONPATH", fake_runner.PATH)
    monkeypatch.delenv("DEFECT", raising=False)

    def attempt(line, defect=""):
        monkeypatch.setenv("DEFECT", defect)
        return judge(drive(BenchRun("uno", {0: line}, HZ, program=FAKE, image=Path("none.elf"))))

    return attempt


def cli(*words):
    """Run `pixstep bench`; return exit status and output. A traceback fails the test."""
    done = CliRunner().invoke(main, ["bench", *map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.output


# Lines


@pytest.mark.parametrize("hz", rates.CLOCKS_HZ[:3])
@pytest.mark.parametrize("motion", rates.MOTIONS)
def test_no_line_of_a_search_is_refused_for_its_form(hz, motion):
    unit = lines.grid(hz)
    assert unit * hz <= lines.RESOLUTION_STEPS_PER_S < (unit + 2) * hz
    for count in range(unit, 9000, unit + 38):
        line = rates.line_of(motion, count, hz, 0.3)
        assert not line_check.refused(line_check.check(line)), count
        assert line.line_speed == count


@pytest.mark.parametrize("steps", clocks.STEPS)
@pytest.mark.parametrize("motion", clocks.MOTIONS)
def test_lines_for_fast_clocks_are_what_they_are_called(motion, steps):
    line = clocks.line_of(motion, steps, 50)
    assert not line_check.refused(line_check.check(line))
    assert max(line.counts) == steps
    assert (line.backlash != 0) == (motion in ("smooth", "ramps"))
    assert (len(set(line.counts)) == 1) == (motion == "one count")


def test_every_pixel_near_the_peak_accelerates_or_brakes():
    up = len(lines.ramp(2000, HZ))
    line = lines.at_peak(2000, HZ, 2.0)
    near = line.speeds[up + 1 : up + 61]
    assert len(near) == 60 and max(near) == 2000 and min(near) >= 1900
    assert all(a != b for a, b in pairwise(near))


def test_the_ramp_line_is_the_ramp_itself():
    hz = ramp.CLOCKS[0]
    assert lines.ramp(300, hz) == list(range(0, 301, 10))
    period, steps = period_ticks(hz, TICK_HZ), ramp.steps_of(hz)
    assert steps == 4500
    own = ramp.exact.instants(ramp.line_of(hz), period)[:steps]
    assert abs(own - ramp.ideal_ticks(steps, TICK_HZ)).max() < 1e-6


def test_kinds_of_pixels_are_what_they_are_called():
    wide = {kind.name: _wide(kind) for kind in decode.KINDS if kind.high > kind.low}
    flat = {kind.name: _flat(kind) for kind in decode.KINDS if kind.high > kind.low}
    assert [name for name, is_wide in wide.items() if is_wide] == ["smooth, 40-bit (long pixels)"]
    assert flat["smooth, flat (below a tick from step to step)"]
    assert not flat["smooth, steep"] and not flat["smooth, slow"]
    for kind in decode.KINDS:
        line, lead = kind.line()
        assert not line_check.refused(line_check.check(line))
        inner = line.speeds[lead : line.pixels - lead + 1]
        assert kind.plain or (min(inner), max(inner)) == (kind.low, kind.high)


def _wide(kind):
    """A fast end that 32 bits are not enough for (NARROW_MAX in curve_flat.c)."""
    return kind.high * int(period_ticks(kind.hz, TICK_HZ)) >= 0x2A00_0000


def _flat(kind):
    """Every pixel changes an interval by less than a tick from step to step."""
    ticks, middle = int(period_ticks(kind.hz, TICK_HZ)), (kind.low + kind.high) // 2
    turns = ((kind.low, middle), (middle, kind.high), (kind.low, kind.high))
    flat = [abs(b - a) * ticks < min(a, b) ** 3 for a, b in turns]
    assert all(flat) or not any(flat)
    return all(flat)


# How a run ends


def test_a_right_run_is_clean(fake):
    assert fake(worked_line(0, pixels=34)).kind == CLEAN


@pytest.mark.parametrize("defect", ["moved", "missing", "doubled", "drift", "late", "stops"])
def test_wrong_edges_without_a_fault_are_wrong(fake, defect):
    assert fake(worked_line(0, pixels=34), defect).kind == WRONG


def test_a_fault_after_right_edges_is_a_fault(fake):
    trial = fake(worked_line(0, pixels=34), "halts")
    assert (trial.kind, trial.detail) == (FAULT, "starved")
    assert 0 < trial.steps < worked_line(0, pixels=34).total_steps


def test_a_board_that_no_longer_answers_is_mute_though_its_edges_are_right(fake):
    trial = fake(worked_line(0, pixels=34), "mute")
    assert trial.kind == MUTE and "no reply" in trial.detail
    assert trial.steps == worked_line(0, pixels=34).total_steps


def test_a_refusal_is_named(fake):
    trial = fake(Line((10, 10, 10, 10)))
    assert trial.text == "refused oscillates" and trial.kind == REFUSED and trial.steps == 0


def test_windows_account_for_their_steps(fake):
    line = Line((200,) * 40, PLAIN)
    windows = (RunWindow(1000, 3000), RunWindow(4000, 6000))
    done = drive(BenchRun("uno", {0: line}, HZ, windows=windows, program=FAKE, image=Path("n")))
    assert len(done.views) == 2
    for view in done.views:
        assert 1900 < view["steps"] < 2100
        assert view["interrupt_cycles"] == pytest.approx(view["cycles"] / 10, abs=1)
        assert sections.passes(view) == pytest.approx(view["cycles"] / 500, abs=1)
        assert sections.decoding(view) == pytest.approx(view["cycles"] / 4, abs=1)


# The search


class World:
    """Lines up to `limit` are clean, short ones a little further; some counts are not."""

    def __init__(self, limit, bad=(), kind=FAULT, short=10):
        self.limit, self.bad, self.kind, self.short = limit, bad, kind, short
        self.tried = []

    def __call__(self, count, seconds):
        self.tried.append((count, seconds))
        limit = self.limit + (self.short if seconds < LONG_S else 0)
        clean = count <= limit and count not in self.bad
        return BenchTrial(CLEAN) if clean else BenchTrial(self.kind, "decoder_late")


@pytest.mark.parametrize("limit", [0, 1, 4, 5, 398, 399, 400, 1000])
def test_search_finds_the_limit_whatever_short_lines_say(limit):
    world = World(limit)
    found = Search(world, 4, 1000).go()
    assert found.count == limit // 4 * 4
    assert (found.beyond is None) == (limit == 1000)
    assert found.holes == {} and found.wrong == {}
    assert all(count <= limit for count in found.confirmed)
    assert len(found.confirmed) == 4 or limit < 40
    assert len(world.tried) == len(set(world.tried)) < 30


def test_a_search_that_ends_at_its_first_count_confirms_that():
    """Fewer than one unit cannot be moved to an awkward count."""
    shift = partial(rates.awkward, 4, Fraction(800_000))
    found = Search(World(7), 4, 1000, shift).go()
    assert found.count == 4 and found.confirmed == [shift(4)]


def test_search_reports_a_hole_and_goes_on_below_it():
    found = Search(World(400, bad={200, 360}), 4, 1000).go()
    assert list(found.holes) == [200]
    assert found.count == 196
    assert all(count < 200 for count in found.confirmed)


def test_search_remembers_wrong_edges():
    found = Search(World(400, kind=WRONG), 4, 1000).go()
    assert found.count == 400 and 404 in found.wrong
    row = rates.row("uno", 1, "smooth", HZ, found, 0)
    assert row["steps_per_s"] == 12_000 and "uno 1 smooth 30 Hz, 12120 steps/s: wrong" in str(row)


def test_awkward_counts_have_intervals_near_a_half_tick():
    count = rates.awkward(16, period_ticks(HZ, TICK_HZ), 1600)
    assert 1584 < count <= 1600 and count % 2 == 0
    assert abs(period_ticks(HZ, TICK_HZ) / count % 1 - Fraction(1, 2)) < Fraction(1, 8)


def test_overload_rates_reach_a_million_and_alike_rows_are_one():
    tried = overload.rates_tried()
    assert tried[0] == 10_000 and tried[-1] == 1_000_000 and tried == sorted(set(tried))
    row = {"board": "uno", "motion": "smooth", "detail": "", "edges": 3}
    ends = [CLEAN, CLEAN, REFUSED]
    made = [row | {"steps_per_s": n, "outcome": end} for n, end in enumerate(ends)]
    first, second = overload.spans(made)
    assert (first["lowest"], first["highest"], first["rates"], first["edges"]) == (0, 1, 2, 6)
    assert second["outcome"] == REFUSED


# Gathering and showing


def _square(number):
    if number == 4:
        raise UserError("four is too many")
    return [{"number": number, "square": number * number, "wrong": ["odd"] * (number == 3)}]


def _figure():
    def tasks():
        return [Task("squares", _square, (n,), alone=n == 1) for n in range(5)]

    columns = (key("n", "number"), key("n*n", "square", ".1f"), key("none", "none"))
    return BenchFigure("squares", "Squares", "Of numbers.", tasks, columns)


def test_rows_keep_their_order_and_wrong_ones_are_gathered():
    shares = []
    measured = run.measure([_figure()], shares.append, executor=lambda: ThreadPoolExecutor(2))
    assert [row["square"] for row in measured["figures"]["squares"]] == [0, 1, 4, 9]
    assert measured["failures"] == ["odd"]
    assert measured["not_measured"] == ["squares: four is too many"]
    assert shares[-1] == 1.0 and shares == sorted(shares)
    text = tables.markdown([_figure()], measured)
    assert "### Squares\n\nOf numbers.\n\n| n | n*n | none |\n| --: | --: | --: |" in text
    assert "| 3 | 9.0 | - |" in text


def test_sections_are_those_of_the_firmware():
    text = natives.source("firmware/hal/cpu.h").read_text()
    named = re.findall(r"CPU_SECTION_(\w+) = (\d+)", text)
    assert [name.lower() for name, _ in named] == [*sections.SECTIONS, "caller"]
    assert [int(value) for _, value in named] == list(range(len(named)))


# The comparison


def test_every_goal_has_a_reader_and_each_figure_its_target():
    rows = compare.compare({"figures": {}})
    assert [row["met"] for row in rows] == [None] * len(rows)
    assert {row["id"] for row in rows} == {goal.id for goal in peers.goals()}
    for goal in peers.goals():
        assert all(peer.project in peers.projects() for peer in goal.peers)
    assert peers.source()


def test_met_and_missed():
    uno = {"board": "uno", "axes": 1, "motion": "constant", "hz": 30.0}
    measured = {
        "figures": {
            "rates": [uno | {"steps_per_s": 250_000}, uno | {"hz": 100.0, "steps_per_s": 1}],
            "ramp": [{"hz": 100.0, "ramp_max_us": 0.03, "ramp_rms_us": 0.0201}],
            "overload": [{"wrong": []}, {"wrong": ["x"]}],
        }
    }
    met = {row["id"]: row["met"] for row in compare.compare(measured)}
    assert met["constant_uno"] is True and met["ramp"] is False and met["overload"] is False
    assert met["share_uno"] is None


# The command


def test_misuse_is_one_line(tmp_path):
    doc = tmp_path / "DOC.md"
    doc.write_text("no markers\n")
    junk = tmp_path / "junk.json"
    junk.write_text("[1, 2]")
    old = tmp_path / "old.json"
    figure = {"rates": [{"board": "uno"}]}
    old.write_text(json.dumps({"figures": figure, "failures": [], "not_measured": []}))
    for words, text in (
        (["--from", tmp_path / "none"], "No such file"),
        (["--from", old, "--compare"], "not a result of this version"),
        (["--from", junk], "not a result of"),
        (["--write", doc], "has no markers"),
        (["--write", doc, "--quick"], "--write takes all figures"),
        (["--write", tmp_path / "none"], "No such file"),
        (["--only", "rates", "--quick"], "nothing to measure"),
    ):
        status, output = cli(*words)
        assert status == 2 and text in output and output.count("\n") == 1
    assert cli("--only", "nonsense")[0] == 2


def test_a_saved_result_is_shown_compared_and_written(tmp_path):
    ramps = [
        {"board": "uno", "hz": 100.0, "pixels": 30, "steps": 4500, "ramp_max_us": 0.03}
        | dict.fromkeys(("ramp_rms_us", "line_max_us", "line_rms_us"), 0.01)
    ]
    saved = tmp_path / "saved.json"
    saved.write_text(json.dumps({"figures": {"ramp": ramps}, "failures": [], "not_measured": []}))
    assert "0.0300" in cli("--from", saved)[1]
    status, output = cli("--from", saved, "--compare")
    assert status == 0 and "0.03 / 0.01" in output and "not measured" in output
    told = json.loads(cli("--from", saved, "--compare", "--json")[1])
    assert told["schema"] == 1
    assert next(row for row in told["targets"] if row["id"] == "ramp")["met"] is True
    doc = tmp_path / "DOC.md"
    doc.write_text("<!-- begin generated: timing -->\n<!-- end generated: timing -->\n")
    assert cli("--from", saved, "--write", doc)[0] == 0
    assert "### Targets" in doc.read_text() and "| uno | 100 | 30 | 4500 |" in doc.read_text()


@pytest.mark.parametrize(
    ("key", "said"), [("failures", "WRONG EDGES: uno"), ("not_measured", "not measured: uno")]
)
def test_wrong_edges_and_lacking_figures_fail_the_command(tmp_path, key, said):
    saved = tmp_path / "saved.json"
    saved.write_text(
        json.dumps({"figures": {}, "failures": [], "not_measured": []} | {key: ["uno"]})
    )
    status, output = cli("--from", saved)
    assert status == 1 and said in output


def test_what_is_not_built_is_named_once(monkeypatch, tmp_path):
    monkeypatch.setenv("PIXSTEP_ROOT", str(tmp_path))
    status, output = cli("--only", "ramp")
    assert status == 2 and "is not built" in output and output.count("\n") == 1


def test_quick_leaves_the_searches_out():
    assert {figure.name for figure in figures.chosen(quick=True)} == set(figures.NAMES) - {
        "rates", "clocks", "overload",
    }  # fmt: skip


# The real images


@pytest.mark.usefixtures("simulator")
def test_a_short_real_run(tmp_path):
    status, output = cli("--only", "ramp", "--only", "sizes", "--json")
    measured = json.loads(output)
    assert status == 0 and measured["failures"] == []
    for row in measured["figures"]["ramp"]:
        assert row["line_max_from_zero_us"] <= 1 / 16
    assert {row["board"] for row in measured["figures"]["sizes"]} == set(boards.BOARD_NAMES)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("motion", clocks.MOTIONS)
def test_a_clock_is_clean_or_too_fast_by_name(motion):
    two = clocks.ClockSearch("mega", 2, motion, 10)
    assert clocks.attempt(two, 500, 0.2).kind == CLEAN
    assert clocks.attempt(two, 500, 0.2, serial_load=True).kind == CLEAN
    fast = clocks.attempt(clocks.ClockSearch("mega", 4, motion, 10), 4000, 0.2)
    assert fast.kind == FAULT and fast.detail


@pytest.mark.usefixtures("simulator")
def test_what_a_board_cannot_do_is_not_measured():
    with pytest.raises(UserError, match="uno at 1000000 steps/s: refused"):
        accuracy.measure("uno", 1_000_000, False)
    line = lines.constant(10_000, 9)
    with pytest.raises(UserError, match="uno, 1 axes, constant rate: too_fast"):
        stretch.moving("uno", line, Fraction(100), stretch.inside(line))


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_a_million_steps_a_second_end_by_name(board):
    for motion in overload.MOTIONS:
        (row,) = overload.measure(board, motion, 1_000_000)
        assert row["wrong"] == [] and row["outcome"] in (REFUSED, FAULT) and row["detail"]
