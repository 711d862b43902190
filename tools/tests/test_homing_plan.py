# SPDX-License-Identifier: MIT
"""Homing's plan and sequence, over a test double of board and plant."""

import itertools
import random
from fractions import Fraction

import pytest

from fake_home import FakeHome, Plant
from pixstep.board import registers as regs
from pixstep.errors import UserError
from pixstep.lines import runs
from pixstep.moves import fast, homing, legs
from pixstep.moves.homing import HomingError
from worked import DATA

PROFILE = fast.read(DATA / "AccProf-fast-move.csv")
HZ = Fraction(300)


def plan(direction=1, **changes):
    request = legs.HomingRequest(0, direction, **{"search_steps": 6000, **changes})
    return legs.plan(PROFILE, request, HZ)


def home(plant, made=None, **options):
    board = FakeHome(plant, hz=int(HZ), **options)
    return homing.home(board, made or plan(), HZ, board), board


def test_a_seek_line_is_a_ramp_held_and_mirrored():
    seek = legs.seek_line(fast.Acceleration((4, 12, 20)), -1, 100)
    assert seek.rising == (-4, -12, -20) and seek.falling == (-12, -4) and seek.hold_px == 2
    assert (seek.steps, seek.pixels) == (-92, 7)
    assert runs.seek_entries(seek) == [
        (runs.MARK_START | runs.MARK_SEEK, 0), (0, 0), (-4, 1), (-12, 1), (-20, 3),
        (runs.MARK_DOWN, 0), (-12, 1), (-4, 1), (runs.MARK_END, 0),
    ]  # fmt: skip


def test_a_seek_for_opening_at_one_speed():
    seek = legs.seek_line(fast.Acceleration((5,)), 1, 70_000 * 5, opens=True)
    assert runs.seek_entries(seek) == [
        (runs.MARK_START | runs.MARK_SEEK | runs.MARK_SEEK_OPEN, 0), (0, 0),
        (5, 65_535), (5, 70_000 - 65_535), (runs.MARK_DOWN, 0), (runs.MARK_END, 0),
    ]  # fmt: skip


@pytest.mark.parametrize("steps", range(4, 400, 7))
def test_a_search_never_goes_beyond_its_distance(steps):
    ramp = PROFILE.leading(10)
    seek = legs.seek_line(ramp, 1, steps)
    assert steps - seek.rising[-1] < seek.steps <= steps or len(seek.rising) < 10
    assert seek.steps <= steps and seek.rising == ramp.counts[: len(seek.rising)]


def test_homing_uses_the_first_haps_entries_of_the_profile():
    assert plan().ramp.counts == PROFILE.counts[:10] and plan().top == PROFILE.counts[9]
    assert plan(haps=3).top == PROFILE.counts[2]
    assert plan(haps=99).top == PROFILE.top
    assert plan().slow == PROFILE.counts[0] and plan(slow=1).slow == 1


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"haps": 0}, "HAPs 0"),
        ({"slow": 5}, "slow approach at 5 steps/pixel: 1 to 4"),
        ({"slow": 0}, "slow approach at 0"),
        ({"search_steps": 3}, "search distance 3 is less than the first entry"),
        ({"search_steps": 0}, "search distance 0"),
        ({"clear_steps": -1}, "clear distance -1"),
    ],
)
def test_plans_that_cannot_be(changes, text):
    with pytest.raises(UserError, match=text):
        plan(**changes)


def test_a_profile_without_haps_needs_the_option():
    with pytest.raises(UserError, match="give haps"):
        legs.plan(fast.Acceleration((4, 8)), legs.HomingRequest(0, 1), HZ)


def names(result):
    return [leg.name for leg in result.legs]


def test_from_an_open_switch():
    result, board = home(Plant(start=123))
    assert names(result) == list(homing.LEGS[1:])
    assert board.plant.load == 2000 and result.position_steps == 0 == board.position
    assert result.edge.position_steps == 2000 - 123
    assert result.legs[-1].steps == -result.zeroed_steps < 0
    assert result.as_json()["legs"][0]["steps"] == result.legs[0].steps


def test_from_a_closed_switch_it_leaves_first():
    result, board = home(Plant(start=3000))
    assert names(result)[0] == "leave the switch" and board.plant.load == 2000
    assert result.position_steps == 0


def test_never_faster_than_the_haps_entry_and_steps_no_higher_than_the_profile():
    _, board = home(Plant(start=-300))
    entries = (0, *PROFILE.counts[:10])
    for counts in board.moves:
        sizes = [abs(count) for count in counts]
        assert max(sizes) <= entries[-1]
        for before, after in zip((0, *sizes), (*sizes, 0), strict=True):
            low, high = sorted((before, after))
            assert high == low or any(
                a <= low and high <= b for a, b in itertools.pairwise(entries)
            )


@pytest.mark.parametrize("clear", [500, 20])
def test_the_slow_approach_starts_clear_of_the_switch(clear):
    made = plan(clear_steps=clear)
    result, board = home(Plant(start=1990), made)
    assert "stand clear" in names(result) and board.plant.load == 2000
    slow = result.legs[names(result).index("slow approach")]
    opened = result.legs[names(result).index("back off")].trip.position_steps
    assert opened - slow.start_steps == clear


def test_many_starts_and_delays_end_on_one_step():
    rng = random.Random(7)
    made = plan(slow=2)
    ends = set()
    for _ in range(200):
        plant = Plant(start=rng.randint(-450, 3950), delay_s=rng.uniform(0, 0.001))
        home(plant, made)
        ends.add(plant.load)
    assert max(ends) - min(ends) <= 1


@pytest.mark.parametrize(
    ("plant", "changes", "name", "text"),
    [
        (Plant(stuck=False), {}, "limit_plus", r"plus limit switch tripped \(approach"),
        (Plant(stuck=False), {"search_steps": 900}, "home_not_found", "did not close within"),
        (Plant(stuck=True), {}, "limit_minus", r"minus limit switch tripped \(leave the switch"),
        (Plant(stuck=True), {"search_steps": 400}, "home_stuck", "did not open within"),
    ],
)
def test_named_faults_in_words(plant, changes, name, text):
    with pytest.raises(HomingError, match=text) as caught:
        home(plant, plan(**changes))
    assert caught.value.name == name and str(caught.value).startswith(f"axis 0: {name}: ")
    assert len(caught.value.legs) == 1 and caught.value.legs[0].steps


def test_a_leg_too_long_for_the_queue_is_refused_before_it_moves():
    with pytest.raises(HomingError, match=r"approach takes \d+ queue entries.*fewer HAPs"):
        home(Plant(), plan(haps=20))


def test_minus_direction_turns_every_leg():
    minus, plus = plan(direction=-1), plan()
    for leg in ("approach", "back_off", "slow_approach"):
        turned, straight = getattr(minus, leg)(), getattr(plus, leg)()
        assert [-count for count in turned.rising] == list(straight.rising)
        assert (turned.hold_px, turned.opens) == (straight.hold_px, straight.opens)


def test_a_leg_that_does_not_get_on_is_given_up():
    """Two seconds and eight pixels without a step, a pixel or another state."""

    class Stuck(FakeHome):
        def run(self, entries):
            self.end_s = float("inf")

    stuck = Stuck(Plant())
    text = "axis 0: approach does not get on: for 2.03 s running in pixel 0"
    with pytest.raises(HomingError, match=text):
        homing.home(stuck, plan(), Fraction(300), stuck)
    assert 2.0 < stuck.time < 2.1


def test_a_board_slower_than_its_time_is_waited_for():
    """As a simulated board on a busy machine is: by the wall clock each leg takes seconds."""

    class Slow(FakeHome):
        slowness = 60.0

        def now_s(self):
            return self.slowness * self.time

        def axis(self, axis):
            state = super().axis(axis)
            if regs.axis_state(state["axis_state"]) == "running":
                state["pixel"] = int(self.time * self.hz)
            return state

    slow = Slow(Plant())
    assert homing.home(slow, plan(), Fraction(300), slow).legs[-1].end_steps == 0
    assert slow.now_s() > 15
