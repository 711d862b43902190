# SPDX-License-Identifier: MIT
"""Tables of the documentation, generated from the firmware's own tables, kept between markers."""

import re
import shlex
from pathlib import Path

from pixstep import atomic, natives
from pixstep.board import boards, features, flash, registers
from pixstep.errors import UserError

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


def between(text: str, name: str, content: str, path: Path | str = "file") -> str:
    """Return `text` with what stands between the markers of `name` replaced by `content`.

    The markers are comment lines `begin generated: NAME` and `end generated: NAME`.
    """
    pattern = _marker_pattern(name)
    if not pattern.search(text):
        raise UserError(f"{path}: has no markers {_begin(name)!r} and {_end(name)!r}")
    return pattern.sub(lambda _: f"{_begin(name)}\n{content.rstrip()}\n{_end(name)}", text, count=1)


def marked(name: str, content: str) -> str:
    """Return `content` between its markers."""
    return f"{_begin(name)}\n{content.rstrip()}\n{_end(name)}\n"


def write(path: Path, name: str, content: str) -> bool:
    """Rewrite the generated part of a file; return True if it changed."""
    text = _read(path)
    fresh = between(text, name, content, path)
    if fresh != text:
        atomic.write_text(path, fresh)
    return fresh != text


def check(path: Path, name: str, content: str) -> bool:
    """True if the generated part of a file is what it should be."""
    text = _read(path)
    return between(text, name, content, path) == text


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def _begin(name: str) -> str:
    return f"<!-- begin generated: {name} -->"


def _end(name: str) -> str:
    return f"<!-- end generated: {name} -->"


def _marker_pattern(name: str) -> re.Pattern:
    return re.compile(f"{re.escape(_begin(name))}\n.*?{re.escape(_end(name))}", re.DOTALL)


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
    rows = [(str(item.bit), f"`{item.name}`", item.meaning) for item in features.table()]
    return table(("bit of `features`", "name", "what"), rows)


def _per_axis(board: boards.Board, pin: boards.Pin) -> bool:
    """True if every axis has the pin's signal."""
    return len([other for other in board.pins if other.signal == pin.signal]) == board.axes and (
        pin.signal in ("STEP", "DIR", "ENABLE", "HOME", "LIMIT_MINUS", "LIMIT_PLUS")
    )


def _rows(found: tuple[registers.Register, ...], *, limits: bool = False) -> list[tuple[str, ...]]:
    rows = []
    for register in found:
        row = (f"0x{register.address:04X}", f"`{register.name}`", register.type, register.unit)
        if limits:
            row += tuple(str(v) for v in (register.minimum, register.maximum, register.default))
        rows.append((*row, register.meaning))
    return rows


def _codes(codes: dict[int, registers.Code]) -> str:
    rows = [(str(code.code), f"`{code.name}`", code.text) for code in codes.values()]
    return table(("code", "name", "meaning"), rows)


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in lines)
