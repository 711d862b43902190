# SPDX-License-Identifier: MIT
"""Fixtures of tests that fly: a RunEngine, its documents, a machine."""

import pytest
from bluesky import RunEngine
from flying import Documents

import pixstep as px

MACHINE = """
[clock]
pixel = 100
[boards.mega]
kind = "mega"
[motors.X]
board = "mega"
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
backlash = 12
limits = { max_speed = "60 steps/px", max_acceleration = "8 steps/px2" }
[motors.Y]
board = "mega"
axis = 1
kind = "plain"
steps_per_unit = "50 steps/deg"
direction = "-"
limits = { max_acceleration = "8 steps/px2" }
"""


@pytest.fixture
def documents():
    return Documents()


@pytest.fixture
def engine(documents):
    engine = RunEngine(context_managers=[])
    engine.subscribe(documents)
    return engine


@pytest.fixture
def machine(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE)
    return px.Machine.load(path)
