# SPDX-License-Identifier: MIT
"""The commands of the virtual bench: a line of text each, read whole before any is done.

press home 0          release home 0        (home, minus, plus; AXIS)
estop press           estop release
clock 30Hz            clock stop            clock start     clock +300ppm   clock drop 3
clock gate 512 20ms   clock gate off        clock rest 1s   clock jitter 5us    clock false
load 0 home=2000,travel=-500..4000,start=100
supply 5V             supply off            supply brownout reset
wait 200ms
until moves 0         until rests 0 20s     until edges 0 1000     until permit off 5s
status                quit
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import boards
from pixstep.errors import RefusedError, UserError
from pixstep.lines.units import parse_hz, parse_seconds
from pixstep.simulation.virtual_bench import (
    REST_S,
    SIGNALS,
    NotInTimeError,
    VirtualBench,
    wired,
)

Act = Callable[[VirtualBench], object]
_MOST_HZ = 60_000  # of the simulator's clock
_MOST_PPM = 100_000
_MOST_S = 86_400
_MOST_REST_S = 3600
_MOST_JITTER_S = 0.01
_LIMIT_S = 60.0  # of `until`, in simulated time
_PPM = re.compile(r"([+-]?[0-9]+(?:\.[0-9]+)?)ppm")
_PARAMETERS = re.compile(r"[a-z_]+=[-+.:a-z0-9]+(,[a-z_]+=[-+.:a-z0-9]+)*")
FORMS = {
    "press": "press home|minus|plus AXIS",
    "release": "release home|minus|plus AXIS",
    "estop": "estop press|release",
    "clock": "clock 30Hz|stop|start|+300ppm|drop N|gate EDGES TIME|gate off|rest TIME|jitter TIME"
    "|false",
    "load": "load AXIS PARAMETERS",
    "supply": "supply 5V|off|brownout",
    "reset": "reset",
    "wait": "wait TIME",
    "until": "until moves|rests AXIS, edges AXIS N or permit on|off, [LIMIT]",
    "status": "status",
    "quit": "quit",
}


@dataclass(frozen=True)
class Order:
    """One command: its text, where it was written, and what it does."""

    text: str
    place: str
    act: Act

    def obey(self, bench: VirtualBench) -> None:
        """Do it. Raises UserError or NotInTimeError with the place."""
        try:
            self.act(bench)
        except UserError as error:
            raise UserError(f"{self.place}: {error}") from None
        except NotInTimeError as error:
            raise NotInTimeError(f"{self.place}: {error}") from None


def parse(text: str, kind: boards.BoardKind, place: str) -> Order | None:
    """Return a command for a board, None for an empty line. Raises UserError with the place."""
    words = text.partition("#")[0].split()
    if not words:
        return None
    try:
        if words[0] not in FORMS:
            raise UserError(f"there is no command {words[0]!r}: one of {', '.join(FORMS)}")
        return Order(" ".join(words), place, _READERS[words[0]](words, kind))
    except UserError as error:
        raise UserError(f"{place}: {error}") from None


def parse_all(lines: Iterable[str], kind: boards.BoardKind, name: str) -> list[Order]:
    """Return the commands of a script. Raises RefusedError for the first wrong line."""
    places = ((f"{name}: line {number}", text) for number, text in enumerate(lines, start=1))
    try:
        return [order for place, text in places if (order := parse(text, kind, place))]
    except UserError as error:
        raise RefusedError(str(error)) from None


def _wrong(words: list[str]) -> UserError:
    return UserError(f"{' '.join(words)!r}: expected {FORMS[words[0]]}")


def _word(words: list[str], table: dict[str, Act]) -> Act:
    """Return what the only word behind a command's name means."""
    if len(words) != 2 or words[1] not in table:
        raise _wrong(words)
    return table[words[1]]


def _axis(words: list[str], word: str, kind: boards.BoardKind) -> int:
    if not (word.isascii() and word.isdecimal()):
        raise _wrong(words)
    if len(word) > 3 or int(word) >= kind.axes:
        raise UserError(f"{' '.join(words)!r}: axis {word}: the {boards.axes_text(kind.name)}")
    return int(word)


def _number(words: list[str], word: str) -> int:
    if not (word.isascii() and word.isdecimal() and len(word) < 10):
        raise _wrong(words)
    return int(word)


def _seconds(words: list[str], word: str, most_s: float = _MOST_S) -> float:
    try:
        seconds = parse_seconds(word)
    except UserError as error:
        raise UserError(f"{' '.join(words)!r}: {error}") from None
    if seconds > most_s:
        raise UserError(f"{' '.join(words)!r}: at most {most_s:g} s")
    return float(seconds)


def _switch(words: list[str], kind: boards.BoardKind) -> Act:
    if len(words) != 3 or words[1] not in SIGNALS:
        raise _wrong(words)
    switch, axis = words[1], _axis(words, words[2], kind)
    if not wired(kind, switch, axis):
        raise UserError(f"{' '.join(words)!r}: the {kind.name} has no such input")
    closed = words[0] == "press"
    return lambda bench: bench.turn_switch(switch, axis, closed=closed)


def _estop(words: list[str], _: boards.BoardKind) -> Act:
    return _word(words, {
        "press": lambda bench: bench.turn_estop(pressed=True),
        "release": lambda bench: bench.turn_estop(pressed=False),
    })  # fmt: skip


def _clock(words: list[str], _: boards.BoardKind) -> Act:
    if len(words) > 2:
        return _clock_change(words)
    if len(words) != 2:
        raise _wrong(words)
    if words[1] == "false":
        return lambda bench: bench.false_edge()
    if words[1] in ("stop", "start"):
        runs = words[1] == "start"
        return lambda bench: bench.run_clock(runs)
    error = _PPM.fullmatch(words[1])
    if error:
        ppm = float(error[1])
        if abs(ppm) >= _MOST_PPM:
            raise UserError(f"{' '.join(words)!r}: less than {_MOST_PPM} ppm")
        return lambda bench: bench.set_clock_ppm(ppm)
    hz = _hz(words)
    return lambda bench: bench.set_clock_hz(hz)


def _clock_change(words: list[str]) -> Act:
    """Return what a word with a number or a time behind it does to the clock."""
    if words[1:] == ["gate", "off"]:
        return lambda bench: bench.gate_clock(0, 0.0)
    if len(words) == 4 and words[1] == "gate":
        edges, gate_s = _number(words, words[2]), _seconds(words, words[3], _MOST_REST_S)
        return lambda bench: bench.gate_clock(edges, gate_s)
    if len(words) != 3:
        raise _wrong(words)
    if words[1] == "drop":
        count = _number(words, words[2])
        return lambda bench: bench.drop_pulses(count)
    if words[1] == "rest":
        rest_s = _seconds(words, words[2], _MOST_REST_S)
        return lambda bench: bench.rest_clock(rest_s)
    if words[1] == "jitter":
        jitter_s = _seconds(words, words[2], _MOST_JITTER_S)
        return lambda bench: bench.jitter_clock(jitter_s)
    raise _wrong(words)


def _hz(words: list[str]) -> Fraction:
    try:
        hz = parse_hz(words[1])
    except UserError:
        raise _wrong(words) from None
    if hz > _MOST_HZ:
        raise UserError(f"{' '.join(words)!r}: at most {_MOST_HZ} Hz")
    return hz


def _load(words: list[str], kind: boards.BoardKind) -> Act:
    if len(words) != 3 or not _PARAMETERS.fullmatch(words[2]):
        raise _wrong(words)
    axis, parameters = _axis(words, words[1], kind), words[2]
    return lambda bench: bench.set_load(axis, parameters)


def _supply(words: list[str], _: boards.BoardKind) -> Act:
    return _word(words, {
        "5V": lambda bench: bench.switch_supply(powered=True),
        "off": lambda bench: bench.switch_supply(powered=False),
        "brownout": lambda bench: bench.reset("brownout"),
    })  # fmt: skip


def _alone(act: Act) -> Callable[[list[str], boards.BoardKind], Act]:
    def read(words: list[str], _: boards.BoardKind) -> Act:
        if len(words) != 1:
            raise _wrong(words)
        return act

    return read


def _wait(words: list[str], _: boards.BoardKind) -> Act:
    if len(words) != 2:
        raise _wrong(words)
    seconds = _seconds(words, words[1])
    return lambda bench: bench.wait(seconds)


def _until(words: list[str], kind: boards.BoardKind) -> Act:
    takes = {"moves": 3, "rests": 3, "edges": 4, "permit": 3}.get(words[1] if words[1:] else "", 0)
    if not takes or len(words) not in (takes, takes + 1):
        raise _wrong(words)
    limit_s = _seconds(words, words[takes]) if words[takes:] else _LIMIT_S
    holds = _condition(words, kind)
    text = " ".join(words[:takes])
    return lambda bench: bench.wait_until(holds(bench), limit_s, text)


def _condition(
    words: list[str], kind: boards.BoardKind
) -> Callable[[VirtualBench], Callable[[], bool]]:
    """Return what makes the condition of a bench, from when the command begins."""
    if words[1] == "permit":
        if words[2] not in ("on", "off"):
            raise _wrong(words)
        level = int(words[2] == "on")
        return lambda bench: lambda: bench.permit() == level
    axis = _axis(words, words[2], kind)
    if words[1] == "rests":
        return lambda bench: _Rest(bench, axis)
    if words[1] == "edges":
        wanted = _number(words, words[3])
        return lambda bench: lambda: bench.edges(axis) >= wanted
    return lambda bench: _moves(bench, axis)


def _moves(bench: VirtualBench, axis: int) -> Callable[[], bool]:
    before = bench.edges(axis)
    return lambda: bench.edges(axis) != before


class _Rest:
    """True when called once an axis has made no edge for a while."""

    def __init__(self, bench: VirtualBench, axis: int) -> None:
        self.bench, self.axis = bench, axis
        self.edges, self.since_s = bench.edges(axis), bench.time_s

    def __call__(self) -> bool:
        now = self.bench.edges(self.axis)
        if now != self.edges:
            self.edges, self.since_s = now, self.bench.time_s
        return self.bench.time_s - self.since_s >= REST_S


def _quit(bench: VirtualBench) -> None:
    bench.ended = True


_READERS: dict[str, Callable[[list[str], boards.BoardKind], Act]] = {
    "press": _switch,
    "release": _switch,
    "estop": _estop,
    "clock": _clock,
    "load": _load,
    "supply": _supply,
    "reset": _alone(lambda bench: bench.reset("external")),
    "wait": _wait,
    "until": _until,
    "status": _alone(lambda _: None),
    "quit": _alone(_quit),
}
