# SPDX-License-Identifier: MIT
"""Writes the firmware's own tables as JSON, which the Python package reads when it runs.

    tables.py FIRMWARE OUTPUT      FIRMWARE: the folder `firmware` of the sources

The build runs this program, in a clone and for a wheel alike.
"""

import json
import sys
from pathlib import Path

import board_files
import register_rows
from deffiles import TableError

FEATURES_HIGH = 16  # the first bit of register `features_high`


def tables(firmware: Path) -> dict:
    """Return everything that the .def files say; raises TableError for a mistake in one."""
    faults = register_rows.codes(firmware / "core/base/faults.def", "FAULT", register_rows.FAULT)
    line_errors = register_rows.codes(
        firmware / "core/base/line_errors.def", "LINE_ERROR", register_rows.LINE_ERROR
    )
    boards = board_files.boards(firmware / "avr/boards")
    registers = register_rows.registers(firmware / "core/wire/registers.def")
    features = register_rows.codes(
        firmware / "build_features.def", "FEATURE", register_rows.FEATURE
    )
    named = {
        "fault_code": faults,
        "line_error": line_errors,
        "line_warning": line_errors,
        "features": [row for row in features if row["bit"] < FEATURES_HIGH],
        "features_high": [
            row | {"bit": row["bit"] - FEATURES_HIGH}
            for row in features
            if row["bit"] >= FEATURES_HIGH
        ],
    }
    axes = max((len(board["timers"]) for board in boards), default=0)
    register_rows.add_meanings(registers, named, axes)
    return {
        "registers": registers,
        "faults": faults,
        "line_errors": line_errors,
        "features": features,
        "boards": boards,
    }


def main() -> None:
    """Write the tables, or say in one line what is wrong with them."""
    firmware, output = map(Path, sys.argv[1:])
    try:
        made = tables(firmware)
    except (TableError, OSError) as error:
        sys.exit(str(error))
    output.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
