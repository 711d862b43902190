# SPDX-License-Identifier: MIT
"""ophyd-async's Motor: set, stop, fly, and bluesky's plans with it: PV MOVES SEED."""

import asyncio
import contextlib
import json
import random
import sys

from bluesky import RunEngine
from bluesky.plans import count, rel_scan, scan
from bluesky.run_engine import call_in_bluesky_event_loop
from ophyd_async.core import FlyMotorInfo, init_devices
from ophyd_async.epics.motor import Motor, MotorLimitsError


def tell(*row):
    """Print a row."""
    print(json.dumps(row), flush=True)


async def try_moves(motor, moves):
    """Move, stop in the middle, ask for what is beyond the limits, fly."""
    for _ in range(moves):
        target = random.randrange(-800, 801) / 400
        await motor.set(target)
        tell("move", target, 0, await motor.user_readback.get_value())
    await motor.set(0)
    await motor.velocity.set(40)
    status = motor.set(90)
    while await motor.user_readback.get_value() < 2:
        await asyncio.sleep(0.005)
    await motor.stop()
    with contextlib.suppress(RuntimeError):  # it was stopped
        await status
    while not await motor.motor_done_move.get_value():
        await asyncio.sleep(0.01)
    tell("stopped", await motor.user_readback.get_value(), await motor.user_setpoint.get_value())
    before = await motor.user_readback.get_value()
    try:
        await motor.set(1000)
    except MotorLimitsError:
        tell("beyond", -12, before == await motor.user_readback.get_value())
    await motor.user_setpoint.set(1000)
    kept = await motor.user_setpoint.get_value()
    tell("refused", int(kept != 1000), before == await motor.user_readback.get_value())
    await motor.set(0)
    await motor.prepare(FlyMotorInfo(start_position=0, end_position=1, time_for_move=1))
    await motor.kickoff()
    await motor.complete()
    ramp = await motor.acceleration_time.get_value() / 2
    await motor.velocity.set(await motor.max_velocity.get_value())
    tell("flown", await motor.user_readback.get_value(), 1 + ramp)


def main(name, moves, seed):
    """Print a row for each thing that was tried."""
    random.seed(seed)
    engine = RunEngine()
    with init_devices():
        motor = Motor(f"ca://{name}", name="m")
    call_in_bluesky_event_loop(try_moves(motor, moves), 600)
    seen = []
    engine.subscribe(lambda kind, document: seen.append(document["data"]["m"]), "event")
    engine(count([motor], num=3))
    engine(scan([], motor, 0, 1, 5))
    engine(rel_scan([], motor, -0.5, 0.5, 3))
    tell("plans", *seen)


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
