# SPDX-License-Identifier: MIT
"""Rule: a module's state is its own: no variable of the firmware in RAM is visible to the linker.

    writable.py [HOST_BUILD]     looks at the objects of the native build and of every board's

The table below holds the exceptions, each with its reason. A row that names nothing is an error.
"""

import sys
from pathlib import Path

from common import ROOT, board_names, build_folder, finish
from modules import ModuleError, Symbols, build_symbols

# nm's letters of what lies in RAM: zeroed, initialised, common; also the small ones of other parts.
IN_RAM = set("BDCGS")

# The compiler's marks of an object that can be optimised with others: no variables.
LTO_MARK = "__gnu_lto"

SHARED = {
    "step_engines": "the step interrupt (assembly) and the main loop share it",
    "step_isr_last": "the step interrupt (assembly) and its half in C share it",
    "step_isr_before_low": "the step interrupt's own (assembly)",
    "step_isr_before_high": "the step interrupt's own (assembly)",
    "pixel_clock_edges": "the capture interrupt (assembly) and the main loop share it",
    "records_thinned": "the account of whole pixels (assembly) reads it",
    "clock_overflows": "handlers read the coarse clock (clock_units.h)",
    "uart_place": "the receive interrupt (assembly) and uart.c share it",
    "step_rings": "the step interrupt (assembly) and the main loop share it",
}


def writable(found: list[Symbols]) -> dict[str, str]:
    """Source by name of the variables that others can write."""
    return {
        name: one.source
        for one in found
        for name, kind in one.defined.items()
        if kind in IN_RAM and not name.startswith(LTO_MARK)
    }


def complaints(variables: dict[str, str], shared: dict[str, str]) -> list[str]:
    """Variables outside of the table, and rows without a variable."""
    found = [
        f"{source}: {name} can be written by every module: make it static"
        for name, source in sorted(variables.items())
        if name not in shared
    ]
    gone = sorted(shared.keys() - variables.keys())
    return found + [f"the table's {name} is no variable of the firmware" for name in gone]


def main() -> None:
    """Look at the objects of every build."""
    host = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "host"
    builds = [host, *(build_folder(board) for board in board_names())]
    try:
        found = [one for build in builds for one in build_symbols(build)]
    except ModuleError as error:
        finish("writable", "nothing looked at", [str(error)])
    problems = complaints(writable(found), SHARED)
    finish("writable", f"{len(found)} objects of {len(builds)} builds", problems)


if __name__ == "__main__":
    main()
