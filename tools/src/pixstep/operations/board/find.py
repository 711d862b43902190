# SPDX-License-Identifier: MIT
"""Which boards there are, and what they say of themselves: scan, info, features."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypedDict

from pixstep.board import boards, scan, settings, snapshot
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import LEAST_BAUD, MOST_BAUD, PARITIES
from pixstep.board.scan import BAUDS, ScannedBoard
from pixstep.board.snapshot import LINE_COUNTERS, ClockData
from pixstep.errors import FINE, NEGATIVE, UserError
from pixstep.operations import bus
from pixstep.operations import machine_defaults as machine
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import ALL, UNITS, Known, OnPort, ToBoards, Units
from pixstep.operations.desk import Desk
from pixstep.operations.facts import Facts
from pixstep.operations.kinds import TEXT
from pixstep.operations.request import operation, option
from pixstep.operations.result import Page, Result
from pixstep.simulation import report

_USUAL = "usual"


class FoundBoard(TypedDict):
    """What answered at an address; `trouble` says why it is not a board to talk to."""

    unit: int
    board: str
    firmware: str
    map_version: int
    axes: int
    status: str
    fault: str
    trouble: str


class SerialSettings(TypedDict):
    """How boards were spoken to; None if none answered."""

    baud: int | None
    parity: str | None


class FoundBoards(SerialSettings):
    """What answered on a port."""

    port: str
    boards: list[FoundBoard]


class Feature(TypedDict):
    """A part of the firmware that an image has or lacks."""

    name: str
    bit: int
    has: bool
    meaning: str


class BoardFeatures(TypedDict):
    """The features of a board's image."""

    unit: int
    board: str
    features: list[Feature]


class Features(TypedDict):
    """The features of some boards."""

    boards: list[BoardFeatures]


class BoardPixelClock(TypedDict):
    """A board's pixel clock: as it is set, and as it was measured.

    `clock_out_hz` is the clock that the board makes itself; 0: none.
    """

    present: bool
    edges: int
    set_hz: str
    clock_out_hz: int
    divider: int
    measured_hz: float | None
    measured: ClockData | None


class StoredSettings(TypedDict):
    """Whether a board's settings are stored, and whether those in force are others."""

    record: int
    stored: bool
    differ: bool


class AxisInfo(TypedDict):
    """How an axis is."""

    axis: int
    state: str
    position_steps: int
    pixel: int
    lines_done: int
    queue_free: int
    underruns: int


class BoardInfo(TypedDict):
    """What a board is and how it is."""

    unit: int
    board: str
    firmware: str
    map_version: int
    server_id: str
    identification: dict[str, str]
    features: list[str]
    status: str
    reset_cause: str
    fault: str
    pixel_clock: BoardPixelClock
    outputs: str
    inputs: str
    settings: StoredSettings
    counters: dict[str, int]
    axes: list[AxisInfo]


class BoardInfos(TypedDict):
    """The identity and state of some boards."""

    boards: list[BoardInfo]


@operation("board scan")
class BoardScan(OnPort):
    """Look for boards at every address of the line.

    Exit status 0 if a board answers, 1 if none does.
    """

    result = FoundBoards

    units: Units = option(
        UNITS, "Addresses.", "--unit", default=ALL, default_text="1-247",
        machine=machine.units_if_named,
    )  # fmt: skip
    bauds: str | None = option(
        TEXT,
        "Try several rates, each with every parity, until something answers: 9600,19200, or "
        "without a value all usual ones.",
        shown="[RATES]", alone=_USUAL,
    )  # fmt: skip

    def run(self, desk: Desk) -> Result:
        """Ask every address at each rate."""
        addresses = scan.UNITS if isinstance(self.units, str) else self.units
        rates, patience_s = self._rates(), self.timeout or scan.TIMEOUT_S
        with bus.opened(desk, self) as found, scan.quickly(found.modbus, patience_s):
            answers, place = _search(desk, found, addresses, rates)
        if answers:
            desk.aside(f"note: {self.port}: {place['baud']} baud, parity {place['parity']}")
        else:
            desk.aside(f"{self.port}: nothing answers")
        data = {"port": self.port, **place, "boards": [item.as_json() for item in answers]}
        there = any(not item.trouble for item in answers)
        return Result(data, lambda page: _write_found(page, answers), FINE if there else NEGATIVE)

    def _rates(self) -> list[tuple[int, str]]:
        """Return the rates and parities to try in turn."""
        if self.bauds is None:
            return [(self.baud, self.bus.real_parity)]
        if self.bauds == _USUAL:
            return [(baud, parity) for baud in BAUDS for parity in PARITIES]
        texts = [text.strip() for text in self.bauds.split(",")]
        if not all(text.isdecimal() and LEAST_BAUD <= int(text) <= MOST_BAUD for text in texts):
            raise AskedError(
                "{bauds} {rates}: rates from {least} to {most} baud are wanted, as in 9600,19200",
                rates=self.bauds, least=LEAST_BAUD, most=MOST_BAUD,
            )  # fmt: skip
        return [(int(text), parity) for text in texts for parity in PARITIES]


@operation("board info")
class Info(ToBoards):
    """Show the identity and state of boards.

    Identity, status, fault, reset cause, pixel clock, counters, axes, whether settings are stored.
    """

    result = BoardInfos

    @classmethod
    def prepare(cls, facts: Facts, say: Callable[[Iterable[str]], None]) -> None:
        """Show also a board that the machine file has otherwise."""
        del say
        facts.any_board = True

    def run(self, desk: Desk) -> Result:
        """Read each board; what those that answer say is there also if another does not."""
        told: list[BoardInfo] = []

        def write(page: Page) -> None:
            for item in told:
                _write_info(page, item)

        def read(item: Known) -> None:
            told.append(_info(item))
            desk.so_far = result

        result = Result({"boards": told}, write)
        bus.each_board(desk, self, read)
        return result


@operation("board features")
class ShowFeatures(ToBoards):
    """Show what boards' images were built with.

    A command that needs what a board's image lacks is refused, and names it.
    """

    result = Features

    def run(self, desk: Desk) -> Result:
        """Ask each board."""
        with bus.boards(desk, self) as (_found, known):
            told: list[BoardFeatures] = [
                {"unit": item.board.unit, "board": item.who.board, "features": _features(item)}
                for item in known
            ]
        return Result({"boards": told}, lambda page: _write_features(page, told))


def _search(
    desk: Desk, found: Link, addresses: Iterable[int], rates: list[tuple[int, str]]
) -> tuple[list[ScannedBoard], SerialSettings]:
    """Scan at one rate after the other until a board answers; return what did, and where."""
    answers: list[ScannedBoard] = []
    for index, (baud, parity) in enumerate(rates):
        if len(rates) > 1 and not _at(found, baud, parity):
            continue
        title = f"looking for boards at {baud} baud, parity {parity} ({index + 1}/{len(rates)})"
        with desk.progress(title) as show:
            heard = scan.scan(found.modbus, addresses, show)
        if any(not item.trouble for item in heard) or len(rates) == 1:
            return heard, {"baud": baud, "parity": parity}
        answers = answers or heard
    return answers, {"baud": None, "parity": None}


def _at(found: Link, baud: int, parity: str) -> bool:
    """Go to a rate and parity; False if the port cannot."""
    try:
        found.modbus.reconfigure(baud, parity)
    except UserError:
        return False
    return True


def _write_found(page: Page, answers: list[ScannedBoard]) -> None:
    if not answers:
        return
    table = report.new_table("unit", "board", "firmware", "map", "axes", "status", "fault")
    for column in (1, 5, 6):
        table.columns[column].justify = "left"
    for item in answers:
        if not item.board:
            table.add_row(str(item.unit), "?", "", "", "", item.trouble, "")
            continue
        version = str(item.map_version) + (f" ({item.trouble})" if item.trouble else "")
        table.add_row(
            str(item.unit), item.board, item.firmware, version, str(item.axes), item.status,
            item.fault,
        )  # fmt: skip
    page.draw(table)


def _info(known: Known) -> BoardInfo:
    board, who = known.board, known.who
    state, axes = board.inputs(), board.axes(who.axis_count)
    names = board.map.input
    told = settings.read(board)
    clock = snapshot.read_clock(board, state)
    return {
        "unit": board.unit,
        "board": who.board,
        "firmware": who.firmware,
        "map_version": who.map_version,
        "server_id": server_id(known),
        "identification": _identification(known),
        "features": [item.name for item in boards.features() if board.has(item.name)],
        "status": regs.words(names("status"), state["status"]),
        "reset_cause": regs.words(names("reset_cause"), state["reset_cause"]),
        "fault": board.fault_text(),
        "pixel_clock": {
            "present": regs.flags(state["status"])["clock"],
            "edges": state["pixel_edges"],
            "set_hz": f"{told['pixel_hz_num']}/{told['pixel_hz_den']}",
            "clock_out_hz": told.get(boards.CLOCK_OUT_SETTING, 0),
            "divider": settings.divider_of(told),
            "measured_hz": snapshot.measured_hz(clock, state, board.tick_hz()),
            "measured": clock.as_json() if clock else None,
        },
        "outputs": regs.words(names("outputs"), state["outputs"]),
        "inputs": regs.words(names("inputs"), state["inputs"]),
        "settings": {
            "record": state["settings_serial"],
            "stored": bool(state["settings_serial"]),
            "differ": bool(state["settings_state"] & settings.DIFFERS),
        },
        "counters": {name: state[name] for name in LINE_COUNTERS},
        "axes": [
            {
                "axis": number,
                "state": regs.words(board.map.axis_input("axis_state"), axis["axis_state"]),
                "position_steps": axis["position_steps"],
                "pixel": axis["pixel"],
                "lines_done": axis["lines_done"],
                "queue_free": axis["queue_free"],
                "underruns": axis["underruns"],
            }
            for number, axis in enumerate(axes)
        ],
    }


def server_id(known: Known) -> str:
    """Return the answer to function 17; of a board without it the same from its registers."""
    if known.board.has("diagnosis"):
        return known.board.identify().text
    return f"pixstep {known.who.board} {known.who.firmware}"


def _features(known: Known) -> list[Feature]:
    """Return all features, and whether the board has each."""
    return [
        {
            "name": item.name,
            "bit": item.bit,
            "has": known.board.has(item.name),
            "meaning": item.meaning,
        }
        for item in boards.features()
    ]


def _write_features(page: Page, told: list[BoardFeatures]) -> None:
    boards = (f"{item['unit']} {item['board']}" for item in told)
    table = report.new_table("feature", *boards, "what")
    for column in table.columns:
        column.justify = "left"
    for row in zip(*(item["features"] for item in told), strict=True):
        has = ("yes" if one["has"] else "no" for one in row)
        table.add_row(row[0]["name"], *has, row[0]["meaning"])
    page.draw(table, wide=True)


def _identification(known: Known) -> dict[str, str]:
    """Return the objects of function 43/14; none if the board does not have it."""
    if not known.board.has("diagnosis"):
        return {}
    try:
        return known.board.identification()
    except BoardError:
        return {}


def _write_info(page: Page, told: BoardInfo) -> None:
    page.draw(_headline(told))
    clock = told["pixel_clock"]
    seen = "present" if clock["present"] else "not present"
    set_to = f"set to {clock['set_hz']} Hz{_measured_text(clock)}"
    if clock["clock_out_hz"]:
        set_to += f", {clock['clock_out_hz']} Hz made by the board itself"
    for name, text in (
        ("status", told["status"]),
        ("fault", told["fault"] or "none"),
        ("reset", told["reset_cause"]),
        ("pixel clock", f"{seen}, {clock['edges']} edges since reset, {set_to}"),
        ("outputs", told["outputs"]),
        ("switches", told["inputs"]),
        ("settings", _settings_text(told["settings"])),
        ("counters", ", ".join(f"{key} {count}" for key, count in told["counters"].items())),
    ):
        page.tell(f"  {name:<13}{text}")
    table = report.new_table("axis", "state", "position", "pixel", "lines", "queue free",
                             "underruns")  # fmt: skip
    table.columns[1].justify = "left"
    for axis in told["axes"]:
        table.add_row(*(str(value) for value in axis.values()))
    page.draw(table)


def _headline(told: BoardInfo) -> Any:
    from rich.text import Text  # takes a while to load

    return Text(
        f"board {told['unit']}: {told['board']}, firmware {told['firmware']}, register map "
        f"{told['map_version']} ({told['server_id']})",
        style="bold",
    )


def _measured_text(clock: BoardPixelClock) -> str:
    """Return what there is to say of a clock: edges of a pixel if several, what was measured."""
    found, edges = clock["measured"], clock["divider"]
    text = f", {edges} edges a pixel" if edges > 1 else ""
    if found is None:
        hz = clock["measured_hz"]
        return f"{text}; measured {hz:.4g} Hz: another clock" if hz else text
    return (
        f"{text}; period {found['period_us']:.3f} us ({found['offset_ppm']:+.1f} ppm), jitter "
        f"{found['mean_jitter_us']:.2f} us, {found['missing_edges']} missing, "
        f"{found['false_edges']} false"
    )


def _settings_text(stored: StoredSettings) -> str:
    if not stored["stored"]:
        return "defaults, nothing is stored" if not stored["differ"] else "not stored"
    text = f"stored as record {stored['record']}"
    return f"{text}; those in force differ from it" if stored["differ"] else text
