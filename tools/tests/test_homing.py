# SPDX-License-Identifier: MIT
"""Homing on the simulated boards: speeds, captured edges, faults by name, the command."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest
from click.testing import CliRunner

from effort import cases
from homebench import HomeBench
from pixstep.board import boards
from pixstep.cli.main import main
from pixstep.moves import experiments, fast, homing, homing_judge, legs
from worked import DATA

pytestmark = pytest.mark.usefixtures("simulator")
PATH = DATA / "AccProf-fast-move.csv"
PROFILE = fast.read(PATH)
HZ = Fraction(90)
PLANT = "home=2000,hyst=8,travel=-500..4000"
AXES = [(board.name, axis) for board in boards.all_boards() for axis in range(board.axes)]
BOARDS = [("uno", 0), ("mega", 1), ("m1284", 1)]


def job(board, axis, knobs, *, direction=1, hz=HZ, inverted="none", filter_us=None, **changes):
    request = legs.HomingRequest(axis, direction, **{"search_steps": 6000, **changes})
    plan = legs.plan(PROFILE, request, hz)
    return homing_judge.HomeJob(plan, board, hz, knobs, inverted, filter_us)


def passed(tmp_path, *arguments, **options):
    run = experiments.run_homing(job(*arguments, **options), tmp_path)
    summary = homing_judge.judge(run)
    assert summary["reasons"] == []
    assert summary["verdict"] == "pass" and summary["position_steps"] == 0
    return summary


@pytest.mark.parametrize(
    ("board", "axis", "start"),
    cases(
        [*((*each, 123) for each in AXES), *((*each, 3990) for each in BOARDS)],
        [(*each, start) for each in AXES for start in (123, 3990)],
    ),
)
def test_homing_from_both_sides(tmp_path, board, axis, start):
    summary = passed(tmp_path, board, axis, f"{PLANT},start={start},delay=8000")
    assert summary["captures"] == 3 + (start > 2000)
    assert summary["load_at_rest_steps"] == 2000
    assert summary["edge"]["position_steps"] == 2000 - start == summary["counted_steps"]


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_ten_haps_are_never_exceeded(tmp_path, board, axis):
    run = experiments.run_homing(job(board, axis, f"{PLANT},start=-400"), tmp_path)
    summary = homing_judge.judge(run)
    assert summary["haps"] == 10 and summary["verdict"] == "pass"
    shortest = min(b - a for a, b in zip(run.edges.rising, run.edges.rising[1:], strict=False))
    assert int(shortest) == int(run.job.period / PROFILE.counts[9])
    approach = summary["legs"][0]["pixel_counts"]
    assert tuple(approach[:11]) == (*PROFILE.counts[:10], PROFILE.counts[9])
    assert tuple(approach[-9:]) == PROFILE.counts[8::-1]


@pytest.mark.parametrize("haps", [1, 2, 14])
def test_other_haps(tmp_path, haps):
    summary = passed(tmp_path, "uno", 0, f"{PLANT},start=1700", haps=haps)
    assert summary["haps_entry_steps_px"] == PROFILE.counts[haps - 1]


def test_an_approach_that_trips_while_it_speeds_up(tmp_path):
    summary = passed(tmp_path, "mega", 2, f"{PLANT},start=1970")
    counts = summary["legs"][0]["pixel_counts"]
    assert max(counts) < PROFILE.counts[9] and counts == counts[::-1]


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_minus_direction(tmp_path, board, axis):
    """With its level turned the plant's switch is closed below its place."""
    summary = passed(
        tmp_path, board, axis, f"{PLANT},start=3000,active=high", direction=-1, inverted="limits"
    )
    assert summary["load_at_rest_steps"] == 1992 == summary["switch_closes_at_steps"]


@pytest.mark.parametrize(("board", "axis"), cases(BOARDS, AXES))
@pytest.mark.parametrize("late", [-1, 0, 1])
def test_the_captured_edge_between_two_steps(tmp_path, board, axis, late):
    """At 25 Hz and 4 steps a pixel a step comes every 10 ms: late by less than that the
    switch closes before the next step, late by just that on it, which then is at its edge."""
    knobs = f"{PLANT},start=1900,delay={boards.load(board).tick_hz // 100 + late}"
    summary = passed(tmp_path, board, axis, knobs, hz=Fraction(25), clear_steps=20)
    assert summary["edge"]["position_steps"] == 100 + (late >= 0)


@pytest.mark.parametrize(("board", "axis"), BOARDS)
@pytest.mark.parametrize(
    ("start", "bounce", "filter_us"),
    [
        (1600, "bounce=12,bounce_ticks=12000", None),
        (2500, "bounce=40,bounce_ticks=60000", 6000),
    ],
)
def test_a_switch_that_bounces(tmp_path, board, axis, start, bounce, filter_us):
    """The first edge counts, from wherever the approach begins."""
    knobs = f"{PLANT},start={start},{bounce}"
    summary = passed(tmp_path, board, axis, knobs, filter_us=filter_us)
    assert summary["load_at_rest_steps"] == 2000


@pytest.mark.parametrize(("board", "axis"), BOARDS)
@pytest.mark.parametrize(
    ("knobs", "name", "text"),
    [
        (f"{PLANT},start=1000,stuck=home:open", "limit_plus", "plus limit switch tripped"),
        (f"{PLANT},start=500,stuck=home:closed", "limit_minus", "minus limit switch tripped"),
        ("home=2000,stuck=home:open", "home_not_found", "did not close within 5904 steps"),
        ("home=2000,stuck=home:closed", "home_stuck", "did not open within 5904 steps"),
        ("home=9000", "home_not_found", "did not close within 5904 steps"),
        ("travel=-500..1500", "limit_plus", "plus limit switch tripped"),
    ],
)
def test_named_faults(tmp_path, board, axis, knobs, name, text):
    run = experiments.run_homing(job(board, axis, knobs), tmp_path)
    assert isinstance(run.error, homing.HomingError)
    summary = homing_judge.judge(run)
    assert summary["fault"] == name and not summary["found"]
    assert summary["verdict"] == "fail"
    (reason,) = summary["reasons"]  # and no finding about the edges besides
    assert reason.startswith(f"axis {axis}: {name}: ") and text in reason


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_home_again_after_faults(board, axis):
    with HomeBench(board, axis) as bench:
        for stuck, name in (("home:open", "limit_plus"), ("home:closed", "limit_minus")):
            bench.sim.knobs(0, axis, f"stuck={stuck}")
            bench.sim.run(100_000)
            with pytest.raises(homing.HomingError) as caught:
                bench.home()
            assert caught.value.name == name
            bench.sim.knobs(0, axis, "stuck=none")
            bench.sim.run(100_000)
            bench.board.command("clear_fault", [axis])
            assert bench.home().position_steps == 0
            assert bench.load_position() == 0
            bench.assert_follows_zero()


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_play_does_not_move_home(board, axis):
    """The edge is always met from the same side, so the play is always taken up."""
    with HomeBench(board, axis, "home=0,hyst=2,travel=-900..900,play=40,start=-300") as bench:
        motors = set()
        for place in (-700, 300, -20, 600):
            bench.sim.knobs(0, axis, f"start={place}")
            bench.sim.run(100_000)
            bench.home()
            motors.add(bench.sim.plant(0, axis)[0])
        assert motors == {0}


@pytest.fixture(scope="module")
def sound(simulator, tmp_path_factory):
    """A homing without a finding."""
    run = experiments.run_homing(
        job("uno", 0, f"{PLANT},start=500"), tmp_path_factory.mktemp("sound")
    )
    assert homing_judge.judge(run)["reasons"] == []
    return run


def spoilt(run, defect):
    """Return a run with a defect."""
    if defect == "a step missing":
        edges = run.edges
        return replace(
            run,
            edges=replace(
                edges,
                step_cycles=edges.step_cycles[2:],
                step_levels=edges.step_levels[2:],
            ),
        )
    legs_made = list(run.homed.legs)
    trip = legs_made[0].trip
    if defect == "a tick off":
        trip = replace(trip, ticks=trip.ticks + 1)
    elif defect == "a step off":
        trip = replace(trip, position_steps=trip.position_steps - 1)
    legs_made[0] = replace(legs_made[0], trip=trip)
    homed = replace(run.homed, legs=tuple(legs_made))
    if defect == "not on 0":
        homed = replace(homed, position_steps=1)
    changed = replace(run, homed=homed)
    if defect == "too fast":
        lower = replace(run.job.plan, ramp=PROFILE.leading(9))
        changed = replace(changed, job=replace(run.job, plan=lower))
    if defect == "load off":
        changed = replace(changed, load_steps=run.load_steps + 3)
    return changed


@pytest.mark.parametrize(
    ("defect", "text"),
    [
        ("a step missing", "STEP edges, the board says"),
        ("a tick off", "not a constant apart"),
        ("a step off", "the edges say"),
        ("not on 0", "ends at position 1, not 0"),
        ("too fast", "120 steps in a pixel, HAPs allow 94"),
        ("load off", "3 steps beyond the place where its switch closes"),
    ],
)
def test_seeded_defects_are_found(sound, defect, text):
    summary = homing_judge.judge(spoilt(sound, defect))
    assert summary["verdict"] == "fail"
    assert any(text in reason for reason in summary["reasons"]), summary["reasons"]


def invoke(tmp_path, *words):
    common = ("home", "sim", PATH, "--pixel-hz", 30, "--out", tmp_path)
    return CliRunner().invoke(main, [str(word) for word in (*common, *words)])


def test_the_command_prints_and_draws(tmp_path):
    done = invoke(tmp_path, "--board", "mega", "--axis", 3, "--plant", f"{PLANT},start=9", "--plot")
    assert done.exit_code == 0, done.output
    assert "PASS" in done.output and "slow approach" in done.output
    assert "now stands on position 0" in " ".join(done.output.split())
    assert (tmp_path / "homing.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "summary.json").read_text())["verdict"] == "pass"


def test_the_command_fails_by_name(tmp_path):
    done = invoke(tmp_path, "--board", "uno", "--plant", f"{PLANT},stuck=home:open", "--json")
    assert done.exit_code == 1
    assert json.loads(done.stdout)["fault"] == "limit_plus"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--board", "uno", "--axis", 1, "--plant", PLANT), "axis 1: the uno has 1"),
        (("--board", "uno", "--plant", "home=x"), "home='x'"),
        (("--board", "uno", "--plant", PLANT, "--slow", 9), "slow approach at 9 steps/pixel"),
        (("--board", "uno", "--plant", PLANT, "--haps", 0), "HAPs 0"),
        (("--board", "uno", "--plant", PLANT, "--search", 2), "search distance 2"),
    ],
)
def test_misuse_is_one_line(tmp_path, words, text):
    done = invoke(tmp_path, *words)
    assert done.exit_code == 2 and text in done.output
    assert not list(tmp_path.iterdir())
