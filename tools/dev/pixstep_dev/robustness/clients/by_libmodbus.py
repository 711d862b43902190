# SPDX-License-Identifier: MIT
"""The conformance list by libmodbus: a C program that runs it and prints a line a case."""

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep_dev.robustness.clients import cases

_FEATURES = "features"  # the row with the register's value
_ILLEGAL_FUNCTION = "exception 01"


def run(port: str, board: str) -> dict[str, str]:
    """Return the result of every case; those that are not in the program's list are not offered."""
    known = boards.load(board)
    program = natives.program("pixstep-libmodbus")
    facts = (known.id, known.axes, known.tick_hz)
    done = natives.run([str(program), port, board, *map(str, facts)])
    if done.returncode:
        raise UserError(f"pixstep-libmodbus: {done.stderr.strip()}")
    found = dict(line.split("\t", 1) for line in done.stdout.splitlines())
    has = _features(found.pop(_FEATURES, ""))
    strangers = found.keys() - {case.name for case in cases.CASES}
    if strangers:
        raise UserError(f"pixstep-libmodbus: no such case: {', '.join(sorted(strangers))}")
    return {
        case.name: _result(found[case.name], case.is_served(has))
        if case.name in found
        else cases.NOT_OFFERED
        for case in cases.CASES
    }


def _features(text: str) -> frozenset[str]:
    """Return the features of the board from the program's first row."""
    if not text.isdecimal():
        raise UserError(f"pixstep-libmodbus: register features: {text or 'not read'}")
    return boards.feature_names(int(text))


def _result(text: str, served: bool) -> str:
    if not served and text == _ILLEGAL_FUNCTION:
        return cases.REFUSED
    if not served and text == cases.OK:
        return f"{cases.FAIL}: served without its feature"
    return cases.OK if text == cases.OK else f"{cases.FAIL}: {text}"
