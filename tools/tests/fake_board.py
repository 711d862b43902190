# SPDX-License-Identifier: MIT
"""A test double of boards on a line, at the level of bytes: register map 6, settings, safety.

It stands where the simulator's pipe does (`transmit`), so the real client talks to it. It knows
the rules of the map, not the motion: a line that runs is done when its pixels have passed.
"""

from dataclasses import dataclass, field
from functools import partial

from clock import TICK_HZ
from fake_modbus import ADDRESS, BUSY, FAILURE, VALUE, FakeServer, RefusalError
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.lines import runs
from pixstep.lines.runs import MARK_DIVIDER
from pixstep_trials.wire import crc16

MAP = regs.register_map()
FAULT = {code.name: code.code for code in regs.faults().values()}
STATE = {name: code for code, name in enumerate(regs.AXIS_STATES)}
REPLY_S = 0.005
QUEUE = 128
STORE_S = 0.2


class FakeWorld:
    """Time that passes by waiting and by requests."""

    def __init__(self):
        self.time = 100.0
        self.then = []  # (time, action), as someone at the machine does them

    def now_s(self):
        return self.time

    def wait(self, seconds):
        self.time += seconds
        for due in [item for item in self.then if item[0] <= self.time]:
            self.then.remove(due)
            due[1]()

    def later(self, seconds, action):
        """Do something when so much time has passed."""
        self.then.append((self.time + seconds, action))


class FakeLine:
    """The line with its boards; `lose` replies are lost, `garble` bytes come in their place."""

    def __init__(self, world, *boards):
        self.world, self.boards = world, boards
        self.lose = 0
        self.garble = b""
        self.requests = []

    @staticmethod
    def command(_text):
        """Take a change of baud: bytes here have no duration."""
        return "ok"

    def cycles(self, seconds):
        """Return a time in cycles of no board in particular."""
        return round(seconds * TICK_HZ)

    def transmit(self, data, _timeout=None):
        """Return the reply to a frame, empty for none."""
        self.world.wait(REPLY_S)
        assert crc16(data) == 0
        self.requests.append(data)
        replies = [board.answer(data[0], data[1:-2]) for board in self.boards]
        reply = b"".join(found for found in replies if found)
        if self.lose:
            self.lose -= 1
            return b""
        return self.garble or reply


@dataclass
class FakeAxis:
    """One axis: its queue, where it is in its line."""

    state: str = "empty"
    entries: list = field(default_factory=list)
    next_block: int = 0
    position: int = 0
    lines_done: int = 0
    token: int = 0
    started_s: float = 0.0
    pixel: int = 0
    last: int = 0  # count of the newest entry
    records: list = field(default_factory=list)
    count: int = 0  # of the run that is being made
    repeat: int = 0


class FakeBoard(FakeServer):
    """One board; tests press its buttons by its attributes."""

    def __init__(self, world, unit=1, kind="mega"):
        self.world = world
        self.kind = kind
        self.id = {name: code for code, name in regs.BOARD_IDS.items()}[kind]
        self.axes = [FakeAxis() for _ in range(boards.load(kind).axes)]
        self.holdings = self.defaults()
        self.holdings[0] = unit
        self.said = []  # the dividers of lines
        self.stored = None
        self.serial = 0
        self.storing_until = 0.0
        self.values = {
            "map_version": regs.MAP_VERSION, "firmware_version": 0x0001,
            "record_capacity": 10, "reset_cause": 1,
            **self.intervals(), "event_capacity": 4,
            "features": 0xFFFF, "features_high": (1 << len(boards.features()) - 16) - 1,
        }  # fmt: skip
        self.inputs_bits = 0
        self.estop = self.clock = self.permit = False
        self.plays_unknown = 0  # bit n: axis n
        self.clock_hz = 30.0
        self.drivers = 0
        self.fault = (0, 0, 0, 0)  # code, argument, axis, pixel
        self.events = []
        self.commands = []  # (name, mask, argument)
        self.first_edge = 60_000 + 977 * unit  # its count of clock edges began there
        self.mark = (0, 0.0)  # count, time
        self.zero_edge = 0
        self.counters = dict.fromkeys(range(11, 19), 0)

    def intervals(self):
        """Return the shortest intervals by register: with some axes moving, and with all."""
        table = boards.load(self.kind)
        found = {}
        for name in ("min_interval", "smooth_min_interval"):
            *fewer, every = getattr(table, f"{name}s_ticks")
            found[f"{name}_ticks"] = every
            found |= {f"{name}_{axes}_ticks": ticks for axes, ticks in enumerate(fewer, 1)}
        return found

    @staticmethod
    def defaults():
        words = {}
        for item in regs.settings():
            for index in range(item.words):
                shift = 16 * (item.words - 1 - index)
                words[item.address + index] = item.default >> shift & 0xFFFF
        return words

    def setting(self, name):
        item = MAP.holding(name)
        return item.decode([self.holdings[item.address + n] for n in range(item.words)])

    def without(self, *names):
        """Take features away, and what goes with them."""
        for name in names:
            register, bit = self.place_of(name)
            self.values[register] &= ~(1 << bit)
        if "events" in names:
            self.values["event_capacity"] = 0

    def has(self, name):
        register, bit = self.place_of(name)
        return bool(self.values[register] >> bit & 1)

    @staticmethod
    def place_of(name):
        bit = boards.feature_named(name).bit
        return ("features_high", bit - 16) if bit > 15 else ("features", bit)

    def latch(self, name, argument=0, axis=0, pixel=0):
        """Stop everything with a fault."""
        if not self.fault[0]:
            self.fault = (FAULT[name], argument, axis, pixel)
            number = len(self.events) + 1
            ms = int(1000 * self.world.time)
            self.events.append((number, FAULT[name], axis, argument, pixel, ms))
        self.permit = False
        for item in self.axes:
            if item.state in ("armed", "running"):
                item.state = "fault"

    def press_estop(self, pressed=True):
        self.estop = pressed
        if pressed:
            self.latch("estop")

    def read(self, inputs, first, count):
        if not 1 <= count <= 125:
            raise RefusalError(VALUE)
        area = self.input_words(first) if inputs else self.holdings
        try:
            return [area[first + index] & 0xFFFF for index in range(count)]
        except KeyError:
            raise RefusalError(ADDRESS) from None

    def input_words(self, first):
        """Return the mapped input words around an address, by address."""
        if first >= regs.EVENT_BASE:
            return self.event_words()
        if regs.ROOM_BASE <= first < regs.RECORD_BASE:
            free = [runs.MOST_BYTES * (QUEUE - len(axis.entries)) for axis in self.axes]
            return dict(enumerate(free, regs.ROOM_BASE))
        if first >= regs.RECORD_BASE:
            return self.record_words((first - regs.RECORD_BASE) // regs.RECORD_STRIDE)
        return InputWords(self)

    def value(self, name):
        code, argument, axis, pixel = self.fault
        known = {
            "board_id": self.id, "axis_count": len(self.axes), "status": self.status(),
            "fault_code": code, "fault_argument": argument, "fault_axis": axis,
            "fault_pixel": pixel, "fault_mask": 1 << code & 0xFFFE,
            "fault_mask_high": 1 << code >> 16, "inputs": self.inputs_bits,
            "pixel_edges": int(self.clock_hz * self.world.time) if self.clock else 0,
            "outputs": self.drivers | self.permit << 8, "settings_serial": self.serial,
            "settings_state": self.settings_state(), "clock_edge": self.edge() & 0xFFFF,
            "mark_count": self.mark[0] & 0xFF, "mark_units": self.ticks(self.mark[1]) // 64,
            "clock_edge_ticks": self.ticks((self.edge() - self.first_edge) / self.edge_hz()),
            "zero_edge": self.zero_edge, "mark_steady": self.mark[0] > 0,
            "ready": any(axis.state == "armed" for axis in self.axes),
        }  # fmt: skip
        return known.get(name, self.values.get(name, 0))

    def status(self):
        states = [axis.state for axis in self.axes]
        return (
            self.clock | ("armed" in states) << 1 | ("running" in states) << 2
            | bool(self.fault[0]) << 3 | self.estop << 4 | self.permit << 5
            | self.plays_unknown << 12
        )  # fmt: skip

    def edge(self):
        """Return the number of the newest clock edge, by this board's own count."""
        return self.first_edge + int(self.world.time * self.edge_hz())

    def edge_hz(self):
        return (self.setting("pixel_hz_num") or 1) / (self.setting("pixel_hz_den") or 1)

    def settings_state(self):
        storing = self.world.time < self.storing_until
        return (self.serial > 0) | (self.stored != self.holdings) << 1 | storing << 2

    @staticmethod
    def axis_value(axis, name):
        return {
            "axis_state": STATE[axis.state], "queue_free": QUEUE - len(axis.entries),
            "next_block": axis.next_block, "position_steps": axis.position,
            "pixel": axis.pixel, "lines_done": axis.lines_done,
        }.get(name, 0)  # fmt: skip

    def record_words(self, number):
        axis = self.axes[number]
        kept = axis.records[-self.values["record_capacity"] :]
        newest = kept[-1][0] if kept else 0
        words = [newest >> 16, newest, len(kept), len(axis.records)]
        for pixel, steps in kept:
            words += [pixel, steps >> 16, steps, steps >> 16, steps, 0]
        words += [0] * (regs.RECORD_STRIDE - len(words))
        base = regs.RECORD_BASE + number * regs.RECORD_STRIDE
        return {base + index: word for index, word in enumerate(words)}

    def event_words(self):
        capacity = self.values["event_capacity"]
        words = [len(self.events)]
        for number, code, axis, argument, pixel, ms in self.events[-capacity:]:
            words += [number, code, axis, argument, pixel >> 16, pixel, ms >> 16, ms]
        found = PaddedWords(enumerate(words, regs.EVENT_BASE))
        found.mapped = range(regs.EVENT_BASE, regs.EVENT_BASE + 1 + capacity * regs.EVENT_WORDS)
        return found

    def read_bits(self, coils, first, count):
        if not coils:
            bits = self.status() | self.inputs_bits << 16
            if first + count > 32:
                raise RefusalError(ADDRESS)
            return [bits >> first + index & 1 for index in range(count)]
        found = self.coils()
        try:
            return [found[first + index] for index in range(count)]
        except KeyError:
            raise RefusalError(ADDRESS) from None

    def coils(self):
        found = {regs.COIL_CLEAR: bool(self.fault[0]), regs.COIL_PERMIT: self.permit}
        for number, axis in enumerate(self.axes):
            found[regs.COIL_DRIVER + number] = bool(self.drivers >> number & 1)
            found[regs.COIL_ARMED + number] = axis.state in ("armed", "running")
            found[regs.COIL_STOP + number] = False
        return found

    # Writes

    def write_coils(self, first, values):
        if any(first + index not in self.coils() for index in range(len(values))):
            raise RefusalError(ADDRESS)
        for index, value in enumerate(values):
            group, axis = (first + index) // 4 * 4, (first + index) % 4
            names = {
                regs.COIL_DRIVER: ("disable", "enable"), regs.COIL_ARMED: ("disarm", "arm"),
                regs.COIL_STOP: ("", "stop"),
            }.get(group)  # fmt: skip
            if group == regs.COIL_CLEAR:
                names = ("permit_off", "permit_on") if axis else ("", "clear_fault")
                axis = 0
            if names[value]:
                self.obey(names[value], 1 << axis, 0)

    def write(self, first, words):
        if first == regs.QUEUE_WINDOW:
            self.queue(words)
            return
        if first == regs.COMMAND_BASE and 2 <= len(words) <= 4:
            names = {code: name for name, code in regs.COMMANDS.items()}
            mask, code, argument, self.named_edge = (*words, 0, 0)[:4]
            if code not in names:
                raise RefusalError(VALUE)
            self.obey(names[code], mask, argument)
            return
        wanted = self.holdings | {first + index: word for index, word in enumerate(words)}
        if wanted.keys() != self.holdings.keys():
            raise RefusalError(ADDRESS)
        for item in regs.settings():
            value = item.decode([wanted[item.address + n] for n in range(item.words)])
            if not item.minimum <= value <= item.maximum:
                raise RefusalError(VALUE)
        if any(axis.entries for axis in self.axes) or self.world.time < self.storing_until:
            raise RefusalError(BUSY)
        self.holdings = wanted

    def queue(self, words):
        block, number, *rest = words
        packed, number = divmod(number, 0x100)
        if number >= len(self.axes):
            raise RefusalError(VALUE)
        axis = self.axes[number]
        if block == (axis.next_block - 1) & 0xFFFF:
            return
        if block != axis.next_block or axis.state == "fault":
            raise RefusalError(VALUE)
        if packed:
            data = b"".join(word.to_bytes(2) for word in rest)
            found = runs.unpack(data[:packed], axis.last)
            entries = [(count & 0xFFFF, repeat) for count, repeat in found]
        else:
            entries = list(zip(rest[::2], rest[1::2], strict=True))
        last = entries[-1][0]
        self.take_divider(entries)
        if len(axis.entries) + len(entries) > QUEUE:
            raise RefusalError(BUSY)
        axis.next_block = (block + 1) & 0xFFFF
        axis.entries += entries
        axis.last = last
        axis.state = axis.state if axis.state == "running" else "loaded"

    def take_divider(self, entries):
        """Take the third entry of a line whose start mark promises one: setting `divider`."""
        count, repeat = entries[0]
        if repeat or count & (15 | MARK_DIVIDER) != 1 | MARK_DIVIDER:
            return
        edges, _ = entries.pop(2)
        self.said.append(edges)
        if edges != self.setting("divider"):
            if any(axis.entries for axis in self.axes):
                raise RefusalError(VALUE)
            self.holdings[MAP.holding("divider").address] = edges

    def obey(self, name, mask, argument):
        """Do a command for the axes of a mask."""
        self.commands.append((name, mask, argument))
        chosen = [axis for index, axis in enumerate(self.axes) if mask >> index & 1]
        if name in ("arm", "stop", "disarm", "discard", "enable", "disable") and (
            not mask or mask >> len(self.axes)
        ):
            raise RefusalError(FAILURE)
        getattr(self, f"obey_{name}", lambda *_: None)(chosen, mask, argument)

    def obey_arm(self, chosen, mask, token):
        if self.fault[0] or self.estop or any(axis.state != "loaded" for axis in chosen):
            raise RefusalError(FAILURE)
        self.drivers |= mask
        for axis in chosen:
            axis.state, axis.token = "armed", token
            if not token:
                self.start(axis)

    def obey_go(self, _chosen, _mask, token):
        ahead = (self.named_edge - self.edge()) & 0xFFFF
        for axis in (axis for axis in self.axes if axis.state == "armed"):
            if axis.token != token:
                self.latch("wrong_token", axis.token)
                return
            if not self.named_edge or not 1 < ahead < 0x8000:
                raise RefusalError(FAILURE)
            self.zero_edge = self.named_edge
            edges = self.edge() - self.first_edge + ahead
            self.world.later(edges / self.edge_hz() - self.world.time, partial(self.begin, axis))

    def begin(self, axis):
        if axis.state == "armed":
            self.start(axis)

    def obey_mark(self, *_):
        self.mark = (self.mark[0] + 1, self.world.time)

    def ticks(self, seconds):
        return round(seconds * boards.load(self.kind).tick_hz) & 0xFFFFFFFF

    def start(self, axis):
        axis.state, axis.started_s = "running", self.world.time
        axis.pixel, axis.records = 0, []

    def obey_stop(self, chosen, _mask, _argument):
        for axis in chosen:
            axis.state, axis.entries, axis.repeat = "empty", [], 0

    obey_discard = obey_disarm = obey_stop

    def obey_enable(self, _chosen, mask, _argument):
        self.drivers |= mask

    def obey_disable(self, _chosen, mask, _argument):
        self.drivers &= ~mask

    def obey_clear_fault(self, *_):
        if self.estop:
            raise RefusalError(FAILURE)
        self.fault = (0, 0, 0, 0)
        for axis in self.axes:
            if axis.state == "fault":
                axis.state, axis.entries, axis.repeat = "empty", [], 0

    def obey_permit_on(self, *_):
        if self.fault[0]:
            raise RefusalError(FAILURE)
        self.permit = True

    def obey_permit_off(self, *_):
        self.permit = False

    def obey_store(self, _chosen, _mask, key):
        if key != regs.STORE_KEY:
            raise RefusalError(VALUE)
        self.storing_until = self.world.time + STORE_S
        self.stored, self.serial = dict(self.holdings), self.serial + 1

    def obey_default_settings(self, _chosen, _mask, key):
        if key != regs.STORE_KEY:
            raise RefusalError(VALUE)
        self.holdings = self.defaults()

    def tick(self):
        """Let running lines go on to the present."""
        hz = self.setting("pixel_hz_num") / self.setting("pixel_hz_den")
        for axis in self.axes:
            while axis.state == "running":
                if axis.started_s + (axis.pixel + 1) / hz > self.world.time:
                    break
                self.next_pixel(axis)

    def next_pixel(self, axis):
        """Make one pixel of a line, or end it."""
        while not axis.repeat:
            if not axis.entries:
                self.latch("starved", 0, self.axes.index(axis), axis.pixel)
                return
            axis.count, axis.repeat = axis.entries.pop(0)
            if axis.repeat == 0 and axis.count & 15 == 1:  # a start, its parameters behind it
                axis.entries.pop(0)
            elif (axis.count, axis.repeat) == (2, 0):
                axis.state, axis.lines_done = "done", axis.lines_done + 1
                return
        axis.repeat -= 1
        axis.pixel += 1
        axis.position += axis.count - 0x10000 if axis.count & 0x8000 else axis.count
        axis.records.append((axis.pixel, axis.position))


class PaddedWords(dict):
    """Words by address; those of the mapped addresses that are not given are 0."""

    mapped = range(0)

    def __missing__(self, address):
        if address in self.mapped:
            return 0
        raise KeyError(address)


def places(items):
    """Return (item, shift) by address, high word first."""
    return {
        item.address + index: (item, 16 * (item.words - 1 - index))
        for item in items
        for index in range(item.words)
    }


class InputWords:
    """The input words of a board and its axes by address, each computed when it is asked for."""

    board_places = places(MAP.inputs)
    axis_places = places(MAP.axis_inputs)

    def __init__(self, board):
        self.board = board

    def __getitem__(self, address):
        number, inside = divmod(address - regs.AXIS_BASE, regs.AXIS_STRIDE)
        if 0 <= number < len(self.board.axes):
            item, shift = self.axis_places[inside]
            value = self.board.axis_value(self.board.axes[number], item.name)
        else:
            item, shift = self.board_places[address]
            value = self.board.value(item.name)
        return value >> shift & 0xFFFF
