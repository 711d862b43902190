# SPDX-License-Identifier: MIT
"""`pixstep board scan`, `info`, `features`: which boards there are, what they say of themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

import click

from pixstep import progress
from pixstep.board import clockstate, features, scan, settings
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import LEAST_BAUD, MOST_BAUD, PARITIES, Port
from pixstep.board.scan import BAUDS, Found
from pixstep.board.snapshot import LINE_COUNTERS
from pixstep.cli.board.group import (
    ALL,
    UNITS,
    Known,
    Units,
    boards,
    opened,
    port_options,
    units_option,
)
from pixstep.cli.command import command
from pixstep.cli.options import json_option, say, show_json
from pixstep.errors import UserError
from pixstep.simulation.report import WIDE, new_console, new_table

if TYPE_CHECKING:
    import rich.console


class _Place(TypedDict):
    baud: int | None
    parity: str | None


class _Feature(TypedDict):
    name: str
    bit: int
    has: bool
    meaning: str


class _PixelClock(TypedDict):
    present: bool
    edges: int
    set_hz: str
    divider: int
    measured_hz: float | None
    measured: clockstate.ClockData | None


class _Stored(TypedDict):
    record: int
    stored: bool
    differ: bool


class _Axis(TypedDict):
    axis: int
    state: str
    position_steps: int
    pixel: int
    lines_done: int
    queue_free: int
    underruns: int


class _Info(TypedDict):
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
    pixel_clock: _PixelClock
    outputs: str
    inputs: str
    settings: _Stored
    counters: dict[str, int]
    axes: list[_Axis]


@command("scan")
@port_options
@click.option("--unit", "units", type=UNITS, default=ALL, help="Addresses.  [default: 1-247]")
@click.option(
    "--bauds",
    is_flag=False,
    flag_value="usual",
    metavar="[RATES]",
    help="Try several rates, each with every parity, until something answers: 9600,19200, or "
    "without a value all usual ones.",
)
@json_option
@click.pass_context
def scan_command(
    ctx: click.Context, port: Port, units: Units, bauds: str | None, as_json: bool
) -> None:
    """Look for boards at every address of the line.

    Exit status 0 if a board answers, 1 if none does.
    """
    addresses = scan.UNITS if isinstance(units, str) else units
    rates = _rates(bauds, port)
    with opened(port) as found, scan.quickly(found.modbus, port.timeout_s or scan.TIMEOUT_S):
        answers, place = _search(found, list(addresses), rates)
    if as_json:
        show_json({"port": port.name, **place, "boards": [item.as_json() for item in answers]})
    elif answers:
        say((f"{port.name}: {place['baud']} baud, parity {place['parity']}",))
        _print_found(answers)
    else:
        click.echo(f"{port.name}: nothing answers", err=True)
    ctx.exit(0 if any(not item.trouble for item in answers) else 1)


@command("info")
@port_options
@units_option
@json_option
def info_command(port: Port, units: Units, as_json: bool) -> None:
    """Show what boards are and how they are.

    Identity, status, fault, reset cause, pixel clock, counters, axes, whether settings are stored.
    """
    with boards(port, units) as (_found, known):
        told = [_info(item) for item in known]
    if as_json:
        show_json({"boards": told})
        return
    console = new_console()
    for item in told:
        _print_info(console, item)


@command("features")
@port_options
@units_option
@json_option
def features_command(port: Port, units: Units, as_json: bool) -> None:
    """Show what boards' images were built with.

    A command that needs what a board's image lacks is refused, and names it.
    """
    with boards(port, units) as (_found, known):
        told = [
            {"unit": item.board.unit, "board": item.who.board, "features": _features(item)}
            for item in known
        ]
    if as_json:
        show_json({"boards": told})
        return
    table = new_table("feature", *(f"{item['unit']} {item['board']}" for item in told), "what")
    for column in table.columns:
        column.justify = "left"
    rows = zip(*(item["features"] for item in told), strict=True)
    for row in rows:
        has = ("yes" if one["has"] else "no" for one in row)
        table.add_row(row[0]["name"], *has, row[0]["meaning"])
    new_console(narrowest=WIDE).print(table, markup=False)


def _rates(bauds: str | None, port: Port) -> list[tuple[int, str]]:
    """Return the rates and parities to try in turn."""
    if bauds is None:
        return [(port.baud, port.real_parity)]
    if bauds == "usual":
        return [(baud, parity) for baud in BAUDS for parity in PARITIES]
    texts = [text.strip() for text in bauds.split(",")]
    if not all(text.isdecimal() and LEAST_BAUD <= int(text) <= MOST_BAUD for text in texts):
        raise UserError(
            f"--bauds {bauds}: rates from {LEAST_BAUD} to {MOST_BAUD} baud are wanted, as in "
            f"9600,19200"
        )
    chosen = [int(text) for text in texts]
    return [(baud, parity) for baud in chosen for parity in PARITIES]


def _search(
    found: Link, addresses: list[int], rates: list[tuple[int, str]]
) -> tuple[list[Found], _Place]:
    """Scan at one rate after the other until a board answers; return what did, and where."""
    answers: list[Found] = []
    for index, (baud, parity) in enumerate(rates):
        if len(rates) > 1 and not _at(found, baud, parity):
            continue
        title = f"looking for boards at {baud} baud, parity {parity} ({index + 1}/{len(rates)})"
        with progress.shown(title) as show:
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


def _print_found(answers: list[Found]) -> None:
    table = new_table("unit", "board", "firmware", "map", "axes", "status", "fault")
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
    new_console().print(table)


def _info(known: Known) -> _Info:
    """Return all that a board says, as plain data."""
    board, who = known.board, known.who
    state, axes = board.inputs(), board.axes(who.axis_count)
    names = board.map.input
    told = settings.read(board)
    clock = clockstate.read(board, state)
    return {
        "unit": board.unit,
        "board": who.board,
        "firmware": who.firmware,
        "map_version": who.map_version,
        "server_id": server_id(known),
        "identification": _identification(known),
        "features": [item.name for item in features.table() if board.has(item.name)],
        "status": regs.words(names("status"), state["status"]),
        "reset_cause": regs.words(names("reset_cause"), state["reset_cause"]),
        "fault": board.fault_text(),
        "pixel_clock": {
            "present": regs.flags(state["status"])["clock"],
            "edges": state["pixel_edges"],
            "set_hz": f"{told['pixel_hz_num']}/{told['pixel_hz_den']}",
            "divider": settings.divider_of(told),
            "measured_hz": clockstate.measured_hz(clock, state, board.tick_hz()),
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


def _features(known: Known) -> list[_Feature]:
    """Return all features, and whether the board has each."""
    return [
        {
            "name": item.name,
            "bit": item.bit,
            "has": known.board.has(item.name),
            "meaning": item.meaning,
        }
        for item in features.table()
    ]


def _identification(known: Known) -> dict[str, str]:
    """Return the objects of function 43/14; none if the board does not have it."""
    if not known.board.has("diagnosis"):
        return {}
    try:
        return known.board.identification()
    except BoardError:
        return {}


def _print_info(console: rich.console.Console, told: _Info) -> None:
    """Print a board's page."""

    def line(name: str, text: str) -> None:
        console.print(f"  {name:<13}{text}", markup=False, soft_wrap=True)

    console.print(
        f"board {told['unit']}: {told['board']}, firmware {told['firmware']}, "
        f"register map {told['map_version']} ({told['server_id']})", style="bold", markup=False,
    )  # fmt: skip
    line("status", told["status"])
    line("fault", told["fault"] or "none")
    line("reset", told["reset_cause"])
    clock = told["pixel_clock"]
    seen = "present" if clock["present"] else "not present"
    set_to = f"set to {clock['set_hz']} Hz{_measured_text(clock)}"
    line("pixel clock", f"{seen}, {clock['edges']} edges since reset, {set_to}")
    line("outputs", told["outputs"])
    line("switches", told["inputs"])
    line("settings", _settings_text(told["settings"]))
    line("counters", ", ".join(f"{name} {count}" for name, count in told["counters"].items()))
    table = new_table("axis", "state", "position", "pixel", "lines", "queue free", "underruns")
    table.columns[1].justify = "left"
    for axis in told["axes"]:
        table.add_row(*(str(value) for value in axis.values()))
    console.print(table)


def _measured_text(clock: _PixelClock) -> str:
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


def _settings_text(stored: _Stored) -> str:
    if not stored["stored"]:
        return "defaults, nothing is stored" if not stored["differ"] else "not stored"
    text = f"stored as record {stored['record']}"
    return f"{text}; those in force differ from it" if stored["differ"] else text
