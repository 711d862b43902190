# SPDX-License-Identifier: MIT
"""The play of an axis, measured at its home switch on simulated boards."""

import random
import shlex
import sys
from fractions import Fraction

import pytest

from effort import cases
from homebench import PROFILE, HomeBench
from pixstep.errors import UserError
from pixstep.machine import files
from pixstep.machine.files import MachineFile
from pixstep.moves import play_measurement
from pixstep.moves.homing import HomingError

HZ = Fraction(500)
SLOWEST = 1  # steps/px: 2 ms a step, longer than any contact here takes
RANDOM_PLANTS = cases(3, 200)
ON_ONE_BOARD = 20


def measured(bench, **options):
    plan = bench.plan(slow=SLOWEST, search_steps=6000)
    options.setdefault("repeat", 2)
    if options.pop("by_encoder", False):
        options["encoder"] = bench.load_position
    return play_measurement.measure(bench.board, plan, bench.hz, bench.world, **options)


def random_plant(rng):
    """Return knobs, and the play and hysteresis in them."""
    play, hysteresis = (
        rng.choice((0, 1, rng.randint(2, 60), rng.randint(61, 1500))),
        rng.randint(0, 40),
    )
    bounce = 2 * rng.randint(0, 4)
    knobs = (
        f"play={play},home=0,hyst={hysteresis},start={rng.randint(-1200, 1200)},"
        f"taken_up={rng.choice(('plus', 'minus'))},delay={rng.randint(0, 16_000)},"
        f"bounce={bounce},bounce_ticks={max(bounce, round(3000 ** rng.random()))}"
    )
    return knobs, play, hysteresis


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("board", "axis"), [("uno", 0), ("mega", 1), ("m1284", 1)])
def test_random_plants_are_measured_within_a_step(board, axis):
    rng = random.Random(f"{board} 16")
    left = RANDOM_PLANTS
    while left:
        many = min(left, ON_ONE_BOARD)
        left -= many
        with HomeBench(board, axis, knobs="home=0", hz=HZ) as bench:
            for _ in range(many):
                knobs, play, hysteresis = random_plant(rng)
                bench.sim.knobs(0, axis, knobs)
                bench.sim.wait_s(0.01)  # the filters see the switch
                found = measured(bench, hysteresis=hysteresis)
                assert abs(found.play - play) <= 1 and found.spread <= 1, (knobs, found)


@pytest.mark.usefixtures("simulator")
def test_without_its_hysteresis_the_sum_is_found_and_an_encoder_tells_them_apart():
    with HomeBench("uno", knobs="play=37,home=0,hyst=9,start=-200,taken_up=minus", hz=HZ) as bench:
        found = measured(bench)
        assert (found.play, found.hysteresis, found.spread) == (46, None, 0)
        found = measured(bench, by_encoder=True)
        assert (found.play, found.hysteresis, found.spread) == (37, 9, 0)
        with pytest.raises(UserError, match="46 steps apart, less than its hysteresis of 47"):
            measured(bench, hysteresis=47)


@pytest.mark.usefixtures("simulator")
def test_in_the_minus_direction():
    with HomeBench("mega", knobs="play=37,home=0,hyst=9,start=300,active=high", hz=HZ) as bench:
        plan = bench.plan(direction=-1, slow=SLOWEST, search_steps=6000)
        found = play_measurement.measure(
            bench.board, plan, bench.hz, bench.world, repeat=2, hysteresis=9
        )
        assert (found.play, found.spread) == (37, 0)


@pytest.mark.usefixtures("simulator")
def test_a_switch_that_is_not_there_is_a_named_fault():
    with HomeBench("mega", knobs="home=90000,start=0", hz=HZ) as bench:
        with pytest.raises(HomingError, match="did not close within") as caught:
            measured(bench)
        assert caught.value.name == "home_not_found"


def test_at_least_one_approach():
    with pytest.raises(UserError, match="0 approaches: at least 1"):
        play_measurement.measure(None, None, HZ, None, repeat=0)


def test_the_middle_of_the_approaches_counts():
    found = play_measurement.MeasuredPlay(
        0, tuple(play_measurement.Approach(place, 0) for place in (50, 44, 45)), 5, False
    )
    assert (found.play, found.spread) == (40, 6)


MACHINE = """\
# my machine
[clock]
pixel = "500 Hz"

[boards.main]
kind = "mega"

[motors.M40]   # the slide
axis = 1
kind = "plain"
backlash = "3 steps"   # by hand
steps_per_unit = "400 steps/mm"

[motors.M41]
axis = 2
kind = "plain"
"""


def test_the_machine_file_keeps_its_comments(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE)
    files.set_backlash(path, "M40", 37)
    assert path.read_text() == MACHINE.replace('"3 steps"', '"37 steps"')
    files.set_backlash(path, "M41", 4)
    machine = MachineFile.load(path)
    assert machine["M41"].backlash_steps == 4 and "# my machine" in path.read_text()
    with pytest.raises(UserError, match="there is no motor 'M42'"):
        files.set_backlash(path, "M42", 1)
    before = path.read_text() + "[nonsense\n"
    path.write_text(before)
    with pytest.raises(UserError, match=r"machine\.toml:\d+"):
        files.set_backlash(path, "M40", 1)
    assert path.read_text() == before


def test_the_profile_is_quick_enough_to_matter():
    assert max(PROFILE.counts[: PROFILE.haps]) > 20 * SLOWEST


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("print('12,5')", "printed '12,5"),
        ("print('nan')", "printed 'nan"),
        ("raise SystemExit(4)", "ended with status 4"),
    ],
)
def test_an_encoder_s_command_that_does_not_tell(code, message):
    read = play_measurement.of_command(shlex.join([sys.executable, "-c", code]))
    with pytest.raises(UserError, match=message):
        read()


def test_an_encoder_s_command():
    assert (
        play_measurement.of_command(shlex.join([sys.executable, "-c", "print(-12.5)"]))() == -12.5
    )
    with pytest.raises(UserError, match="No such file"):
        play_measurement.of_command("no-such-program-anywhere")()
    for text in ("", "  ", "'"):
        with pytest.raises(UserError, match="encoder"):
            play_measurement.of_command(text)
