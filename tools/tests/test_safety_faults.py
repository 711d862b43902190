# SPDX-License-Identifier: MIT
"""Faults around the motion, provoked on the real image: emergency stop, silence on the bus, resets,
the stack, a token that does not fit.
"""

from dataclasses import replace

import pytest

from bench import Bench
from faultbench import FaultBench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep_trials.wire import seal

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = boards.BOARD_NAMES
ALL_AXES = [(board.name, range(board.axes)) for board in boards.all_boards()]
LONG = Line((40,) * 200, PLAIN)
BROWN_OUT, WATCHDOG = 4, 8  # bits of reset_cause
WAIT_CYCLES = 10_000_000
REST_CYCLES = 200_000


def running(bench, steps=400):
    """Let every axis of the bench run a long line."""
    for axis in bench.axes:
        bench.load(LONG, axis)
    bench.arm()
    bench.run_until_steps(steps)


def estop_pin(bench, level):
    (pin,) = [one for one in boards.load(bench.name).pins if one.signal == "ESTOP"]
    bench.sim.command(f"pin 0 {pin.port} {pin.bit} {level}")


@pytest.mark.provokes("estop")
@pytest.mark.parametrize(
    ("board", "axes"), [(board.name, range(board.axes)) for board in boards.all_boards()]
)
def test_estop(board, axes):
    with FaultBench(board, axes) as bench:
        running(bench)
        pixel = bench.board.axis(0)["pixel"] + 1
        estop_pin(bench, 0)
        bench.run_into_fault(bench.sim.cycles(4e-3))
        bench.assert_fault("estop", pixel=range(pixel, pixel + 2))
        with pytest.raises(BoardError):  # as long as it is pressed
            bench.board.command("clear_fault", [])
        estop_pin(bench, 1)
        bench.sim.wait_s(1e-3)
        bench.board.command("clear_fault", [])
        assert bench.fault() == "none"


# The emergency stop's interrupt; a round at rest takes twice that.
@pytest.mark.parametrize(
    ("board", "handler_cycles"), [("uno", 450), ("mega", 1000), ("m1284", 1200)]
)
def test_permit_goes_off_when_the_estop_comes_while_it_is_switched_on(board, handler_cycles):
    request = seal(b"\x01\x06" + bytes([1, 1, 0, regs.COMMANDS["permit_on"]]))
    on_at = permitted(board, request, None).cycle
    for before in range(2, 60, 4):
        permit = permitted(board, request, on_at - before)
        assert permit.level == 0
        assert permit.cycle < on_at + handler_cycles


def permitted(board, request, estop_at):
    """Send a request to a board that has just started; return its permit output 8 ms later."""
    with Bench(board) as bench:
        bench.sim.command(f"send {request.hex()} 0")
        if estop_at is not None:
            (pin,) = [one for one in boards.load(board).pins if one.signal == "ESTOP"]
            bench.sim.pin(0, pin.port, pin.bit, 0, at=estop_at)
        bench.sim.wait_s(8e-3)
        return bench.sim.permit(0)


def ms_unit(board):
    """Return how many seconds a board's millisecond takes (clock_now_ms)."""
    tick_hz = boards.load(board).tick_hz
    units_256 = 256 * 64 / tick_hz
    return units_256 if tick_hz == 16_000_000 else units_256 * 256 / (1000 * (1 << 22) // tick_hz)


@pytest.mark.provokes("bus_silent")
@pytest.mark.parametrize("board", BOARDS)
def test_bus_silent(board):
    with FaultBench(board) as bench:
        bench.board.write_setting("bus_timeout_ms", 80)
        bench.load(LONG)
        bench.arm()
        last_request = bench.sim.cycle
        bench.run_into_fault()
        lasted = (bench.sim.cycle - last_request) / bench.sim.tick_hz
        assert 76.2 < lasted / ms_unit(board) < 81
        # Line zero is one or two pixels of 10 ms behind the arming.
        bench.assert_fault("bus_silent", pixel=range(5, 9), argument=80)
        assert bench.count() > 100


@pytest.mark.provokes("bus_silent")
@pytest.mark.parametrize("board", BOARDS)
def test_a_board_whose_host_has_died_stops_by_itself(board):
    """As it comes, with the default settings."""
    with FaultBench(board) as bench:
        bench.board.default_settings()
        bench.board.set_pixel_hz(bench.hz)
        upload = bench.load(Line((9,) * 1000, PLAIN))
        assert upload.done
        bench.arm()
        last_request = bench.sim.cycle
        bench.sim.run(bench.sim.cycles(2900e-3))  # in one piece: looking takes long
        bench.run_into_fault(bench.sim.cycles(1100e-3))
        lasted = (bench.sim.cycle - last_request) / bench.sim.tick_hz
        assert 2995.2 < lasted / ms_unit(board) < 3002.9
        last = round(lasted * 100)
        bench.assert_fault("bus_silent", pixel=range(last - 4, last + 1), argument=3000)


@pytest.mark.provokes("bus_silent")
@pytest.mark.parametrize("board", ["mega", "m1284"])
def test_a_silent_bus_may_let_the_line_end(board):
    """Every pixel of the line that moves is made, none of the next one; both axes agree."""
    with FaultBench(board, (0, 1), hz=100) as bench:
        bench.board.write_setting("silence_waits", 1)
        bench.board.write_setting("bus_timeout_ms", 300)
        for axis in (0, 1):
            for clocked in (True, False):
                line = replace(Line((9,) * 60, PLAIN), clocked=clocked)
                upload = LineUpload(bench.board, axis, queue_entries(line, more=clocked))
                upload.push()
                assert upload.done
        bench.board.command("arm", [0, 1])
        bench.run_into_fault(bench.sim.cycles(2.0))
        bench.sim.run(bench.sim.cycles(0.5))
        bench.assert_fault("bus_silent", pixel=61, argument=300)
        assert [bench.sim.count(0, axis) for axis in (0, 1)] == [540, 540]
        for axis in (0, 1):
            found = bench.board.axis(axis)
            assert (found["lines_done"], found["position_steps"]) == (1, 540)


@pytest.mark.parametrize("board", ["uno", "mega", "m1284"])
def test_a_reset_makes_the_tag_0(board):
    with FaultBench(board) as bench:
        bench.board.write_setting("tag", 0xBEEF)
        bench.board.command("enable", [0])
        bench.board.command("stop", [0])
        assert bench.board.setting("tag") == 0xBEEF
        bench.sim.command("hang 0 main")
        bench.sim.run(bench.sim.cycles(1.0))
        assert bench.board.setting("tag") == 0


def restarted(bench):
    """After a reset: nothing has moved since, the positions began anew, as the table says."""
    assert bench.board.axis(0)["position_steps"] == 0
    with pytest.raises(BoardError):
        bench.load(LONG)
        bench.arm()
    bench.board.command("clear_fault", [])
    assert bench.fault() == "none"


@pytest.mark.provokes("reset")
@pytest.mark.parametrize(
    ("board", "hang"),
    [*((board, what) for board in BOARDS for what in ("main", "interrupts")), ("uno", "axis 0")],
)
def test_reset_by_the_watchdog(board, hang):
    # Without its step interrupt an axis has no account of time: the next edge of a fast clock would
    # seem to be off before the watchdog comes.
    with FaultBench(board, range(boards.load(board).axes), hz=2) as bench:
        running(bench, 20)
        bench.sim.command(f"hang 0 {hang}")
        bench.run_into_fault(4_000_000)
        bench.assert_fault("reset", pixel=1, argument=WATCHDOG, known=False)
        restarted(bench)


@pytest.mark.provokes("underrun")
@pytest.mark.parametrize("axis", range(4))
def test_underrun_of_an_axis_whose_interrupt_never_comes(axis):
    """Nobody waits for an interrupt at rest; the next line finds the axis dead, without a step."""
    with FaultBench("mega", range(4)) as bench:
        bench.sim.command(f"hang 0 axis {axis}")
        bench.sim.run(4_000_000)
        assert bench.fault() == "none"
        for other in bench.axes:
            bench.load(LONG, other)
        bench.arm()
        bench.run_into_fault(4_000_000)
        assert bench.count(axis) == 0
        bench.assert_fault("underrun", axis, pixel=1, argument=1, known=False)


@pytest.mark.provokes("underrun")
@pytest.mark.parametrize("axis", range(4))
def test_underrun_of_an_interrupt_that_does_not_come(axis):
    """The mega checks time: it stops the axis; its timer would repeat a period for ever."""
    with FaultBench("mega", range(4)) as bench:
        running(bench)
        pixel = bench.board.axis(axis)["pixel"] + 1
        bench.sim.command(f"hang 0 axis {axis}")
        before = bench.sim.cycle
        bench.run_into_fault()
        assert bench.sim.cycle - before < bench.sim.cycles(0.040)
        pixels = range(pixel, pixel + 4)
        bench.assert_fault("underrun", axis, pixel=pixels, argument=1, known=False)


@pytest.mark.provokes("reset")
@pytest.mark.parametrize("board", BOARDS)
def test_reset_by_a_low_supply(board):
    with FaultBench(board) as bench:
        running(bench)
        bench.sim.command("reset 0 brownout")
        bench.run_into_fault(4_000_000)
        bench.assert_fault("reset", pixel=1, argument=BROWN_OUT, known=False)
        restarted(bench)


@pytest.mark.provokes("stack_overflow")
@pytest.mark.parametrize("board", BOARDS)
def test_stack_overflow(board):
    """Something writes on the word below the stack."""
    with FaultBench(board) as bench:
        running(bench)
        pixel = bench.board.axis(0)["pixel"] + 1
        bench.sim.command("poke 0 _end 00")
        bench.run_into_fault(bench.sim.cycles(4e-3))
        bench.assert_fault("stack_overflow", pixel=range(pixel, pixel + 2))
        with pytest.raises(BoardError):  # it does not mend itself
            bench.board.command("clear_fault", [])


@pytest.mark.provokes("wrong_token")
@pytest.mark.parametrize(
    ("board", "axes"), [(board.name, range(board.axes)) for board in boards.all_boards()]
)
def test_wrong_token(board, axes):
    with FaultBench(board, axes) as bench:
        for axis in bench.axes:
            bench.load(LONG, axis)
        order(bench, "arm", 0x1234)
        bench.sim.wait_s(60e-3)
        assert bench.state() == "armed" and bench.count() == 0
        order(bench, "go", 0x4321)
        bench.assert_fault("wrong_token", pixel=1, argument=0x4321)
        assert bench.count() == 0


def order(bench, name, token):
    """Give a command with its argument to the bench's axes."""
    mask = sum(1 << axis for axis in bench.axes)
    bench.board.write(regs.COMMAND_BASE, [mask, regs.COMMANDS[name], token, 1])
