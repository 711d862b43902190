# SPDX-License-Identifier: MIT
"""Smooth homing on the simulated boards: speeds, mirrored stops, captured edges, faults."""

import json
import random
from dataclasses import replace
from fractions import Fraction

import pytest
from click.testing import CliRunner

from effort import cases
from homebench import PROFILE as STEEP
from homebench import HomeBench, assert_repeats, repeat
from pixstep.board import boards
from pixstep.cli.main import main
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.moves import experiments, fast, homing, homing_judge, legs
from pixstep.simulation.logs import read_edges
from worked import DATA

pytestmark = pytest.mark.usefixtures("simulator")
PATH = DATA / "AccProf-fast-move.csv"
PROFILE = fast.read(PATH)
SPEEDS = (0, 8, 16, 24, 32, 40, 52, 64, 84, 104, 136)  # of its first ten entries, by hand
HZ = Fraction(290)  # 136 steps/px: just below what seeks of the mega may have
PLANT = "home=2000,hyst=8,travel=-500..4000"
AXES = [(board.name, axis) for board in boards.all_boards() for axis in range(board.axes)]
BOARDS = [("uno", 0), ("mega", 2), ("m1284", 0)]
TRIPS = cases(10, 20)
BOUNCES = cases(5, 60)


def run(tmp_path, board, axis, knobs, *, direction=1, inverted="none", filter_us=None, **changes):
    options = {"search_steps": 6000, "decode": SMOOTH, **changes}
    plan = legs.plan(PROFILE, legs.HomingRequest(axis, direction, **options), HZ)
    return experiments.run_homing(
        homing_judge.HomeJob(plan, board, HZ, knobs, inverted, filter_us), tmp_path
    )


def passed(tmp_path, *arguments, **options):
    summary = homing_judge.judge(run(tmp_path, *arguments, **options))
    assert summary["reasons"] == []
    assert summary["verdict"] == "pass" and summary["position_steps"] == 0
    assert all(0 < leg["max_edge_error_ticks"] < 1 for leg in summary["legs"])
    return summary


def speeds_of(counts):
    speeds = [0]
    for count in counts:
        speeds.append(2 * count - speeds[-1])
    return speeds


@pytest.mark.parametrize(
    ("board", "axis", "start"),
    cases(
        [*((*each, 123) for each in AXES), *((*each, 3400) for each in BOARDS)],
        [(*each, start) for each in AXES for start in (123, 3400)],
    ),
)
def test_homing_from_both_sides(tmp_path, board, axis, start):
    summary = passed(tmp_path, board, axis, f"{PLANT},start={start},delay=8000")
    assert summary["decode"] == "smooth" and summary["load_beyond_switch_steps"] in (0, 1)
    assert summary["haps"] == 10 and summary["haps_entry_steps_px"] == SPEEDS[10]
    assert 39_000 < summary["fastest_steps_s"] <= 136 * 290 == summary["haps_entry_steps_s"]
    counts = summary["legs"][0]["pixel_counts"]
    assert tuple(counts[:12]) == (*PROFILE.counts[:10], 136, 136)
    assert tuple(counts[-10:]) == PROFILE.counts[9::-1]


@pytest.mark.parametrize(("board", "axis"), cases(BOARDS, AXES))
def test_minus_direction(tmp_path, board, axis):
    knobs = f"{PLANT},start=3000,active=high"
    summary = passed(tmp_path, board, axis, knobs, direction=-1, inverted="limits")
    assert summary["load_at_rest_steps"] == 1992 == summary["switch_closes_at_steps"]


@pytest.mark.parametrize(("board", "axis"), BOARDS)
def test_a_switch_that_bounces(tmp_path, board, axis):
    """From several starts, so that the first edge meets the main loop anywhere in its round."""
    for start in (1000, *range(2500, 2500 + 2 * BOUNCES, 2)):
        summary = passed(
            tmp_path, board, axis, f"{PLANT},start={start},bounce=12,bounce_ticks=12000"
        )
        assert summary["load_at_rest_steps"] == 2000


@pytest.mark.parametrize(("board", "axis"), BOARDS)
@pytest.mark.parametrize(
    ("knobs", "name"),
    [
        (f"{PLANT},start=1000,stuck=home:open", "limit_plus"),
        (f"{PLANT},start=500,stuck=home:closed", "limit_minus"),
        ("home=2000,stuck=home:open", "home_not_found"),
        ("home=2000,stuck=home:closed", "home_stuck"),
    ],
)
def test_named_faults(tmp_path, board, axis, knobs, name):
    done = run(tmp_path, board, axis, knobs)
    summary = homing_judge.judge(done)
    assert summary["fault"] == name and summary["legs"][0]["decode"] == "smooth"
    (reason,) = summary["reasons"]  # and no finding about the edges besides
    assert reason.startswith(f"axis {axis}: {name}: ")
    assert summary["legs"][0]["max_edge_error_ticks"] < 1


@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 0), ("mega", 3)])
def test_trips_while_speeding_up_stop_mirrored(tmp_path, board, axis):
    """The mirrored stop begins at any of the speeds; every edge is where its pixels put it."""
    path, rng, tops = tmp_path / "edges.csv", random.Random(axis), set()
    with HomeBench(board, axis, f"{PLANT},start=0", hz=HZ, edges=path) as bench:
        plan = bench.plan(profile=PROFILE, decode=SMOOTH, slow=4, search_steps=6000)
        made = []
        for index in range(TRIPS):
            place = 2000 - rng.randint(1, (60, 700)[index % 2])
            bench.sim.knobs(0, axis, f"start={place},delay={rng.randint(0, 16_000)}")
            bench.sim.run(50_000)
            found = homing.home(bench.board, plan, bench.hz, bench.world)
            made += [leg for leg in found.legs if leg.decode == SMOOTH]
        bench.sim.command("flush")
    edges, tick_hz = read_edges(path).axis(0, axis), boards.load(board).tick_hz
    for leg in made:
        counts, _, off_ticks, reasons = homing_judge.judge_leg(
            plan,
            leg,
            homing_judge.leg_edges(edges, leg, tick_hz),
            tick_hz / HZ,
            tick_hz=tick_hz,
            stopped=False,
        )
        assert reasons == [] and off_ticks < 1
        speeds = speeds_of(counts)
        top = speeds.index(max(speeds))
        assert speeds[-top - 1 :] == speeds[top::-1]
        if leg.name != "slow approach":
            assert tuple(speeds[: top + 1]) == SPEEDS[: top + 1]
            tops.add(speeds[top])
    assert len(made) == 3 * TRIPS and len(tops) >= cases(3, 5), tops


@pytest.mark.parametrize("axis", range(4))
def test_many_homings_of_the_mega_end_on_one_step(axis):
    count = cases(8, 25)
    assert_repeats(repeat("mega", axis, count, seed=50 + axis, decode=SMOOTH), count)


def test_many_homings_of_the_uno_end_on_one_step():
    count = cases(25, 100)
    assert_repeats(repeat("uno", 0, count, seed=60, decode=SMOOTH), count)


def test_the_bench_profile_is_sound_smoothly():
    assert STEEP.leading(STEEP.haps).speeds(SMOOTH) == (4, 36, 64, 76)


def without_a_step(edges, step):
    """Leave out a step and its pulse's end."""
    chosen = [index for index in range(len(edges.step_cycles)) if index // 2 != step]
    return replace(
        edges, step_cycles=edges.step_cycles[chosen], step_levels=edges.step_levels[chosen]
    )


def late_by(edges, step, ticks):
    cycles = edges.step_cycles.copy()
    cycles[2 * step] += ticks
    return replace(edges, step_cycles=cycles)


@pytest.fixture(scope="module")
def sound(simulator, tmp_path_factory):
    done = run(tmp_path_factory.mktemp("sound"), "uno", 0, f"{PLANT},start=500")
    assert homing_judge.judge(done)["reasons"] == []
    return done


@pytest.mark.parametrize("step", [300, 700])
@pytest.mark.parametrize("ticks", [-2, 2])
def test_an_edge_two_ticks_off_is_found(sound, step, ticks):
    spoilt = replace(sound, edges=late_by(sound.edges, step, ticks))
    (reason,) = homing_judge.judge(spoilt)["reasons"]
    assert reason.startswith("approach: 1 edges are a tick or more off, ")


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (110, "approach: the speed changes from 50 to 66 steps/pixel in pixel 7"),
        (900, "approach: 138 steps/pixel after pixel 15, HAPs allow 136"),
    ],
)
def test_a_step_missing_is_found(sound, step, text):
    """The counts alone tell it: the speeds no longer fit."""
    reasons = homing_judge.judge(replace(sound, edges=without_a_step(sound.edges, step)))["reasons"]
    assert any("STEP edges, the board says" in reason for reason in reasons)
    assert text in reasons


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"ramp": PROFILE.leading(9)}, "136 steps/pixel after pixel 10, HAPs allow 104"),
        ({"ramp": fast.Acceleration((2, 6, 60, 80))}, "the speed changes from 0 to 8"),
    ],
)
def test_speeds_beyond_the_profile_are_found(sound, changes, text):
    job = replace(sound.job, plan=replace(sound.job.plan, **changes))
    reasons = homing_judge.judge(replace(sound, job=job))["reasons"]
    assert any(text in reason for reason in reasons), reasons


def test_a_leg_of_plain_lines_is_no_smooth_one(sound):
    """Taken for the other decode rule the same edges fail."""
    turned = tuple(
        replace(leg, decode=PLAIN if leg.decode == SMOOTH else SMOOTH) for leg in sound.legs
    )
    reasons = homing_judge.judge(replace(sound, homed=replace(sound.homed, legs=turned)))["reasons"]
    assert {reason.partition(":")[0] for reason in reasons} >= {"approach", "stand clear"}


def invoke(tmp_path, profile, *words):
    common = (
        "home",
        "sim",
        profile,
        "--board",
        "uno",
        "--pixel-hz",
        290,
        "--out",
        tmp_path / "out",
    )
    plant = ("--plant", f"{PLANT},start=1500", "--json")
    return CliRunner().invoke(main, [str(word) for word in (*common, *plant, *words)])


@pytest.mark.parametrize(
    ("name", "words", "decode", "note"),
    [
        ("fast.csv", (), "plain", ""),
        ("fast.csv", ("--decode", "smooth"), "smooth", ""),
        ("AccProfM39-30Hz-1.CSV", (), "smooth", "named for M39"),
        ("AccProfM39-30Hz-1.CSV", ("--decode", "plain"), "plain", ""),
        ("AccProfM40-30Hz-1.csv", (), "plain", "named for M40"),
    ],
)
def test_the_command_takes_the_rule_of_the_motor_named(tmp_path, name, words, decode, note):
    (tmp_path / name).write_bytes(PATH.read_bytes())
    done = invoke(tmp_path, tmp_path / name, *words)
    assert done.exit_code == 0, done.output
    summary = json.loads(done.stdout)
    assert summary["decode"] == decode == summary["legs"][0]["decode"]
    assert note in done.stderr and ("named for" in done.stderr) == bool(note)


def test_the_command_refuses_a_profile_that_oscillates(tmp_path):
    path = tmp_path / "ten.csv"
    path.write_bytes(b"    10\r\n" * 12)
    done = invoke(tmp_path, path, "--haps", 5, "--decode", "smooth")
    assert done.exit_code == 3 and not (tmp_path / "out").exists()
    assert f"{path}: entry 1, decoded as smooth: equal counts entered at" in done.stderr
    assert invoke(tmp_path, path, "--haps", 5, "--decode", "plain").exit_code == 0
