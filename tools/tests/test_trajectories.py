# SPDX-License-Identifier: MIT
"""Tables of two axes: their files, circles, transitions, and the modelled machine."""

import struct
import sys
from math import cos, hypot, pi, sin, trunc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from effort import cases
from pixstep.errors import RefusedError, UserError
from pixstep.trajectories import circle, runs, table, transitions
from pixstep.trajectories.circle import Circle, CircleRequest, roundness_of
from pixstep.trajectories.transitions import Servo, TablePlay

COUNTS_PER_IN = 1_638_400
PLAY = 7485
POINTS = 8192
SMALL, LARGE = 102_400, 3_276_800  # radius in counts: 1/8 in and 4 in in diameter
SMALL_POINT_S, LARGE_POINT_S = 81.81 / POINTS, 150.8 / POINTS
SOFT, STIFF = Servo(5, 0.4), Servo(10, 0.6)


# Files


def a_table(records=40, holds=3):
    return circle.make(CircleRequest(5000, points=records, revolutions=1, holds=holds))


def equal(one, other):
    return np.array_equal(one.positions, other.positions) and np.array_equal(
        one.velocities, other.velocities
    )


@pytest.mark.parametrize("name", ["t.trj", "t.csv", "t.parquet", "no-suffix"])
def test_a_table_is_read_as_it_was_written(tmp_path, name):
    made = a_table()
    table.write(tmp_path / name, made)
    found, notes = table.read(tmp_path / name)
    assert equal(made, found) and notes == ()


def test_a_record_is_four_little_endian_numbers(tmp_path):
    made = table.made([[1, -2], [3, -5]], [[2, -3], [0, 7]], "t")
    table.write(tmp_path / "t.trj", made)
    data = (tmp_path / "t.trj").read_bytes()
    assert struct.unpack("<8i", data) == (1, 2, -2, -3, 3, 0, -5, 7)


def test_hold_records_that_move_are_at_rest_and_it_is_said(tmp_path):
    made = circle.make(CircleRequest(SMALL, holds=1024, revolutions=1))
    data = np.frombuffer(_records(made), dtype="<i4").reshape(-1, 4).copy()
    data[:1024, 3] = 78  # as the recovered program leaves it
    (tmp_path / "old.trj").write_bytes(data.tobytes())
    found, notes = table.read(tmp_path / "old.trj")
    assert equal(found, made)
    assert "1024 hold records have a velocity" in notes[0]


def _records(made):
    columns = np.empty((made.records, 4), dtype="<i4")
    columns[:, 0::2], columns[:, 1::2] = made.positions, made.velocities
    return columns.tobytes()


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbfp1;p2\r\n0;0\r\n4;-3\r\n",
        "sep=;\r\np1;p2;;\r\n0;0;;\r\n4;\u22123;;\r\n;;;\r\n;;;\r\n".encode(),
        "Gr\xf6\xdfe\tp1\tp2\r0\t0\t0\r1\t4\t-3\r".encode("cp1252"),
        "p1\tp2\n0\t0\n4\t-3\n\n".encode("utf-16"),
    ],
)
def test_what_a_spreadsheet_exports_is_read(tmp_path, data):
    (tmp_path / "own.csv").write_bytes(data)
    assert table.read(tmp_path / "own.csv")[0].positions.tolist() == [[0, 0], [4, -3]]


def test_velocities_are_taken_from_the_positions_around(tmp_path):
    (tmp_path / "own.csv").write_text("point,p2,p1\n0,0,0\n1,-3,4\n2,-6,10\n3,-7,12\n")
    found, notes = table.read(tmp_path / "own.csv")
    assert found.positions.tolist() == [[0, 0], [4, -3], [10, -6], [12, -7]]
    assert found.velocities.tolist() == [[0, 0], [5, -3], [4, -2], [0, 0]]
    assert "no velocities" in notes[0]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("x.trj", b"\x01\x00" * 50, "x.trj: record 7 at byte 96 is cut off: 4 of 16 bytes"),
        ("x.trj", b"", "x.trj: 0 records"),
        ("x.trj", b"\xff" * 32, None),
        ("x.trj", bytes(range(128, 256)), "x.trj: record 1: v1 = "),
        ("x.trj", struct.pack("<8i", 0, 0, 0, 0, 0, 0, 10**9, 0), "record 2: p2 = 1000000000 is "),
        ("x.csv", b"p1,v1,p2,v2\n0,0,0,0\n1,nan,0,0\n", "x.csv:3: v1 = 'nan': expected a whole"),
        ("x.csv", b"p1,p2\n0,0\n1e3,0\n", "x.csv:3: p1 = '1e3': expected a whole"),
        ("x.csv", b"p1,p2\n0,0\n0,1000000000\n", "x.csv: record 2: p2 = 1000000000 is "),
        ("x.csv", b"p1,p2\n0,0\n99999999999,0\n", "x.csv: record 2: p1 = 99999999999: a record"),
        ("x.csv", b"p1,p2\n0,0\n" + b"9" * 50 + b",0\n", "x.csv:3: p1 = '9999"),
        ("x.csv", b"p1,v1,p2,v2\n0,0,0,0\n0,0,0,16384\n", "x.csv: record 2: v2 = 16384: a pixel"),
        ("x.csv", b"p1,p2\n0,0\n7\n", "x.csv:3: 1 fields, the header has 2"),
        ("x.csv", b"p1;p2\n0;0\n;\n7;1\n", "x.csv:3: an empty row between records"),
        ("x.csv", b"p1;p2\n0;0\n1.000;1\n", "x.csv:3: p1 = '1.000': expected a whole"),
        ("x.csv", b"p1,p1\n0,0\n", "x.csv: expected one column p1"),
        ("x.csv", b"p1,p2,v1\n0,0,0\n", "x.csv: columns v1 and v2 come together"),
        ("x.csv", b"some words of a letter", "x.csv: expected one column p1"),
        ("x.csv", b"p1,p2\n0,0\n", "x.csv: 1 records"),
        ("x.csv", b'p1,p2\n"0\n', "x.csv:2"),
        ("x.parquet", b"PAR1 and nothing behind", "x.parquet: not a Parquet file"),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused_with_its_place(put, name, content, message):
    path = put(content, name)
    if message is None:  # all of it is -1: a motor that rests, its holds made so
        assert table.read(path)[0].velocities[0].tolist() == [0, 0]
        return
    with pytest.raises(RefusedError) as caught:
        table.read(path)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_numbers_that_are_none_in_parquet(tmp_path):
    path = tmp_path / "x.parquet"
    for values, message in (
        ([0.0, float("nan")], "record 2: p1 = nan: expected a whole number"),
        ([0.5, 1.0], "record 1: p1 = 0.5: expected a whole number"),
        ([0.0, 1e9], "record 2: p1 = 1000000000 is "),
    ):
        table.write_columns(path, {"p1": np.array(values), "p2": np.zeros(2)})
        with pytest.raises(RefusedError, match=r"x\.parquet: ") as caught:
            table.read(path)
        assert message in str(caught.value)
    table.write_columns(path, {"p1": np.array(["a", "b"]), "p2": np.zeros(2)})
    with pytest.raises(RefusedError, match="p1: expected whole numbers, not string"):
        table.read(path)


def test_parquet_without_pyarrow_says_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UserError, match=r"t\.parquet: Parquet needs pyarrow: pip install"):
        table.write(tmp_path / "t.parquet", a_table())
    assert list(tmp_path.iterdir()) == []


# Circles


def test_a_circle_is_the_recovered_program_s():
    made = circle.make(CircleRequest(SMALL))
    assert made.records == 1024 + 3 * POINTS + 1 and made.holds == 1024
    assert not np.any(made.velocities[:1024])
    for i in (0, 1, 5, 1000, 2048, 2731, 4096, 8192, 3 * POINTS):
        angle, speed = 2 * pi * i / POINTS, 2 * pi / POINTS
        near = 1e-7  # so little floating point may miss a whole number
        wanted = [
            trunc(value + (near if value > 0 else -near))
            for value in (SMALL * cos(angle), SMALL * sin(angle),
                          -SMALL * speed * sin(angle), SMALL * speed * cos(angle))
        ]  # fmt: skip
        row = made.positions[1024 + i].tolist() + made.velocities[1024 + i].tolist()
        assert row == wanted, i


@pytest.mark.parametrize("lead_in", [0, 1, 64, 129])
def test_a_circle_is_found_again(lead_in):
    made = circle.make(CircleRequest(3200, 500, revolutions=2, holds=5, lead_in=lead_in))
    found = circle.find(made)
    assert found == Circle(3200, 500, 5 + lead_in, 2)
    shorter = made.without_holds()
    assert circle.find(shorter).start == found.start - (made.records - shorter.records)
    assert shorter.holds <= 1 and np.array_equal(shorter.positions[-1], made.positions[-1])


def test_a_lead_in_comes_up_to_speed_along_the_circle():
    made = circle.make(CircleRequest(SMALL, lead_in=128, holds=0))
    distance = np.hypot(*made.positions.T) - SMALL
    assert np.max(np.abs(distance)) <= 1.5
    speed = np.hypot(*np.diff(made.positions, axis=0).T)
    assert speed[0] <= 2 and np.all(np.abs(np.diff(speed)) <= 2.5)
    assert abs(made.positions[0, 1]) == abs(made.positions[-1, 1]) > 0


@pytest.mark.parametrize(
    "positions",
    [
        [[0, 0], [1, 1]],
        [[0, 0], [0, 0]],
        [[0, 1], [0, 2]],
        [[100, 0], [100, 0]],
        [[100, 0], [0, 100], [-100, 0], [0, -100]],
        [[100, 0], [0, -100], [-100, 0], [0, 100], [100, 0]],
    ],
)
def test_what_is_no_circle_is_said(positions):
    made = table.made(positions, np.zeros_like(positions), "t")
    with pytest.raises(UserError, match="t: not a c"):
        circle.find(made)


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (CircleRequest(10**9), "at least 383519 points"),
        (CircleRequest(100, revolutions=1000), "at most 2000000"),
    ],
)
def test_circles_that_cannot_be(request_, message):
    with pytest.raises(UserError, match=message):
        circle.make(request_)


# Transitions


def recovered(positions, play, steps, first_way):
    """The offsets of the recovered program, with its two known faults mended.

    A reversal at index 0 is seen, and the direction is that of the next difference that is not 0.
    """
    moves = np.diff(positions).tolist()
    way, offset, since, offsets = first_way, 0.0, None, [0]
    for i in range(1, len(positions)):
        now = next((move for move in moves[i - 1 :] if move), None)
        now = way if now is None else (1 if now > 0 else -1)
        if now != way:
            way, since = now, i
        goal = 0 if way == first_way else -first_way * play
        if since is not None:
            share = min(1, (i - since) / steps)
            start = -first_way * play - goal
            offset = start + (goal - start) * share
        offsets.append(offset)
    return offsets


def test_the_offsets_are_those_of_the_recovered_program():
    made = circle.make(CircleRequest(SMALL, revolutions=2, holds=4))
    found = transitions.compensate(made, (TablePlay(PLAY, 64), TablePlay(5000, 100)))
    assert found.taken_up == (-1, 1)
    for axis, (play, steps) in enumerate(((PLAY, 64), (5000, 100))):
        wanted = recovered(made.positions[:, axis], play, steps, found.taken_up[axis])
        apart = found.offsets[:, axis] - np.array(wanted)
        assert np.max(np.abs(apart)) < 1
        assert set(np.unique(found.offsets[:, axis])[[0, -1]]) == {0, -found.taken_up[axis] * play}
    rows = [(item.axis, item.record - 4, item.direction) for item in found.transitions]
    assert rows == [
        (1, 2048, -1), (0, 4096, 1), (1, 6144, 1), (0, 8192, -1),
        (1, 10240, -1), (0, 12288, 1), (1, 14336, 1),
    ]  # fmt: skip
    assert all(item.missing == 0 for item in found.transitions)


zigzags = st.lists(st.tuples(st.integers(-9, 9), st.integers(1, 12)), min_size=1, max_size=12)


@settings(
    max_examples=cases(100, 2000),
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
@given(zigzags, st.integers(0, 300), st.integers(1, 20))
def test_offsets_of_any_motion(runs, play, steps):
    moves = [count for count, repeat in runs for _ in range(repeat)]
    place = np.concatenate([[0], np.cumsum(moves)])
    positions = np.column_stack([place, np.zeros_like(place)])
    made = table.made(positions, np.zeros_like(positions), "t")
    found = transitions.compensate(made, (TablePlay(play, steps), TablePlay(0, 1)))
    offsets = found.offsets[:, 0]
    way = found.taken_up[0]
    assert offsets[0] == 0 and np.all((-way * offsets >= 0) & (-way * offsets <= play))
    assert not np.any(found.offsets[:, 1])
    jumps = np.abs(np.diff(offsets))
    assert np.max(jumps, initial=0) <= -(-play // steps)  # however close the reversals
    added = found.table.velocities[:, 0]
    assert np.array_equal(added[:-1], np.diff(offsets)) and added[-1] == 0
    assert sum(added) == offsets[-1]
    # Nothing changes before the first reversal, nor in the point that turns.
    turns = [item.record for item in found.transitions]
    assert not np.any(offsets[: turns[0] + 2] if turns else offsets)
    for item, end in zip(found.transitions, [*turns[1:], len(place) - 1], strict=False):
        goal = 0 if item.direction == way else -way * play
        reached = int(offsets[min(end + 1, len(place) - 1)])
        assert abs(goal - reached) == item.missing
        if end - item.record - 1 >= steps:
            assert item.missing == 0 and reached == goal


def test_a_second_reversal_turns_back_from_where_the_offset_is():
    place = np.array([0, 10, 20, 30, 29, 20, 10, 11, 20, 30, 40, 50, 60])
    made = table.made(np.column_stack([place, place]), np.zeros((13, 2)), "t")
    found = transitions.compensate(made, (TablePlay(40, 8), TablePlay(0, 8)))
    assert found.offsets[:, 0].tolist() == [0, 0, 0, 0, 0, -5, -10, -15, -10, -5, 0, 0, 0]
    assert [item.missing for item in found.transitions] == [25, 0]


def test_an_axis_that_never_moves_and_no_play():
    made = table.made([[0, 0], [1, 0], [0, 0]], np.zeros((3, 2)), "t")
    found = transitions.compensate(made, (TablePlay(0, 4), TablePlay(9, 4)))
    assert not np.any(found.offsets) and found.transitions == ()


def test_what_cannot_be_taken_up_is_said():
    made = a_table()
    with pytest.raises(UserError, match="axis 2: a transition of 0 points"):
        transitions.compensate(made, (TablePlay(1, 1), TablePlay(1, 0)))
    with pytest.raises(RefusedError, match=r"circle, compensated: record \d+: v1 = "):
        transitions.compensate(made, (TablePlay(10**6, 2), TablePlay(1, 1)))


# The modelled machine: the cells of the published table and of its extension, in inches


def error_in(radius, steps, servo=None, point_s=1.0, set_to=PLAY):
    """The largest radius error over a revolution; 0 steps: not compensated."""
    made = circle.make(CircleRequest(radius, holds=0, revolutions=1))
    name = runs.COMPENSATED if steps else runs.ORIGINAL
    plays = (TablePlay(set_to, steps or 1),) * 2
    trace = runs.run_modelled(made, plays, name, runs.ModelledMachine((PLAY, PLAY), point_s, servo))
    return abs(roundness_of(trace, circle.find(made)).worst) / COUNTS_PER_IN


def near(found, wanted):
    """Within 2 % and a count, and the last digit of a figure with six places."""
    return abs(found - wanted) <= 0.02 * wanted + 1 / COUNTS_PER_IN + 0.5e-6


@pytest.mark.parametrize(
    ("radius", "play", "wanted"),
    [
        (SMALL, 0.0040, 0.004001), (SMALL, 0.0045, 0.004501), (SMALL, 0.0050, 0.005001),
        (SMALL, PLAY / COUNTS_PER_IN, 0.004569), (LARGE, PLAY / COUNTS_PER_IN, 0.004569),
    ],
)  # fmt: skip
def test_uncompensated_the_error_is_the_play(radius, play, wanted):
    counts = round(play * COUNTS_PER_IN)
    made = circle.make(CircleRequest(radius, holds=0, revolutions=1))
    trace = runs.run_modelled(
        made, (TablePlay(0),) * 2, "original", runs.ModelledMachine((counts, counts), 1.0)
    )
    errors = roundness_of(trace, circle.find(made)).errors
    assert abs(np.max(np.abs(errors)) / COUNTS_PER_IN - wanted) <= 1.5e-6
    if counts == PLAY:
        highest = 0.004256 if radius == SMALL else 0.004558
        assert abs(np.max(errors) / COUNTS_PER_IN - highest) <= 1.5e-6


@pytest.mark.parametrize(
    ("steps", "small", "large"),
    [
        (8, 0.000001, 0.000038), (16, 0.000005, 0.000151), (32, 0.000019, 0.000495),
        (64, 0.000073, 0.001284), (100, 0.000172, 0.001963), (128, 0.000268, 0.002332),
        (150, 0.000353, 0.002559), (200, 0.000563, 0.002960), (256, 0.000806, 0.003242),
        (512, 0.001735, 0.003847), (1024, 0.002696, 0.004184),
    ],
)  # fmt: skip
def test_compensated_by_an_ideal_servo(steps, small, large):
    assert near(error_in(SMALL, steps), small)
    assert near(error_in(LARGE, steps), large)


@pytest.mark.parametrize(
    ("steps", "cells"),
    [
        (1, (0.001623, 0.001079, 0.001603, 0.000889)),
        (4, (0.001537, 0.000847, 0.001275, 0.000495)),
        (8, (0.001255, 0.000459, 0.000661, 0.000230)),
        (16, (0.000582, 0.000218, 0.000289, 0.000151)),
        (32, (0.000276, 0.000109, 0.000498, 0.000495)),
        (64, (0.000136, 0.000073, 0.001288, 0.001285)),
        (128, (0.000268, 0.000268, 0.002335, 0.002332)),
    ],
)
def test_compensated_by_a_servo(steps, cells):
    machines = ((SMALL, SMALL_POINT_S), (LARGE, LARGE_POINT_S))
    found = [
        error_in(radius, steps, servo, point_s)
        for radius, point_s in machines
        for servo in (SOFT, STIFF)
    ]
    assert all(near(one, wanted) for one, wanted in zip(found, cells, strict=True)), found


@pytest.mark.parametrize(
    ("share", "wanted"),
    [(0.8, 0.000914), (0.9, 0.000458), (0.95, 0.000229), (1.0, 0.000073), (1.05, 0.000307),
     (1.1, 0.000540), (1.2, 0.001008)],
)  # fmt: skip
def test_a_play_that_is_wrongly_known(share, wanted):
    assert near(error_in(SMALL, 64, set_to=round(share * PLAY)), wanted)


def test_a_servo_follows_with_its_lag():
    ramp = np.arange(400) * 10.0
    assert np.max(np.abs(transitions.follow(ramp, 0.01, STIFF) - ramp)) < 1e-9  # feed-forward
    step = np.concatenate([np.zeros(5), np.full(400, 100.0)])
    followed = transitions.follow(step, 0.01, STIFF)
    assert np.max(followed) > 110 and abs(followed[-1] - 100) < 0.01
    with pytest.raises(UserError, match=r"at most 159\.155 Hz"):
        transitions.follow(ramp, 0.01, Servo(200))


# The number of points


def crest(radius=SMALL, servo=STIFF, point_s=SMALL_POINT_S):
    return transitions.Crest(radius, POINTS, PLAY, point_s, servo)


@pytest.mark.parametrize(
    ("radius", "servo", "point_s", "published"),
    [
        (SMALL, SOFT, SMALL_POINT_S, 0.000136), (SMALL, STIFF, SMALL_POINT_S, 0.000073),
        (LARGE, SOFT, LARGE_POINT_S, 0.000289), (LARGE, STIFF, LARGE_POINT_S, 0.000151),
    ],
)  # fmt: skip
def test_the_chosen_number_is_as_good_as_the_best_published(radius, servo, point_s, published):
    chosen = transitions.choose(crest(radius, servo, point_s))
    assert chosen.error / COUNTS_PER_IN <= published
    around = (chosen.steps - 1, chosen.steps + 1, 2 * chosen.steps, chosen.steps // 2)
    assert all(
        chosen.error <= transitions.predicted_error(crest(radius, servo, point_s), steps)
        for steps in around
    )
    reached = error_in(radius, chosen.steps, servo, point_s)
    assert near(reached, chosen.error / COUNTS_PER_IN)


def test_without_a_servo_the_fewest_that_the_motor_can_do():
    assert transitions.choose(crest(servo=None), 15).steps == 15
    assert transitions.choose(crest(), 70).steps == 70
    assert transitions.least_steps(PLAY, 117) == 64 and transitions.least_steps(PLAY, 10**6) == 1
    with pytest.raises(UserError, match="longer than the 1024 points"):
        transitions.choose(crest(), 2000)


def slack_in(radius, steps):
    """The closed form: the load is caught at the angle f where R (1 - cos f) = b (1 - g / phi).

    The transition begins a point behind the crest: g = f - 2 pi / points.
    """
    phi, point = 2 * pi * steps / POINTS, 2 * pi / POINTS
    low, high = point, phi + point
    for _ in range(60):
        middle = (low + high) / 2
        caught = radius * (1 - cos(middle)) >= PLAY * (1 - (middle - point) / phi)
        low, high = (low, middle) if caught else (middle, high)
    return radius * (hypot(1, sin(low)) - 1) / COUNTS_PER_IN


@pytest.mark.parametrize("steps", [32, 64, 150, 256])
def test_the_slack_left_is_the_closed_form(steps):
    found = transitions.predicted_error(crest(servo=None), steps) / COUNTS_PER_IN
    assert abs(found - slack_in(SMALL, steps)) <= 0.01 * found
