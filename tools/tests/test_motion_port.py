# SPDX-License-Identifier: MIT
"""A motion on a port, in real time: its thread feeds a kilohertz line while the program works."""

import asyncio
import os
import random
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import pixstep as px
from effort import cases
from sim_terminal import on_terminal

HANG_S = 1800
# A host that gets no processor for a while is not taken for a dead one.
PATIENT_S = 2
PIXEL_HZ = 200  # what a busy machine of two cores keeps up with beside a program that computes
COUNTS = np.random.default_rng(2).integers(1, 4, 800)  # the Uno's queue holds some 130 of them


PROCESSES = {}


def simulator_of(port):
    """Return the number of the process behind a terminal."""
    return PROCESSES[port].pid


@pytest.fixture
def port(simulator):
    """Start a simulated Uno behind a pseudo terminal; yield the terminal's name."""
    with on_terminal("uno", PIXEL_HZ) as (name, process):
        PROCESSES[name] = process
        yield name


@pytest.fixture
def board(port):
    """Return the board, which stops for no host that is slow."""
    with px.connect(port, timeout_s=PATIENT_S) as bus:
        found = bus.board()
        found.device.write_setting("bus_timeout_ms", 0)
        yield found


def test_a_streamed_line_goes_on_beside_a_program_that_computes(board):
    line = px.line(COUNTS, decode="plain", pixel_hz=PIXEL_HZ)
    seen, total = [], 0
    with board.start(line) as motion:
        while not motion.done:
            total += sum(index * index for index in range(20_000))  # keeps Python's lock
            time.sleep(0.002)
            seen.append((motion.status()[0].share, len(motion.records()[0])))
            total += board.device.input("status")  # asks the board besides
    (state,) = motion.wait()
    assert (state.state, state.position_steps) == ("done", line.total_steps)
    assert seen == sorted(seen) and len({share for share, _ in seen}) > 5
    assert total
    motion._handle._thread.join()
    assert sys.getswitchinterval() == pytest.approx(0.005)


def test_a_stop_from_another_thread(board):
    line = px.line(COUNTS, decode="plain", pixel_hz=PIXEL_HZ)
    motion = board.start(line)
    stopped = []
    other = threading.Thread(target=lambda: (time.sleep(0.5), stopped.append(motion.stop())))
    other.start()
    with pytest.raises(px.MotionStoppedError):
        motion.wait()
    other.join()
    ((state,),) = stopped
    assert 0 < state.position_steps < line.total_steps
    assert board.run(px.line([2, 4, 2], decode="plain", pixel_hz=PIXEL_HZ))[0].state == "done"


def test_async_on_a_port(board):
    async def main():
        ticks = 0
        async with board.start(px.line([2] * 300, decode="plain", pixel_hz=PIXEL_HZ)) as motion:
            while not motion.done:
                ticks += 1
                await asyncio.sleep(0.01)
            (state,) = await motion.wait_async()
        with pytest.raises(px.MotionTimeoutError):
            await board.start(px.line(COUNTS, decode="plain", pixel_hz=PIXEL_HZ)).wait_async(0.1)
        return ticks, state

    ticks, state = asyncio.run(main())
    assert ticks > 3 and state.position_steps == 600


PROGRAM = """\
import sys, time
import pixstep as px
bus = px.connect(sys.argv[1], timeout_s=2)
board = bus.board()
board.device.write_setting("bus_timeout_ms", 0)
motion = board.start(px.line([2] * 20000, decode="plain", pixel_hz=200))
print("begun", flush=True)
if sys.argv[2] == "waits":
    motion.wait()
elif sys.argv[2] == "works":
    while True:
        time.sleep(0.05)
"""


@pytest.mark.parametrize("how", ["ends", "waits", "works"])
def test_a_program_that_ends_stops_its_axes(port, how):
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, port, how],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.3)
        if how != "ends":
            process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=HANG_S)
    assert ("KeyboardInterrupt" in errors) == (how != "ends")
    with px.connect(port, timeout_s=PATIENT_S) as bus:
        (state,) = bus.board().axes()
        assert state.state == "empty" and 0 < state.position_steps < 40_000


@pytest.mark.parametrize("seed", range(cases(4, 60)))
def test_a_stop_at_any_moment_leaves_nothing_that_moves_or_waits(board, seed):
    rng = random.Random(seed)
    line = px.line(COUNTS, decode="plain", pixel_hz=PIXEL_HZ)
    motion = board.start({0: line})
    time.sleep(rng.random() * 0.6)
    how = rng.choice(["here", "beside requests", "by an exception"])
    if how == "here":
        motion.stop()
    elif how == "beside requests":
        other = threading.Thread(target=motion.stop)
        other.start()
        while other.is_alive():
            board.axes()
    else:
        with pytest.raises(ZeroDivisionError), motion:
            raise ZeroDivisionError
    (before,) = board.axes()
    time.sleep(0.05)
    (after,) = board.axes()
    assert before == after and after.state == "empty"
    assert 0 < after.position_steps < line.total_steps
    with pytest.raises(px.MotionStoppedError):
        motion.wait()
    (state,) = board.run(px.line([2] * 10, decode="plain", pixel_hz=PIXEL_HZ))
    assert (state.state, state.position_steps) == ("done", after.position_steps + 20)


def test_a_board_that_is_lost_is_told(port):
    with px.connect(port, timeout_s=0.2) as bus:
        board = bus.board()
        board.device.write_setting("bus_timeout_ms", 0)
        motion = board.start(px.line([2] * 5000, decode="plain", pixel_hz=PIXEL_HZ))
        os.kill(simulator_of(port), signal.SIGKILL)
        with pytest.raises(px.BoardError, match="NOT STOPPED as far as is known"):
            motion.wait()
        assert motion._over
        with pytest.raises(px.BoardError):
            motion.stop()
