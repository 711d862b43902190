# SPDX-License-Identifier: MIT
"""Tables of the documentation, generated from the firmware's own tables."""

import shlex
from collections.abc import Mapping

from pixstep import natives
from pixstep.board import boards, flash, registers
from pixstep_dev.markdown import table

_ACCESS_INPUT = "FC04"
_ACCESS_HOLDING = "FC03, 06, 16"


def protocol() -> str:
    """Return the tables of boards, features, registers, faults and line errors."""
    parsed = registers.register_map()
    parts = [
        "### Boards\n",
        _boards(),
        "\n### Features\n",
        _features(),
        "\n### Input registers of the board\n",
        table(("address", "name", "type", "unit", "meaning"), _rows(parsed.inputs)),
        f"\n### Input registers of axis a, at 0x{registers.AXIS_BASE:04X} + "
        f"0x{registers.AXIS_STRIDE:02X} * a\n",
        table(("offset", "name", "type", "unit", "meaning"), _rows(parsed.axis_inputs)),
        "\n### Holding registers\n",
        table(
            ("address", "name", "type", "unit", "min", "max", "default", "meaning"),
            _rows(parsed.holdings, limits=True),
        ),
        "\n### Faults\n",
        _codes(registers.faults()),
        "\n### Line errors and warnings\n",
        _codes(registers.line_errors()),
    ]
    return "\n".join(parts) + "\n"


def wiring() -> str:
    """Return the pin table of every board as Markdown."""
    parts = []
    for name in boards.BOARD_NAMES:
        board = boards.load(name)
        parts.append(f"### {name} ({board.part})\n")
        rows = [
            (
                pin.signal,
                str(pin.axis) if _per_axis(board, pin) else "",
                pin.header,
                f"P{pin.port}{pin.bit}",
                f"OC{board.timers[pin.axis]}B" if pin.signal == "STEP" else "",
            )
            for pin in board.pins
        ]
        parts.append(table(("signal", "axis", "header pin", "port", "timer output"), rows))
        parts.append("")
    return "\n".join(parts)


def flashing() -> str:
    """Return avrdude's command line for every board as Markdown."""
    lines = []
    for name in boards.BOARD_NAMES:
        image = flash.built_image(name).relative_to(natives.root())
        lines.append(shlex.join(flash.command(name, "/dev/ttyACM0", image)))
    return "\n".join(["```", *lines, "```"])


def _boards() -> str:
    """Return a row for every board."""
    head = ("`board_id`", "name", "board", "part", "clock", "axes", "queue entries an axis")
    rows = [
        (
            str(board.id),
            board.name,
            board.label,
            board.part,
            board.mhz_text,
            str(board.axes),
            str(board.queue_entries),
        )
        for board in boards.all_boards()
    ]
    return table(head, rows)


def _features() -> str:
    """Return a row for every feature that an image may be built without."""
    rows = [(str(item.bit), f"`{item.name}`", item.meaning) for item in boards.features()]
    return table(("bit of `features`, from 16 on of `features_high`", "name", "what"), rows)


def _per_axis(board: boards.BoardKind, pin: boards.Pin) -> bool:
    """True if every axis has the pin's signal."""
    return len([other for other in board.pins if other.signal == pin.signal]) == board.axes and (
        pin.signal in ("STEP", "DIR", "ENABLE", "HOME", "LIMIT_MINUS", "LIMIT_PLUS")
    )


def _rows(
    found: tuple[registers.RegisterEntry, ...], *, limits: bool = False
) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for register in found:
        row: tuple[str, ...] = (
            f"0x{register.address:04X}",
            f"`{register.name}`",
            register.type,
            register.unit,
        )
        if limits:
            row += tuple(str(v) for v in (register.minimum, register.maximum, register.default))
        rows.append((*row, register.meaning))
    return rows


def _codes(codes: Mapping[int, registers.Code | registers.Fault]) -> str:
    rows = [(str(code.code), f"`{code.name}`", code.text) for code in codes.values()]
    return table(("code", "name", "meaning"), rows)
