# SPDX-License-Identifier: MIT
"""Everything that a command does, as a function: `pixstep line make` is `ops.line_make`.

    from pixstep import ops
    made = ops.line_make(speed="12mm/s", max_acceleration="90mm/s2", length="20mm",
                         output="line.csv", machine="machine.toml")
    made["pixels"], made.page()

Values are those of the command's options, by the same names; a value with a unit may be a text. No
machine file is looked for: `machine` names one, `motor` the motors of it that are meant.
"""

from typing import Any

from pixstep.operations import catalog, python


def __getattr__(name: str) -> Any:
    """Return an operation as a function when it is first asked for."""
    found = python.function(name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(map(python.name_of, catalog.OPERATIONS))
