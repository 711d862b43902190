# SPDX-License-Identifier: MIT
"""The interface for programs, `import pixstep`, as Markdown from its docstrings."""

from collections.abc import Iterator
from pathlib import Path

import griffe

import pixstep
from pixstep.errors import UserError
from pixstep_dev.markdown import table

_SECTIONS = {
    "Machines": ("Machine", "Motor"),
    "Profiles and lines": (
        "read_profile", "make_profile", "make_line", "line_from_positions", "line", "read_line",
        "import_line", "Profile", "MotionLine", "CheckResult", "Finding", "Limits",
    ),
    "Files": ("convert_file", "Converted"),
    "Motion programs": ("read_program", "MotionProgram", "ProgramPlan"),
    "Simulated runs": (
        "simulate", "PixelClock", "Run", "AxisRun", "ClockFigures", "ClockErrors", "Ticks",
    ),
    "Boards": ("connect", "Bus", "Board", "AxisState", "AxisRecords"),
    "Motions": ("Motion", "AxisProgress", "MoveResult", "HomeResult", "SeekResult"),
    "Simulated boards": ("simulated_board", "simulated_bus", "VirtualBoard", "VirtualBus"),
    "Errors": (
        "PlainError", "UserError", "RefusedError", "LineRefusedError", "SimulatorError",
        "RunFailedError", "BoardError", "NoReplyError", "LineLostError", "BusyError",
        "NotPossibleError", "MissingFeatureError", "LineRefusedByBoardError", "FaultError",
        "HomingError", "MotionStoppedError", "MotionTimeoutError",
    ),
}  # fmt: skip


def api() -> str:
    """Return every public name by section, with signature, fields, methods and examples."""
    named = {name for names in _SECTIONS.values() for name in names}
    if named != set(pixstep.__all__):
        raise UserError(f"docs api: no section, or no such name: {named ^ set(pixstep.__all__)}")
    folder = Path(pixstep.__file__).parents[1]
    package = griffe.load("pixstep", search_paths=[folder], resolve_aliases=True)
    parts = []
    for title, names in _SECTIONS.items():
        parts.append(f"## {title}")
        parts += [text for name in names for text in _item(package[name].final_target)]
    return "\n\n".join(parts)


def _item(item: griffe.Object) -> Iterator[str]:
    """Yield the parts of a class or a function."""
    if not item.docstring:
        raise UserError(f"docs api: {item.path} has no docstring")
    yield f"### {item.name}"
    if isinstance(item, griffe.Function):
        yield _signature(item)
    yield from _text(item.docstring)
    if isinstance(item, griffe.Class):
        yield from _members(item)


def _members(item: griffe.Class) -> Iterator[str]:
    """Yield a table of the values of a class, then its methods."""
    public = [member for name, member in item.members.items() if not name.startswith("_")]
    values = [member for member in public if isinstance(member, griffe.Attribute)]
    if values:
        rows = [
            (
                f"`{one.name}`",
                "`" + str(one.annotation).replace(" | ", "` or `") + "`",
                _line_of(one),
            )
            for one in values
        ]
        yield table(("value", "type", "meaning"), rows)
    for method in public:
        if isinstance(method, griffe.Function) and method.docstring:
            yield _signature(method, f"{item.name}.")
            yield from _text(method.docstring)


def _line_of(value: griffe.Attribute) -> str:
    """Return the docstring of a value in one line; empty if it has none."""
    return " ".join(value.docstring.value.split()) if value.docstring else ""


def _signature(function: griffe.Function, owner: str = "") -> str:
    """Return the call in a block of code, a parameter a line where it is long."""
    head = f"{owner}{function.name}("
    words = [*_parameters(function)]
    tail = f") -> {function.returns}" if function.returns else ")"
    text = f"{head}{', '.join(words)}{tail}"
    if len(text) > 90:
        text = "\n".join([head, *(f"    {word}," for word in words), tail])
    return f"```python\n{text}\n```"


def _parameters(function: griffe.Function) -> Iterator[str]:
    """Yield the parameters as a caller sees them."""
    keywords = False
    for one in function.parameters:
        if one.name in ("self", "cls"):
            continue
        if one.kind is griffe.ParameterKind.keyword_only and not keywords:
            keywords = True
            yield "*"
        default = f" = {one.default}" if one.default is not None else ""
        yield f"{one.name}: {one.annotation}{default}"


def _text(docstring: griffe.Docstring) -> Iterator[str]:
    """Yield the paragraphs of a docstring, its example as a block of code."""
    text, _, example = docstring.value.partition("Example:\n")
    yield text.strip()
    if example:
        lines = [line.removeprefix("    ") for line in example.rstrip().splitlines()]
        yield "```python\n" + "\n".join(lines) + "\n```"
