# SPDX-License-Identifier: MIT
"""Measure what docs/TIMING.md states: cycles, highest clean rates, sizes, stack.

All of it comes from the real images in the simulator: handler and decode cycles from a smooth and
a plain line under serial load, the highest clean rate by bisection over constant-rate lines whose
every edge must pass the verdict.
"""

import shutil
import tempfile
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from pixstep import boards, files, natives, profile
from pixstep.demo import PROFILE
from pixstep.errors import UserError
from pixstep.judge import Judgement
from pixstep.line import PLAIN, SMOOTH, Line
from pixstep.simrun import Job
from pixstep.simtask import simulate

_HZ = Fraction(50)
_SECTIONS = {SMOOTH: 1, PLAIN: 2}
_RATE_TOP = 400_000  # steps/s: no board of these reaches it
_RATE_STEP = 500  # steps/s: resolution of the search
_RATE_PIXELS = 10  # 0.2 s at the rate under test

Progress = Callable[[float], None]


def measure(progress: Progress = lambda _: None, *, rates: bool = True) -> dict:
    """Measure both boards; return plain data. Takes minutes with `rates`."""
    result = {}
    todo = sum(2 + (2 * _axis_counts(name)[-1] if rates else 0) for name in boards.BOARD_NAMES)
    done = 0

    def step() -> None:
        nonlocal done
        done += 1
        progress(min(1.0, done / todo))

    for name in boards.BOARD_NAMES:
        row = {"size": size(name), "decode": {}, "handlers": {}, "rates": []}
        stack = []
        for decode in (SMOOTH, PLAIN):
            judged = _run(name, {0: _example(decode)}, Fraction(30), serial_load=True)
            summary = judged.summary
            row["decode"][decode] = _decode_cycles(summary, decode)
            _merge_handlers(row["handlers"], summary["handlers"])
            stack.append(summary["stack_used_bytes"])
            step()
        for axes in _axis_counts(name) if rates else []:
            for decode in (SMOOTH, PLAIN):
                rate = highest_rate(name, decode, axes)
                row["rates"].append({"axes": axes, "decode": decode, "steps_per_s": rate})
                step()
        row["stack_used_bytes"] = max(stack)
        row["handlers"] = list(row["handlers"].values())
        result[name] = row
    return result


def size(board: str) -> dict:
    """Return flash and static RAM of a board's image in bytes, by avr-size."""
    tool = shutil.which("avr-size")
    if not tool:
        raise UserError("avr-size is missing: run tools/setup")
    done = natives.run([tool, natives.image(board)])
    if done.returncode:
        raise UserError(f"avr-size: {done.stderr.strip()}")
    text, data, bss = (int(word) for word in done.stdout.splitlines()[1].split()[:3])
    return {"flash_bytes": text + data, "ram_bytes": data + bss}


def highest_rate(board: str, decode: str, axes: int) -> int:
    """Return the highest clean constant rate in steps/s, to _RATE_STEP, all axes at once."""
    low, high = 0, _RATE_TOP // _RATE_STEP
    while high - low > 1:
        middle = (low + high) // 2
        if clean(board, decode, axes, middle * _RATE_STEP):
            low = middle
        else:
            high = middle
    return low * _RATE_STEP


def clean(board: str, decode: str, axes: int, steps_per_s: int) -> bool:
    """True if every edge of `axes` simultaneous lines at this rate passes the verdict."""
    count = int(Fraction(steps_per_s) / _HZ) // 2 * 2
    if count < 20:
        return True
    line = _sustained(decode, count)
    return _run(board, dict.fromkeys(range(axes), line), _HZ).passed


def markdown(measured: dict) -> str:
    """Return the tables of docs/TIMING.md."""
    parts = ["### Interrupt handlers, cycles from the flag's service to the end of RETI\n"]
    parts.append("| board | handler | min | mean | max | latest start |")
    parts.append("| --- | --- | --: | --: | --: | --: |")
    for board, row in measured.items():
        for one in row["handlers"]:
            parts.append(
                f"| {board} | {one['name']} | {one['cycles_min']} | {one['cycles_mean']:.1f} | "
                f"{one['cycles_max']} | {one['latency_max']} |"
            )
    parts.append("\n### Decoding, cycles a step in the main loop\n")
    parts.append("| board | smooth | plain |\n| --- | --: | --: |")
    for board, row in measured.items():
        parts.append(f"| {board} | {row['decode'][SMOOTH]:.0f} | {row['decode'][PLAIN]:.0f} |")
    if any(row["rates"] for row in measured.values()):
        parts.append("\n### Highest clean rate, steps/s on each of the axes at once\n")
        parts.append("| board | axes | smooth | plain |\n| --- | --: | --: | --: |")
        parts += _rate_rows(measured)
    parts.append("\n### Size, bytes\n")
    parts.append("| board | flash | of | static RAM | worst stack | RAM left |")
    parts.append("| --- | --: | --: | --: | --: | --: |")
    for board, row in measured.items():
        ram, stack = row["size"]["ram_bytes"], row["stack_used_bytes"]
        left = boards.RAM_BYTES[board] - ram - stack
        parts.append(
            f"| {board} | {row['size']['flash_bytes']} | {boards.FLASH_BYTES[board]} | {ram} | "
            f"{stack} | {left} |"
        )
    return "\n".join(parts) + "\n"


def _rate_rows(measured: dict) -> list[str]:
    rows = []
    for board, row in measured.items():
        by_axes: dict[int, dict[str, int]] = {}
        for one in row["rates"]:
            by_axes.setdefault(one["axes"], {})[one["decode"]] = one["steps_per_s"]
        for axes, rates in by_axes.items():
            rows.append(f"| {board} | {axes} | {rates[SMOOTH]} | {rates[PLAIN]} |")
    return rows


def _axis_counts(board: str) -> list[int]:
    return list(range(1, boards.load(board).axes + 1))


def _example(decode: str) -> Line:
    """Return the worked example, smooth with backlash or plain."""
    source = natives.source(PROFILE)
    speeds, _ = files.read_prn(source)
    plain = decode == PLAIN
    request = profile.LineRequest(1000, 40, 0 if plain else 250, plain=plain)
    made = profile.generate(speeds, request, str(source))
    return Line(tuple(made.counts), decode, request.backlash)


def _sustained(decode: str, count: int) -> Line:
    """Return a line at one rate: plain counts, or smooth pixels that all accelerate a little.

    The smooth boundary speeds go count, count - 2d, count - d and again, d being about 2 %, so
    that no pixel takes the easier path of constant speed and no two counts are equal.
    """
    if decode == PLAIN:
        return Line((count,) * _RATE_PIXELS, PLAIN)
    d = 2 * max(1, count // 100)
    speeds = [0, *([count, count - 2 * d, count - d] * (_RATE_PIXELS // 3)), count, 0]
    return Line(tuple((a + b) // 2 for a, b in pairwise(speeds)), SMOOTH)


def _run(
    board: str, lines: dict[int, Line], hz: Fraction, *, serial_load: bool = False
) -> Judgement:
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        job = Job(board, lines, hz, serial_load=serial_load)
        return simulate(job, Path(folder))


def _decode_cycles(summary: dict, decode: str) -> float:
    """Return the main loop's cycles a step in the decoder, interrupts excluded."""
    sections = summary["section_cycles"]
    steps = summary["axes"][0]["steps"]
    return sections[_SECTIONS[decode]] / steps if sections and steps else float("nan")


def _merge_handlers(known: dict[str, dict], rows: list[dict]) -> None:
    """Merge handler statistics of several runs by name."""
    for row in rows:
        old = known.get(row["name"])
        if old is None:
            known[row["name"]] = dict(row)
            continue
        count = old["count"] + row["count"]
        total = old["count"] * old["cycles_mean"] + row["count"] * row["cycles_mean"]
        old.update(
            count=count,
            cycles_min=min(old["cycles_min"], row["cycles_min"]),
            cycles_max=max(old["cycles_max"], row["cycles_max"]),
            cycles_mean=total / count if count else 0.0,
            latency_max=max(old["latency_max"], row["latency_max"]),
        )
