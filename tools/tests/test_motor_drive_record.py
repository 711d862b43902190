# SPDX-License-Identifier: MIT
"""A motor record above the drive of a simulated board: DMOV, MOVN, readbacks, edges, play."""

import random
from contextlib import contextmanager

import numpy as np
import pytest

from drive_bench import RecordAbove, driven, rising_s
from effort import cases
from pixstep.motor_record.traffic import Verb

pytestmark = pytest.mark.usefixtures("simulator")
FIELDS = {
    "MRES": 0.01, "VELO": 30, "VBAS": 1, "ACCL": 0.1, "BDST": 0.3, "BVEL": 5, "BACC": 0.1,
    "VMAX": 100, "JVEL": 5, "JAR": 50, "HVEL": 20,
}  # fmt: skip


@contextmanager
def recorded(kind="mega", pixel_hz=30, plant=None, edges=None, **fields):
    """Yield a record above axis 0 of a board, and its drive watched by it."""
    plants = {(1, 0): plant} if plant else None
    with driven([kind], [(1, 0)], pixel_hz=pixel_hz, edges=edges, plants=plants) as (
        bus,
        drives,
        _,
    ):
        above = RecordAbove(bus, drives["1.0"], lambda: bus.made_steps(1, 0), FIELDS | fields)
        above.let_pass(0.5)
        above.clear()
        yield above


def required(above, target=None):
    """Judge a record at rest: readback, edges, targets; no edge has come since DMOV became 1."""
    record, made = above.record, above.edges()
    assert record["RMP"] == made and round(record["RBV"] / 0.01) == made
    assert above.at_done in (None, made)
    assert not record["MISS"] and not above.drive.problem
    if target is not None:
        assert abs(record["RBV"] - target) < 0.0101


@pytest.mark.parametrize(("kind", "hz"), [("mega", 30), ("uno", 100), ("m1284", 1000)])
def test_random_moves_some_stopped_some_with_another_target(kind, hz):
    chosen = random.Random(hz)
    with recorded(kind, hz) as above:
        for nth in range(cases(16, 500)):
            if nth % 8 == 0:
                above.put("BDST", chosen.choice([0.3, -0.3, 0.5, -1, 0]))
                above.put("BVEL", chosen.choice([2, 5, 30]))
                above.put("VELO", chosen.choice([10, 30, 80]))
                above.settle()
            required(above)
            above.clear()
            way = chosen.choice([0.01, -0.02, 0.2, -0.3, 1, -4, 15]) * chosen.uniform(0.5, 1.5)
            target = round(above.record["VAL"] + way, 2)
            above.put("VAL", target)
            what = chosen.random()
            if what < 0.3:
                above.let_pass(chosen.uniform(0, 1.2))
                above.put("STOP", 1)
                target = None
            elif what < 0.5:
                above.let_pass(chosen.uniform(0, 1.0))
                target = round(target + chosen.uniform(-3, 3), 2)
                above.put("VAL", target)
            above.settle()
            required(above, target)
            assert above.dmov[0] == 0 and above.dmov[-1] == 1


def test_the_legs_of_a_backlash_move(tmp_path):
    path = tmp_path / "edges.csv"
    with recorded(edges=path) as above:
        begun_s = above.bus.time_s
        above.put("VAL", -6.0)
        above.settle()
        required(above, -6.0)
        assert above.dmov == [0, 1] and above.movn == [1, 0, 1, 0]
        assert [one.verb for one in above.asked].count(Verb.GO) == 2
        assert Verb.STOP_AXIS not in [one.verb for one in above.asked]
    edges = rising_s(path)
    edges = edges[edges > begun_s]
    assert len(edges) == 630 + 30
    seam_s = edges[630] - edges[629]
    # The last pixel of a leg and the first of the other one have at least two steps at VBAS.
    assert seam_s < 0.035


@pytest.mark.parametrize("bdst", [0.6, -0.6])
def test_the_load_ends_in_the_same_place_whatever_the_way(bdst):
    chosen = random.Random(8)
    with recorded(plant="play=40,home=100000,travel=-90000..90000", BDST=bdst) as above:
        simulator, offsets = above.bus._simulated.simulator, set()
        above.put("VAL", 1.0)
        above.settle()
        above.put("VAL", 0.0)
        above.settle()
        for nth in range(cases(10, 500)):
            target = round(chosen.uniform(-4, 4), 2)
            above.put("VAL", target)
            if nth % 5 == 4:  # stopped somewhere: the next whole move makes it good
                above.let_pass(chosen.uniform(0, 1))
                above.put("STOP", 1)
                above.settle()
                required(above)
                continue
            above.settle()
            required(above, target)
            if abs(above.record["VAL"] - target) < 1e-9 and Verb.GO in [
                one.verb for one in above.asked
            ]:
                motor, load = simulator.plant(0, 0)
                offsets.add(motor - load)
            above.clear()
        assert max(offsets) - min(offsets) <= 1


def test_jog_home_tweak_and_a_position_that_is_set():
    plant = "home=2000,hyst=8,travel=-5000..9000,start=1500"
    with recorded(pixel_hz=100, plant=plant, BDST=0) as above:
        above.put("HOMF", 1)
        above.settle()
        assert above.record["RMP"] == 0 and above.edges() == 500 and above.record["ATHM"]
        above.put("TWV", 0.5)
        above.put("TWR", 1)
        above.settle()
        assert above.record["RMP"] == -50 and above.edges() == 450
        above.put("JOGF", 1)
        above.let_pass(1)
        above.put("JOGF", 0)
        above.settle()
        assert above.record["RMP"] == above.edges() - 500 > 300
        assert abs(above.record["VAL"] - above.record["RBV"]) < 1e-9
        above.put("SET", 1)
        above.put("FOFF", 1)
        above.put("VAL", 50.0)
        above.settle()
        above.put("SET", 0)
        made = above.edges()
        assert above.record["RMP"] == 5000
        above.put("VAL", 49.0)
        above.settle()
        assert above.record["RMP"] == 4900 and above.edges() == made - 100


def test_a_line_beside_is_external_motion():
    import pixstep as px

    with recorded(BDST=0) as above:
        line = px.line([20] * 30, decode="plain", pixel_hz=30)
        with above.bus.board(1).start(line):
            above.let_pass(0.7)
            assert above.record["DMOV"] == 0 and above.record["MOVN"] == 1
        above.settle()
        required(above)
        assert above.record["RMP"] == 600


def test_delays_retries_and_pause():
    with recorded(DLY=0.1, RTRY=5, BDST=0) as above:
        above.put("VAL", 4.0)
        above.let_pass(0.15)
        above.put("SPMG", 1)
        above.let_pass(1)
        stopped = above.edges()
        above.let_pass(0.3)
        assert above.edges() == stopped < 400
        above.put("SPMG", 3)
        above.settle()
        above.let_pass(0.2)
        required(above, 4.0)
        assert np.all(np.diff(above.dmov) != 0)
