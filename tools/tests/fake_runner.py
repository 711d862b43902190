# SPDX-License-Identifier: MIT
"""A test double of the simulator with a board in it: the control protocol, Modbus, ideal edges.

It is given the runner's arguments and answers its commands. The edges it writes are the exact
instants rounded down (a step on an edge stays on it), so a verdict over it must pass; DEFECT in
the environment names what it does wrong instead (see `_spoil` and `_serve`).
"""

import json
import os
import sys
from fractions import Fraction
from pathlib import Path

from clock import TICK_HZ
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.lines import exact, runs
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import check, refused
from pixstep.lines.units import edge_tick, period_ticks
from pixstep_trials.wire import crc16, seal

# PYTHONPATH of this program: what a test has on its own path, a child does not.
_TOOLS = Path(__file__).resolve().parents[1]
PATH = os.pathsep.join(str(_TOOLS / folder) for folder in ("src", "dev"))
BYTE_CYCLES = 11 * TICK_HZ // 115_200
GAP_CYCLES = 28_000
QUEUE_SLOTS = 64
FAULT_CODE = 5
STATUS = regs.register_map().input("status").address
FEATURES = regs.register_map().input("features").address
ALL_FEATURES = 0xFFFF
DEFECT = os.environ.get("DEFECT", "")


class FakeAxis:
    """Queue, line and motion of one axis."""

    def __init__(self):
        self.entries, self.state, self.next_block = [], 0, 0
        self.error, self.error_pixel, self.line, self.zero = 0, 0, None, None

    def take(self, entries):
        """Take a block; return the exception code, 0 if taken."""
        if len(self.entries) + len(entries) > QUEUE_SLOTS:
            return 6
        self.entries += entries
        self.next_block += 1
        self.state = 1
        if entries[-1] == (runs.MARK_END, 0):
            return self._complete()
        return 0

    def _complete(self):
        (word, _), (backlash, _), *body, _ = self.entries
        decode = SMOOTH if word & runs.MARK_SMOOTH else PLAIN
        line = Line(tuple(runs.decode(body)), decode, backlash, bool(word & runs.MARK_NEGATIVE))
        errors = [item for item in check(line) if item.severity == "error"]
        if refused(errors):
            codes = {code.name: code.code for code in regs.line_errors().values()}
            self.state, self.error = 6, codes[errors[0].name]
            self.error_pixel = errors[0].pixel
            return 3
        self.line, self.state = line, 2
        return 0


class Fake:
    """The simulated world."""

    def __init__(self, arguments):
        options = dict(zip(arguments[::2], arguments[1::2], strict=False))
        numerator, denominator = options["--pixel-hz"].split("/")
        self.real_hz = Fraction(int(numerator), int(denominator))
        self.board = options["--board"].split("=")[0]
        self.options, self.cycle = options, 0
        self.axes = [FakeAxis() for _ in range(boards.load(self.board).axes)]
        self.settings = dict.fromkeys(range(0x200), 0) | {6: 20, 7: 20}
        self.edges, self.last_block, self.lost = [], None, 0

    @property
    def period(self):
        return period_ticks(self.real_hz, TICK_HZ)

    def clock(self):
        first, ticks = 160_000, []
        while first + edge_tick(len(ticks), self.period) <= self.cycle:
            ticks.append(first + edge_tick(len(ticks), self.period))
        return ticks

    def arm(self, mask):
        due = 160_000
        while due <= self.cycle:
            due += edge_tick(1, self.period)
        for index, axis in enumerate(self.axes):
            if mask >> index & 1:
                axis.zero, axis.state = due + edge_tick(1, self.period), 4
                self.edges += self.steps(index, axis)

    def steps(self, index, axis):
        made = [when.floor() for _, when in exact.exact_instants(axis.line, self.period)]
        ticks = self._spoil(made) if index == 0 else made
        signs = exact.directions(axis.line)
        rows, last = [], 1
        for tick, sign in zip(ticks, [*signs, *signs[-1:]], strict=False):
            if sign != last:
                rows.append((axis.zero + tick - 350, index, "DIR", int(sign < 0)))
                last = sign
            rows.append((axis.zero + tick, index, "STEP", 1))
            rows.append((axis.zero + tick + 30, index, "STEP", 0))
        return rows

    def _spoil(self, ticks):
        if DEFECT == "moved":
            ticks[40] += 2
        elif DEFECT == "missing":
            del ticks[40]
        elif DEFECT == "doubled":
            ticks.insert(40, ticks[40] + 60)
        elif DEFECT == "drift":
            ticks = [tick + tick // 1_000_000 for tick in ticks]
        elif DEFECT in ("halts", "stops"):
            del ticks[len(ticks) // 2 :]
        elif DEFECT == "late":
            ticks = [tick + 50 for tick in ticks]
        return ticks

    def input(self, address):
        if address >= regs.RECORD_BASE:
            return self.record(*divmod(address - regs.RECORD_BASE, regs.RECORD_STRIDE))
        if address == FAULT_CODE:
            return int(DEFECT == "halts" and any(axis.zero for axis in self.axes))
        if not regs.AXIS_BASE <= address < regs.AXIS_BASE + 4 * regs.AXIS_STRIDE:
            known = {0: 1, 2: boards.load(self.board).id, 3: len(self.axes), 24: 10}
            known[STATUS] = self.status()
            return known.get(address, ALL_FEATURES if address == FEATURES else 0)
        axis, offset = self.axes[(address - 0x20) // 16], address % 16
        self.update(axis)
        free = QUEUE_SLOTS - (len(axis.entries) if axis.state < 3 else 0)
        pixel = self.passed(axis)
        return {
            0: axis.state, 1: free, 2: axis.next_block, 3: axis.error, 5: axis.error_pixel,
            10: pixel >> 16, 11: pixel & 0xFFFF,
        }.get(offset, 0)  # fmt: skip

    def status(self):
        """Return the word that says whether a line runs; a line here is never only armed."""
        for axis in self.axes:
            self.update(axis)
        return any(axis.state == 4 for axis in self.axes) << 2

    def update(self, axis):
        if axis.state == 4 and self.passed(axis) >= axis.line.pixels:
            axis.state = 5

    def passed(self, axis):
        if axis.zero is None:
            return 0
        count = 0
        while (
            count < axis.line.pixels and axis.zero + edge_tick(count + 1, self.period) <= self.cycle
        ):
            count += 1
        return count

    def record(self, index, offset):
        axis = self.axes[index]
        newest = self.passed(axis)
        count = min(newest, 10)
        if offset < 4:
            return (newest >> 16, newest & 0xFFFF, count, 0)[offset]
        slot, word = divmod(offset - 4, 6)
        if slot >= count:
            return 0
        pixel = newest - count + 1 + slot
        value = exact.expected_positions(axis.line)[pixel - 1] & 0xFFFFFFFF
        if DEFECT == "table" and pixel == 3:
            value += 1
        return (pixel & 0xFFFF, value >> 16, value & 0xFFFF, value >> 16, value & 0xFFFF, 0)[word]

    def serve(self, frame):
        """Return the reply to a request frame, empty for a broken one or a lost reply."""
        if crc16(frame) != 0 or (DEFECT == "mute" and self.axes[0].state == 4):
            return b""
        unit, function, body = frame[0], frame[1], frame[2:-2]
        if function in (3, 4):
            first, count = int.from_bytes(body[:2]), int.from_bytes(body[2:4])
            read = self.input if function == 4 else self.settings.get
            words = b"".join(read(first + i).to_bytes(2) for i in range(count))
            reply = bytes([unit, function, len(words)]) + words
        elif function == 17:
            reply = bytes([unit, 17, 9, 1, 0]) + b"pixstep"
        else:
            first = int.from_bytes(body[:2])
            data = body[2:4] if function == 6 else body[5:]
            error = self.write(
                first, [int.from_bytes(data[i : i + 2]) for i in range(0, len(data), 2)]
            )
            reply = bytes([unit, function]) + body[:4]
            if error:
                reply = bytes([unit, function | 0x80, error])
            elif first == regs.QUEUE_WINDOW and DEFECT == "lost reply" and self.lost < 2:
                self.lost += 1
                return b""
        return seal(reply)

    def write(self, first, words):
        if first == regs.COMMAND_BASE:
            if words[1] == regs.COMMANDS["arm"]:
                self.arm(words[0])
            return 0
        if first != regs.QUEUE_WINDOW:
            self.settings.update({first + i: word for i, word in enumerate(words)})
            return 0
        block, index, *rest = words
        axis = self.axes[index]
        pairs = [(word - 0x10000 if word & 0x8000 else word) for word in rest]
        entries = list(zip(pairs[::2], rest[1::2], strict=True))
        if (block, index, entries) == self.last_block:
            return 0
        if block != axis.next_block:
            return 3
        error = axis.take(entries)
        self.last_block = (block, index, entries) if not error else self.last_block
        return error

    def stats(self):
        row = {"name": self.board, "handlers": [], "interrupt_cycles": self.cycle // 10}
        row |= {"interrupts_off_max_cycles": 90, "interrupts_off_main_max_cycles": 50}
        row |= {"section_entries": [self.cycle // 500] * 6 + [0]}
        row |= {"sections": [self.cycle // 2, self.cycle // 4, 0, 0, 0, 0, 0], "axes": []}
        row |= {"stack_free_bytes": 900, "stack_used_bytes": 100, "sleep_cycles": 0}
        return json.dumps(
            {"cycle": self.cycle, "wall_s": 0.1, "realtime_factor": 9.0, "boards": [row]}
        )

    def finish(self):
        rows = sorted(self.edges)
        lines = [f"{cycle},0,{axis},{signal},{level}" for cycle, axis, signal, level in rows]
        with open(self.options["--edges"], "w") as file:  # noqa: PTH123
            file.write("\n".join(["cycle,board,axis,signal,level", *lines]) + "\n")
        with open(self.options["--clock-log"], "w") as file:  # noqa: PTH123
            rows = [f"{cycle},{cycle}000,true" for cycle in self.clock()]
            file.write("\n".join(["cycle,true_cycle_x1000,edge", *rows]) + "\n")

    def command(self, words):
        if words[0] == "run":
            self.cycle += int(words[1])
            return f"ok {self.cycle}"
        if words[0] == "tx":
            request = bytes.fromhex(words[1])
            reply = self.serve(request)
            self.cycle += (len(request) + len(reply)) * BYTE_CYCLES + 2 * GAP_CYCLES
            return f"rx {reply.hex() or '-'} {self.cycle}"
        if words[0] == "mark":
            return f"ok {self.cycle}"
        if words[0] == "counts":
            axis = int(words[2])
            made = [c for c, a, signal, up in self.edges if (a, signal, up) == (axis, "STEP", 1)]
            return f"counts {sum(cycle <= self.cycle for cycle in made)}"
        if words[0] == "stats":
            return self.stats()
        if words[0] == "quit":
            self.finish()
            return "ok"
        return f"error unknown command {words[0]}"


def main():
    """Serve commands until quit."""
    fake = Fake([word for word in sys.argv[1:] if word != "--control"])
    for line in sys.stdin:
        words = line.split()
        if DEFECT == "dies" and words[0] == "run" and fake.cycle > TICK_HZ:
            sys.exit("simavr: out of luck")
        print(fake.command(words), flush=True)
        if words[0] == "quit":
            return


if __name__ == "__main__":
    main()
