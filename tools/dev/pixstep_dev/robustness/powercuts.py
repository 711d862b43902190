# SPDX-License-Identifier: MIT
"""Power cuts at random cycles of a store: at the next start the old settings or the new, whole.

The byte of EEPROM that is being written when the supply fails is left with any value. Each cut goes
on from what the one before has left behind.
"""

import random
from dataclasses import dataclass, field
from fractions import Fraction

from pixstep.board import settings
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep.simulation.simulator import Simulator
from pixstep_trials.probe import BoardProbe

_STORE_S = 0.23  # of which 55 bytes take 3.4 ms each
_COMMAND_S = 0.004  # the request that begins it is on the line for 2 ms


@dataclass(frozen=True)
class PowercutsPlan:
    """So many power cuts of one board."""

    board: str
    cuts: int
    seed: int = 1


@dataclass
class PowercutsOutcome:
    """What happened. `complaints` is empty if every promise was kept."""

    plan: PowercutsPlan
    cuts: int = 0
    old: int = 0
    new: int = 0
    in_a_byte: int = 0  # cuts while a byte was being written
    complaints: list[str] = field(default_factory=list)


def random_settings(rng: random.Random) -> dict[str, int]:
    """Return values for settings that leave the line to the board as it is."""
    return {
        "dir_setup_us": rng.randint(1, 1000),
        "dir_hold_us": rng.randint(1, 1000),
        "max_acceleration": rng.randint(0, 65535),
        "input_filter_us": rng.randint(100, 20000),
        "start_stop_steps": rng.randint(0, 16383),
        "bus_timeout_ms": rng.randint(0, 60000),
        "idle_off_ms": rng.randint(0, 60000),
        "enable_settle_ms": rng.randint(0, 1000),
    }


def run(plan: PowercutsPlan, progress: Progress = unseen) -> PowercutsOutcome:
    """Run a plan; raises UserError if the simulator cannot run."""
    outcome = PowercutsOutcome(plan)
    rng = random.Random(f"{plan.seed} {plan.board}")
    with SimulatedBoard(plan.board, Fraction(100), seed=plan.seed) as run:
        for _ in range(plan.cuts):
            try:
                _cut_once(rng, run.simulator, run.board, outcome)
            except BoardError as error:
                outcome.complaints.append(f"cut {outcome.cuts}: {error}")
            outcome.cuts += 1
            progress(outcome.cuts / plan.cuts)
    return outcome


def _cut_once(
    rng: random.Random, simulator: Simulator, board: Device, outcome: PowercutsOutcome
) -> None:
    old = settings.read(board)
    for name, value in random_settings(rng).items():
        board.write_setting(name, value)
    new = settings.read(board)
    cut = simulator.cycle + rng.randrange(*map(simulator.cycles, (_COMMAND_S, _STORE_S)))
    board.store()
    if cut > simulator.cycle:
        simulator.run(cut - simulator.cycle)
    outcome.in_a_byte += BoardProbe(simulator).eeprom_state(0).address is not None
    simulator.supply(0, "cycle")
    simulator.boot()
    found = settings.read(board)
    if found == new:
        outcome.new += 1
    elif found == old:
        outcome.old += 1
    else:
        outcome.complaints.append(f"cut {outcome.cuts} at cycle {cut}: neither: {found}")
