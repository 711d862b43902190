# SPDX-License-Identifier: MIT
"""Drives of motors in real time: through a server of the port, and paced simulated boards."""

import time

import pytest

import pixstep as px
from drive_bench import STOP, Watched, move
from pixstep.board.port import Port
from pixstep.motor_drive import BusDrives, DrivenMotor, Pacer
from pixstep.motor_record.traffic import Msta
from pixstep.server.serving import BusServer
from serverbench import until
from sim_terminal import on_terminal

pytestmark = pytest.mark.usefixtures("simulator")
MOTORS = [DrivenMotor("x", 1, 0), DrivenMotor("y", 1, 1)]


class Clock:
    """The time of a real bus, as `Watched` asks for it."""

    @property
    def time_s(self):
        return time.monotonic()

    def let_pass(self, seconds):
        time.sleep(seconds)


class Quiet:
    """What a server tells, unheard."""

    def tell(self, event, **facts):
        pass


def test_through_a_server_that_is_killed_and_back(runtime):
    with on_terminal("mega", 30) as (name, _):
        port = Port(name, timeout_s=0.5)
        server = BusServer(port, Quiet())
        server.open()
        server.listen_here(None)
        with px.connect(name) as bus:
            assert "server" in type(bus.link.modbus).__module__
            with BusDrives(bus.link, MOTORS) as drives:
                motor = Watched(Clock(), drives["x"], lambda: None)
                until(lambda: motor.seen, "a first status")
                motor.obey(move(400))
                assert motor.settle().position_steps == 400
                motor.obey(move(100_000))
                until(lambda: motor.seen and motor.last.position_steps > 500, "steps")
                motor.obey(STOP)
                made = motor.settle().position_steps
                server.close()
                until(lambda: Msta.COMM_ERR in motor.last.flags, "COMM_ERR")
                assert drives["x"].problem
                server = BusServer(port, Quiet())
                server.open()
                server.listen_here(None)
                until(lambda: Msta.COMM_ERR not in motor.last.flags, "the server is back")
                assert motor.last.position_steps == made and not drives["x"].problem
                motor.obey(move(0))
                assert motor.settle().position_steps == 0
            assert drives.failure is None
        server.close()


def test_a_simulated_bus_in_step_with_the_wall_clock():
    with (
        px.simulated_board("mega", pixel_hz=30) as board,
        Pacer(board.link),
        BusDrives(board.link, MOTORS) as drives,
    ):
        motor = Watched(Clock(), drives["x"], lambda: None)
        until(lambda: motor.seen, "a first status")
        begun_s = time.monotonic()
        motor.obey(move(2000, 2000, 2000))
        assert motor.settle().position_steps == 2000
        assert 1.0 < time.monotonic() - begun_s < 6.0
    assert drives.failure is None


def test_a_simulator_that_has_ended_is_told(caplog):
    with px.simulated_board("mega", pixel_hz=30) as board, Pacer(board.link) as pacer:
        board.link.simulator.kill()
        until(lambda: pacer.failure, "no time passes any more")
    (record,) = caplog.records
    assert record.getMessage().startswith("the simulator: its time stands still: simulator: ")
    assert record.exc_info is None
