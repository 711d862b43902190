# SPDX-License-Identifier: MIT
"""Motion that nobody asked for: the board sees it by the timer's own flag, ends it and says so.

The defect is planted from outside, in the engine's state and the timer's interrupt mask, as a step
interrupt would leave them that took a pulsing period for an idle one:

    registers    idle   pulsing, for ever
    state        idle ------------------------->
    edges          ____/~~~\\____/~~~\\____/~~~\\__    until the witness ends them
"""

import pytest

from faultbench import FaultBench
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.lines.line import PLAIN, Line
from pixstep_trials.probe import BoardProbe
from pixstep_trials.wire import seal

pytestmark = pytest.mark.usefixtures("simulator")

MASKS = {1: 0x6F, 3: 0x71, 4: 0x72, 5: 0x73}  # TIMSKn by timer
ENGINE_BYTES, STATE, HALTING, IDLE = 28, 1, 3, 0
OVERFLOW, COMPARE_A = 1, 2
EVERY_AXIS = [(board.name, axis) for board in boards.all_boards() for axis in range(board.axes)]
WITHIN_S = 0.01
LOOK_CYCLES = 5_000  # a fraction of a period of the lines below


def mask_of(bench, axis):
    return MASKS[boards.load(bench.name).timers[axis]]


def settle_as_it_should_not(bench, axis):
    """Make an engine idle whose timer still holds a pulsing period."""
    BoardProbe(bench.sim).poke(0, f"step_engines+{axis * ENGINE_BYTES + STATE}", bytes([IDLE]))
    mask = mask_of(bench, axis)
    BoardProbe(bench.sim).poke(
        0, mask, bytes([BoardProbe(bench.sim).peek(0, mask, 1)[0] & ~COMPARE_A | OVERFLOW])
    )


def halting(bench, axis):
    state = BoardProbe(bench.sim).peek(0, f"step_engines+{axis * ENGINE_BYTES + STATE}", 1)[0]
    mask = BoardProbe(bench.sim).peek(0, mask_of(bench, axis), 1)[0]
    return state == HALTING and mask & COMPARE_A


def run_away(bench, axis, steps_px):
    """Stop an axis and spoil its engine inside the period that its timer holds."""
    bench.load(Line((steps_px,) * 200, PLAIN), axis)
    bench.board.command("arm", [axis])
    # The stop must come early in a period, so that this period still pulses when the engine halts.
    bench.until_true(lambda: bench.count(axis) >= 4, look=LOOK_CYCLES)
    stop = b"\x00\x10\x01\x00\x00\x02\x04" + bytes([0, 1 << axis, 0, regs.COMMANDS["stop"]])
    bench.sim.command(f"send {seal(stop).hex()} 0")
    bench.until_true(lambda: halting(bench, axis), bench.sim.cycles(WITHIN_S), 200)
    settle_as_it_should_not(bench, axis)


@pytest.mark.provokes("stray_steps")
@pytest.mark.parametrize(("board", "axis"), EVERY_AXIS)
def test_a_runaway_is_seen_and_ended(board, axis):
    """Within two periods and 10 ms of the first edge that nobody asked for."""
    with FaultBench(board, range(boards.load(board).axes)) as bench:
        run_away(bench, axis, 4)
        bench.until_true(bench.latched, bench.sim.cycles(WITHIN_S), 200)
        edges = bench.count(axis)
        bench.assert_fault("stray_steps", axis, pixel=range(1, 200), known=False)
        assert bench.count(axis) == edges
        bench.board.command("clear_fault", [])
        assert bench.fault() == "none"
        bench.load(Line((7,) * 3, PLAIN), axis)
        bench.board.command("arm", [axis])
        bench.until(lambda: bench.state(axis) == "done")
        assert bench.count(axis) == edges + 21


@pytest.mark.parametrize(("board", "axis"), EVERY_AXIS)
def test_an_emergency_stop_ends_a_runaway(board, axis):
    """In hardware terms, whatever the software believes: with the main loop held, no witness."""
    (pin,) = [one for one in boards.load(board).pins if one.signal == "ESTOP"]
    with FaultBench(board, range(boards.load(board).axes)) as bench:
        run_away(bench, axis, 4)
        with bench.main_loop_held():
            before = bench.count(axis)
            bench.sim.wait_s(0.05)
            assert bench.count(axis) > before + 5  # it does run away
            bench.sim.pin(0, pin.port, pin.bit, 0)
            pressed = bench.count(axis)
            bench.sim.wait_s(0.05)
            assert bench.count(axis) <= pressed + 2
            last = bench.count(axis)
            bench.sim.wait_s(0.05)
            assert bench.count(axis) == last


@pytest.mark.parametrize(("board", "axis"), EVERY_AXIS)
def test_no_order_of_ordinary_commands_wakes_the_witness(board, axis):
    """Stops at many places of slow and fast lines, twice: no edge of these is a stray one."""
    with FaultBench(board, range(boards.load(board).axes)) as bench:
        for steps_px in (2, 5, 11, 60, 200):
            for delay in range(0, 170_000, 37_013):
                bench.load(Line((steps_px,) * 200, PLAIN), axis)
                bench.board.command("arm", [axis])
                bench.until(lambda: bench.state(axis) == "running")
                bench.sim.run(200_000 + delay)
                bench.board.command("stop", [axis])
                bench.board.command("stop", [axis])
                bench.sim.wait_s(WITHIN_S)
                assert bench.fault() == "none"
                assert bench.board.axis(axis)["position_steps"] == bench.sim.steps(0, axis)
