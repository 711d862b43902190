# SPDX-License-Identifier: MIT
"""The generated part of docs/FAULTS.md: every fault, what to do about it, which test provokes it.

A test says by its decorator `@pytest.mark.provokes("starved")` which faults it makes a simulated
board have. They are read from the tests' sources, so that the document needs no test run.
"""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from pixstep import natives
from pixstep.board import registers
from pixstep.errors import UserError
from pixstep_dev.markdown import table

TESTS = "tools/tests"
_MARK = "provokes"


def faults() -> str:
    """Return the tables of faults, line errors and warnings as Markdown."""
    known = [fault for fault in registers.faults().values() if fault.code]
    errors = [error for error in registers.line_errors().values() if error.code]
    return "\n".join(
        [
            "### Faults: what happened, and what to do\n",
            table(
                ("code", "name", "meaning", "cause", "cure"),
                [(str(f.code), f"`{f.name}`", f.text, f.cause, f.cure) for f in known],
            ),
            "\n### Faults: what is known afterwards, and how it is known to be so\n",
            table(("code", "name", "argument", "positions", "provoked by"), _known_rows(known)),
            "\n### Line errors: a line is refused before anything moves\n",
            _error_table([error for error in errors if error.code < registers.FIRST_WARNING]),
            "\n### Warnings: the line is taken\n",
            _error_table([error for error in errors if error.code >= registers.FIRST_WARNING]),
        ]
    )


def provoking_tests(folder: Path) -> dict[str, list[str]]:
    """Return the tests that provoke each fault, by its name, as "file.py: test_name"."""
    found = defaultdict(list)
    for path in sorted(folder.glob("test_*.py")):
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"))
        except (OSError, SyntaxError) as error:
            raise UserError(f"{path}: {error}") from None
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef):
                for name in _marked(function):
                    found[name].append(f"{path.name}: {function.name}")
    return dict(found)


def _marked(function: ast.FunctionDef) -> Iterator[str]:
    """Yield the arguments of a test's `provokes` marks."""
    for decorator in function.decorator_list:
        call = decorator if isinstance(decorator, ast.Call) else None
        if call and isinstance(call.func, ast.Attribute) and call.func.attr == _MARK:
            yield from (ast.literal_eval(argument) for argument in call.args)


def _known_rows(known: list[registers.Fault]) -> list[tuple[str, ...]]:
    tests = provoking_tests(natives.root() / TESTS)
    return [
        (
            str(fault.code),
            f"`{fault.name}`",
            fault.argument or "0",
            fault.position,
            ", ".join(f"`{test}`" for test in tests.get(fault.name, [])) or "no test",
        )
        for fault in known
    ]


def _error_table(errors: list[registers.Code]) -> str:
    rows = [(str(error.code), f"`{error.name}`", error.text, error.cure) for error in errors]
    return table(("code", "name", "meaning", "cure"), rows)
