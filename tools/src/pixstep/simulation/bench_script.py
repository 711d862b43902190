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
from pixstep.simulation.virtual_bench import REST_S, SIGNALS, NotInTimeError, VirtualBench, wired

Act = Callable[[VirtualBench], object]
_MOST_HZ = 60_000  # of the simulator's clock
_MOST_PPM = 100_000
# Of a time, by its word in the patterns; LIMIT is in simulated time, and may be left out.
_MOST_S = {"TIME": 86_400, "LIMIT": 86_400, "REST": 3600, "JITTER": 0.01}
_LIMIT = "60s"
_VALUES = ("AXIS", "N", "PPM", "HZ", "PARAMETERS", *_MOST_S)
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
        except (UserError, NotInTimeError) as error:
            kind = NotInTimeError if isinstance(error, NotInTimeError) else UserError
            raise kind(f"{self.place}: {error}") from None


def parse(text: str, kind: boards.BoardKind, place: str) -> Order | None:
    """Return a command for a board, None for an empty line. Raises UserError with the place."""
    words = text.partition("#")[0].split()
    if not words:
        return None
    try:
        if words[0] not in FORMS:
            raise UserError(f"there is no command {words[0]!r}: one of {', '.join(FORMS)}")
        return Order(" ".join(words), place, _read(words, kind))
    except UserError as error:
        raise UserError(f"{place}: {error}") from None


def parse_all(lines: Iterable[str], kind: boards.BoardKind, name: str) -> list[Order]:
    """Return the commands of a script. Raises RefusedError for the first wrong line."""
    places = ((f"{name}: line {number}", text) for number, text in enumerate(lines, start=1))
    try:
        return [order for place, text in places if (order := parse(text, kind, place))]
    except UserError as error:
        raise RefusedError(str(error)) from None


def _read(words: list[str], kind: boards.BoardKind) -> Act:
    """Return what a command does, by the first of its patterns that fits."""
    for pattern, act in _READERS[words[0]].items():
        wanted = pattern.split()
        said = [*words, _LIMIT] if wanted[-1] == "LIMIT" and len(words) < len(wanted) else words
        if len(said) == len(wanted) and all(map(_fits, wanted, said)):
            values = [
                _value(words, name, word, kind)
                for name, word in zip(wanted, said, strict=True)
                if name in _VALUES
            ]
            return lambda bench: act(bench, *values)
    raise _wrong(words)


def _fits(name: str, word: str) -> bool:
    """Whether a word may stand where a pattern has a word, or in capitals the name of a value."""
    if name == "PPM":
        return _PPM.fullmatch(word) is not None
    return name in _VALUES or name == word


def _wrong(words: list[str], why: object = "") -> UserError:
    return UserError(f"{' '.join(words)!r}: {why or f'expected {FORMS[words[0]]}'}")


def _value(words: list[str], name: str, word: str, kind: boards.BoardKind) -> object:
    """Return a value of a command. Raises UserError saying what is wrong with it."""
    if name in ("AXIS", "N") and not (word.isascii() and word.isdecimal() and len(word) < 10):
        raise _wrong(words)
    if name == "N":
        return int(word)
    if name == "AXIS":
        return _axis(words, word, kind)
    if name in _MOST_S:
        return _seconds(words, word, _MOST_S[name])
    if name == "PPM":
        ppm = float(word.removesuffix("ppm"))
        if abs(ppm) >= _MOST_PPM:
            raise _wrong(words, f"less than {_MOST_PPM} ppm")
        return ppm
    if name == "HZ":
        return _hz(words, word)
    if not _PARAMETERS.fullmatch(word):
        raise _wrong(words)
    return word


def _axis(words: list[str], word: str, kind: boards.BoardKind) -> int:
    if len(word) > 3 or int(word) >= kind.axes:
        raise _wrong(words, f"axis {word}: the {boards.axes_text(kind.name)}")
    if words[1] in SIGNALS and not wired(kind, words[1], int(word)):
        raise _wrong(words, f"the {kind.name} has no such input")
    return int(word)


def _seconds(words: list[str], word: str, most_s: float) -> float:
    try:
        seconds = parse_seconds(word)
    except UserError as error:
        raise _wrong(words, error) from None
    if seconds > most_s:
        raise _wrong(words, f"at most {most_s:g} s")
    return float(seconds)


def _hz(words: list[str], word: str) -> Fraction:
    try:
        hz = parse_hz(word)
    except UserError:
        raise _wrong(words) from None
    if hz > _MOST_HZ:
        raise _wrong(words, f"at most {_MOST_HZ} Hz")
    return hz


def _turned(word: str, *, closed: bool) -> dict[str, Callable[..., object]]:
    def act(switch: str) -> Callable[..., object]:
        return lambda bench, axis: bench.turn_switch(switch, axis, closed=closed)

    return {f"{word} {switch} AXIS": act(switch) for switch in SIGNALS}


def _moves(bench: VirtualBench, axis: int) -> Callable[[], bool]:
    before = bench.edges(axis)
    return lambda: bench.edges(axis) != before


def _rests(bench: VirtualBench, axis: int) -> Callable[[], bool]:
    """Return what is true once an axis has made no edge for a while."""
    edges, since_s = bench.edges(axis), bench.time_s

    def rests() -> bool:
        nonlocal edges, since_s
        now = bench.edges(axis)
        if now != edges:
            edges, since_s = now, bench.time_s
        return bench.time_s - since_s >= REST_S

    return rests


def _permit(level: int) -> Callable[..., object]:
    text = f"until permit {'on' if level else 'off'}"
    return lambda bench, limit_s: bench.wait_until(lambda: bench.permit() == level, limit_s, text)


def _until_edges(bench: VirtualBench, axis: int, wanted: int, limit_s: float) -> None:
    text = f"until edges {axis} {wanted}"
    bench.wait_until(lambda: bench.edges(axis) >= wanted, limit_s, text)


# What each command does: patterns in their order, with the names of values in capitals.
_READERS: dict[str, dict[str, Callable[..., object]]] = {
    "press": _turned("press", closed=True),
    "release": _turned("release", closed=False),
    "estop": {
        "estop press": lambda bench: bench.turn_estop(pressed=True),
        "estop release": lambda bench: bench.turn_estop(pressed=False),
    },
    "clock": {
        "clock stop": lambda bench: bench.run_clock(False),
        "clock start": lambda bench: bench.run_clock(True),
        "clock false": lambda bench: bench.simulator.edge(0, "pulse"),
        "clock gate off": lambda bench: bench.simulator.clock("gate 0 0"),
        "clock gate N REST": lambda bench, edges, rest_s: bench.simulator.clock(
            f"gate {edges} {round(1e6 * rest_s)}"
        ),
        "clock drop N": lambda bench, count: bench.simulator.clock(f"drop {count}"),
        "clock rest REST": lambda bench, rest_s: bench.simulator.clock(
            f"rest {round(1e6 * rest_s)}"
        ),
        "clock jitter JITTER": lambda bench, jitter_s: bench.simulator.clock(
            f"jitter {round(1e9 * jitter_s)}"
        ),
        "clock PPM": lambda bench, ppm: bench.set_clock_ppm(ppm),
        "clock HZ": lambda bench, hz: bench.set_clock_hz(hz),
    },
    "load": {"load AXIS PARAMETERS": lambda bench, axis, text: bench.set_load(axis, text)},
    "supply": {
        "supply 5V": lambda bench: bench.switch_supply(powered=True),
        "supply off": lambda bench: bench.switch_supply(powered=False),
        "supply brownout": lambda bench: bench.simulator.reset(0, "brownout"),
    },
    "reset": {"reset": lambda bench: bench.simulator.reset(0, "external")},
    "wait": {"wait TIME": lambda bench, seconds: bench.wait(seconds)},
    "until": {
        "until moves AXIS LIMIT": lambda bench, axis, limit_s: bench.wait_until(
            _moves(bench, axis), limit_s, f"until moves {axis}"
        ),
        "until rests AXIS LIMIT": lambda bench, axis, limit_s: bench.wait_until(
            _rests(bench, axis), limit_s, f"until rests {axis}"
        ),
        "until edges AXIS N LIMIT": _until_edges,
        "until permit on LIMIT": _permit(1),
        "until permit off LIMIT": _permit(0),
    },
    "status": {"status": lambda _: None},
    "quit": {"quit": lambda bench: setattr(bench, "ended", True)},
}
