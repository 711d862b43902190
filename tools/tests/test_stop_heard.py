# SPDX-License-Identifier: MIT
"""A stop reaches whom it is for: behind damaged replies of others, with a mask for all boards."""

import pytest

from bench import Bench
from effort import TRIED_BOARDS
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep_trials import frames
from pixstep_trials.wire import seal
from test_bus import DIAGNOSING

pytestmark = pytest.mark.usefixtures("simulator")

BOARDS = TRIED_BOARDS
SILENCES_US = (1812, 2250)
RUNNING = Line((40,) * 200, PLAIN)
REPLY = seal(bytes([2, 4, 250, *range(250)]))  # of another board: 125 registers
FLIPPED = bytes([*REPLY[:100], REPLY[100] ^ 0x10, *REPLY[101:]])
STOP_ALL = frames.order("stop", 0x0F, unit=frames.BROADCAST)
JUNK = {
    "a bit flipped": FLIPPED,
    "a byte missing": REPLY[:-1],
    "a byte too many": bytes([2]) + REPLY,
    "two at once": FLIPPED + FLIPPED[:60],
}


def start(bench):
    """Let every axis run."""
    for axis in bench.axes:
        bench.load(RUNNING, axis)
    bench.board.command("permit_on", [0])
    bench.arm()
    bench.run_until_steps(bench.count() + 100)


def assert_stopped(bench):
    bench.sim.wait_s(20e-3)
    assert bench.sim.permit(0).level == 0
    made = [bench.count(axis) for axis in bench.axes]
    bench.sim.wait_s(50e-3)
    assert [bench.count(axis) for axis in bench.axes] == made
    assert bench.fault() == "none"
    assert all(bench.state(axis) == "empty" for axis in bench.axes)


@pytest.mark.parametrize("what", JUNK)
@pytest.mark.parametrize("board", BOARDS)
def test_a_stop_behind_a_long_damaged_reply_is_heard(board, what):
    axes = range(boards.load(board).axes)
    for silence_us in SILENCES_US:
        for phase in range(3):
            with Bench(board, axes) as bench:
                start(bench)
                bench.sim.run(phase * 5003)
                bench.sim.command(f"send {JUNK[what].hex()} {silence_us}")
                bench.sim.command(f"send {STOP_ALL.hex()} 0")
                bench.sim.wait_s(40e-3)
                assert_stopped(bench)


@pytest.mark.parametrize("name", ["stop", "disarm"])
def test_what_quiets_all_axes_quiets_a_board_of_one(name):
    """Sent to every board at once, and by its address."""
    for unit in (frames.BROADCAST, frames.UNIT):
        with Bench("uno") as bench:
            if name == "stop":
                start(bench)
            else:
                bench.load(RUNNING)
                bench.board.command("arm", [0], 7)
            bench.sim.command(f"send {frames.order(name, 0x0F, unit=unit).hex()} 0")
            bench.sim.wait_s(5e-3)
            assert_stopped(bench)


def test_axes_that_a_board_has_not_are_refused_otherwise():
    with Bench("uno") as bench:
        bench.load(RUNNING)
        for name, mask in (("arm", 3), ("discard", 15), ("enable", 2), ("stop", 14), ("stop", 0)):
            reply = bench.sim.transmit(frames.order(name, mask))
            assert reply[1] == 0x90, (name, mask)
        assert bench.state(0) == "loaded"


@pytest.mark.parametrize("board", DIAGNOSING)
def test_listen_only_lets_the_bus_fall_silent(board):
    """Nobody obeys in listen-only mode: what is said then keeps no axis running."""
    with Bench(board) as bench:
        bench.board.write_setting("bus_timeout_ms", 300)
        start(bench)
        listen_only = seal(bytes([1, 8, 0, 4, 0, 0]))
        bench.sim.command(f"send {listen_only.hex()} 0")
        for _ in range(10):
            bench.sim.command(f"send {frames.order('stop', 1).hex()} 0")
            bench.sim.wait_s(50e-3)
        assert bench.sim.permit(0).level == 0
        made = bench.count(0)
        bench.sim.wait_s(50e-3)
        assert bench.count(0) == made
        bench.sim.command(f"send {seal(bytes([1, 8, 0, 1, 0, 0])).hex()} 0")
        bench.sim.wait_s(20e-3)
        assert bench.fault() == "bus_silent"


def test_a_fault_before_the_first_step_is_in_the_first_pixel():
    """Not where the line before it had ended."""
    with Bench("uno") as bench:
        bench.load(Line((4,) * 7, PLAIN))
        bench.arm()
        bench.until(lambda: bench.state(0) == "done")
        bench.load(RUNNING)
        bench.board.command("arm", [0], 5)
        bench.board.go(6, 1)
        bench.sim.wait_s(5e-3)
        assert bench.fault() == "wrong_token"
        assert bench.board.input("fault_pixel") == 1
