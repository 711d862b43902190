# SPDX-License-Identifier: MIT
"""Unmodified clients of EPICS, each in a process of its own, with `pixstep ioc` above steppers."""

import bisect
import os
import re
import signal
import threading

import numpy as np
import pytest
from caproto import ChannelType

from effort import cases, only_long
from iocprocess import MACHINE, Command
from pixstep import natives
from pixstep.simulation import logs

PV = "T:m1"
QUICK = MACHINE.replace("DHLM = 100,", "VELO = 400, VMAX = 400, BVEL = 400, DHLM = 100,").replace(
    'backlash = "8 steps"', ""
)
# Moves of each client on a simulated board, which makes them in real time: five in a second.
BOARD_MOVES = int(os.environ.get("PIXSTEP_BOARD_MOVES", cases(5, 100)))
# Moves above ideal steppers in the long check, 10,000 in all; ophyd-async takes longest for each.
MOVES = {
    "pyepics_motor.py": 3000,
    "ophyd_motor.py": 3000,
    "ophyd_async_motor.py": 500,
    "caproto_motor.py": 3500,
}
PROGRAMS = tuple(MOVES)
BACKLASH = MACHINE.replace("5 mm/s", "40 mm/s").replace("50 mm/s2", "400 mm/s2")
BOARD = BACKLASH.replace('backlash = "8 steps"', "")
OPHYDS = """
[clock]
pixel = "30 Hz"

[boards.main]
kind = "mega"

[motors."XF:31IDA-OP{Tbl-Ax:X1}Mtr"]
axis = 0
kind = "smooth"
steps_per_unit = "1000 steps/mm"
limits.max_speed = "1 mm/s"
limits.max_acceleration = "10 mm/s2"
"""
ESS = "PIXSTEP_ESS_TESTS"
ESS_FILES = ("010", "100", "101", "121", "131", "140", "240", "500", "970")


class Judge:
    """Follows DMOV and RBV, and judges them by the steps that were made."""

    def __init__(self, command):
        self.command = command
        self.wire = command.wire()
        self.wire.monitor(f"{PV}.DMOV", data_type=ChannelType.TIME_INT)
        self.wire.monitor(f"{PV}.RBV", data_type=ChannelType.TIME_DOUBLE)
        self._over = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        """Take monitors as they come: a client that does not read loses some."""
        while not self._over.is_set():
            self.wire.listen(0.2)

    def judge(self):
        """Assert that no step was made while DMOV was 1, and RBV is what was counted.

        Return how many moves there were.
        """
        self._over.set()
        self._reader.join()
        assert self.command.end(signal.SIGINT) == 0
        rows = (self.command.folder / "m1.edges").read_text().split()
        times_s, steps = [float(one) for one in rows[::2]], [int(one) for one in rows[1::2]]
        rests = 0
        last_s = readback = None
        for (name, value), stamp_s in zip(self.wire.seen, self.wire.stamps_s, strict=True):
            if name.endswith("RBV"):
                readback = value
                continue
            if value == 0 and last_s is not None:
                made = bisect.bisect(times_s, stamp_s) - bisect.bisect(times_s, last_s)
                assert made == 0, f"{made} steps at rest, after {last_s}"
            if value == 1 and rests:
                at = bisect.bisect(times_s, stamp_s) - 1
                assert readback == pytest.approx(steps[at] / 400 if at >= 0 else 0, abs=1e-9)
            rests += value
            last_s = stamp_s if value else None
        assert "Traceback" not in self.command.log.read_text()
        return rests - 1


@pytest.fixture
def ioc(tmp_path):
    """Yield a server with quick ideal steppers."""
    (tmp_path / "machine.toml").write_text(QUICK)
    command = Command(tmp_path)
    yield command
    command.process.kill()


def check_rows(rows, moves_wanted):
    """Assert what a client has seen."""
    moves = [row for row in rows if row[0] == "move"]
    assert len(moves) == moves_wanted
    for _, target, code, position in moves:
        assert (code, position) == (0, pytest.approx(target, abs=1e-9))
    others = {row[0]: row[1:] for row in rows if row[0] != "move"}
    stopped, target = others["stopped"]
    assert stopped == pytest.approx(target)
    assert 2 <= stopped < 89.9
    assert others.get("beyond", [-12, True]) == [-12, True]
    assert others["refused"] == [1, True]
    if "flown" in others:
        assert others["flown"][0] == pytest.approx(others["flown"][1], abs=0.0025)
    if "plans" in others:
        wanted = [0, 0.25, 0.5, 0.75, 1, 0.5, 1, 1.5]
        assert others["plans"][3:] == pytest.approx(wanted, abs=1e-9)


# libca's own client starts quickly; ophyd, above the same library, takes long to load.
@pytest.mark.parametrize("program", cases(PROGRAMS[:1], PROGRAMS))
def test_moves_of_a_client(ioc, program):
    judge, moves = Judge(ioc), cases(10, MOVES[program])
    check_rows(ioc.client(program, PV, moves, 7, seconds=900), moves)
    assert judge.judge() >= moves


def judge_board(folder):
    """Assert by a simulated board's edges what `Judge` does; return how many moves there were."""
    axis = logs.read_edges(folder / "edges.csv").axis(0, 0)
    steps_s = axis.rising / 16e6
    made = np.concatenate(([0], np.cumsum(axis.directions())))
    last_s, rests = None, 0
    for row in (folder / "dmov.csv").read_text().split():
        name, value, time_s, raw = row.split(",")
        if name != PV:
            continue
        at = int(np.searchsorted(steps_s, float(time_s)))
        if value == "1":
            assert made[at] == int(raw), f"{raw} at {time_s} s"
            rests += 1
            last = at
        elif last_s is not None:
            assert at == last, f"{at - last} steps at rest, before {time_s} s"
        last_s = time_s if value == "1" else None
    return rests


@pytest.mark.parametrize("program", cases(PROGRAMS[-1:], PROGRAMS))
def test_moves_of_a_client_on_a_simulated_board(tmp_path, simulator, program):
    move_on_a_board(tmp_path, BOARD, program)


@only_long
def test_moves_against_backlash_on_a_simulated_board(tmp_path, simulator):
    move_on_a_board(tmp_path, BACKLASH, PROGRAMS[0])


def move_on_a_board(tmp_path, machine, program):
    """Let a client move a simulated board, and judge both."""
    (tmp_path / "machine.toml").write_text(machine)
    command = Command(tmp_path, ideal=False)
    try:
        command.wire().close()
        rows = command.client(program, PV, BOARD_MOVES, 7, seconds=900 + BOARD_MOVES)
        assert command.end(signal.SIGINT) == 0
    finally:
        command.process.kill()
    check_rows(rows, BOARD_MOVES)
    assert judge_board(tmp_path) >= BOARD_MOVES
    assert "Traceback" not in command.log.read_text()


@only_long
def test_ophyds_own_tests_of_motors(tmp_path):
    (tmp_path / "machine.toml").write_text(OPHYDS)
    command = Command(tmp_path)
    command.wire().close()
    places = (natives.root() / "build" / "clients").glob("lib/python*/site-packages/ophyd/tests")
    (place,) = places
    done = command.run_client(
        "-m", "pytest", "-q", "-W", "ignore", "-p", "no:cacheprovider", "-k", "pyepics",
        place / "test_epicsmotor.py",
    )  # fmt: skip
    assert re.search(r"^22 passed", done.stdout, re.MULTILINE), done.stdout
    assert command.end(signal.SIGINT) == 0


@pytest.mark.skipif(ESS not in os.environ, reason=f"{ESS} names no folder with ESS' test files")
def test_the_files_of_the_ess(ioc):
    folder = os.environ[ESS]
    ioc.wire().close()
    ioc.env["TESTEDMOTORADDR"] = PV
    for number in ESS_FILES:
        done = ioc.run_client(
            "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", folder,
            *sorted(natives.root().joinpath(folder).glob(f"{number}*.py")),
        )  # fmt: skip
        print(number, done.stdout.strip().splitlines()[-1])
        assert "passed" in done.stdout
