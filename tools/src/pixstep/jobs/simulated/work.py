# SPDX-License-Identifier: MIT
"""A block simulated: all its boards in one run of the simulator, by the runner that prints jobs.

Its edges are written here, as Parquet; what is given back is a small row a motor and line. This is
what runs in processes of this computer and of others.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from pixstep import atomic
from pixstep.board import settings
from pixstep.board.errors import BoardError
from pixstep.errors import PlainError, UserError
from pixstep.jobs import stations
from pixstep.jobs.runner import Chain, ChainEnd, RunWatch
from pixstep.jobs.shapes import MINUS
from pixstep.jobs.simulated import cuts, judge, rows
from pixstep.jobs.simulated.cuts import JobBlock, unpack
from pixstep.jobs.simulated.judge import BlockOutcome
from pixstep.jobs.stations import Station
from pixstep.simulation.logs import read_clock_log, read_edges, read_plant
from pixstep.simulation.simulated_board import SETTLE_PIXELS, SimLink
from pixstep.simulation.simulator import SimOptions

_TOKEN = 1  # the same for every run of a block: so the same cycles
_EDGES, _CLOCK, _PLANTS = "edges.csv", "clock.csv", "plants.csv"


@dataclass(frozen=True)
class Answer:
    """What comes back of a block: its rows packed, by whom, and how long that took.

    `refused` says why a process did not simulate it.
    """

    key: str
    rows: bytes
    host: str
    edges: str
    seconds: float
    refused: str = ""


def simulate(data: bytes, folder: str) -> Answer:
    """Simulate a block; leave its edges in a folder of this computer."""
    began = time.monotonic()
    block, who = unpack(data), cuts.host()
    path = Path(folder).expanduser().resolve() / f"{block.key}.parquet"
    try:
        cuts.require_same_tools(
            block.tools, cuts.tools_here(block.place.kinds, block.world.images), who
        )
        with atomic.told_of(path.parent):
            atomic.make_folder(path.parent)
        found = _judged(block, path)
    except PlainError as error:
        return Answer(block.key, b"", who, str(path), 0.0, str(error))
    packed = rows.pack(found)
    return Answer(block.key, packed, who, str(path), round(time.monotonic() - began, 3))


def _judged(block: JobBlock, path: Path) -> list[rows.LineRow]:
    """Run and judge a block, and write its edges."""
    part = atomic.unfinished_folder(path.parent)
    try:
        with atomic.told_of(path):
            trouble = _run(block, part.path)
        place = part.path / _PLANTS
        made = BlockOutcome(
            block, read_edges(part.path / _EDGES), read_clock_log(part.path / _CLOCK),
            read_plant(place) if place.is_file() else {}, trouble,
        )  # fmt: skip
    finally:
        part.remove()
    found = judge.judge(made)
    with atomic.rules(atomic.WriteRules(force=True)):
        atomic.write_bytes(path, rows.pack_edges(found.edges))
    return found.rows


def _run(block: JobBlock, folder: Path) -> str:
    """Make the lines, as a printer makes them; return what went wrong, if anything did."""
    machine, job = block.job.machine.tables, block.job
    plants = plants_of(block)
    options = SimOptions(
        [(kind, cuts.image_of(kind, block.world.images)) for kind in block.place.boards.values()],
        machine.clock_hz, pixel_ppm=block.world.ppm, flaws=block.world.flaws,
        seed=block.world.seed, edges=folder / _EDGES, clock_log=folder / _CLOCK,
        plants=plants, plant_log=folder / _PLANTS if plants else None,
    )  # fmt: skip
    trouble = ""
    with SimLink(options) as link:
        try:
            found = _stations(block, link)
            _set_up(block, found)
            chain = Chain(
                job, machine, found, link.world, lambda event: None, RunWatch(), 1, job.lines,
                token=_TOKEN,
            )  # fmt: skip
            if chain.make() is ChainEnd.DRY:
                trouble = f"the bus was too slow: the motors rested after line {chain.made}"
        except (BoardError, UserError) as error:
            trouble = str(error)
        link.world.wait(float(SETTLE_PIXELS / machine.pixel_hz))
        link.simulator.quit()
    return trouble


def _stations(block: JobBlock, link: SimLink) -> list[Station]:
    return [
        Station(
            name, link.board(number + 1),
            {motor: axis for motor, (board, axis) in block.place.motors.items() if board == number},
            link,
        )
        for number, name in enumerate(block.place.boards)
    ]  # fmt: skip


def _set_up(block: JobBlock, found: list[Station]) -> None:
    """Set the boards as the job has them."""
    for station in found:
        old = settings.read(station.board)
        settings.write(
            station.board, old, settings.changes(old, block.settings.get(station.name, {}))
        )
    stations.set_clock(found, block.job.machine.tables)
    stations.ready(found)


def plants_of(block: JobBlock) -> dict[tuple[int, int], str]:
    """Return the play of each motor whose lines take it up, on the side that the job says."""
    found = {}
    for name, place in block.place.motors.items():
        if play := block.job.header.motors[name].backlash:
            side = "minus" if block.job.runs_of(1)[name].play_side == MINUS else "plus"
            found[place] = f"play={play},taken_up={side}"
    return found
