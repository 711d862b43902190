# SPDX-License-Identifier: MIT
"""docs/PLC.md is true: its requests, taken from the page, do on a simulated Mega what it says."""

import re
import shlex
import struct
import subprocess

import pytest

from bench import Bench
from pixstep import natives
from pixstep.board import boards, rtu
from pixstep.board import registers as regs
from sim_terminal import on_terminal

PAGE = natives.source("docs/PLC.md")
HANG_S = 1800
UNIT = 1
REFUSED, NOT_NOW, BUSY = 3, 4, 6
STATE, NEXT_BLOCK, LINE_ERROR = 0, 2, 3  # words from 32 on
FAULT = 5  # word from 0 on
ESTOP = next(pin for pin in boards.load("mega").pins if pin.signal == "ESTOP")


def rows(heading):
    """Return the rows of the first table of a chapter, without its head."""
    chapter = PAGE.read_text(encoding="utf-8").partition(f"\n## {heading}\n")[2]
    table = re.search(r"^\|(?:.|\n(?=\|))*", chapter, re.M).group()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table.split("\n")[2:]]


def commands():
    """Return the words of each mbpoll command."""
    text = PAGE.read_text(encoding="utf-8").partition("\n## By mbpoll\n")[2]
    block = text.partition("```sh board\n")[2].partition("```")[0]
    return [shlex.split(row, comments=True) for row in block.splitlines()]


def pdu_of(words):
    """Return what mbpoll asks a board for, by its options."""
    first, kind = int(option(words, "-r")), option(words, "-t")
    values = [int(word) for word in words[words.index("/dev/ttyACM0") + 1 :]]
    return write(first, *values) if values else read(int(kind), first, int(option(words, "-c")))


def option(words, name):
    return words[words.index(name) + 1]


def read(kind, first, count):
    return struct.pack(">BHH", {3: rtu.READ_INPUTS, 4: rtu.READ_HOLDINGS}[kind], first, count)


def write(first, *values):
    if len(values) == 1:
        return struct.pack(">BHH", rtu.WRITE_ONE, first, values[0])
    head = struct.pack(">BHHB", rtu.WRITE, first, len(values), 2 * len(values))
    return head + struct.pack(f">{len(values)}H", *values)


class Plc:
    """A PLC that knows the page alone."""

    def __init__(self, bench):
        self.bench = bench
        self.pdus = [pdu_of(words) for words in commands()]

    def ask(self, pdu):
        """Return the exception of a request, or 0, and the words of its reply."""
        reply = self.bench.board.modbus.ask(UNIT, pdu)
        if reply.exception is not None:
            return reply.exception, ()
        words = reply.pdu[2:] if reply.pdu[0] == rtu.READ_INPUTS else b""
        return 0, struct.unpack(f">{len(words) // 2}H", words)

    def request(self, number, block=0):
        """Make a request of the page; request 5 with the block number that is read."""
        pdu = self.pdus[number - 1]
        return self.ask(pdu[:6] + struct.pack(">H", block) + pdu[8:] if number == 5 else pdu)

    def recover(self, case):
        """Make the writes that the page has for a case; return the exceptions."""
        (cells,) = [row for row in rows("Recovery") if row[0] == case]
        found = re.findall(r"FC16 (\d+): `([\d ]+)`", cells[3])
        assert found
        return [self.ask(write(int(at), *map(int, values.split())))[0] for at, values in found]

    def axis(self):
        return self.request(6)[1]

    def load_and_arm(self):
        """Go the page's way from request 4 on; return the block's number."""
        (block,) = self.request(4)[1]
        assert self.request(5, block)[0] == 0
        assert (self.axis()[STATE], self.axis()[NEXT_BLOCK]) == (2, block + 1)
        assert self.request(7)[0] == 0
        return block

    def runs(self):
        """Wait until the axis has begun."""
        self.bench.until(lambda: self.axis()[STATE] == 4)


@pytest.fixture
def plc(simulator):
    with Bench("mega", hz=30) as bench:
        found = Plc(bench)
        assert [found.request(number)[0] for number in (2, 3)] == [0, 0]
        yield found


def test_the_table_the_commands_and_the_bytes_say_the_same():
    listed = rows("Ten requests")
    asked = commands()
    assert len(listed) == len(asked) == 10
    for (_, _, function, first, words, _), command in zip(listed, asked, strict=True):
        at, hexadecimal = re.fullmatch(r"(\d+) \(0x(\w{4})\)", first).groups()
        assert int(at) == int(hexadecimal, 16) == int(option(command, "-r"))
        pdu = pdu_of(command)
        assert pdu[0] == int(function.split()[0])
        if "read" in words:
            assert words == f"{option(command, '-c')} read"
        else:
            assert words.strip("`").split() == command[command.index("/dev/ttyACM0") + 1 :]
    text = PAGE.read_text(encoding="utf-8")
    arm = rtu.RtuRequest(UNIT, pdu_of(asked[6])).frame
    assert f"request 7  {arm.hex(' ').upper()}\n" in text
    assert f"reply      {rtu.seal(arm[:6]).hex(' ').upper()}\n" in text


def test_the_ten_requests_run_a_line(simulator):
    with Bench("mega", hz=30) as bench:
        plc = Plc(bench)
        head = plc.request(1)[1]
        assert (head[0], head[2], head[FAULT]) == (6, 2, 0)
        assert [plc.request(number)[0] for number in (2, 3)] == [0, 0]
        assert plc.load_and_arm() == 0
        states = []

        def done():
            seen = plc.request(8)[1]
            states.append(seen[STATE])
            return seen[STATE] == 5

        bench.until(done, seconds=4)
        assert sorted(set(states)) == [3, 4, 5] and states == sorted(states)
        seen = plc.request(8)[1]
        assert (seen[6:8], seen[10:12], seen[12]) == ((0, 600), (0, 60), 1)
        assert plc.request(9)[0] == 0
        assert plc.request(10)[1][STATE] == 0
        assert plc.load_and_arm() == 1  # it goes on counting
        plc.runs()
        assert plc.request(9)[0] == 0
        bench.sim.wait_s(0.01)
        assert plc.request(10)[1][:3:2] == (0, 2)
        steps = bench.count()
        assert 600 < steps < 1200
        bench.assert_rest()


def test_a_fault_whose_cause_is_still_there(plc):
    plc.load_and_arm()
    plc.runs()
    plc.bench.sim.command(f"pin 0 {ESTOP.port} {ESTOP.bit} 0")
    plc.bench.sim.wait_s(0.01)
    head = plc.request(1)[1]
    assert head[FAULT] == 12 and head[4] & 1 << 4 and plc.axis()[STATE] == 7
    assert plc.request(7)[0] == NOT_NOW
    assert plc.request(5, plc.axis()[NEXT_BLOCK])[0] == REFUSED and not plc.axis()[LINE_ERROR]
    assert plc.recover("fault") == [NOT_NOW]
    plc.bench.sim.command(f"pin 0 {ESTOP.port} {ESTOP.bit} 1")
    plc.bench.sim.wait_s(0.01)
    assert not plc.request(1)[1][4] & 1 << 4
    assert plc.recover("cause still there") == [0]
    assert plc.axis()[STATE] == 0 and plc.axis()[NEXT_BLOCK] == 1
    plc.load_and_arm()
    plc.runs()


def test_a_block_that_is_refused(plc):
    too_fast = write(4096, 0, 0, 33, 0, 0, 0, 16383, 60, 2, 0)
    assert plc.ask(too_fast)[0] == REFUSED
    assert (plc.axis()[STATE], plc.axis()[LINE_ERROR]) == (6, 7)
    assert plc.request(7)[0] == NOT_NOW
    assert plc.recover("line refused") == [0]
    assert (plc.axis()[STATE], plc.axis()[LINE_ERROR]) == (0, 7)  # says nothing any more
    assert plc.request(5, plc.axis()[NEXT_BLOCK] + 7)[0] == REFUSED
    assert plc.axis()[STATE] == 0
    plc.load_and_arm()


def test_a_block_that_was_taken_may_come_again(plc):
    assert plc.request(5, 0)[0] == plc.request(5, 0)[0] == 0
    assert (plc.axis()[STATE], plc.axis()[NEXT_BLOCK]) == (2, 1)
    assert plc.request(5, 3)[0] == REFUSED and plc.axis()[STATE] == 2
    assert [plc.request(number)[0] for number in (2, 3)] == [BUSY, BUSY]
    assert plc.recover("setting") == [0]
    assert [plc.request(number)[0] for number in (2, 3)] == [0, 0]
    assert plc.axis()[NEXT_BLOCK] == 1


def test_arm_wants_a_whole_line(plc):
    assert plc.request(7)[0] == NOT_NOW
    assert plc.ask(write(4096, 0, 0, 33, 0, 0, 0, 10, 60))[0] == 0
    assert plc.axis()[STATE] == 1 and plc.request(7)[0] == NOT_NOW
    assert plc.ask(write(4096, 1, 0, 2, 0))[0] == 0
    assert plc.axis()[STATE] == 2 and plc.request(7)[0] == 0


def test_a_full_queue_is_busy(plc):
    runs = [word for n in range(29) for word in (n % 2 + 5, 1)]
    assert plc.ask(write(4096, 0, 0, 33, 0, 0, 0, *runs))[0] == 0
    assert plc.ask(write(4096, 1, 0, *runs))[0] == 0
    assert plc.ask(write(4096, 2, 0, *runs))[0] == BUSY
    assert plc.axis()[NEXT_BLOCK] == 2


def test_off_a_limit_switch(plc):
    pin = next(
        pin for pin in boards.load("mega").pins if (pin.signal, pin.axis) == ("LIMIT_PLUS", 0)
    )
    plc.load_and_arm()
    plc.runs()
    plc.bench.sim.command(f"pin 0 {pin.port} {pin.bit} 0")
    plc.bench.until(lambda: plc.request(1)[1][FAULT])
    assert plc.request(1)[1][FAULT] == 9 and plc.request(7)[0] == NOT_NOW
    assert plc.recover("limit switch") == [0]
    block = plc.axis()[NEXT_BLOCK]
    assert plc.ask(write(4096, block, 0, 33, 0, 0, 0, 65526, 20, 2, 0))[0] == 0
    assert plc.request(7)[0] == 0
    plc.bench.until(lambda: plc.axis()[STATE] == 5)
    assert plc.request(1)[1][FAULT] == 0


@pytest.mark.usefixtures("simulator", "mbpoll")
def test_the_commands_as_typed():
    """As the page says for a simulated board: no parity, and a long time-out."""
    with on_terminal("mega", 30) as (name, _):

        def call(number):
            words = [name if word == "/dev/ttyACM0" else word for word in commands()[number - 1]]
            words[words.index("even")] = "none"
            done = subprocess.run(
                [words[0], "-o", "10", *words[1:]],
                capture_output=True, text=True, timeout=HANG_S, check=False,
            )  # fmt: skip
            return done.stdout + done.stderr

        def words_of(text):
            return [int(word) for word in re.findall(r"^\[\d+\]:\s+(\d+)", text, re.M)]

        assert words_of(call(1))[FAULT] == 0
        for number in (2, 3):
            assert "Written" in call(number)
        assert words_of(call(4)) == [0]
        assert "Written 10 references" in call(5)
        assert words_of(call(6))[:3:2] == [2, 1]
        assert "Written 2 references" in call(7)
        for _ in range(200):
            seen = words_of(call(8))
            if seen[STATE] == 5:
                break
        assert (regs.AXIS_STATES[seen[STATE]], seen[7], seen[12]) == ("done", 600, 1)
        assert "Written 2 references" in call(9)
        assert words_of(call(10))[STATE] == 0
