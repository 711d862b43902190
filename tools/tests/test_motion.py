# SPDX-License-Identifier: MIT
"""Motions on simulated boards by their handle: watched, stopped, awaited, on several boards."""

import asyncio
import contextlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import pixstep as px
from pixstep.simulation.logs import read_edges

pytestmark = pytest.mark.usefixtures("simulator")
SHORT = px.line([2, 6, 8, 6, 2], pixel_hz=100)
LONG = px.line([20] * 400, decode="plain", pixel_hz=1000)


@pytest.fixture
def uno():
    with px.simulated_board("uno", pixel_hz=1000) as board:
        yield board


def test_a_board_like_any_other():
    with px.simulated_board("mega", pixel_hz=30, divider=4) as board:
        assert isinstance(board, px.Board)
        assert (board.kind, board.pixel_hz, board.device.clock_hz()) == ("mega", 30, 120)
        before_s = board.time_s
        board.let_pass("250 ms")
        assert board.time_s - before_s == pytest.approx(0.25, abs=1e-6)
        line = px.line([2, 6, 8, 6, 2], pixel_hz=30)
        (state,) = board.run(line, axis=2)
        assert (state.axis, state.state, state.position_steps) == (2, "done", 24)
        assert board.made_steps(2) == 24
        assert list(state.records.pixel) == [1, 2, 3, 4, 5]
    with pytest.raises(px.BoardError, match="has been ended"):
        board.axes()


def watched(edges):
    """Run a streamed line and return all that is seen of it on the way, and its edges."""
    seen = []
    line = px.line(np.random.default_rng(3).integers(1, 9, 700), decode="plain", pixel_hz=1000)
    with px.simulated_board("uno", pixel_hz=1000, edges=edges, seed=5) as board:
        with board.start(line) as motion:
            while not motion.done:
                (one,) = motion.status()
                seen.append((one.state, one.pixel, one.position_steps, round(one.share, 6)))
                seen.append(tuple(len(records) for records in motion.records()))
                board.device.input("status")  # the caller may ask for other things meanwhile
        seen.append(motion.wait())
        seen.append(board.time_s)
    return line, seen, read_edges(edges).axis(0, 0).rising


def test_the_same_calls_give_the_same_motion(tmp_path):
    line, seen, rising = watched(tmp_path / "one.csv")
    _, again, same = watched(tmp_path / "two.csv")
    assert seen == again and np.array_equal(rising, same)
    assert len(rising) == line.total_steps
    (state,) = seen[-2]
    assert (state.state, state.position_steps) == ("done", line.total_steps)
    shares = [one[3] for one in seen[:-2] if len(one) == 4]
    assert shares == sorted(shares) and 0 < shares[1] < 1 and len(shares) > 4
    counts = [one[0] for one in seen[:-2] if len(one) == 1]
    assert counts == sorted(counts) and 0 < counts[len(counts) // 2] < counts[-1]


def test_a_stop_ends_the_motion_where_it_is(uno):
    motion = uno.start(LONG)
    uno.let_pass(0.1)
    (running,) = motion.status()
    assert running.state == "running" and running.pixels == 400
    (state,) = motion.stop()
    assert 0 < state.position_steps == uno.made_steps() < LONG.total_steps
    with pytest.raises(px.MotionStoppedError, match=rf"axis 0 at position {state.position_steps}"):
        motion.wait()
    assert motion.done and motion.stop() == (state,)
    uno.let_pass(0.2)
    assert uno.made_steps() == state.position_steps
    assert uno.run(SHORT_AT_1000)[0].state == "done"  # nothing is left in the queue


SHORT_AT_1000 = px.line([2, 6, 8, 6, 2], pixel_hz=1000)


def test_a_stop_of_the_board_stops_its_motion(uno):
    motion = uno.start(LONG)
    uno.let_pass(0.1)
    (state,) = uno.stop()
    assert motion._over and 0 < state.position_steps < LONG.total_steps
    with pytest.raises(px.MotionStoppedError, match=rf"at position {state.position_steps}"):
        motion.wait()


def test_a_stop_when_all_is_over_changes_nothing(uno):
    motion = uno.start(SHORT_AT_1000)
    (state,) = motion.wait()
    assert motion.stop()[0].position_steps == state.position_steps == 24
    assert motion.wait() == (state,)
    assert motion.status()[0].share == 1


def test_leaving_the_block_waits_and_an_exception_stops(uno):
    with uno.start(SHORT_AT_1000) as motion:
        pass
    assert motion._over and uno.axes()[0].state == "done"
    with pytest.raises(ZeroDivisionError) as error, uno.start(LONG) as motion:
        motion.status()
        _ = 1 / 0
    assert motion._over and "board 1 axis 0 at position " in error.value.__notes__[0]
    with uno.start(LONG) as motion:
        motion.stop()  # asked for: no error behind it
    assert uno.made_steps() < 24 + 2 * LONG.total_steps


def test_waiting_is_limited_in_the_time_of_the_board(uno):
    motion = uno.start(LONG)
    before_s = uno.time_s
    with pytest.raises(px.MotionTimeoutError, match=r"takes longer than 0\.05 s"):
        motion.wait("50 ms")
    assert uno.time_s - before_s == pytest.approx(0.05, abs=0.03)
    with pytest.raises(px.UserError, match="timeout_s"):
        motion.wait(-1)
    assert motion.wait()[0].position_steps == LONG.total_steps


def test_what_keeps_lines_from_being_armed_is_raised_by_start(uno):
    with pytest.raises(px.RefusedError):
        uno.start(px.line([2, 9, 8, 6, 2], pixel_hz=1000))
    with pytest.raises(px.BoardError, match="line refused"):
        uno.start(px.line([2, 9, 8, 6, 2], pixel_hz=1000), check=False)
    motion = uno.start(LONG)
    with pytest.raises(px.BoardError, match=r"axis 0 is (armed|running)"):
        uno.start(LONG)
    assert motion.wait()[0].state == "done"


def test_a_fault_is_raised_by_wait_with_its_name():
    with px.simulated_board("uno", pixel_hz=30) as board:
        motion = board.start(LONG)  # of 1000 Hz, at a clock of 30 Hz
        with pytest.raises(px.FaultError, match="fault pixel_clock_missing") as error:
            motion.wait()
        assert error.value.name == "pixel_clock_missing"
        assert motion.status()[0].state == "fault"
        board.clear_fault()
        board.device.set_pixel_hz(30)
        assert board.run(px.line([2, 6, 8, 6, 2], pixel_hz=30))[0].state == "done"


def test_the_bus_waits_for_motions_at_its_end_and_stops_them_when_it_is_closed(tmp_path):
    edges = tmp_path / "edges.csv"
    with px.simulated_board("uno", pixel_hz=1000, edges=edges) as board:
        whole = board.start(SHORT_AT_1000)
    assert whole.wait()[0].state == "done"
    board = px.simulated_board("uno", pixel_hz=1000)
    motion = board.start(LONG)
    board.close()
    with pytest.raises(px.MotionStoppedError):
        motion.wait()
    with pytest.raises(KeyError), px.simulated_board("uno", pixel_hz=1000) as board:
        motion = board.start(LONG)
        raise KeyError
    with pytest.raises(px.MotionStoppedError):
        motion.wait()


def test_a_failure_that_nobody_has_noticed_is_raised_at_the_end_of_the_bus():
    with pytest.raises(px.FaultError), px.simulated_board("uno", pixel_hz=30) as board:
        board.start(LONG)
        board.let_pass(3)
    with px.simulated_board("uno", pixel_hz=30) as board:
        motion = board.start(LONG)
        with pytest.raises(px.FaultError):
            motion.wait()  # once is enough
    with px.simulated_board("uno", pixel_hz=1000) as board:
        board.start(LONG).stop()


def test_a_stopped_motion_has_all_records_up_to_the_stop():
    line = px.make_line(speed=40, max_acceleration=4, length=8000, pixel_hz=100)
    with px.simulated_board("mega", pixel_hz=100) as board:
        motion = board.start(line)
        board.let_pass(1)
        (state,) = motion.stop()
        (records,) = motion.records()
    assert list(records.pixel) == list(range(1, len(records) + 1))
    # It rests in the pixel behind the newest record, or at its edge.
    assert 0 <= state.position_steps - records.actual_steps[-1] <= 40


def test_boards_that_begin_together_leave_each_other_time_for_their_records():
    line = px.make_line(speed=40, max_acceleration=4, length=3000, pixel_hz=100)
    with px.simulated_bus(["mega", "uno"], pixel_hz=100) as bus:
        states = bus.start({1: [line, line], 2: line}).wait()
    assert [state.records.missed for unit in (1, 2) for state in states[unit]] == [0, 0, 0]


def test_threads_may_use_one_simulated_board():
    with px.simulated_board("mega", pixel_hz=1000) as board:
        motion = board.start(LONG)
        errors = []

        def asking():
            try:
                for _ in range(200):
                    board.axes()
            except Exception as error:
                errors.append(error)

        threads = [threading.Thread(target=asking) for _ in range(3)]
        for thread in threads:
            thread.start()
        assert motion.wait()[0].state == "done"
        for thread in threads:
            thread.join()
    assert not errors


def test_two_boards_begin_on_one_edge(tmp_path):
    edges = tmp_path / "edges.csv"
    lines = {
        1: [px.line([4] * 300, decode="plain", pixel_hz=500), px.line([2, 6, 6, 2], pixel_hz=500)],
        2: px.line([5] * 200, decode="plain", pixel_hz=500),
    }
    with px.simulated_bus(["mega", "uno"], pixel_hz=500, edges=edges, seed=7) as bus:
        motion = bus.start(lines)
        assert {(one.unit, one.axis) for one in motion.status()} == {(1, 0), (1, 1), (2, 0)}
        found = motion.wait()
        assert {unit: [one.position_steps for one in states] for unit, states in found.items()} == {
            1: [1200, 16],
            2: [1000],
        }
        assert [(one.unit, one.axis) for one in motion.records()] == [(1, 0), (1, 1), (2, 0)]
        assert bus.made_steps(2, 0) == 1000
        with pytest.raises(px.UserError, match="axis 1: the uno has 1 axis: 0"):
            bus.made_steps(2, 1)
        with pytest.raises(px.UserError, match="unit 3: expected a whole number, 1 to 2"):
            bus.made_steps(3)
        with pytest.raises(px.UserError, match="one clock drives all boards"):
            bus.start({1: SHORT, 2: px.line([2, 2], pixel_hz=60)})
        with pytest.raises(px.UserError, match="expected lines by address"):
            bus.start([SHORT])
        stopped = bus.start({1: lines[1], 2: lines[2]})
        bus.let_pass(0.4)
        states = stopped.stop()
        assert len(states) == 3
        with pytest.raises(px.MotionStoppedError):
            stopped.wait()
    first = [read_edges(edges).axis(*place).rising[0] for place in ((0, 0), (0, 1), (1, 0))]
    assert max(first) - min(first) < 16e6 / 500  # all within the first pixel


def test_two_motions_on_one_bus_feed_both(tmp_path):
    with px.simulated_bus(["uno", "uno"], pixel_hz=500) as bus:
        counts = np.random.default_rng(1).integers(1, 9, (2, 900))
        lines = [px.line(row, decode="plain", pixel_hz=500) for row in counts]
        motions = [bus.board(unit).start(lines[unit - 1]) for unit in (1, 2)]
        states = [motion.wait()[0] for motion in motions]
        assert [one.position_steps for one in states] == [item.total_steps for item in lines]


def test_async(uno):
    async def main():
        turns = 0

        async def other():
            nonlocal turns
            while True:
                turns += 1
                await asyncio.sleep(0)

        task = asyncio.ensure_future(other())
        async with uno.start(SHORT_AT_1000) as motion:
            assert (await motion.wait_async())[0].state == "done"
        with pytest.raises(px.MotionTimeoutError):
            await uno.start(LONG).wait_async(0.05)
        uno.stop()
        waiting = asyncio.ensure_future(uno.start(LONG).wait_async())
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        task.cancel()
        return turns

    assert asyncio.run(main()) > 3
    assert uno.axes()[0].state == "empty"


def test_moves_homing_and_seeks(tmp_path):
    plant = "home=0,hyst=2,travel=-900..900,start=-300"
    ramp = [2, 20, 50, 70]
    with px.simulated_board("mega", pixel_hz=500, plant=plant) as board:
        with board.home(profile=ramp, slow=2, search=2500, clear=5) as motion:
            assert motion.status()[0].share < 1
        homed = motion.wait()
        assert (homed.axis, homed.direction, homed.position_steps) == (0, "plus", 0)
        assert 295 <= homed.edge_steps <= 305 and len(homed.legs) >= 3
        moved = board.move(-200, profile=ramp).wait()
        assert (moved.from_steps, moved.position_steps, moved.steps) == (0, -200, -200)
        assert moved.top_speed_steps_px <= 70
        assert board.move(10, profile=ramp, max_speed="1000 steps/s").wait().pixels == 5
        found = board.seek(profile=ramp, search=2500, direction="plus").wait()
        assert abs(found.edge_steps) <= 3 and found.position_steps >= found.edge_steps
        assert board.seek(profile=ramp, until="closed", search=500).wait().edge_steps is None
        away = board.seek(profile=ramp, direction="minus", until="open", search=2500).wait()
        assert abs(away.edge_steps) <= 5
        with pytest.raises(px.HomingError, match="did not close within") as error:
            board.seek(profile=ramp, direction="minus", search=300).wait()
        assert error.value.name == "home_not_found"
        board.clear_fault()
        assert board.move(5, profile=px.Profile((10, 20, 40))).wait().position_steps


MACHINE = """\
[clock]
pixel = "500 Hz"

[boards.main]
kind = "mega"

[motors.X]
axis = 1
kind = "smooth"
direction = "-"
steps_per_unit = "100 steps/mm"

[motors.X.limits]
max_speed = "60 steps/px"
max_acceleration = "40 steps/px2"
"""


def test_a_motor_has_its_axis_direction_scale_and_limits(tmp_path):
    (tmp_path / "machine.toml").write_text(MACHINE)
    motor = px.Machine.load(tmp_path / "machine.toml")["X"]
    with px.simulated_board("mega", pixel_hz=500, plant={1: "play=0"}) as board:
        moved = board.move("20 mm", motor=motor, profile=[2, 20, 50, 70]).wait()
        assert (moved.axis, moved.steps, moved.top_speed_steps_px) == (1, -2000, 60)
        assert board.made_steps(1) == -2000
        with pytest.raises(px.UserError, match="motor X is on axis 1"):
            board.move("3 mm", motor=motor, axis=0, profile=[2])
        with pytest.raises(px.UserError, match="profile: none is given"):
            board.move("3 mm", motor=motor)
        with pytest.raises(px.UserError, match="needs a motor's steps per mm"):
            board.move("3 mm", profile=[2])
        with pytest.raises(px.UserError, match="axis 4: board 1 has 4: 0 to 3"):
            board.move(3, axis=4, profile=[2])
        with pytest.raises(px.UserError, match="above 0 and never falling"):
            board.move(3, profile=[5, 4])
    with (
        px.simulated_board("uno", pixel_hz=500) as board,
        pytest.raises(px.RefusedError, match="motor X is on a mega, board 1 is a uno"),
    ):
        board.move("3 mm", motor=motor, profile=[2])


@pytest.mark.parametrize("name", ["moves", "homes"])
def test_a_stopped_move_or_homing(name):
    with px.simulated_board("mega", pixel_hz=500, plant="home=8000,start=0") as board:
        if name == "moves":
            motion = board.move(5000, profile=[2, 10])
        else:
            motion = board.home(profile=[2, 10], search=9000)
        board.let_pass(0.5)
        (state,) = motion.stop()
        assert 0 < state.position_steps == board.made_steps() < 5000
        with pytest.raises(px.MotionStoppedError, match="axis 0 at position"):
            motion.wait()


def test_ctrl_c_in_wait_stops_the_axes(uno):
    motion = uno.start(LONG)
    advance = motion._handle._time._lender.advance
    calls = []

    def interrupted(end_s=None):
        calls.append(end_s)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return advance(end_s)

    motion._handle._time._lender.advance = interrupted
    with pytest.raises(KeyboardInterrupt) as error:
        motion.wait()
    (note,) = error.value.__notes__
    assert note == f"board 1 axis 0 at position {uno.made_steps()}"
    assert uno.axes()[0].state == "empty"
    with pytest.raises(px.MotionStoppedError):
        motion.wait()


def test_an_error_of_the_progress_stops_the_axes(uno):
    def fails(share):
        raise RuntimeError("no screen")

    motion = uno.start(LONG, progress=fails)
    with pytest.raises(RuntimeError, match="no screen") as error:
        motion.wait()
    assert error.value.__notes__[0].startswith("board 1 axis 0 at position ")
    assert uno.axes()[0].state == "empty"


def test_a_simulator_that_ends_is_told_and_nothing_hangs(uno):
    motion = uno.start(LONG)
    uno._bus._link.simulator.kill()
    with pytest.raises(px.PlainError):
        motion.wait()
    with contextlib.suppress(px.PlainError):
        motion.stop()
    assert motion._over
    left = [one for one in threading.enumerate() if one.name == "pixstep motion" and one.is_alive()]
    end_s = time.monotonic() + 5
    while any(one.is_alive() for one in left) and time.monotonic() < end_s:
        time.sleep(0.01)
    assert not any(one.is_alive() for one in left)


WITHOUT_NUMPY = """\
import sys
for name in ("numpy", "pandas", "pyarrow"):
    sys.modules[name] = None
import pixstep as px
with px.simulated_board("uno", pixel_hz=100) as board:
    motion = board.start(px.line([2, 6, 8, 6, 2], pixel_hz=100))
    (state,) = motion.wait()
    print(state, state.records, motion.status()[0].share)
    print(board.move(5, profile=[2, 3]).wait().steps)
    try:
        motion.records()
    except px.UserError as error:
        print(error)
"""


def test_boards_move_without_numpy():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_NUMPY], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    moved, steps, records = done.stdout.splitlines()
    assert "state='done', position_steps=24" in moved and moved.endswith(" None 1.0")
    assert steps == "5" and records == (
        "this needs numpy: pip install 'pixstep[numpy]' (in a clone: tools/setup)"
    )
