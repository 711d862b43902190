# SPDX-License-Identifier: MIT
"""Lines from scanspecs: where their points lie, what is refused, and their flight on a board."""

import bluesky.plans as bp
import numpy as np
import pytest
from bluesky.utils import FailedStatus
from flying import at_rest
from scanspec.specs import Concat, Fly, Linspace, Product, Spiral, Static, Zip

import pixstep as px

make = px.fly.line_from_scanspec
SCALE = {"steps_per_unit": "400 steps/mm", "pixel_hz": 100, "max_acceleration": 8}


def edges_of(line):
    """Return where the load is at each pixel's edge of a line, in the scan's unit."""
    steps = line.line.direction * np.cumsum((0, *line.counts))
    return line.start + steps / line.steps_per_unit


@pytest.mark.parametrize(
    ("spec", "pixels"),
    [
        (Fly(Linspace("x", 0, 10, 101)), 1),
        (Linspace("x", 10, 0, 101), 1),  # what has no bounds is given bounds
        (Fly(0.03 @ Linspace.bounded("x", -1, 1, 40)), 3),
        (0.05 @ Linspace("x", 0, 1, 10), 5),
        (Concat(Linspace.bounded("x", 0, 1, 20), Linspace.bounded("x", 1, 2, 18)), 1),
        (Static("x", 1.0, 1).zip(Linspace("y", 1, 1, 1)), None),
        (Linspace("x", 0, 4, 3), 1),
    ],
)
def test_points_lie_where_the_spec_has_them(spec, pixels):
    if pixels is None:
        with pytest.raises(px.RefusedError, match="stands still"):
            make(spec, axis="x", **SCALE)
        return
    line = make(spec, **SCALE)
    frames = spec.frames(bounds=True)
    assert line.points == len(frames) and set(line.point_pixels) == {pixels}
    edges = edges_of(line)
    step = 1 / 400
    first = line.run_up
    for point in range(line.points):
        low, high = first + point * pixels, first + (point + 1) * pixels
        assert abs(edges[low] - frames.lower["x"][point]) <= step
        assert abs(edges[high] - frames.upper["x"][point]) <= step
        assert list(line.points_of(range(low + 1, high + 1))) == [point + 1] * pixels
        if pixels % 2 == 0:
            assert abs(edges[low + pixels // 2] - frames.midpoints["x"][point]) <= step
    assert set(line.points_of(range(1, first + 1))) <= {0}
    assert set(line.points_of(range(first + pixels * line.points + 1, line.pixels + 1))) <= {0}
    assert abs(edges[-1] - line.end) <= step
    assert not line.check("mega", guaranteed=False).refused


def test_the_run_up_keeps_the_motors_acceleration(machine):
    line = make(0.05 @ Linspace("x", 0, 10, 51), motor=machine["X"])
    assert line.counts[0] == 0  # in which play is taken up
    speeds = np.array(line.line.speeds)
    assert np.abs(np.diff(speeds)).max() <= 8
    slow = make(0.05 @ Linspace("x", 0, 10, 51), motor=machine["X"], max_acceleration=2)
    assert slow.run_up > line.run_up
    fixed = make(0.05 @ Linspace("x", 0, 10, 51), motor=machine["X"], run_up="30 px")
    assert fixed.run_up == 1 + 30 + 2


@pytest.mark.parametrize(
    ("spec", "options", "said"),
    [
        (
            Product(Linspace("y", 0, 1, 3), Linspace("x", 0, 10, 101)),
            {"axis": "x"},
            r"axis [xy]: point 102: begins at .*: a line has no gaps; what fits: points that join",
        ),
        (
            Product(Linspace("y", 0, 1, 3), ~Linspace("x", 0, 10, 101)),
            {"axis": "x"},
            r"axis y: point 102: begins at 0\.5, the point before ends at 0: a line has no gaps",
        ),
        (3 * ~Linspace("x", 0, 10, 101), {}, r"axis x: point 102: turns back at 10\.05 mm"),
        (Spiral("x", 0, 10, 1, "y", 0, 10), {"axis": "x"}, r"axis x: point 3: turns back"),
        (Static("x", 1, 5), {}, r"axis x: stands still at 1 in all points: what fits: move it"),
        (
            Linspace.bounded("x", 0, 1, 5).concat(Linspace.bounded("x", 1, 2, 50)),
            {},
            r"axis x: point [3-7] \(pixel \d+\): .*; what fits: \d+ times as many pixels, 0\.\d+ s",
        ),
        (
            0.015 @ Linspace("x", 0, 1, 5),
            {},
            r"point 1: 0\.015 s are 1\.5 pixels at 100 Hz: what fits",
        ),
        (0.004 @ Linspace("x", 0, 1, 5), {}, r"0\.004 s are 0\.4 pixels .*: 0\.01 s or 0\.02 s"),
        (Linspace("x", 0, 1, 5), {"axis": "z"}, r"axis 'z': the spec has x"),
        (Zip(Linspace("x", 0, 1, 5), Linspace("y", 0, 1, 5)), {}, r"axis: the spec has x, y"),
        (Linspace("x", 0, 1, 5), {"max_acceleration": None}, r"axis x: give max_acceler"),
        (Linspace("x", 0, 1, 5), {"pixel_hz": None}, r"needs a pixel frequency"),
        (Linspace("x", 0, 1, 5), {"unit": "deg"}, r"unit 'deg': needs steps per deg"),
        (Linspace("x", 0, 2000, 3), {}, r"axis x: pixel 1: .*the most are 16383|axis x: .*16383"),
    ],
)  # fmt: skip
def test_what_is_refused(spec, options, said):
    with pytest.raises(px.UserError, match=said) as refused:
        make(spec, **{**SCALE, **options})
    assert "\n" not in str(refused.value)


def test_play_is_taken_up_before_the_first_point(machine):
    line = make(0.03 @ Linspace("x", 0, 10, 83), motor=machine["X"])
    assert line.line.shifted_pixels <= line.run_up + 1
    faster = Concat(Linspace.bounded("x", 0, 1, 40), Linspace.bounded("x", 1, 3, 50))
    with pytest.raises(
        px.RefusedError, match=r"axis x: point 1 \(pixel \d+\): .* steps of play are"
    ):
        make(0.02 @ faster, motor=machine["X"])
    assert make(0.02 @ faster, motor=machine["X"], backlash=0).points == 90


def test_play_needs_speed(machine):  # the board's rule: all of it fits one pixel at line speed
    with pytest.raises(px.RefusedError, match=r"B > V.*; what fits: 12 steps a pixel or more"):
        make(0.1 @ Linspace("x", 0, 2, 101), motor=machine["X"])


def test_what_fits_is_true():
    two = Linspace.bounded("x", 0, 1, 5).concat(Linspace.bounded("x", 1, 2, 50))
    with pytest.raises(px.RefusedError, match=r"what fits: 8 times as many pixels, 0\.08 s"):
        make(two, **SCALE)
    assert make(0.08 @ two, **SCALE).points == 55


def test_a_motor_of_plain_lines_may_turn(machine):
    line = make(3 * ~Linspace("x", 0, 1, 101), decode="plain", **SCALE)
    edges = edges_of(line)[line.run_up :]
    assert abs(edges[101] - 1.005) < 1 / 400 and abs(edges[202] + 0.005) < 1 / 400


def test_a_scan_from_its_start(engine, documents, machine):
    spec = Zip(Linspace("x", 1, 5, 41), Linspace("y", 0, 2, 41)).zip(Static("z", 3.0))
    motors = {"x": machine["X"], "y": machine["Y"]}
    lines = px.fly.lines_from_scanspec(0.04 @ spec, motors)
    x, y = lines["x"], lines["y"]
    assert x.pixels == y.pixels and x.run_up == y.run_up
    with px.simulated_board("mega", pixel_hz=100) as board:
        flyer = px.fly.LineFlyer(board, [x, y])
        with pytest.raises(
            FailedStatus,
            match=r"X: is at 0 mm, the scan's line begins at 0\.875 mm: .* by \+350 steps",
        ):
            engine(bp.fly([flyer]))
        at_rest(board)
        assert board.made_steps() == 0
        for line, motor in ((x, machine["X"]), (y, machine["Y"])):
            board.move(line.start_steps, profile=px.Profile((4, 8, 12)), motor=motor).wait()
        engine(bp.fly([flyer]))
    points = documents.column("fly_point")
    last = {point: row for row, point in enumerate(points)}  # the row of each point's end
    for name, axis, scale in (("X", "x", 400), ("Y", "y", 50)):
        upper = spec.frames(bounds=True).upper[axis]
        actual = documents.column(f"fly_{name}_actual")
        assert list(actual) == list(documents.column(f"fly_{name}_expected"))
        ends = np.array([actual[last[point]] for point in range(1, 42)])
        assert np.abs(ends - upper).max() <= 1.01 / scale
    assert set(points) == set(range(42))
    descriptor = documents.of("descriptor")[-1]
    assert descriptor["data_keys"]["fly_point"]["dtype"] == "integer"


@pytest.mark.parametrize("there", [-4.0, 4.0])
def test_positions_of_a_scan_are_the_loads(engine, documents, there):
    spec = Linspace.bounded("x", 2.0, 2.0 + there, 50)
    line = make(spec, backlash=20, **SCALE)
    with px.simulated_board("mega", pixel_hz=100, plant="play=20") as board:
        # Approached in the direction in which the load follows at position 0.
        for steps in (line.start_steps - 200, 200):
            board.move(steps, profile=px.Profile((4, 8, 12)), axis=0).wait()
        motor, load = board._bus._simulated.simulator.plant(0, 0)
        assert motor == load == line.start_steps
        engine(bp.fly([px.fly.LineFlyer(board, line)]))
        motor, load = board._bus._simulated.simulator.plant(0, 0)
    assert load == motor + (20 if there < 0 else 0)
    assert round(400 * documents.column("fly_x_actual")[-1]) == load
    assert abs(load - 400 * line.end) <= 1


def test_axes_without_motors_are_named(machine):
    spec = Zip(Linspace("x", 1, 5, 41), Linspace("y", 0, 2, 41))
    with pytest.raises(px.UserError, match="motors 7: expected motors by axis of the spec"):
        px.fly.lines_from_scanspec(spec, 7)
    with pytest.raises(px.UserError, match="axis 'w': the spec has x, y"):
        px.fly.lines_from_scanspec(spec, {"w": machine["X"]})
    with pytest.raises(px.UserError, match="axis y: moves in the spec, and has no motor"):
        px.fly.lines_from_scanspec(spec, {"x": machine["X"]})
