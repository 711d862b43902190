# SPDX-License-Identifier: MIT
"""The wiring drawings of docs/wiring, with the pins of firmware/hal/boards/*.def."""

from collections.abc import Callable, Iterable
from pathlib import Path

from pixstep.board import boards
from pixstep_dev import markdown
from pixstep_dev.docs.drawing import (
    Across,
    DrawnWire,
    End,
    Gap,
    PinBlock,
    Series,
    WiringDrawing,
    svg,
)

BOARDS = ("uno", "mega", "m1284")
_CHIP = "m1284"  # the board that is built from its chip
_SUPPLY = PinBlock("Motor supply", "", ("+", "-"))
_MOTOR = PinBlock("Stepper motor", "two coils", ("A +", "A -", "B +", "B -"))
_HOT = "Never plug or unplug a motor or a driver while the motor supply is on."
_CURRENT = "Set the driver's current before the motor is connected."


def drawings() -> dict[str, str]:
    """Return every drawing as SVG, by the name of its file."""
    made = {}
    for name in BOARDS:
        for driver, draw in _DRIVERS.items():
            made[f"{name}-{driver}.svg"] = svg(draw(name))
        made[f"{name}-inputs.svg"] = svg(_inputs(name))
    made[f"{_CHIP}-chip.svg"] = svg(_chip(_CHIP))
    made["clock-own.svg"] = svg(_own_clock())
    made["clock-board.svg"] = svg(_clock_of_a_board())
    made["rs485.svg"] = svg(_rs485())
    return made


def stale(folder: Path) -> list[Path]:
    """Return the drawings in a folder that are missing, differ or are no drawing of ours."""
    made = drawings()
    extra = {path.name for path in folder.glob("*.svg")} - set(made)
    differ = {name for name, text in made.items() if not _is(folder / name, text)}
    return [folder / name for name in sorted(differ | extra)]


def _is(path: Path, text: str) -> bool:
    """True if a file is there and says just this."""
    return path.is_file() and path.read_text(encoding="utf-8") == text


def write(folder: Path) -> list[Path]:
    """Rewrite the drawings that differ, remove what is none; return their files."""
    made, found = drawings(), stale(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for path in found:
        if path.name in made:
            markdown.replace(path, made[path.name])
        else:
            path.unlink()
    return found


def _pins(name: str, signal: str) -> str:
    """Return the header pins of a signal, of all axes: "D12 (D2, D7, D45)"."""
    first, *others = [pin.header for pin in boards.load(name).pins if pin.signal == signal]
    return f"{first} ({', '.join(others)})" if others else first


def _row(name: str, signal: str) -> str:
    """Return the label of a board's pin."""
    return f"{signal} {_pins(name, signal)}"


def _axes_note(name: str) -> tuple[str, ...]:
    others = [str(axis) for axis in range(1, boards.load(name).axes)]
    if not others:
        return ()
    axes = f"axes {', '.join(others[:-1])} and {others[-1]}" if others[1:] else "axis 1"
    return (f"Drawn for axis 0; in parentheses the pins of {axes}.",)


def _title(name: str) -> str:
    return boards.load(name).label


def _board_of_driver(name: str) -> PinBlock:
    signals = [_row(name, signal) for signal in ("STEP", "DIR", "ENABLE")]
    return PinBlock(_title(name), "USB to the host", right=(*signals, "5V", "GND"))


def _power(driver: str, pins: Iterable[str], capacitor: bool = True) -> Gap:
    """Return the motor's side of a driver: supply pins first, then the two coils."""
    plus, minus, *coils = pins
    ends: list[tuple[str, str, End]] = [
        ("motor", plus, (_SUPPLY.title, "+")),
        ("ground", minus, (_SUPPLY.title, "-")),
        *[("coil", pin, (_MOTOR.title, name))
          for pin, name in zip(coils, _MOTOR.left, strict=True)],
    ]  # fmt: skip
    wires = [DrawnWire(kind, ((driver, pin), end)) for kind, pin, end in ends]
    parts = [Across("100 µF", (driver, plus), (driver, minus))] if capacitor else []
    return Gap(wires, parts)


def _carrier(
    name: str, driver: PinBlock, high: tuple[str, ...], notes: tuple[str, ...]
) -> WiringDrawing:
    """Return a board with a driver carrier: what is named in `high` goes to 5 V."""
    board = _board_of_driver(name)
    step, direction, enable, five, ground = board.right
    wires = [
        DrawnWire("step", ((board.title, step), (driver.title, "STEP"))),
        DrawnWire("dir", ((board.title, direction), (driver.title, "DIR"))),
        DrawnWire("enable", ((board.title, enable), (driver.title, driver.left[2]))),
        DrawnWire("5v", ((board.title, five), *[(driver.title, pin) for pin in high])),
        DrawnWire("ground", ((board.title, ground), (driver.title, "GND"))),
    ]
    pull_up = Across("10 kΩ", (board.title, enable), (board.title, five))
    return WiringDrawing(
        f"{_title(name)} with {driver.title} carrier",
        ((board,), (driver,), (_SUPPLY, _MOTOR)),
        (Gap(wires, (pull_up,)), _power(driver.title, driver.right)),
        (*_axes_note(name), *notes, _CURRENT, _HOT),
    )


def _a4988(name: str) -> WiringDrawing:
    driver = PinBlock(
        "A4988", "",
        ("STEP", "DIR", "ENABLE", "VDD", "MS1, MS2, MS3", "GND", "RESET joined to SLEEP"),
        ("VMOT", "GND", "1A", "1B", "2A", "2B"),
    )  # fmt: skip
    notes = ("MS1, MS2 and MS3 at 5 V: 1/16 step. Motor supply 8 to 35 V.",)
    return _carrier(name, driver, ("VDD", "MS1, MS2, MS3"), notes)


def _drv8825(name: str) -> WiringDrawing:
    driver = PinBlock(
        "DRV8825", "",
        ("STEP", "DIR", "ENABLE", "RESET, SLEEP", "M2", "GND", "M0, M1 open"),
        ("VMOT", "GND", "A1", "A2", "B1", "B2"),
    )  # fmt: skip
    notes = ("M2 at 5 V, M0 and M1 open: 1/16 step. Motor supply 8.2 to 45 V.",)
    return _carrier(name, driver, ("RESET, SLEEP", "M2"), notes)


def _tmc2209(name: str) -> WiringDrawing:
    driver = PinBlock(
        "TMC2209", "names of coil pins differ",
        ("STEP", "DIR", "EN", "VIO", "MS1, MS2", "GND"),
        ("VM", "GND", "A2", "A1", "B1", "B2"),
    )  # fmt: skip
    notes = ("MS1 and MS2 at 5 V: 1/16 step. Motor supply 4.75 to 29 V.",)
    return _carrier(name, driver, ("VIO", "MS1, MS2"), notes)


def _opto(name: str) -> WiringDrawing:
    board = _board_of_driver(name)
    driver = PinBlock(
        "Opto-isolated driver", "common cathode",
        ("PUL +", "DIR +", "ENA +", "", "PUL -, DIR -, ENA -"),
        ("+ V", "GND", "A +", "A -", "B +", "B -"),
    )  # fmt: skip
    pairs = zip(("step", "dir", "enable"), board.right, driver.left, strict=False)
    wires = [
        DrawnWire(kind, ((board.title, mine), (driver.title, its))) for kind, mine, its in pairs
    ]
    wires.append(DrawnWire("ground", ((board.title, "GND"), (driver.title, driver.left[4]))))
    return WiringDrawing(
        f"{_title(name)} with an opto-isolated driver",
        ((board,), (driver,), (_SUPPLY, _MOTOR)),
        (Gap(wires), _power(driver.title, driver.right, capacitor=False)),
        (
            *_axes_note(name),
            "Inputs for 5 V. No other joint between the board and the motor supply.",
            "ENABLE low (LED off) is on: while the board is in reset such a driver is on.",
            _CURRENT,
            _HOT,
        ),
    )


def _inputs(name: str) -> WiringDrawing:
    """Return a board with switches, emergency stop, permit output and pixel clock."""
    first = [_row(name, signal) for signal in ("HOME", "LIMIT_MINUS", "LIMIT_PLUS")]
    stop, permit = _row(name, "ESTOP"), _row(name, "PERMIT")
    clocks = _clock_rows(name)
    board = PinBlock(_title(name), "", right=(*first, "5V", stop, "GND", permit, *clocks))
    switch = [
        PinBlock("Home switch", "closes to ground", ("contact", "common")),
        PinBlock("Limit switch, minus end", "closes to ground", ("contact", "common")),
        PinBlock("Limit switch, plus end", "closes to ground", ("contact", "common")),
    ]
    button = PinBlock("Emergency stop", "two contacts, normally closed",
                   ("contact 1", "common 1"), ("contact 2",))  # fmt: skip
    laser = PinBlock("Laser or spindle", "enable input, high is on", ("enable", "ground"))
    source = PinBlock("Pixel clock source", "5 V square wave", ("clock", "ground"))
    power = PinBlock("Supply of drives and laser", "contactor or relay", ("cut",))
    grounds = [(one.title, "common") for one in switch]
    grounds += [(button.title, "common 1"), (laser.title, "ground"), (source.title, "ground")]
    here = board.title
    wires = [
        *[DrawnWire("signal", ((here, pin), (one.title, "contact")))
          for pin, one in zip(first, switch, strict=True)],
        DrawnWire("enable", ((here, stop), (button.title, "contact 1"))),
        DrawnWire("ground", ((here, "GND"), *grounds)),
        DrawnWire("step", ((here, permit), (laser.title, "enable"))),
        DrawnWire("dir", (*[(here, clock) for clock in clocks], (source.title, "clock"))),
    ]  # fmt: skip
    cut = DrawnWire("motor", ((button.title, "contact 2"), (power.title, "cut")))
    parts = (
        Across("100 nF", (here, stop), (here, "GND")),
        Series("1 kΩ", (here, stop)),
        Across("1 kΩ", (here, "5V"), (here, stop)),
        Across("10 kΩ", (here, "GND"), (here, permit)),
    )
    return WiringDrawing(
        f"{_title(name)}: switches, emergency stop, permit, pixel clock",
        ((board,), (*switch, button, laser, source), (power,)),
        (Gap(wires, parts), Gap([cut])),
        (
            *_axes_note(name),
            "Emergency stop normally closed: set bit 2 of inputs_inverted (value 4).",
            "Contact 2 cuts the power without asking the board.",
        ),
        staggered=True,
    )  # fmt: skip


def _chip(name: str) -> WiringDrawing:
    """Return a bare chip: what it needs to run on the left, every signal on the right."""
    title = boards.load(name).part
    signals = [
        f"{pin.signal}{f' {pin.axis}' if _is_of_axis(name, pin.signal) else ''} {_leg(pin)}"
        for pin in boards.load(name).pins
    ]
    needs = ("RESET 9", "RXD0 PD0 14", "TXD0 PD1 15", "VCC 10, AVCC 30", "GND 11, 31",
             "AREF 32", "XTAL1 13", "XTAL2 12")  # fmt: skip
    chip = PinBlock(title, "numbers: legs of the DIP-40", needs, signals)
    serial = PinBlock(
        "Serial adapter", "5 V, USB to the host", right=("DTR", "TX", "RX", "5V", "GND")
    )
    crystal = PinBlock("Crystal", "20 MHz", right=("1", "2"))
    reset, receive, send, five, ground, reference, *clocks = needs
    wires = [
        DrawnWire("enable", ((serial.title, "DTR"), (title, reset))),
        DrawnWire("signal", ((serial.title, "TX"), (title, receive))),
        DrawnWire("step", ((serial.title, "RX"), (title, send))),
        DrawnWire("5v", ((serial.title, "5V"), (title, five))),
        DrawnWire("ground", ((serial.title, "GND"), (title, ground))),
        *[DrawnWire("coil", ((crystal.title, its), (title, mine)))
          for its, mine in zip(crystal.right, clocks, strict=True)],
    ]  # fmt: skip
    parts = (
        Series("100 nF", (serial.title, "DTR")),
        Across("10 kΩ", (title, reset), (title, five)),
        Across("100 nF", (title, five), (title, ground)),
        Across("100 nF", (title, ground), (title, reference)),
    )
    return WiringDrawing(
        f"{title}: the bare chip",
        ((serial, crystal), (chip,)),
        (Gap(wires, parts),),
        (
            "22 pF from each leg of the crystal to GND; crystal and capacitors close to the chip.",
            "100 nF at each supply leg, too. DTR resets the chip for its boot loader.",
        ),
    )


def _is_of_axis(name: str, signal: str) -> bool:
    """True if a board has a signal for each axis."""
    return sum(pin.signal == signal for pin in boards.load(name).pins) > 1


def _leg(pin: boards.Pin) -> str:
    """Return a port of the chip and its leg of the DIP-40: "PD4 18"."""
    bit = pin.bit
    legs = {"A": 40 - bit, "B": 1 + bit, "C": 22 + bit, "D": 14 + bit}
    return f"{pin.header} {legs[pin.port]}"


def _clock_rows(name: str) -> list[str]:
    """Return the labels of a board's clock inputs."""
    own = {pin.signal for pin in boards.load(name).pins}
    return [_row(name, one) for one in ("PIXEL_CLOCK", "PIXEL_CLOCK_COPY") if one in own]


def _own_clock() -> WiringDrawing:
    """Return each board with the wire from its own clock to its clock input."""
    columns, gaps = [], []
    for name in ("mega", "m1284", "uno"):
        out, clocks = _row(name, "CLOCK_OUT"), _clock_rows(name)
        about = "" if boards.load(name).all_features else "image with FEATURE_CLOCK_OUT"
        board = PinBlock(_title(name), about, right=(out, *clocks))
        columns.append((board,))
        gaps.append(Gap([DrawnWire("dir", [(board.title, row) for row in board.right])]))
    return WiringDrawing(
        "A clock to try with: one wire on the board itself",
        columns,
        gaps,
        (
            "Disconnect every other clock source first. Then: pixstep board set clock_out_hz=30",
            "The default image of the Uno makes no clock.",
        ),
    )


def _clock_of_a_board() -> WiringDrawing:
    """Return a board that makes the clock of two others."""
    out = _row("mega", "CLOCK_OUT")
    maker = PinBlock(_title("mega"), "makes the clock", right=(out, "GND"))
    others = [
        PinBlock(_title(name), "follows it", (*_clock_rows(name), "GND"))
        for name in ("uno", "m1284")
    ]  # fmt: skip
    clock = [(one.title, one.left[0]) for one in others]
    ground = [(one.title, "GND") for one in others]
    return WiringDrawing(
        "A clock to try with: a board that makes the clock of others",
        ((maker,), others),
        (Gap([
            DrawnWire("dir", ((maker.title, out), *clock)),
            DrawnWire("ground", ((maker.title, "GND"), *ground)),
        ]),),
        ("On the board that makes it: pixstep board set clock_out_hz=100 --store",),
    )  # fmt: skip


def _rs485() -> WiringDrawing:
    """Return two boards on one bus; the transceivers are those of a MAX485 module."""
    host = PinBlock("USB adapter for RS-485", "at the host", right=("A", "B", "GND"))
    columns: list[list[PinBlock]] = [[host], [], []]
    near, far = [], []
    for number, name in enumerate(("uno", "mega"), start=1):
        chip = PinBlock(f"MAX485 module {number}", "", ("A", "B", "GND"),
                     ("RO", "DI", "DE joined to RE", "VCC", "GND"))  # fmt: skip
        board = PinBlock(_title(name), f"Modbus address {number}",
                      ("RX0 D0", "TX0 D1", _row(name, "RS485_DE"), "5V", "GND"))  # fmt: skip
        columns[1].append(chip)
        columns[2].append(board)
        kinds = ("signal", "step", "enable", "5v", "ground")
        far += [DrawnWire(kind, ((chip.title, its), (board.title, mine)))
                for kind, its, mine in zip(kinds, chip.right, board.left, strict=True)]  # fmt: skip
    for kind, line in (("dir", "A"), ("coil", "B"), ("ground", "GND")):
        near.append(
            DrawnWire(kind, ((host.title, line), *[(chip.title, line) for chip in columns[1]]))
        )
    last = columns[1][-1].title
    ends = (
        Across("120 Ω", (host.title, "A"), (host.title, "B")),
        Across("120 Ω", (last, "A"), (last, "B")),
    )
    return WiringDrawing(
        "Two boards on one RS-485 bus",
        columns,
        (Gap(near, ends), Gap(far)),
        (
            "120 Ω at both ends of the bus, none between; bias the bus at one place.",
            "Unplug the boards' USB while the bus is in use. Many modules carry their own 120 Ω.",
        ),
    )


_DRIVERS: dict[str, Callable[[str], WiringDrawing]] = {
    "a4988": _a4988,
    "drv8825": _drv8825,
    "tmc2209": _tmc2209,
    "opto": _opto,
}
