# SPDX-License-Identifier: MIT
"""The drive of motor records on simulated boards, its commands by hand, judged by STEP edges."""

import random
import time
from fractions import Fraction

import numpy as np
import pytest

import pixstep as px
from drive_bench import STOP, Watched, counter, driven, home, jog, move, rising_s, speeds
from effort import cases
from pixstep.board import boards, settings
from pixstep.motor_drive import BusDrives, DrivenMotor
from pixstep.motor_record.traffic import MotorCommand, Msta, Verb
from pixstep.moves.trapezoid import MoveKinematics, Trapezoid

pytestmark = pytest.mark.usefixtures("simulator")
QUIET_S = 0.3


def turn_estop(bus, *, pressed):
    """Press or release the emergency stop of the first board."""
    pin = next(pin for pin in boards.load("mega").pins if pin.signal == "ESTOP")
    bus.link.simulator.pin(0, pin.port, pin.bit, int(not pressed))


def at_rest(motor, position):
    """Whether a motor rests where it should: by its status, at the pins, and for a while."""
    motor.settle()
    made = motor.edges()
    motor.bus.let_pass(0.05)
    return (motor.last.position_steps, made, motor.edges()) == (position, made, made)


@pytest.mark.parametrize("kind", ["uno", "mega", "m1284"])
def test_moves_end_where_they_should(kind):
    chosen = random.Random(kind)
    hz = 30
    with driven([kind], [(1, 0)], pixel_hz=hz) as (_, drives, watched):
        motor, here = watched["1.0"], 0
        for _ in range(cases(8, 400)):
            speed, acceleration = 10 ** chosen.uniform(1.5, 4), 10 ** chosen.uniform(3, 6)
            base = chosen.choice([0, chosen.uniform(0, speed)])
            steps = int(chosen.choice([1, -1, 5, -30, 300, 3000]) * chosen.uniform(1, 3))
            steps = max(-int(3 * speed), min(steps, int(3 * speed)))
            verb = chosen.choice([Verb.MOVE_ABS, Verb.MOVE_REL])
            begun_s = motor.bus.time_s
            here += steps
            target = here if verb is Verb.MOVE_ABS else steps
            motor.obey(move(target, speed, base, acceleration, verb=verb))
            motor.settle(slice_s=0.005)
            assert motor.edges() == motor.last.position_steps == here
            top = int(drives["1.0"].top_speed_steps_s / hz)
            wanted = MoveKinematics(speed, base, acceleration).within(top, hz)
            late_s = motor.times[-1] - begun_s - Trapezoid(steps, wanted, hz).lasts_s
            assert 0 < late_s < 0.08  # requests before it, a look after it
            assert (Msta.DIRECTION in motor.last.flags) == (steps > 0)
            assert not drives["1.0"].problem


def test_no_edge_comes_after_done(tmp_path):
    chosen = random.Random(4)
    path = tmp_path / "edges.csv"
    done_s, asked_s = [], []
    with driven(["mega"], [(1, 0)], pixel_hz=100, edges=path) as (bus, _, watched):
        motor = watched["1.0"]
        for _ in range(cases(12, 300)):
            asked_s.append(bus.time_s)
            steps = chosen.randint(-900, 900) or 1
            motor.obey(move(steps, chosen.uniform(300, 6000), verb=Verb.MOVE_REL))
            if chosen.random() < 0.4:
                bus.let_pass(chosen.uniform(0, 0.3))
                motor.obey(STOP)
            motor.settle(slice_s=0.003)
            done_s.append(motor.times[-1])
            bus.let_pass(0.05)
    edges = rising_s(path)
    for done, asked in zip(done_s, [*asked_s[1:], np.inf], strict=True):
        assert not np.any((edges > done) & (edges < asked))


def test_a_long_move_begins_at_once_and_is_stopped_in_its_middle(tmp_path):
    path = tmp_path / "edges.csv"
    with driven(["uno"], [(1, 0)], edges=path) as (bus, _, watched):
        motor = watched["1.0"]
        asked_s = bus.time_s
        motor.obey(move(1_000_000, 1234.5))
        bus.let_pass(5)
        moving = motor.last
        assert Msta.MOVING in moving.flags
        motor.obey(STOP)
        made = motor.settle().position_steps
        assert 5500 < made == motor.edges() < 6300
        assert at_rest(motor, made)
    edges = rising_s(path)
    assert 0 < edges[0] - asked_s < 0.05
    spacing = np.diff(edges)[500:-1]  # at speed: without a gap, within the rounding of a pixel
    assert np.all((spacing > 0.95 / 1234.5) & (spacing < 1.05 / 1234.5))


@pytest.mark.parametrize("speed", [300, 300.000001])
def test_a_move_of_months_begins_at_once(speed, monkeypatch):
    """Its pixels are all alike: who looked for one that is not would keep the bus for minutes."""
    made, pixels = Trapezoid._made, []

    def counted(self, pixel):
        pixels.append(pixel)
        assert len(pixels) < 100_000  # of 200 million
        return made(self, pixel)

    monkeypatch.setattr(Trapezoid, "_made", counted)
    with driven(["mega"], [(1, 0), (1, 1)]) as (bus, drives, watched):
        motor, other = watched["1.0"], watched["1.1"]
        motor.obey(move(2_000_000_000, speed))
        bus.let_pass(1)
        other.obey(move(40, speed))
        assert at_rest(other, 40)
        assert motor.edges() > 250 and Msta.MOVING in motor.last.flags
        motor.obey(STOP)
        assert at_rest(motor, motor.settle().position_steps)
        assert not any(drive.problem for drive in drives.values())


def test_a_move_of_no_steps_ends_at_once():
    with driven(["mega"], [(1, 0)]) as (bus, _, watched):
        motor = watched["1.0"]
        for commands in (move(0), move(0, verb=Verb.MOVE_REL)):
            begun_s = bus.time_s
            motor.obey(commands)
            motor.settle(slice_s=0.001)
            assert motor.times[-1] - begun_s < 0.02
            assert motor.edges() == motor.last.position_steps == 0


def legs(motor, first, second, wait_s=0.0):
    """Give a first leg that announces a second one; return the commands of that."""
    then = move(second, 800, 100, 8000)
    motor.bus.let_pass(wait_s)
    motor.obey(move(first), then)
    return then


@pytest.mark.parametrize("first", [-40, -4000, 400])
def test_the_board_goes_from_leg_to_leg_by_itself(first, tmp_path):
    path = tmp_path / "edges.csv"
    answer_s = 0.05  # the host thinks so long, and the board does not wait for it
    with driven(["mega"], [(1, 0)], pixel_hz=100, edges=path) as (bus, _, watched):
        motor = watched["1.0"]
        then = legs(motor, first, first + 30)
        assert motor.settle(slice_s=0.002).position_steps == first
        bus.let_pass(answer_s)
        motor.obey(then)
        assert motor.settle(slice_s=0.002).position_steps == first + 30
        assert any(Msta.MOVING in one.flags for one in motor.seen)
        assert motor.edges() == first + 30
        motor.obey(then)  # asked for again: nothing moves
        assert at_rest(motor, first + 30)
    edges = rising_s(path)
    assert len(edges) == abs(first) + 30
    seam = abs(first)
    assert edges[seam] - edges[seam - 1] < 0.025


def test_another_answer_at_the_end_of_the_first_leg():
    with driven(["mega"], [(1, 0)], pixel_hz=100) as (bus, _, watched):
        motor = watched["1.0"]
        for answer, ends in (
            (move(700), 700),
            (move(100, verb=Verb.MOVE_REL), 600),  # from where the record has seen the motor
            ((), None),  # no second leg is wanted
            (STOP, None),
            (None, None),  # no answer at all
        ):
            motor.obey(move(0))
            assert at_rest(motor, 0)
            legs(motor, 500, 2500)
            assert motor.settle(slice_s=0.002).position_steps == 500
            if answer is None:
                bus.let_pass(1.2)
            else:
                motor.obey(answer)
            bus.let_pass(0.02)
            position = motor.settle().position_steps if ends is None else ends
            assert at_rest(motor, position)
            assert motor.edges() == position and 500 <= position < 2500


@pytest.mark.parametrize("stop_s", [0.3, 0.62, 0.7])
def test_a_stop_in_either_leg(stop_s):
    with driven(["mega"], [(1, 0)], pixel_hz=100) as (bus, _, watched):
        motor = watched["1.0"]
        then = legs(motor, -2000, -1800)
        confirmed, end_s = False, bus.time_s + stop_s
        while bus.time_s < end_s - 1e-6:
            bus.let_pass(min(0.01, end_s - bus.time_s))
            if motor.rests and not confirmed:
                confirmed = True
                motor.obey(then)
        motor.obey(STOP)
        motor.settle()
        assert at_rest(motor, motor.edges()) and -2000 <= motor.edges() < 0
        motor.obey(move(-1800))
        assert at_rest(motor, -1800) and motor.edges() == -1800


@pytest.mark.parametrize(("kind", "hz"), [("uno", 30), ("mega", 1000)])
@pytest.mark.parametrize("velocity", [15, -700, 6000])
def test_a_jog_keeps_its_speed_without_a_gap(kind, hz, velocity, tmp_path):
    path = tmp_path / "edges.csv"
    with driven([kind], [(1, 0)], pixel_hz=hz, edges=path) as (bus, _, watched):
        motor = watched["1.0"]
        motor.obey(jog(velocity, base=abs(velocity)))
        bus.let_pass(2.5)
        motor.obey(STOP)
        position = motor.settle().position_steps
        assert at_rest(motor, position) and motor.edges() == position
        assert position == pytest.approx(2.5 * velocity, rel=0.05, abs=2)
    spacing = np.diff(rising_s(path))
    even_s = 1 / abs(velocity)
    assert np.max(spacing) < even_s + 1.1 / hz if abs(velocity) < hz else 1.3 * even_s


def test_a_jog_changes_its_speed_and_turns():
    with driven(["mega"], [(1, 0)], pixel_hz=100) as (bus, _, watched):
        motor = watched["1.0"]
        motor.obey(jog(1000))
        bus.let_pass(1.5)
        before = motor.edges()
        motor.obey([MotorCommand(Verb.JOG_VELOCITY, 3000)])
        bus.let_pass(2)
        faster = motor.edges()
        assert faster - before > 3500
        motor.obey([MotorCommand(Verb.JOG_VELOCITY, -2000)])
        bus.let_pass(3)
        assert motor.edges() < faster
        assert Msta.MOVING in motor.last.flags and Msta.DIRECTION not in motor.last.flags
        motor.obey(STOP)
        assert at_rest(motor, motor.settle().position_steps)
        assert motor.edges() == motor.last.position_steps


PLANTS = {
    (1, 0): "home=2000,hyst=8,travel=-500..4000,start=100",
    (1, 1): "home=9000,hyst=8,travel=-500..1000,start=100",
}


def test_home_limits_and_faults():
    with driven(["mega"], [(1, 0), (1, 1)], pixel_hz=100, plants=PLANTS) as (bus, drives, watched):
        good, bad = watched["1.0"], watched["1.1"]
        good.obey(home(Verb.HOME_FOR))
        good.settle()
        assert good.last.position_steps == 0 and good.edges() == 1900
        assert good.flags() == Msta.DONE | Msta.HOME | Msta.HOMED
        good.obey(move(-300))
        assert at_rest(good, -300) and good.edges() == 1600

        bad.obey(move(3000))  # the switch of one axis stops all of its board
        good.obey(move(-1800))
        assert bad.settle().position_steps == bad.edges() < 920
        assert bad.flags() == Msta.DONE | Msta.PLUS_LS and not drives["1.1"].problem
        assert good.settle().flags & Msta.PROBLEM and "limit_plus" in drives["1.0"].problem
        assert good.last.position_steps == good.edges() - 1900
        made = bad.edges()
        bad.obey(move(3000))  # on towards the switch: nothing moves
        bad.settle()
        bad.obey(jog(500))
        bad.settle()
        assert bad.edges() == made and bad.flags() == Msta.DONE | Msta.PLUS_LS
        bad.obey(move(0))  # away from it
        assert at_rest(bad, 0) and bad.flags() == Msta.DONE
        good.obey(move(0))
        assert at_rest(good, 0) and not drives["1.0"].problem

        bad.obey(home(Verb.HOME_FOR))  # the limit switch comes first
        bad.settle()
        assert bad.flags() == Msta.DONE | Msta.PLUS_LS | Msta.PROBLEM
        assert "limit_plus" in drives["1.1"].problem
        bad.obey(home(Verb.HOME_REV))
        bus.let_pass(0.3)
        bad.obey(STOP)
        bad.settle()
        bus.let_pass(QUIET_S)
        assert bad.last.position_steps == bad.edges() and Msta.HOMED not in bad.last.flags
        bad.obey([MotorCommand(Verb.LOAD_POS, 77)])
        bad.settle()
        assert bad.last.position_steps == 77 and bad.flags() == Msta.DONE


def test_a_home_switch_that_is_not_found():
    with driven(
        ["uno"], [(1, 0)], pixel_hz=100, plants={(1, 0): PLANTS[1, 0]}, search_steps=900
    ) as (_, drives, watched):
        motor = watched["1.0"]
        motor.obey(home(Verb.HOME_FOR))
        motor.settle()
        assert Msta.PROBLEM in motor.last.flags and "home_not_found" in drives["1.0"].problem
        assert motor.last.position_steps == motor.edges()
        motor.obey(move(0))
        assert at_rest(motor, 0) and not drives["1.0"].problem


def test_a_board_that_is_switched_off_and_back():
    axes = [(1, 0), (2, 0)]
    with driven(["mega", "uno"], axes) as (bus, drives, watched):
        lost, other = watched["1.0"], watched["2.0"]
        simulator = bus._simulated.simulator
        lost.obey(move(8000))
        other.obey(move(20_000))
        bus.let_pass(1)
        simulator.supply(0, "off")
        made = lost.edges()
        bus.let_pass(1)
        assert lost.last.flags & Msta.COMM_ERR and drives["1.0"].problem
        assert Msta.COMM_ERR not in other.last.flags and not drives["2.0"].problem
        bus.let_pass(2.5)  # by now all that was queued would be over
        assert lost.flags() & (Msta.DONE | Msta.COMM_ERR) == Msta.DONE | Msta.COMM_ERR
        lost.obey(move(0))  # not kept for later
        lost.settle()
        simulator.supply(0, "on")
        bus.let_pass(4.5)
        assert lost.flags() == Msta.DONE | Msta.PROBLEM
        assert "was reset" in drives["1.0"].problem
        assert lost.edges() == made  # nothing has moved since
        lost.obey(move(100))
        lost.settle()
        assert lost.edges() == made and Msta.PROBLEM in lost.last.flags
        lost.obey([MotorCommand(Verb.LOAD_POS, 500)])
        lost.settle()
        lost.obey(move(600))
        assert at_rest(lost, 600) and lost.edges() == made + 100
        assert not drives["1.0"].problem
        assert at_rest(other, 20_000) and other.edges() == 20_000


def test_a_bus_that_loses_requests_and_replies():
    chosen = random.Random(2)
    with driven(["mega"], [(1, 0)], pixel_hz=100) as (bus, drives, watched):
        motor, here, simulator = watched["1.0"], 0, bus._simulated.simulator
        transmit, lost = simulator.transmit, []

        def losing(data, timeout_cycles=None):
            kind = chosen.random()
            reply = transmit(data, timeout_cycles) if kind > 0.03 else b""
            if kind > 0.06:
                return reply
            lost.append(kind)
            simulator.run(timeout_cycles or 0)
            return b""

        simulator.transmit = losing
        for _ in range(cases(12, 200)):
            steps = chosen.choice([1, -40, 300, -900]) * chosen.randint(1, 3)
            then = legs(motor, here + steps, here + steps + 20)
            assert motor.settle().position_steps == here + steps
            motor.obey(then)
            here += steps + 20
            assert at_rest(motor, here) and motor.edges() == here
        assert len(lost) > 5 and not drives["1.0"].problem
        simulator.transmit = transmit


def test_what_no_motor_can_do_is_a_problem_in_words():
    with driven(["uno"], [(1, 0)]) as (_, drives, watched):
        motor = watched["1.0"]
        for commands, said in (
            (move(float("nan")), "nan"),
            (move(float("inf")), "inf"),
            (move(3e9), "counts to"),
            (move(100, speed=0), "speed of 0"),
        ):
            motor.obey(commands)
            motor.settle()
            assert Msta.PROBLEM in motor.last.flags and said in drives["1.0"].problem
        motor.obey(move(50))
        assert at_rest(motor, 50) and motor.edges() == 50 and not drives["1.0"].problem


def test_a_line_that_others_run_is_seen():
    import pixstep as px

    with driven(["mega"], [(1, 0)]) as (bus, _, watched):
        motor = watched["1.0"]
        motor.seen.clear()
        line = px.line([20] * 60, decode="plain", pixel_hz=30)
        with bus.board(1).start(line):
            bus.let_pass(1)
            assert Msta.MOVING in motor.last.flags and motor.last.position_steps > 100
            motor.drive.obey(move(0))  # not while it runs
            bus.let_pass(0.2)
            assert "another program" in motor.drive.problem
        bus.let_pass(0.6)
        assert at_rest(motor, 1200) and motor.edges() == 1200
        motor.obey(move(0))
        assert at_rest(motor, 0) and not motor.drive.problem


@pytest.mark.parametrize("by_position", [True, False])
@pytest.mark.parametrize("asked", [move(20_000, 3000), jog(3000)])
def test_nothing_moves_because_the_emergency_stop_was_released(asked, by_position):
    """Nor by a new target: a person clears the stop, or homes."""
    with driven(["mega"], [(1, 0)]) as (bus, drives, watched):
        motor, drive = watched["1.0"], drives["1.0"]
        motor.obey(asked)
        bus.let_pass(1.5)
        turn_estop(bus, pressed=True)
        motor.settle()
        made, here = motor.edges(), motor.last.position_steps
        for pressed in (True, False):
            turn_estop(bus, pressed=pressed)
            for again in (asked, move(here - 50)):
                motor.obey(again)
                motor.settle()
                bus.let_pass(QUIET_S)
                assert motor.edges() == made and drive.stopped_elsewhere
                assert "emergency stop" in drive.problem and Msta.PROBLEM in motor.last.flags
        if by_position:
            motor.obey([MotorCommand(Verb.LOAD_POS, here)])
        else:
            bus.board(1).clear_fault()
        bus.let_pass(QUIET_S)
        assert motor.edges() == made
        motor.obey(move(here - 50))
        motor.settle()
        assert motor.last.position_steps == here - 50 and not drive.problem


def test_a_position_that_is_set_while_the_emergency_stop_is_pressed_is_no_release():
    with driven(["mega"], [(1, 0)]) as (bus, drives, watched):
        motor = watched["1.0"]
        for pressed in (True, False):
            turn_estop(bus, pressed=pressed)
            bus.let_pass(QUIET_S)
            if pressed:
                motor.obey([MotorCommand(Verb.LOAD_POS, 7)])
            motor.obey(move(500))
            motor.settle()
            bus.let_pass(QUIET_S)
            assert motor.edges() == 0 and drives["1.0"].stopped_elsewhere, (
                pressed,
                drives["1.0"].problem,
            )


def test_homing_clears_an_emergency_stop_that_was_released():
    with driven(["mega"], [(1, 0)], plants={(1, 0): PLANTS[1, 0]}) as (bus, drives, watched):
        motor = watched["1.0"]
        for pressed in (True, False):
            turn_estop(bus, pressed=pressed)
            bus.let_pass(QUIET_S)
            motor.obey(home(Verb.HOME_FOR))
            motor.settle()
            assert (Msta.HOMED in motor.last.flags) != pressed
        assert motor.last.position_steps == 0 and not drives["1.0"].problem


@pytest.mark.parametrize("asked", [move(20_000, 3000), jog(3000)])
def test_a_stop_by_another_program_is_told_apart(asked):
    with driven(["mega"], [(1, 0)]) as (bus, drives, watched):
        motor, drive = watched["1.0"], drives["1.0"]
        motor.obey(asked)
        bus.let_pass(1.5)
        motor.obey(STOP)
        motor.settle()
        assert not drive.stopped_elsewhere
        motor.obey(asked)
        bus.let_pass(1.5)
        bus.board(1).stop()
        motor.settle()
        assert drive.stopped_elsewhere and Msta.PROBLEM in motor.last.flags
        here = motor.last.position_steps
        assert at_rest(motor, here)
        motor.obey(move(here + 50))
        assert at_rest(motor, here + 50) and not drive.stopped_elsewhere


def test_a_board_of_another_kind_is_told_nothing():
    with px.simulated_bus(["mega"], pixel_hz=30) as bus:
        motors = [DrivenMotor("a", 1, 0)]
        before = settings.read(bus.link.board(1))
        with BusDrives(bus.link, motors, clock_hz=Fraction(50), kinds={1: "uno"}) as drives:
            watched = Watched(bus, drives["a"], counter(bus, motors[0]))
            bus.let_pass(1)
            watched.obey(move(100))
            bus.let_pass(2)
            assert watched.flags() & Msta.COMM_ERR
            assert drives["a"].problem == "board 1 is a mega, and should be a uno"
            assert watched.edges() == 0
        assert settings.read(bus.link.board(1)) == before
        with BusDrives(bus.link, motors, kinds={1: "mega"}) as drives:
            watched = Watched(bus, drives["a"], counter(bus, motors[0]))
            bus.let_pass(1)
            watched.obey(move(100))
            watched.settle()
            assert watched.edges() == 100


SIX = [(1, 0), (1, 1), (1, 2), (1, 3), (2, 0), (3, 0)]


def test_six_axes_of_three_boards_at_once(tmp_path):
    path = tmp_path / "edges.csv"
    with driven(["mega", "uno", "uno"], SIX, edges=path) as (bus, _, watched):
        for wide in range(1, 3):
            asked_s = bus.time_s
            for place, motor in enumerate(watched.values()):
                motor.obey(move((-1) ** wide * (300 + 100 * place), 2000, 2000))
            for place, motor in enumerate(watched.values()):
                assert at_rest(motor, (-1) ** wide * (300 + 100 * place))
                assert motor.edges() == motor.last.position_steps
        first_s = asked_s
    starts = sorted(
        float(next(edge for edge in rising_s(path, unit - 1, axis) if edge > first_s) - first_s)
        for unit, axis in SIX
    )
    print(f"first STEP edges of six axes, ms: {[round(1000 * one, 1) for one in starts]}")
    assert starts[-1] < 0.15


@pytest.mark.parametrize(
    ("kinds", "axes", "hz"), [(["mega"], 4, 1000), (["m1284"], 2, 2000), (["mega"] * 4, 2, 500)]
)
def test_fast_pixels_do_not_run_dry_while_other_axes_begin(kinds, axes, hz):
    chosen = random.Random(hz)
    places = [(1 + board, axis) for board in range(len(kinds)) for axis in range(axes)]
    with driven(kinds, places, pixel_hz=hz) as (_, drives, watched):
        targets = dict.fromkeys(watched, 0)
        for _ in range(cases(2, 40)):
            for name, motor in watched.items():
                targets[name] += chosen.choice([-1, 1]) * chosen.randint(500, 1500)
                motor.obey(move(targets[name], 5000))
            for name, motor in watched.items():
                motor.settle()
                assert not drives[name].problem
                assert motor.edges() == motor.last.position_steps == targets[name]


def test_a_command_waits_for_one_request_of_others():
    with driven(["mega", "uno"], [(1, 0), (1, 1), (2, 0)]) as (bus, drives, watched):
        requests, modbus = [], bus.link.modbus
        ask = modbus.ask

        def noted(unit, pdu, **more):
            requests.append((bus.time_s, unit, pdu))
            return ask(unit, pdu, **more)

        modbus.ask = noted
        watched["1.1"].obey(move(100_000, 777))  # streamed
        watched["2.0"].obey(jog(700))
        bus.let_pass(2)
        waits = []
        for _ in range(cases(8, 40)):
            bus.let_pass(0.033)
            requests.clear()
            watched["1.0"].obey(move(30, verb=Verb.MOVE_REL))
            watched["1.0"].settle()
            mine = [
                place
                for place, (_, unit, pdu) in enumerate(requests)
                if unit == 1 and pdu[0] == 16 and pdu[1:3] == b"\x10\x00" and pdu[9] == 0
            ]
            waits.append(mine[0])
        modbus.ask = ask
        assert max(waits) <= 1 and not drives["1.0"].problem


def processor_share(bus, seconds):
    """Return the share of this process, the simulator not counted, while simulated time passes."""
    begun = time.process_time()
    bus.let_pass(seconds)
    return (time.process_time() - begun) / seconds


def test_latency_and_share_of_processor_time(tmp_path):
    path = tmp_path / "edges.csv"
    asked_s = []
    with driven(["mega", "mega"], [(unit, axis) for unit in (1, 2) for axis in range(4)],
                edges=path) as (bus, _, watched):  # fmt: skip
        motor = watched["1.0"]
        for nth in range(6):
            bus.let_pass(0.2 + 0.0371 * nth % 0.1)
            asked_s.append(bus.time_s)
            motor.obey(move(100, 5000, 5000, verb=Verb.MOVE_REL))
            motor.settle()
        motor.obey(jog(5000, 5000))
        bus.let_pass(0.5)
        stopped_s = bus.time_s
        motor.obey(STOP)
        motor.settle()
        resting = processor_share(bus, cases(2, 20))
        for one in watched.values():
            one.obey(move(20_000, 2000))
        moving = processor_share(bus, cases(1.5, 8))
    edges = rising_s(path)
    waits = [1000 * (edges[edges > one][0] - one) for one in asked_s]
    after = edges[(edges > stopped_s) & (edges < stopped_s + 0.5)]
    stop_ms = 1000 * (after[-1] - stopped_s)
    print(
        f"Mega, 115200 baud: from obey() to the first STEP edge {np.mean(waits):.1f} ms, at most "
        f"{max(waits):.1f} ms; from a stop to the last one {stop_ms:.1f} ms; processor's share of "
        f"8 axes {100 * resting:.2f} % at rest, {100 * moving:.2f} % moving"
    )
    assert max(waits) < 45 and stop_ms < 35


def test_each_command_twice():
    def twice(commands):
        return [one for one in commands for _ in (0, 1)]

    with driven(["mega"], [(1, 0)]) as (_, _, watched):
        motor = watched["1.0"]
        motor.obey(twice(move(500)))
        assert at_rest(motor, 500)
        motor.obey(twice(move(-200, verb=Verb.MOVE_REL)))
        assert at_rest(motor, 300)
        motor.obey(move(900))
        motor.obey(move(900))
        assert at_rest(motor, 900) and motor.edges() == 900
        motor.obey(twice(jog(800)))
        motor.bus.let_pass(0.5)
        motor.obey(twice(STOP))
        assert at_rest(motor, motor.settle().position_steps)
        assert motor.edges() == motor.last.position_steps > 900
        motor.obey(twice([MotorCommand(Verb.LOAD_POS, -5), MotorCommand(Verb.GET_INFO)]))
        assert at_rest(motor, -5)


@pytest.mark.parametrize("seed", range(cases(2, 30)))
def test_commands_in_any_order(seed):
    chosen = random.Random(seed)
    kind = chosen.choice(["mega", "uno"])
    with driven([kind], [(1, 0)], pixel_hz=chosen.choice([30, 200])) as (bus, drives, watched):
        motor, zero, target = watched["1.0"], 0, 0  # position = edges - zero
        for _ in range(24):
            what = chosen.choice(["move", "rel", "jog", "velocity", "stop", "load", "info", "wait"])
            if what == "move":
                target = chosen.randint(-800, 800)
                motor.obey(move(target, chosen.uniform(200, 5000)))
            elif what == "rel":
                motor.obey(move(chosen.randint(-300, 300), verb=Verb.MOVE_REL))
                target = None
            elif what == "jog":
                motor.obey(jog(chosen.uniform(-3000, 3000)))
                target = None
            elif what == "velocity":
                motor.drive.obey([MotorCommand(Verb.JOG_VELOCITY, chosen.uniform(-3000, 3000))])
            elif what == "stop":
                motor.obey(STOP)
                target = None
            elif what == "load":
                motor.obey(STOP)
                motor.settle()
                value = chosen.randint(-1000, 1000)
                motor.obey([MotorCommand(Verb.LOAD_POS, value)])
                motor.settle()
                zero, target = motor.edges() - value, value
            elif what == "info":
                motor.drive.obey([MotorCommand(Verb.GET_INFO), *speeds(1000)])
            bus.let_pass(chosen.choice([0, 0.01, 0.1, 0.4]))
            if chosen.random() < 0.3 and (target is not None or motor.rests):
                motor.settle()
                bus.let_pass(0.05)
                assert motor.last.position_steps == motor.edges() - zero
                assert target is None or motor.last.position_steps == target
                assert not drives["1.0"].problem
