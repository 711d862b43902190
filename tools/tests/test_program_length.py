# SPDX-License-Identifier: MIT
"""Plans of any length: bounded memory, checked whole, and no file that nothing reads."""

import json
import tracemalloc
from fractions import Fraction

import numpy as np
import pytest

from effort import cases, only_long
from pixstep import formats
from pixstep.board import capability
from pixstep.errors import RefusedError
from pixstep.lines.core import Checker, CoreLimits, check
from pixstep.lines.line import Line
from pixstep.lines.runs import safe_entries
from pixstep.programs import plan
from pixstep.programs.pixels import ProgramTrack, Rounding, in_pieces
from pixstep.programs.plan import MOST_PIXELS, Plan
from pixstep.programs.plan_data import PlanOptions
from pixstep.programs.plan_lines import rehearse
from programbench import random_program, setup

MACHINE = """\
[clock]
pixel = "200 Hz"
[boards.main]
kind = "mega"
[motors.X]
axis = 0
kind = "plain"
limits = { max_speed = "20000 steps/s", max_acceleration = "5000000 steps/s2" }
"""


def peak_bytes(text, of, pixels):
    """Return the most memory that so many pixels of a plan take, and how many it has planned."""
    plan = Plan("p.pmc", text.splitlines(), of, PlanOptions())
    tracemalloc.start()
    for _ in plan.counts():
        if plan.report.pixels >= pixels:
            break
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most, plan.report


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize(
    "text", ["INC TS0 TA10 TM8388607 X1000000000", "TS0 TA5 TM90 X10\nDWELL8000000\nX0"]
)
def test_one_long_move_or_dwell_takes_no_more_memory(text, smooth):
    """1 billion steps are 20 million pixels, of which the quick check plans a million."""
    text = text.replace("X0", "X20") if smooth else text
    of = setup(1000, 1, 1000, speed=50, smooth=smooth)
    most, report = peak_bytes(text, of, cases(1_000_000, 10**9))
    assert report.pixels >= cases(1_000_000, 8_000_000)
    assert most < 30e6


@pytest.mark.parametrize("seed", range(cases(12, 200)))
def test_pieces_of_a_plan_have_the_counts_of_the_whole(seed):
    rng = np.random.default_rng(seed)
    motors, smooth = int(rng.integers(1, 4)), bool(seed % 3 == 2)
    of = setup(rng.uniform(0.2, 3, motors), motors, 100, speed=4, smooth=smooth)
    text, _ = random_program(rng, motors, 12, rising=smooth)
    lines = list(Plan("p.pmc", text.splitlines(), of, PlanOptions()).timelines())
    whole, parts = (
        np.vstack(list(Rounding(of).counts(ProgramTrack(found, of))))
        for found in (lines, in_pieces(lines, 23.0))
    )
    assert len(list(in_pieces(lines, 23.0))) > 5
    assert np.array_equal(whole, parts)


def test_a_check_in_parts_finds_what_a_check_of_the_whole_finds():
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(cases(200, 3000)):
        counts = np.repeat(rng.integers(-2, 40, 20), rng.integers(1, 4, 20)).tolist()
        line = Line(tuple(counts), ("plain", "smooth")[int(rng.integers(2))])
        bounds = CoreLimits(1000, 30, 30, 30, 900, 12, 8)
        rows = safe_entries(line)
        whole = check(rows, bounds)
        checker, parts, place = Checker(bounds), [], 0
        while place < len(rows):
            more = int(rng.integers(1, 7))
            parts += checker.more(rows[place : place + more])
            place += more
        assert parts == whole
        found += len(whole)
    assert found > 200


def test_a_plan_is_checked_to_its_last_pixel():
    """A speed that the board has not, behind 2,100,000 pixels of rest."""
    text = "TS0 TA5 TM90 X100\nDWELL2100000\nX50000\nX0"
    of = setup(1000, 1, 1000)  # without a limit of the speed
    with pytest.raises(RefusedError, match="motor X: line refused: too_fast at pixel 21000"):
        rehearse(
            Plan("p.pmc", text.splitlines(), of), capability.named_limits("mega", Fraction(1000))
        )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Go to a folder with a machine file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text(MACHINE)
    return tmp_path


def test_a_plan_that_no_file_holds_is_refused_before_the_work(folder, invoke, monkeypatch):
    monkeypatch.setattr(Plan, "counts", None)  # nothing is planned
    moves = "INC TS0 TA5 TM500\n" + "X100\n" * 30_000
    (folder / "long.pmc").write_text(moves)
    error = invoke("plan", "long.pmc", status=3).stderr
    line = 1 + MOST_PIXELS // 100 + 1
    assert error.startswith(
        f"pixstep: long.pmc:{line}:1: up to here the program takes 10486 s = 2097200 pixels at "
        f"200 Hz, and a line file holds {MOST_PIXELS}: run the program as it is, which takes any "
        f"length (`pixstep board run`"
    )
    (folder / "dwell.pmc").write_text("TS0 TA5 TM90 X10\n" + "DWELL8000000\n" * 2)
    assert "dwell.pmc:3:1: up to here" in invoke("plan", "dwell.pmc", status=3).stderr
    assert not (folder / "plan").exists()


def test_a_move_that_its_speed_makes_too_long_is_refused_before_the_work(
    folder, invoke, monkeypatch
):
    (folder / "slow.pmc").write_text("TS0 TA5 TM900 X400000000\nX0")  # 20,000 s each way
    monkeypatch.setattr(Plan, "counts", None)  # nothing is planned
    error = invoke("plan", "slow.pmc", status=3).stderr
    assert error.startswith("pixstep: slow.pmc:1:1: up to here the program takes 19")
    (folder / "slow.pmc").write_text("TS0 TA5 TM900 X400000000")
    for mode in ("lookahead", "mode1"):
        assert (
            "slow.pmc:1:1: up to here"
            in invoke("plan", "slow.pmc", "--mode", mode, status=3).stderr
        )


def test_a_plan_that_its_limits_make_too_long_is_refused(folder, invoke, monkeypatch):
    (folder / "slow.pmc").write_text("INC TS0 TA1 TM1\n" + "X90\nX-90\n" * 500)
    monkeypatch.setattr(plan, "MOST_PIXELS", 700)
    error = invoke("plan", "slow.pmc", status=3).stderr
    assert error.startswith("pixstep: slow.pmc: by its limits the plan takes more than 700 pixels")
    assert error.count("\n") == 1 and not (folder / "plan").exists()


@pytest.mark.parametrize("seed", range(cases(15, 300)))
@pytest.mark.parametrize("mode", ["lookahead", "mode1"])
def test_no_plan_is_shorter_than_what_the_quick_look_says(seed, mode, monkeypatch):
    rng = np.random.default_rng(seed)
    motors = int(rng.integers(1, 4))
    of = setup(10 ** rng.uniform(-1, 1), motors, 100, speed=10 ** rng.uniform(-1, 2))
    text, _ = random_program(rng, motors, int(rng.integers(1, 15)))
    text += "\nDWELL30\nRAPID X7\nDELAY30"
    total = Plan("p.pmc", text.splitlines(), of, PlanOptions(mode))
    for _ in total.counts():
        pass
    monkeypatch.setattr(plan, "MOST_PIXELS", total.report.total_ms / of.pixel_ms + 1e-6)
    plan.require_length("p.pmc", text.splitlines(), of, PlanOptions(mode))


@only_long
def test_the_longest_plan_is_read_by_what_reads_lines(folder, invoke):
    """2,097,152 pixels to the last one: the ends of the moves are 4 pixels of it."""
    rest = (MOST_PIXELS - 43) * 5
    (folder / "most.pmc").write_text(
        f"TS0 TA10 TM90 X10\nDWELL{rest - 8_000_000}\nDWELL8000000\nX0"
    )
    found = json.loads(invoke("plan", "most.pmc", "--json").output)
    assert MOST_PIXELS - 8 <= found["pixels"] <= MOST_PIXELS
    assert len(formats.read_csv(folder / "plan/X.csv").values) == found["pixels"]
    invoke("line", "check", "plan/X.csv", "--decode", "plain", "--machine", "none")
