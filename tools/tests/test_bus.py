# SPDX-License-Identifier: MIT
"""The real images on a line of bytes: gaps, other boards, hurried masters, rates and parities."""

import pytest

from bench import Bench
from effort import TRIED_BOARDS
from pixstep import natives
from pixstep.board import boards
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.logs import read_edges
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from pixstep_trials import wire

pytestmark = pytest.mark.usefixtures("simulator")

BOARDS = TRIED_BOARDS
# Whose default images serve function 8, and whose do not.
DIAGNOSING = [board.name for board in boards.all_boards() if board.all_features]
OTHERS = sorted(set(BOARDS) - set(DIAGNOSING))
AXES = {board.name: board.axes for board in boards.all_boards()}
UNIT, OTHER, ALL = 1, 9, 0
SETUP_US, BAUD_100, PARITY, REPLY_DELAY_US = 0x0006, 0x0001, 0x000D, 0x000E
AXIS_COUNT, STATUS, FRAMES_OK, CRC_ERRORS, RX_OVERRUNS = 0x0003, 0x0004, 0x0010, 0x0011, 0x0013
BUS_MESSAGES, NO_REPLIES = 0x0064, 0x0065
QUEUE = 0x1000
FAULT_CODE, RESET_CAUSE = 0x0005, 0x000B
# None, decoder late, clock missing, clock edge lost, clock edge placed late.
FOR_LACK_OF_TIME = (0, 2, 4, 7, 18)
LISTEN_ONLY = 0x0040
PARITIES = "NOE"
RATES = [(9600, "N"), (19200, "E"), (115_200, "O"), (250_000, "E"), (1_000_000, "N")]
SILENCE_US = 1750  # above 19200 baud


def possible(tick_hz, baud):
    """Whether a board's clock makes a rate within 2.5 %."""
    divisor = max(1, round(tick_hz / 8 / baud))
    return abs(tick_hz / 8 / divisor / baud - 1) <= 0.025


def fast(tick_hz, baud):
    """Return a rate, or the fastest of RATES below that the board's clock makes."""
    return baud if possible(tick_hz, baud) else 500_000


def frame(*parts):
    """Return bytes and 16-bit words (given as tuples) with their checksum."""
    data = b"".join(
        bytes([part]) if isinstance(part, int) else b"".join(w.to_bytes(2) for w in part)
        for part in parts
    )
    return wire.seal(data)


def read_input(address, unit=UNIT, count=1):
    return frame(unit, 4, (address, count))


def write_one(address, value, unit=UNIT):
    return frame(unit, 6, (address, value))


def odd_block():
    """Return the longest request of the data's functions: a block for the queue, refused as odd."""
    return frame(UNIT, 16, (QUEUE, 123), 246, range(123))


class Master:
    """A simulated board and the master of its line, byte for byte."""

    def __init__(self, sim, board):
        self.sim = sim
        self.diagnoses = board in DIAGNOSING
        self.baud = 115_200
        self.lost = 0  # requests under load that stayed without a reply

    def send(self, data, pause_us=0):
        """Send bytes behind what is under way, then pause; time stands still."""
        self.sim.command(f"send {data.hex()} {pause_us}")

    def ask(self, request):
        """Send a request and return the reply's bytes without address and checksum."""
        reply = self.sim.transmit(request)
        if reply:
            assert wire.crc16(reply) == 0, reply.hex()
        return reply[1:-2]

    def input(self, address):
        return int.from_bytes(self.ask(read_input(address))[2:])

    def holding(self, address):
        return int.from_bytes(self.ask(frame(UNIT, 3, (address, 1)))[2:])

    def long_request(self):
        """Return a long request that changes nothing: a loopback where the board has that."""
        return frame(UNIT, 8, (0, *range(120))) if self.diagnoses else odd_block()

    def rest(self, us=20_000):
        self.sim.run(us * self.sim.tick_hz // 1_000_000)

    def at(self, baud, parity):
        """Turn to another rate and parity."""
        self.sim.command(f"baud {baud} {parity}")

    def change(self, baud, parity):
        """Have the board change its line, and follow it."""
        assert self.ask(write_one(PARITY, PARITIES.index(parity)))
        self.rest()
        self.at(self.baud, parity)
        baud = fast(self.sim.tick_hz, baud)
        assert self.ask(write_one(BAUD_100, baud // 100))
        self.rest()
        self.at(baud, parity)
        self.baud = baud


@pytest.fixture(params=BOARDS)
def master(request):
    """Return the master of a board that has just started."""
    options = SimOptions([(request.param, natives.image(request.param))], 100)
    with SimLink(options) as link:
        yield Master(link.simulator, request.param)


def axis_count(master):
    return master.ask(read_input(AXIS_COUNT))


def send_with_gaps(master, data, gap_us):
    for byte in data[:-1]:
        master.send(bytes([byte]), gap_us)
    return master.ask(data[-1:])


# Just below the silence of 3.5 characters; the board's resolution is 16 us, 64 us at 9600 baud.
@pytest.mark.parametrize(
    ("baud", "parity", "below_us", "above_us"),
    [
        (115_200, "E", 1700, 1770),
        (1_000_000, "E", 1720, 1770),
        (19_200, "E", 1960, 2040),
        (9600, "N", 3930, 4060),
    ],
)
def test_a_gap_within_a_frame_ends_it_from_the_standards_silence_on(
    master, baud, parity, below_us, above_us
):
    master.change(baud, parity)
    assert send_with_gaps(master, read_input(AXIS_COUNT), below_us)
    errors = master.input(CRC_ERRORS)
    request = read_input(AXIS_COUNT)
    master.send(request[:3], above_us)
    assert master.ask(request[3:]) == b""
    assert master.input(CRC_ERRORS) == errors + 2


def test_a_whole_request_behind_a_cut_one_and_a_silence_is_answered(master):
    master.send(read_input(AXIS_COUNT)[:5], SILENCE_US + 50)
    assert axis_count(master)


@pytest.mark.parametrize(("baud", "parity"), RATES)
def test_request_at_once_behind_broadcasts(master, baud, parity):
    master.change(baud, parity)
    before = master.input(NO_REPLIES)
    for value in range(31, 41):
        master.send(write_one(SETUP_US, value, ALL))
    assert master.holding(SETUP_US) == 40
    assert master.input(NO_REPLIES) == before + 10


def test_requests_and_replies_of_others_without_a_silence(master):
    before = master.input(BUS_MESSAGES)
    foreign = [
        frame(OTHER, 3, (0, 2)),
        frame(OTHER, 3, 4, (UNIT << 8 | 3, 0)),
        frame(OTHER, 6, (6, 50)),
        frame(OTHER, 6, (6, 50)),
        frame(OTHER, 0x83, 2),
        frame(OTHER, 1, (0, 9)),
        frame(OTHER, 1, 2, (0x0101,)),
        frame(OTHER, 17),
        frame(OTHER, 17, 4, (0x01FF, 0x4142)),
        frame(OTHER, 16, (0, 2), 4, (1, 2)),
        frame(OTHER, 16, (0, 2)),
        frame(OTHER, 4, 200, (0x0106,) * 100),
    ]
    for one in foreign:
        master.send(one)
    assert axis_count(master)
    assert master.input(CRC_ERRORS) == 0
    # Those, the request behind them and the two just now.
    assert master.input(BUS_MESSAGES) == before + len(foreign) + 3


def test_a_foreign_reply_executes_nothing(master):
    before = master.holding(SETUP_US)
    carried = write_one(SETUP_US, 77)
    reply = bytes([OTHER, 3, len(carried)]) + carried
    master.send(wire.seal(reply))
    assert master.holding(SETUP_US) == before


def test_unknown_frames_are_over_with_silence(master):
    master.send(frame(OTHER, 65, (1, 2, 3)), SILENCE_US + 50)
    assert axis_count(master)
    master.send(bytes([0x55, 0xAA, 0x00]), SILENCE_US + 50)
    assert axis_count(master)
    assert master.input(CRC_ERRORS) == 1


def test_damaged_requests_are_not_answered(master):
    request = read_input(AXIS_COUNT)
    for at in range(len(request)):
        assert master.ask(request[:at] + bytes([request[at] ^ 0x20]) + request[at + 1 :]) == b""
        master.rest(3000)
    assert master.input(CRC_ERRORS) == len(request)
    assert axis_count(master)


def test_broadcast_reads_are_ignored_and_counted(master):
    before = master.input(NO_REPLIES)
    for function in (1, 2, 3, 4):
        assert master.ask(frame(ALL, function, (0, 1))) == b""
    assert master.ask(frame(ALL, 17)) == b""
    assert master.ask(frame(ALL, 43, 14, 1, 0)) == b""
    assert master.input(NO_REPLIES) == before + 6
    assert master.input(CRC_ERRORS) == 0


@pytest.mark.parametrize("master", DIAGNOSING, indirect=True)
def test_listen_only_until_restart(master):
    setup = master.holding(SETUP_US)
    assert master.ask(frame(UNIT, 8, (4, 0))) == b""
    assert axis_count(master) == b""
    assert master.ask(write_one(SETUP_US, setup + 1)) == b""
    master.ask(write_one(SETUP_US, setup + 1, ALL))
    assert master.ask(frame(UNIT, 8, (1, 0xFF00))) == b""
    assert not master.input(STATUS) & LISTEN_ONLY
    assert master.holding(SETUP_US) == setup
    assert master.ask(frame(UNIT, 8, (1, 0))) == bytes([8, 0, 1, 0, 0])
    assert master.input(FRAMES_OK) <= 1


@pytest.mark.parametrize("master", OTHERS, indirect=True)
def test_without_diagnosis_there_is_no_listen_only(master):
    assert master.ask(frame(UNIT, 8, (4, 0))) == bytes([0x88, 1])
    assert master.ask(frame(UNIT, 8, (1, 0))) == bytes([0x88, 1])
    assert not master.input(STATUS) & LISTEN_ONLY
    assert axis_count(master)


def test_what_follows_a_request_is_nobodys(master):
    before = master.holding(SETUP_US)
    master.send(read_input(AXIS_COUNT))
    reply = master.ask(write_one(SETUP_US, before + 1, ALL))
    assert reply[:3] == bytes([4, 2, 0])
    assert master.holding(SETUP_US) == before


@pytest.mark.parametrize(("baud", "parity"), RATES)
def test_longest_frames_at_every_rate(master, baud, parity):
    master.change(baud, parity)
    data = bytes(range(250))
    request = frame(UNIT, 8, (0,))[:-2] + data
    request = wire.seal(request)
    assert len(request) == 254 + 2
    reply = request[1:-2] if master.diagnoses else bytes([0x88, 1])
    for _ in range(3):
        assert master.ask(request) == reply
        assert master.ask(odd_block()) == bytes([0x90, 3])
        assert len(master.ask(read_input(0x0100, count=125))) == 2 + 250
    assert master.input(RX_OVERRUNS) == 0
    assert master.input(CRC_ERRORS) == 0


def test_other_rate_or_parity_is_not_understood(master):
    master.change(250_000, "O")
    for baud, parity in ((250_000, "E"), (115_200, "O"), (115_200, "E")):
        master.at(baud, parity)
        assert axis_count(master) == b""
        master.rest()
    master.at(250_000, "O")
    assert axis_count(master)


def test_bytes_that_nobody_took_in_time_are_counted(master):
    """The receiver keeps two characters and the one that comes in; the next start bit ends that."""
    character = 11 * master.sim.tick_hz // master.baud
    for times in range(1, 4):
        master.sim.command("hang 0 interrupts")
        master.send(bytes(6))
        master.sim.run(7 * character)
        master.sim.command("hang 0 off")
        master.rest()
        assert master.input(RX_OVERRUNS) == times


def test_impossible_rates_are_refused(master):
    for baud_100 in (95, 2304, 9216, 10_000, 10_001):
        if 96 <= baud_100 <= 10_000 and possible(master.sim.tick_hz, 100 * baud_100):
            continue
        assert master.ask(write_one(BAUD_100, baud_100)) == bytes([0x86, 3])
    assert master.ask(write_one(PARITY, 3)) == bytes([0x86, 3])
    assert axis_count(master)


def test_reply_waits_for_the_silence_and_its_delay(master):
    for delay_us in (0, 5000, 20_000):
        assert master.ask(write_one(REPLY_DELAY_US, delay_us))
        begin = master.sim.cycle
        reply = master.sim.transmit(read_input(AXIS_COUNT))
        # Request, silence, delay, reply, and the silence that the simulator waits for.
        took_us = (master.sim.cycle - begin) * 1e6 / master.sim.tick_hz
        line_us = (8 + len(reply)) * 11e6 / 115_200
        waited_us = took_us - line_us - SILENCE_US
        # Two rounds, building and sealing: at most 557 us on the mega, over many phases.
        assert SILENCE_US + delay_us <= waited_us <= SILENCE_US + delay_us + 600


def steps_of(board, folder, load, baud, percent):
    """Run a line on every axis of a board while `load` has the serial line of that rate.

    Returns each axis's STEP edges, its direction's levels, the last states and what was lost.
    """
    axes = range(AXES[board])
    path = folder / f"{load.__name__}.csv"
    counts = (5, 40, 120, 200, 200, 200, 120, 30, 0, -30, -200, -7, 0, 3, 3)
    line = Line(tuple(int(count * percent / 100) for count in counts), PLAIN)
    with Bench(board, axes, hz=100, edges=path) as bench:
        master = Master(bench.sim, board)
        master.change(baud, "E")
        for axis in axes:
            bench.load(line, axis)
        bench.arm()
        end = bench.sim.cycle + bench.sim.tick_hz // 4
        while bench.sim.cycle < end:
            load(master)
        bench.sim.run(max(0, end + bench.sim.tick_hz // 8 - bench.sim.cycle))
        states = [bench.state(axis) for axis in axes]
        overruns = master.input(RX_OVERRUNS)
        bench.sim.command("flush")
    edges = [read_edges(path).axis(0, axis) for axis in axes]
    made = [(e.step_cycles.tolist(), e.direction_levels.tolist()) for e in edges]
    return made, states, overruns + master.lost


def quiet(master):
    master.sim.wait_s(0.01)


def requests(master):
    master.lost += not master.ask(read_input(0x0100, count=100))
    master.lost += not master.ask(master.long_request())


def others(master):
    """Bytes without a silence: what other boards and their master say."""
    for _ in range(8):
        master.send(frame(OTHER, 4, (0, 125)))
        master.send(frame(OTHER, 4, 250, range(125)))
    master.sim.run(8 * 263 * 11 * master.sim.tick_hz // master.baud)


# At 1,000,000 baud bytes without any silence leave the mega a fifth of its time: there the axes
# are slower. Where an axis turns, the receiver may wait for more than its two characters and the
# shift register, which the next start bit runs over: 368 cycles; four that turn at once, each a
# command of 360 cycles, for more than the 1470 at 250,000 baud. Whether a byte comes just then is
# chance: of 40 phases of the requests one or two meet it.
@pytest.mark.parametrize(
    ("board", "load", "baud", "percent", "lost_most"),
    [
        ("uno", requests, 1_000_000, 100, 5),
        ("uno", others, 1_000_000, 100, 5),
        ("uno", requests, 250_000, 100, 0),
        ("uno", others, 250_000, 100, 0),
        ("mega", requests, 1_000_000, 100, 5),
        ("mega", requests, 250_000, 100, 0),
        ("mega", requests, 115_200, 100, 0),
        ("mega", others, 250_000, 100, 2),
        ("mega", others, 115_200, 100, 0),
        ("mega", others, 1_000_000, 25, 10),
        ("m1284", requests, 1_000_000, 100, 5),
        ("m1284", others, 250_000, 100, 0),
    ],
)
def test_a_saturated_line_moves_no_edge(tmp_path, board, load, baud, percent, lost_most):
    made, states, lost = steps_of(board, tmp_path, load, baud, percent)
    assert states == ["done"] * AXES[board]
    assert lost <= lost_most
    assert all(len(steps) > 100 for steps, _ in made)
    assert made == steps_of(board, tmp_path, quiet, baud, percent)[0]


@pytest.mark.parametrize("board", BOARDS)
def test_broadcasts_faster_than_they_are_served_reset_nothing(board):
    with Bench(board) as bench:
        master = Master(bench.sim, board)
        master.change(1_000_000, "N")
        for turn in range(3000):
            master.send(write_one(SETUP_US, 1 + turn % 1000, ALL))
        bench.sim.wait_s(1)
        assert master.input(FAULT_CODE) == 0
        assert master.input(RESET_CAUSE) == 1
        assert master.input(CRC_ERRORS) + master.input(NO_REPLIES) > 10


def run_beside(bench, count, load):
    """Run all axes at `count` steps a pixel, with traffic at 1,000,000 baud; return its master."""
    master = Master(bench.sim, bench.name)
    master.change(1_000_000, "N")
    for axis in bench.axes:
        bench.load(Line((count,) * 60, PLAIN), axis)
    bench.arm()
    bench.run_until_steps(4 * count)
    for _ in range(4):
        if load is others:
            others(master)
        else:
            bench.sim.transmit(master.long_request())
    bench.sim.wait_s(1)
    return master


# A byte takes less time than its interrupt here: the step interrupts have two thirds of it all.
@pytest.mark.parametrize(("board", "count"), [("uno", 2285), ("mega", 400), ("m1284", 900)])
@pytest.mark.parametrize("load", [requests, others])
def test_serial_interrupts_slower_than_the_line_do_not_pile_up(board, count, load):
    with Bench(board, range(AXES[board]), hz=100) as bench:
        master = run_beside(bench, count, load)
        assert master.input(RESET_CAUSE) == 1  # power-on
        assert master.input(FAULT_CODE) in FOR_LACK_OF_TIME
        # Handlers that piled up would take some 20 bytes each, and as many as bytes come.
        assert bench.sim.stats()["boards"][0]["stack_free_bytes"] > 150
        bench.assert_rest()


# The receive interrupt alone takes two thirds of the time, the step interrupts nearly half: until
# the request is over the main loop stands still, for longer than a byte of the coarse clock counts.
@pytest.mark.parametrize("count", [387, 398, 400, 417, 420, 443, 448, 471, 477, 504])
def test_a_main_loop_that_stood_still_accuses_no_axis_of_an_underrun(count):
    with Bench("mega", range(AXES["mega"]), hz=100) as bench:
        master = run_beside(bench, count, requests)
        assert master.input(FAULT_CODE) in FOR_LACK_OF_TIME
        assert all(bench.board.axis(axis)["underruns"] == 0 for axis in bench.axes)
        bench.assert_rest()
