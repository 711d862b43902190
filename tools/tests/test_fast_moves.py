# SPDX-License-Identifier: MIT
"""Fast moves: the planner's promises over random moves and profiles, files, command, simulator."""

import itertools
import json
import random
from dataclasses import replace
from fractions import Fraction

import pytest
from click.testing import CliRunner

from bench import Bench
from effort import TRIED_BOARDS, cases
from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, Line
from pixstep.moves import experiments, fast
from pixstep.moves.move_judge import MoveJob
from worked import DATA, SAMPLE_CSV

PROFILE = DATA / "AccProf-fast-move.csv"
FAST = fast.Acceleration((40, 120, 240, 400, 600, 840, 1120, 1440, 1700, 1900, 2000))
FARTHEST = cases(100_000, 1_000_000)
BOARDS = TRIED_BOARDS


def random_profile(rng):
    top = rng.choice([3, 40, 700, 16_383])
    return fast.Acceleration(tuple(sorted(rng.randint(1, top) for _ in range(rng.randint(1, 30)))))


def random_steps(rng, most=1_000_000):
    return min(most, int(10 ** rng.uniform(0, 6.001)))


def random_moves(seed, count):
    """Yield (profile, steps): N log-uniform in 1..1,000,000, not too many pixels."""
    rng = random.Random(seed)
    for _ in range(count):
        profile = random_profile(rng)
        yield profile, min(random_steps(rng), 3000 * profile.top)


def within_a_jump(profile, speed, following):
    """True if a rise lies inside one of the profile's own rises, or is none."""
    entries = itertools.pairwise((0, *profile.counts))
    return following <= speed or any(low <= speed and following <= high for low, high in entries)


def bounds(profile, pixels):
    """Return the highest speeds that `pixels` pixels can have, from rest to rest."""
    last = len(profile.counts) - 1
    return [profile.counts[min(k, pixels - 1 - k, last)] for k in range(pixels)]


@pytest.mark.parametrize("seed", range(5))
def test_a_move_is_exact_and_never_steeper_than_its_profile(seed):
    for profile, steps in random_moves(seed, 200):
        counts = fast.plan(profile, steps).counts
        assert sum(counts) == steps
        assert min(counts) > 0 and max(counts) <= profile.top
        peak = counts.index(max(counts))
        assert list(counts[: peak + 1]) == sorted(counts[: peak + 1])
        assert list(counts[peak:]) == sorted(counts[peak:], reverse=True)
        for way in (counts, counts[::-1]):
            rises = itertools.pairwise((0, *way))
            assert all(within_a_jump(profile, *rise) for rise in rises)


@pytest.mark.parametrize("seed", range(5))
def test_a_move_is_the_shortest_and_slowest_and_nearly_symmetric(seed):
    for profile, steps in random_moves(seed + 100, 100):
        counts = fast.plan(profile, steps).counts
        most = bounds(profile, len(counts))
        assert all(count <= bound for count, bound in zip(counts, most, strict=True))
        assert sum(bounds(profile, len(counts) - 1)) < steps
        lower = max(counts) - 1
        assert sum(min(bound, lower) for bound in most) < steps
        uneven = [a - b for a, b in zip(counts, counts[::-1], strict=True) if a != b]
        assert uneven in ([], [1, -1], [-1, 1])


def test_every_short_move_of_the_sample():
    profile = fast.read(PROFILE)
    for steps in range(1, 5000):
        assert sum(fast.plan(profile, steps).counts) == steps
    assert fast.plan(profile, 1).counts == (1,)
    assert fast.plan(profile, 2).counts == (2,)
    assert fast.plan(profile, 9).counts == (3, 3, 3)
    assert fast.plan(profile, 13).counts == (4, 5, 4)


def test_a_negative_move_mirrors_the_positive_one():
    positive, negative = fast.plan(FAST, 12_345), fast.plan(FAST, -12_345)
    assert [-count for count in positive.counts] == list(negative.counts)
    assert negative.steps == -12_345 == sum(negative.counts)


def test_maximum_speed():
    profile = FAST.limited(500)
    assert profile.counts == (40, 120, 240, 400, 500)
    assert fast.plan(profile, 100_000).top == 500
    assert FAST.limited(2000) is FAST and FAST.limited(None) is FAST
    assert FAST.limited(400).counts == (40, 120, 240, 400)


def test_moves_far_beyond_a_million_steps():
    move = fast.plan(FAST, fast.MAX_STEPS)
    assert sum(count * repeat for count, repeat in move.runs) == fast.MAX_STEPS
    assert move.pixels < 1_100_000 and len(move.runs) < 40


@pytest.mark.parametrize(
    ("steps", "top", "text"),
    [
        (0, 10, "a move of 0 steps"),
        (2**31, 10, "1 to 2147483647"),
        (-(2**31) + 1, 1, "2147483647 steps at no more than 1 steps/pixel take 2147483647 pixels"),
    ],
)
def test_refused_moves(steps, top, text):
    with pytest.raises(UserError, match=text):
        fast.plan(fast.Acceleration((top,)), steps)


def header(name="p", haps=10):
    return formats.ProfileHeader("Mon Oct 12 15:13:35 2009", name, 1, haps, 0, "30")


@pytest.mark.parametrize(
    ("values", "with_header", "text"),
    [
        ([4, 0, 5], False, r":2:6: 0 steps in a pixel"),
        ([4, -3], True, r":8:5: -3 steps in a pixel"),
        ([4, 9, 8], True, r":9:6: the speed falls from 9 to 8"),
        ([4, 16_384], False, r":2:2: 16384 steps in a pixel, the board takes at most 16383"),
    ],
)
def test_profiles_are_refused_by_file_and_row(tmp_path, values, with_header, text):
    path = tmp_path / "p.csv"
    formats.write_csv(path, values, header() if with_header else None)
    with pytest.raises(UserError, match=f"p.csv{text}"):
        fast.read(path)


def test_profiles_of_many_lines_and_binary_ones(tmp_path):
    """The second line is chosen, read alike from CSV and CSB, its faults named at their places."""
    made = formats.of_lines([(4, 9), (5, 8, 11)], header())
    broken = formats.of_lines([(4, 9), (5, 8, 7)], header())
    for kind, place in (("csv", r":13:6"), ("csb", ": line 2, entry 3")):
        formats.write_motion(tmp_path / f"p.{kind}", replace(made, kind=kind))
        assert fast.read(tmp_path / f"p.{kind}", number=2).counts == (5, 8, 11)
        with pytest.raises(UserError, match=r"choose one by line 1\.\.2"):
            fast.read(tmp_path / f"p.{kind}")
        formats.write_motion(tmp_path / f"q.{kind}", replace(broken, kind=kind))
        with pytest.raises(UserError, match=f"q.{kind}{place}: the speed falls from 8 to 7"):
            fast.read(tmp_path / f"q.{kind}", number=2)


def test_a_speed_limit_makes_a_steep_profile_usable(tmp_path):
    formats.write_csv(tmp_path / "p.csv", [4, 16_384])
    assert fast.read(tmp_path / "p.csv", max_speed=900).counts == (4, 900)


def test_header_gives_haps_and_frequency():
    profile = fast.read(PROFILE)
    assert (profile.haps, profile.made_for_hz) == (10, 30)
    assert profile.notes_at(Fraction(30)) == []
    assert "made for 30 Hz, used at 60 Hz" in profile.notes_at(Fraction(60))[0]


def test_a_move_starts_without_the_pixel_clock():
    line = fast.plan(FAST, 500).line()
    assert line.decode == PLAIN and not line.clocked
    assert runs.queue_entries(line)[0] == (runs.MARK_START, 0)
    clocked = Line(line.counts, PLAIN)
    assert runs.queue_entries(clocked)[0] == (runs.MARK_START | runs.MARK_WAIT_FOR_EDGE, 0)


def invoke(*words):
    return CliRunner().invoke(main, [str(word) for word in ("move", *words)])


def test_make_writes_the_move(tmp_path):
    out = tmp_path / "move.csv"
    done = invoke("make", PROFILE, "--steps", -3000, "--pixel-hz", 30, "-o", out)
    assert done.exit_code == 0, done.output
    assert sum(formats.read_csv(out).values) == -3000
    assert "-3000 steps in 30 pixels, 1.000 s at 30 Hz" in done.output


def test_show_tells_pixels_speeds_and_places(tmp_path):
    words = ("show", PROFILE, "--steps", 3000, "--pixel-hz", 30)
    done = invoke(*words, "--plot", tmp_path / "plan.png")
    assert done.exit_code == 0, done.output
    assert "14 to 17" in done.output and "6780" in done.output
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")
    plan = json.loads(invoke(*words, "--json").stdout)
    assert sum(count * repeat for count, repeat in plan["runs"]) == 3000 == plan["steps"]


@pytest.mark.parametrize(
    ("words", "text", "status"),
    [
        ((SAMPLE_CSV, "--steps", 5), "truncated, 3 of 100", 3),
        ((SAMPLE_CSV, "--raw", "--steps", 5), ":7:6: the speed falls from 100 to 2", 3),
        ((PROFILE, "--steps", 0), "a move of 0 steps", 2),
    ],
)
def test_misuse_is_one_line(tmp_path, words, text, status):
    done = invoke("make", *words, "--pixel-hz", 30, "-o", tmp_path / "x.csv")
    assert done.exit_code == status and text in done.output
    assert not (tmp_path / "x.csv").exists()


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_random_moves_on_one_board_end_on_their_step(board):
    """One move after the other: register and count follow the sum of all of them."""
    rng = random.Random(board)
    sizes = [1, 2, 3, *(random_steps(rng, 30_000) for _ in range(cases(8, 25)))]
    place = edges = 0
    with Bench(board, hz=30) as bench:
        for steps in sizes:
            signed = rng.choice((-1, 1)) * steps
            bench.load(fast.plan(FAST, signed).line())
            bench.arm()
            bench.until(lambda: bench.state() == "done")
            place, edges = place + signed, edges + steps
            assert bench.board.axis(0)["position_steps"] == place
            assert (bench.sim.steps(0, 0), bench.count()) == (place, edges)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("board", "axis", "steps"),
    [
        ("mega", 0, FARTHEST),
        ("mega", 3, -98_765),
        ("uno", 0, 43_210),
        ("uno", 0, 1),
    ],
)
def test_every_edge_of_a_move(tmp_path, board, axis, steps):
    job = MoveJob(FAST, fast.plan(FAST, steps), board, axis, Fraction(30))
    done = experiments.simulate_move(job, tmp_path)
    summary = done.judged.summary
    assert summary["reasons"] == [] and done.judged.passed
    assert summary["move"]["position_register_steps"] == steps
    assert summary["move"]["counted_steps"] == steps
    (found,) = summary["axes"]
    assert found["steps"] == abs(steps) and found["max_edge_error_ticks"] < 1
    assert summary["clock_edge_cycle"] is None


@pytest.mark.usefixtures("simulator")
def test_sim_command_draws_and_judges(tmp_path):
    words = ("sim", PROFILE, "--steps", -5000, "--board", "mega", "--pixel-hz", 30, "--axis", 2)
    done = invoke(*words, "--plot", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert "PASS" in done.output and "ends at -5000 by the board's position register" in done.output
    assert (tmp_path / "move.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "summary.json").read_text())["verdict"] == "pass"


@pytest.mark.usefixtures("simulator")
def test_a_move_too_fast_for_the_board_is_refused(tmp_path):
    steep = fast.Acceleration((100, 9000))
    job = MoveJob(steep, fast.plan(steep, 50_000), "uno", 0, Fraction(60))
    done = experiments.simulate_move(job, tmp_path)
    assert done.judged.summary["verdict"] == "refused"
    assert done.judged.summary["refusal"]["name"] == "too_fast"
    assert done.judged.summary["move"]["counted_steps"] == 0
