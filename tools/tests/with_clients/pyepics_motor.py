# SPDX-License-Identifier: MIT
"""pyepics' Motor: moves, one that is stopped, one beyond the limits: PV MOVES SEED."""

import json
import random
import sys
import time

from epics import Motor


def main(name, moves, seed):
    """Print a row for each thing that was tried."""
    motor = Motor(name)
    random.seed(seed)
    for _ in range(moves):
        target = random.randrange(-800, 801) / 400
        code = motor.move(target, wait=True, timeout=20)
        print(json.dumps(["move", target, code, motor.get("RBV")]))
    motor.move(0, wait=True, timeout=20)
    motor.put("VELO", 40, wait=True)
    motor.move(90, wait=False)
    while motor.get("RBV") < 2:
        time.sleep(0.005)
    motor.stop()
    while not motor.get("DMOV", timeout=5) or motor.get("MOVN"):
        time.sleep(0.01)
    time.sleep(0.1)
    print(json.dumps(["stopped", motor.get("RBV"), motor.get("VAL")]))
    before = motor.get("RBV")
    print(json.dumps(["beyond", motor.move(1000, wait=True), before == motor.get("RBV")]))
    motor.PV("VAL").put(1000, wait=True, timeout=5)
    print(json.dumps(["refused", motor.get("LVIO"), before == motor.get("RBV")]))


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
