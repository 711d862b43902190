# SPDX-License-Identifier: MIT
"""Faults under `pixstep ioc`: a simulated board on a terminal whose switches and supply are worked.

Real time: what is judged are states, positions and messages; times only guard against hanging.
"""

import json
import signal
import subprocess
import sys
import time

import pytest
from caproto import AlarmStatus, ChannelType

from effort import only_long
from iocbench import until
from iocprocess import Command
from pixstep.motor_record import Msta

MACHINE = """
[clock]
pixel = "100 Hz"

[epics]
prefix = "T:"

[boards.main]
kind = "mega"

[motors.a]
axis = 0
kind = "smooth"
limits = { max_speed = "2000 steps/s", max_acceleration = "20000 steps/s2" }
epics = { fields = { HLSV = 2, DHLM = 2e6, DLLM = -2e6 } }

[motors.b]
axis = 1
kind = "smooth"
limits = { max_speed = "2000 steps/s", max_acceleration = "20000 steps/s2" }
"""
HANG_S = 20


class World:
    """A simulated board, perhaps a server of its port, and `pixstep ioc`."""

    def __init__(self, folder):
        self.folder, self.link = folder, folder / "mega"
        self.serve = None
        (folder / "machine.toml").write_text(MACHINE)
        words = ("board", "simulate", "--board", "mega", "--pixel-hz", "100", "--json")
        self.board = subprocess.Popen(
            [sys.executable, "-m", "pixstep", *words, "--link", str(self.link)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.board.stdout.readline()

    def begin(self):
        """Start the records, and return a client."""
        self.command = Command(self.folder, "--port", str(self.link), program=["-m", "pixstep"])
        self.wire = self.command.wire()
        until(lambda: self.wire.value("T:a.UDF") == 0, HANG_S)
        return self.wire

    def begin_server(self):
        """Start a server of the port."""
        self.serve = subprocess.Popen(
            [sys.executable, "-m", "pixstep", "serve", "--port", str(self.link), "--json"],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert json.loads(self.serve.stdout.readline())["event"] == "serving"

    def end_server(self):
        """Let the server die at once."""
        self.serve.kill()
        self.serve.communicate()

    def do(self, text):
        """Work the bench."""
        self.board.stdin.write(f"{text}\n")
        self.board.stdin.flush()

    def close(self):
        """End all, and see that nothing has ended with a traceback."""
        status = self.command.end(signal.SIGINT)
        for process in (self.serve, self.board):
            if process is not None and process.poll() is None:
                process.kill()
                process.communicate()
        text = self.command.log.read_text()
        assert "Traceback" not in text, text
        assert status == 0, text

    def flags(self, name="a"):
        """Return MSTA of a record."""
        return Msta(int(self.wire.value(f"T:{name}.MSTA")))

    def alarm(self, name="a"):
        """Return status and severity of a record."""
        found = self.wire.get(f"T:{name}.RBV", ChannelType.TIME_DOUBLE).metadata
        return AlarmStatus(found.status).name, int(found.severity)

    def steps(self, name="a"):
        """Return the raw position of a record."""
        return self.wire.value(f"T:{name}.RRBV")


@pytest.fixture
def world(simulator, runtime, tmp_path):
    """Yield a board without anybody who talks to it."""
    found = World(tmp_path)
    yield found
    found.close()


def moving(world, name="a", target=1_000_000.0):
    """Begin a move that does not end soon; return what `ended` takes."""
    put = world.wire.begin(f"T:{name}.VAL", target)
    before = world.steps(name)
    until(lambda: world.steps(name) != before, HANG_S)
    return put


def goes_on(world, name="b"):
    """Assert that another axis moves as ever."""
    target = world.steps(name) + 100.0
    assert world.wire.put(f"T:{name}.VAL", target) == ""
    assert world.wire.value(f"T:{name}.RBV") == target


def test_a_limit_switch_stops_and_lets_back(world):
    wire = world.begin()
    put = moving(world)
    world.do("press plus 0")
    assert wire.ended(put) == ""
    assert wire.value("T:a.HLS") == 1
    assert Msta.PLUS_LS in world.flags()
    assert world.alarm() == ("HIGH", 2)
    assert wire.value("T:a.VAL") == wire.value("T:a.RBV") == world.steps()
    goes_on(world)
    world.do("release plus 0")
    until(lambda: wire.value("T:a.HLS") == 0, HANG_S)
    back = world.steps() - 50.0
    assert wire.put("T:a.VAL", back) == ""
    assert wire.value("T:a.RBV") == back
    assert world.alarm() == ("NO_ALARM", 0)


def test_a_board_that_is_switched_off_in_a_move_and_comes_back(world):
    wire = world.begin()
    put = moving(world)
    world.do("supply off")
    until(lambda: world.alarm() == ("COMM", 3), HANG_S)
    wire.put("T:a.DESC", b"lost")
    assert world.alarm() == ("COMM", 3)
    world.do("supply 5V")
    assert wire.ended(put) == ""
    until(lambda: world.command.events("connection back"), HANG_S)
    assert len(world.command.events("connection lost")) == 2  # of both motors
    until(lambda: Msta.PROBLEM in world.flags(), HANG_S)  # the reset has lost the position
    assert world.alarm() == ("STATE", 2)
    wire.put("T:b.SET", 1)
    wire.put("T:b.FOFF", 1)
    wire.put("T:b.VAL", 0.0)
    wire.put("T:b.SET", 0)
    until(lambda: Msta.PROBLEM not in world.flags("b"), HANG_S)
    goes_on(world)


def test_a_server_that_dies_in_a_move_and_comes_back(world):
    world.begin_server()
    wire = world.begin()
    put = moving(world)
    world.end_server()
    until(lambda: world.alarm() == ("COMM", 3), HANG_S)
    world.begin_server()
    until(lambda: world.command.events("connection back"), HANG_S)
    assert world.alarm() == ("NO_ALARM", 0)
    wire.begin("T:a.STOP", 1)
    assert wire.ended(put) == ""
    assert wire.value("T:a.DMOV") == 1
    goes_on(world)
    target = world.steps() - 100.0
    assert wire.put("T:a.VAL", target) == ""
    assert wire.value("T:a.RBV") == target


@only_long
def test_a_stop_by_another_program_is_as_stop(world):
    """The record would go on by a retry."""
    world.begin_server()
    wire = world.begin()
    put = moving(world)
    stop = ("board", "stop", "--port", str(world.link))
    said = subprocess.run(
        [sys.executable, "-m", "pixstep", *stop], capture_output=True, text=True, check=False
    )
    assert said.returncode == 0, said.stderr
    assert wire.ended(put) == ""
    rests = world.steps()
    assert wire.value("T:a.VAL") == wire.value("T:a.RBV") < 1_000_000
    assert world.alarm() == ("STATE", 2)
    goes_on(world)
    assert world.steps() == rests


@only_long
def test_an_emergency_stop_is_a_fault_of_all_axes_until_a_person_clears_it(world):
    world.begin_server()
    wire = world.begin()
    put = moving(world)
    world.do("estop press")
    assert wire.ended(put) == ""
    until(lambda: Msta.PROBLEM in world.flags(), HANG_S)
    assert world.alarm() == ("STATE", 2)
    rests = world.steps()
    target = rests - 100.0
    wire.put("T:a.VAL", target)  # while it is pressed
    world.do("estop release")
    wire.put("T:a.VAL", target)
    time.sleep(2)  # of the bench's time, in which a retry would have come
    assert world.steps() == rests and world.alarm() == ("STATE", 2)
    for field, value in (("SET", 1), ("FOFF", 1), ("VAL", float(rests)), ("SET", 0), ("FOFF", 0)):
        wire.put(f"T:a.{field}", value)  # a person says where the motor is
    until(lambda: wire.put("T:a.VAL", target) == "" and world.steps() == target, HANG_S)
    assert world.alarm() == ("NO_ALARM", 0)
    goes_on(world)


@only_long
def test_homing_finds_the_switch_and_one_without_a_switch_fails_with_its_flag(world):
    world.do("load 0 home=500,hyst=8,travel=-2000..4000")
    wire = world.begin()
    assert wire.put("T:a.HOMF", 1) == ""
    assert wire.value("T:a.HOMF") == 0
    assert Msta.HOMED in world.flags()
    assert abs(world.steps()) <= 20
    world.do("load 1 home=900000,travel=-900000..300")
    assert wire.put("T:b.HOMF", 1) == ""
    assert Msta.HOMED not in world.flags("b")
    assert wire.value("T:b.HLS") == 1 or Msta.PROBLEM in world.flags("b")


@only_long
@pytest.mark.parametrize("by_server", [False, True])
def test_records_that_are_killed_in_a_move_know_the_position_afterwards(world, by_server):
    if by_server:
        world.begin_server()
    wire = world.begin()
    wire.put("T:a.FOFF", 1)
    wire.put("T:a.SET", 1)
    wire.put("T:a.VAL", 7000.0)  # an offset to the board's count that only the drive knows
    wire.put("T:a.SET", 0)
    moving(world)
    until(lambda: world.steps() > 8000, HANG_S)
    state = world.folder / "machine.ioc.json"
    until(lambda: state.exists() and '"moving": true' in state.read_text(), HANG_S)
    world.command.process.kill()
    world.command.process.wait()
    wire = world.begin()
    assert world.command.events("was moving when the last IOC ended")
    wire.begin("T:a.STOP", 1)
    until(lambda: wire.value("T:a.MOVN") == 0 and wire.value("T:a.DMOV") == 1, HANG_S)
    made = made_steps(world)
    assert world.steps() == made + 7000
    assert made > 1000
    assert wire.put("T:a.VAL", float(made + 6900)) == ""
    assert made_steps(world) == made - 100


def made_steps(world):
    """Return the steps of axis 0 that the bench has seen on the board's pins."""
    world.do("status")
    for text in world.board.stdout:
        row = json.loads(text)
        if row["event"] == "status":
            return row["axes"][0]["steps"]
    raise AssertionError("the bench has ended")
