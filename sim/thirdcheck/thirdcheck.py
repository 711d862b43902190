# SPDX-License-Identifier: MIT
"""The Uno image in yasimavr, fed with the inputs of a run that pixstep-sim recorded.

    thirdcheck.py --image UNO.elf --pins UNO.def --run DIR [--min-steps N]

DIR holds edges.csv, clock.csv and serial.csv. The periods of STEP must be the same to the cycle. A
test of the simulator, not of the firmware. Exit status 77, with the reason: no yasimavr here.
"""

import argparse
import csv
import importlib
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from compare import Run, compare

SKIPPED = 77
MIN_STEPS = 20000
# Run on after the last recorded edge, so that a step too many shows.
RUN_ON_CYCLES = 160000
WATCHED = ("DIR", "ENABLE")


def missing() -> str:
    """Return why yasimavr cannot be used; empty when it can."""
    try:
        importlib.import_module("yasimavr.lib.core")
        importlib.import_module("yasimavr.lib.arch_avr")
    except ImportError as error:
        return str(error)
    return ""


def read_pins(path: Path) -> dict[str, str]:
    """Return the watched pins of axis 0 from the board's own table, as {"DIR": "PD4"}."""
    rows = re.findall(r"^BOARD_PIN\((\w+), 0, ([A-Z]), (\d),", path.read_text(), flags=re.MULTILINE)
    return {signal: f"P{port}{bit}" for signal, port, bit in rows if signal in WATCHED}


def read_csv(path: Path) -> Iterator[dict[str, str]]:
    """Yield the rows of a file with a header."""
    with path.open(encoding="ascii", newline="") as file:
        yield from csv.DictReader(file)


def read_edges(path: Path) -> tuple[list[int], list[str]]:
    """Return the rises of STEP of axis 0 of board 0, and the changes of its other outputs."""
    rises: list[int] = []
    changes: list[str] = []
    for row in read_csv(path):
        if (row["board"], row["axis"]) != ("0", "0"):
            continue
        if row["signal"] in WATCHED:
            changes.append(f"{row['signal']} {row['level']} after {len(rises)} steps")
        elif (row["signal"], row["level"]) == ("STEP", "1"):
            rises.append(int(row["cycle"]))
    return rises, changes


def read_serial(path: Path, direction: str) -> list[tuple[int, int]]:
    """Return (cycle, byte) of one direction, "rx" or "tx"."""
    return [
        (int(row["cycle"]), int(row["byte"], 16))
        for row in read_csv(path)
        if row["direction"] == direction
    ]


def replay(image: Path, pins: Path, folder: Path) -> tuple[Run, Run, str]:
    """Return the recorded run, the same in yasimavr, and what the latter took."""
    from board import Uno  # only here: it needs yasimavr

    want = Run(*read_edges(folder / "edges.csv"), read_serial(folder / "serial.csv", "tx"))
    if not want.rises:
        raise ValueError(f"{folder}/edges.csv: no steps")
    rows = read_csv(folder / "clock.csv")
    clock = [int(row["cycle"]) for row in rows if row["edge"] != "missing"]
    end = want.rises[-1] + RUN_ON_CYCLES
    board = Uno(image, read_pins(pins))
    start = time.process_time()
    board.play(clock, read_serial(folder / "serial.csv", "rx"), end)
    spent = f"{end} cycles in {time.process_time() - start:.1f} s of CPU time"
    if board.late_captures:
        spent += f"; {board.late_captures} of {len(clock)} captures up to 3 cycles late"
    return want, Run(board.rises, board.changes, board.sent), spent


def main(words: list[str]) -> int:
    """Replay, compare, say so."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    for name in ("--image", "--pins", "--run"):
        parser.add_argument(name, type=Path, required=True)
    parser.add_argument("--min-steps", type=int, default=MIN_STEPS)
    options = parser.parse_args(words)
    lack = missing()
    if lack:
        print(f"thirdcheck: skipped, no yasimavr here: {lack} (tools/setup tries to install it)")
        return SKIPPED
    want, got, spent = replay(options.image, options.pins, options.run)
    problems, summary = compare(want, got, options.min_steps)
    for problem in problems:
        print(f"thirdcheck: {problem}")
    print(f"thirdcheck: yasimavr against pixstep-sim: {summary}; {spent}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
