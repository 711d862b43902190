# SPDX-License-Identifier: MIT
"""Random trials: lines are queued and armed, then two or three commands come at any moment."""

import random
from dataclasses import dataclass

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep_dev.robustness.orders import lines
from pixstep_dev.robustness.orders.actions import (
    ASK,
    TELL,
    Action,
    BoardOrder,
    ClockCommand,
    Coils,
    Entries,
    Frequency,
    Look,
    PinInput,
    QueueBlock,
    StepWait,
    Wait,
)

# Every command there is, and the coils that stand for one.
COMMANDS = (
    "arm", "disarm", "stop", "discard", "clear_fault", "enable", "disable", "zero", "permit_on",
    "permit_off", "go", "store", "block", "coil arm", "coil disarm", "coil stop", "coil enable",
    "coil disable", "coil clear_fault", "coil permit_on", "coil permit_off", "clock",
)  # fmt: skip
ENDING = ("stop", "disarm", "discard", "coil stop", "coil disarm")  # these meet held periods
ESTOP = "estop"
_WRONG_KEY = 0x5AFF
_STARTS_CYCLES = 240_000  # an axis that waits for no clock makes its first period within so long
_GAP_CYCLES = 320_000
_STEP_LIMIT_CYCLES = 480_000
_AROUND_CYCLES = 1500  # of a STEP edge: the longest way of its handlers, and the confirmation
_WATCH_S = 0.05
_TOKEN = 77
_AHEAD = (0, 1, 4, 20, 40, 0x8000)  # edges; 0 names none, the last one has passed
_CLOCKS = ("off", "on", "drop 1", "drop 3", "ppm 90000", "ppm -2000", "hz 50/1", "hz 700/1")


@dataclass(frozen=True)
class OrdersTrial:
    """What is done, which commands of COMMANDS it tries, and at what speed, steps/s."""

    actions: tuple[Action, ...]
    tried: tuple[str, ...]
    steps_s: float


@dataclass(frozen=True)
class TrialLines:
    """The lines of a trial, by axis."""

    mask: int
    hz: int
    clocked: bool
    token: int | None
    entries: dict[int, Entries]
    speed: lines.Speed


@dataclass(frozen=True)
class TrialBoard:
    """Where a trial happens: the board, its axes, its clock."""

    board: str
    axes: int
    clock_hz: int


def make(rng: random.Random, place: TrialBoard, estop: float) -> OrdersTrial:
    """Return a random trial; `estop` is the share of those in which the stop is pressed."""
    tick_hz = boards.load(place.board).tick_hz
    setup = _setup(rng, place, tick_hz)
    tried = [rng.choice(rng.choice((COMMANDS, ENDING))) for _ in range(rng.choice((2, 2, 3)))]
    if not boards.load(place.board).all_features:  # no coils: the command that each stands for
        tried = [name.removeprefix("coil ") for name in tried]
    if rng.random() < estop:
        tried[rng.randrange(len(tried))] = ESTOP
    made = [*_begin(rng, setup, tick_hz), _moment(rng, setup, tick_hz)]
    for name in tried:
        made += [*_command(rng, name, setup, place.axes), Wait(_gap(rng, name))]
    made += [Look(), Wait(int(_WATCH_S * tick_hz)), Look()]
    return OrdersTrial(tuple(made), tuple(tried), setup.speed.steps_s)


def _setup(rng: random.Random, place: TrialBoard, tick_hz: int) -> TrialLines:
    clocked = rng.random() < 0.25
    hz = place.clock_hz if clocked else rng.choice(lines.pixel_hz(place.board))
    mask = rng.randrange(1, 1 << place.axes)
    made = {}
    for axis in range(place.axes):
        smooth = rng.random() < 0.3
        speed = lines.speed(rng, place.board, hz, smooth=smooth)
        if mask >> axis & 1:
            made[axis] = lines.entries(rng, speed, tick_hz, smooth=smooth, clocked=clocked)
            fastest = speed
    return TrialLines(mask, hz, clocked, _TOKEN if rng.random() < 0.1 else None, made, fastest)


def _begin(rng: random.Random, setup: TrialLines, tick_hz: int) -> list[Action]:
    """Queue the lines and arm them."""
    how = TELL if rng.random() < 0.5 else ASK
    made: list[Action] = [Frequency(setup.hz, TELL)]
    made += [QueueBlock(axis, entries, 0, how) for axis, entries in setup.entries.items()]
    if rng.random() < 0.7:
        made.append(BoardOrder("permit_on", 0, None, TELL))
    made.append(BoardOrder("arm", setup.mask, setup.token, how))
    if setup.token and rng.random() < 0.7:
        ahead = lines.go_ahead(tick_hz, setup.hz)
        made += [Wait(rng.randrange(200_000)), BoardOrder("go", 0, setup.token, TELL, ahead)]
    return made


def _moment(rng: random.Random, setup: TrialLines, tick_hz: int) -> Action:
    """Return the wait for the first command: before the start, in motion, around a STEP edge."""
    way = rng.random()
    if way < 0.3:
        return Wait(rng.randrange(_STARTS_CYCLES))
    if way < 0.6:
        return Wait(_STARTS_CYCLES // 2 + rng.randrange(2 * _STARTS_CYCLES))
    period = int(tick_hz / setup.speed.steps_s)
    more = rng.randrange(period) if way < 0.8 else period
    axis = rng.choice(list(setup.entries))
    around = rng.randint(-_AROUND_CYCLES, _AROUND_CYCLES)
    return StepWait(axis, _STEP_LIMIT_CYCLES, min(more, _STEP_LIMIT_CYCLES) + around)


def _gap(rng: random.Random, name: str) -> int:
    """Short gaps are as likely as long ones; behind an emergency stop they are short."""
    most = _AROUND_CYCLES if name == ESTOP else _GAP_CYCLES
    return int(most ** rng.random())


def _command(rng: random.Random, name: str, setup: TrialLines, axes: int) -> list[Action]:
    how = TELL if rng.random() < 0.5 else ASK
    if name == ESTOP:
        return _press(rng)
    if name == "clock":
        return [ClockCommand(rng.choice(_CLOCKS))]
    if name == "block":
        return [_block(rng, setup, axes, how)]
    if name.startswith("coil "):
        return [_coil(rng, name.removeprefix("coil "), setup, how)]
    mask = setup.mask if rng.random() < 0.7 else rng.randrange(16)
    argument, ahead = None, 0
    if name == "store":
        argument = _WRONG_KEY
    elif name == "go" or (name == "arm" and rng.random() < 0.2):
        argument = rng.choice((0, _TOKEN, _TOKEN, _TOKEN + 1))
    if name == "go":
        ahead = rng.choice(_AHEAD)
    return [BoardOrder(name, mask, argument, how, ahead)]


def _press(rng: random.Random) -> list[Action]:
    """Half of the stops come while a broadcast that switches PERMIT on is being carried out."""
    press = PinInput("ESTOP", 0, 0)
    if rng.random() < 0.5:
        return [press]
    return [BoardOrder("permit_on", 0, None, TELL), Wait(rng.randrange(2 * _AROUND_CYCLES)), press]


def _coil(rng: random.Random, name: str, setup: TrialLines, how: str) -> Coils:
    group = {"enable": 0, "disable": 0, "arm": 1, "disarm": 1, "stop": 2}.get(name)
    value = 0 if name in ("disable", "disarm", "permit_off") else 1
    if group is None:
        coil = regs.COIL_CLEAR if name == "clear_fault" else regs.COIL_PERMIT
        return Coils(coil, (value,), how)
    axes = list(setup.entries)
    first = rng.choice(axes)
    values = [value]
    while first + len(values) in setup.entries and rng.random() < 0.5:
        values.append(value)
    return Coils(4 * group + first, tuple(values), how)


def _block(rng: random.Random, setup: TrialLines, axes: int, how: str) -> QueueBlock:
    """Return the next line, or a block that repeats, is out of order or impossible, or too big."""
    axis = rng.randrange(axes)
    entries = setup.entries.get(axis) or next(iter(setup.entries.values()))
    kind = rng.choice(("next", "repeated", "skipped", "refused", "big"))
    if kind == "refused":
        entries = rng.choice((((0x7FFF, 0),), ((1, 0), (0, 0), (20_000, 1)), ((5, 5), (2, 0))))
    elif kind == "big":
        entries = (*entries[:3], *[(1, 1), (2, 1)] * 16)
    return QueueBlock(axis, entries, {"repeated": -1, "skipped": 1}.get(kind, 0), how)
