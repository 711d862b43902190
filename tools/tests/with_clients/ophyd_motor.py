# SPDX-License-Identifier: MIT
"""ophyd's EpicsMotor, and bluesky's plans with it: PV MOVES SEED."""

import json
import random
import sys
import time

from bluesky import RunEngine
from bluesky.plans import count, rel_scan, scan
from ophyd import EpicsMotor
from ophyd.utils import LimitError


def main(name, moves, seed):
    """Print a row for each thing that was tried."""
    # A move is done before ophyd has dropped its callback: a next one that begins at once may lose
    # its own, and waits for ever. Moves in simulated time are quick enough for that.
    motor = EpicsMotor(name, name="m", settle_time=0.02)
    motor.wait_for_connection(all_signals=True, timeout=10)
    random.seed(seed)
    for _ in range(moves):
        target = random.randrange(-800, 801) / 400
        status = motor.move(target, wait=True, timeout=20)
        print(json.dumps(["move", target, 0 if status.success else 1, motor.position]))
    motor.move(0, wait=True)
    motor.velocity.put(40, wait=True)
    status = motor.move(90, wait=False)
    while motor.position < 2:
        time.sleep(0.005)
    motor.stop()
    while motor.moving or not motor.motor_done_move.get(use_monitor=False):
        time.sleep(0.01)
    time.sleep(0.1)
    print(json.dumps(["stopped", motor.position, motor.user_setpoint.get()]))
    before = motor.position
    try:
        motor.move(1000, wait=True)
    except LimitError:
        print(json.dumps(["beyond", -12, motor.position == before]))
    motor.user_setpoint.put(1000, wait=True, force=True)
    kept = motor.user_setpoint.get(use_monitor=False)
    print(json.dumps(["refused", int(kept != 1000), motor.position == before]))
    seen = []
    engine = RunEngine()
    engine.subscribe(lambda kind, document: seen.append(document["data"]["m"]), "event")
    engine(count([motor], num=3))
    engine(scan([], motor, 0, 1, 5))
    engine(rel_scan([], motor, -0.5, 0.5, 3))
    print(json.dumps(["plans", *seen]))


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
