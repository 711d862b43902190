# SPDX-License-Identifier: MIT
"""caproto's own client: moves by writes that wait, one that is stopped: PV MOVES SEED."""

import json
import random
import sys
import threading
import time

from caproto.threading.client import Context


def main(name, moves, seed):
    """Print a row for each thing that was tried."""
    context = Context()
    pvs = context.get_pvs(
        name, *(f"{name}.{field}" for field in ("RBV", "STOP", "DMOV", "LVIO", "VELO"))
    )
    target, readback, stop, done, violated, speed = pvs
    for pv in pvs:
        pv.wait_for_connection(timeout=10)
    random.seed(seed)
    for _ in range(moves):
        value = random.randrange(-800, 801) / 400
        target.write([value], wait=True, timeout=20)
        print(json.dumps(["move", value, 1 - done.read().data[0].item(), position(readback)]))
    target.write([0.0], wait=True, timeout=20)
    speed.write([40.0], wait=True)
    ended = threading.Event()
    target.write([90.0], wait=False, callback=lambda response: ended.set())
    while position(readback) < 2:
        time.sleep(0.005)
    stop.write([1], wait=False)
    assert ended.wait(10)
    print(json.dumps(["stopped", position(readback), position(target)]))
    before = position(readback)
    target.write([1000.0], wait=True, timeout=20)
    print(json.dumps(["refused", violated.read().data[0].item(), before == position(readback)]))


def position(pv):
    """Return a position."""
    return pv.read().data[0].item()


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
