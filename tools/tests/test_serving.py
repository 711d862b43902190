# SPDX-License-Identifier: MIT
"""`pixstep serve` as processes: a simulated Mega, the server, consoles that come and are killed.

What is judged is what was on the wire, in simulated cycles, and who was told what; wall-clock time
only guards against hanging.
"""

import csv
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import pytest
from pymodbus.client import ModbusTcpClient

import server_client
from bad_bus import whole
from effort import cases
from every_function import EveryFunction
from pixstep import formats, natives
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import NoReplyError
from pixstep.board.port import Port
from pixstep.server import remote
from serverbench import HANG_S, until

HZ = 16_000_000
BYTE_CYCLES = HZ * 11 // 115_200
SILENCE_CYCLES = 2 * BYTE_CYCLES + HZ * 175 // 100_000
FIRST_STOP = [0, 16, 1, 0, 0, 2, 4, 0, 1, 0, 3]  # of a broadcast: axis 0, which every board has
MOST_MS = 20
STREAM_HZ = 2000
QUEUE_S = 3.2  # of a stream of 200 Hz in the queue of a Mega: a longer stall would end the line
CLIENT = Path(server_client.__file__)


class Process(subprocess.Popen):
    """A program of Python whose lines are read as they come."""

    def __init__(self, *words, **options):
        super().__init__([sys.executable, *map(str, words)], stdout=subprocess.PIPE, text=True,
                         **options)  # fmt: skip

    def line(self, holds=lambda _: True):
        """Return the next line that is wanted."""
        for text in self.stdout:
            if holds(text):
                return text
        raise AssertionError(f"ended before that: {self.stderr and self.stderr.read()}")

    def end(self, number=signal.SIGTERM):
        """End the program and return its status and all that it has still written."""
        self.send_signal(number)
        out, _ = self.communicate(timeout=HANG_S)
        return self.returncode, out


class Shop:
    """A simulated board on a terminal, and its server."""

    def __init__(self, folder, *more, pixel_hz=100):
        self.folder = folder
        self.simulator = subprocess.Popen(
            [
                natives.program("pixstep-sim"), "--board", f"mega={natives.image('mega')}",
                "--pixel-hz", str(pixel_hz), "--serial-log", folder / "serial.csv",
                "--edges", folder / "edges.csv", "--pty",
            ],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.port = self.simulator.stdout.readline().strip()
        self.more, self.clients = more, []
        self.start()

    def start(self):
        """Start the server."""
        self.server = Process(
            "-m", "pixstep", "serve", "--port", self.port, "--json", *self.more,
            stderr=subprocess.PIPE,
        )  # fmt: skip
        self.serving = json.loads(self.server.line())
        while self.serving["event"] == "connected":  # a client that waited for a server was quicker
            self.serving = json.loads(self.server.line())
        assert self.serving["event"] == "serving", self.serving

    def client(self, what, *more):
        """Return another process that has begun."""
        process = Process(CLIENT, what, self.port, *more)
        self.clients.append(process)
        assert process.line() == "begun\n"
        return process

    def console(self, *words, port=None, **options):
        """Return a console that runs."""
        environment = os.environ | {"PIXSTEP_PORT": port or self.port}
        return Process("-m", "pixstep", *words, stderr=subprocess.PIPE, env=environment, **options)

    def run(self, *words, status=0, **options):
        """Run a console to its end; return its output and errors."""
        process = self.console(*words, **options)
        out, errors = process.communicate(timeout=HANG_S)
        assert process.returncode == status, (process.returncode, out, errors)
        assert "Traceback" not in errors
        return out, errors

    def board(self):
        return remote.find(Port(self.port)), 1

    def rows(self):
        """End the server and return what it has told."""
        status, out = self.server.end()
        assert status == 143, self.server.returncode
        return [json.loads(text) for text in out.splitlines()]

    def close(self):
        for process in (self.server, self.simulator, *self.clients):
            if process.poll() is None:
                process.kill()
            process.communicate()


@pytest.fixture
def shop(simulator, runtime, tmp_path, request):
    """Yield a board and its server; the board goes on alone. A test may ask for a pixel clock."""
    hz = getattr(request, "param", 100)
    made = Shop(tmp_path, pixel_hz=hz)
    made.run("board", "set", "bus_timeout_ms=0", f"pixel_hz={hz}")
    yield made
    made.close()


class Frame(NamedTuple):
    """A request or a reply on the wire, in cycles."""

    sent: bool  # by the board
    start: int
    end: int
    data: list


def wire(path):
    """Return the frames on the wire in their order."""
    frames, heard, starts = [], b"", []
    with path.open() as file:
        for row in csv.DictReader(file):
            cycle, byte = int(row["cycle"]), int(row["byte"], 16)
            if row["direction"] == "tx":
                if frames and frames[-1].sent and cycle - frames[-1].end < BYTE_CYCLES:
                    frames[-1] = frames[-1]._replace(
                        end=cycle + BYTE_CYCLES, data=[*frames[-1].data, byte]
                    )
                else:
                    frames.append(Frame(True, cycle, cycle + BYTE_CYCLES, [byte]))
                continue
            if (
                starts and cycle - starts[-1] > SILENCE_CYCLES
            ):  # the rest of a frame that met a reply
                heard, starts = b"", []
            heard += bytes([byte])
            starts.append(cycle - BYTE_CYCLES)
            while size := whole(heard):
                frames.append(Frame(False, starts[0], cycle, list(heard[:size])))
                heard, starts = heard[size:], starts[size:]
    return frames


def patiently(ask):
    """Return what a board says, asked again if this computer was too busy to simulate it."""
    for last in (False, False, False, True):
        try:
            return ask()
        except NoReplyError:
            if last:
                raise
    return None


def seen(board, register):
    """Return a register of axis 0; 0 if a look beside a stream, made once, met no reply."""
    try:
        return board.axis(0)[register]
    except NoReplyError:
        return 0


def state_of(board):
    """Return the state of axis 0."""
    return regs.axis_state(patiently(lambda: board.axis(0))["axis_state"])


def is_arm(frame):
    """True for a request to arm axes of board 1."""
    return not frame.sent and frame.data[:4] == [1, 16, 1, 0] and frame.data[9:11] == [0, 1]


def edges(path):
    """Return the cycles of all STEP edges."""
    with path.open() as file:
        return [int(row["cycle"]) for row in csv.DictReader(file) if row["signal"] == "STEP"]


@pytest.mark.parametrize("shop", [STREAM_HZ], indirect=True)
def test_a_stop_is_the_next_frame_while_another_client_streams_at_2_khz(shop):
    """A third one reads without pause. What a stop may wait for was on the wire when it came."""
    rng = random.Random(7)
    streamer, reader = shop.client("stream", STREAM_HZ), shop.client("read")
    stopper = Device(remote.find(Port(shop.port)))
    stops = cases(8, 100)
    for number in range(stops):
        streamer.line(lambda text: text == "running\n")
        time.sleep(0.3 + 0.3 * rng.random())
        if number == 0:
            shop.run("board", "stop", "--no-look")
        else:
            stopper.stop_all()
    cut_short = stopper.modbus.status()["bus"]["cut_short"]
    for process in (streamer, reader):
        process.end(signal.SIGKILL)
    rows = [row for row in shop.rows() if row["event"] == "stop" and row["unit"] == 0]
    shop.simulator.terminate()
    shop.simulator.wait(timeout=HANG_S)
    kinds = len(set(regs.AXIS_COUNTS))
    assert len(rows) >= stops * kinds
    frames = wire(shop.folder / "serial.csv")
    at = [i for i, frame in enumerate(frames) if frame.data[: len(FIRST_STOP)] == FIRST_STOP]
    made = edges(shop.folder / "edges.csv")
    waits_ms, gaps_ms, late_ms, again = [], [], [], 0
    for place, end in zip(at, [*at[1:], len(frames)], strict=True):
        request = next(i for i in range(place - 1, -1, -1) if not frames[i].sent)
        stop = frames[place]
        waits_ms.append(1000 * (frames[place - 1].end - frames[request].start) / HZ)
        gaps_ms.append(1000 * (stop.start - frames[place - 1].end) / HZ)
        arms = [one.start for one in frames[place:end] if is_arm(one)]
        if not arms and end < len(frames):
            again += 1  # after a request without a reply: the stop that counts is the next one
            continue
        until_cycle = min(arms, default=math.inf)
        after = [cycle for cycle in made if stop.end < cycle < until_cycle]
        late_ms.append(1000 * (max(after, default=stop.end) - stop.end) / HZ)
    print(
        f"{len(at)} stops, {again} of them again: on the wire before each "
        f"{min(waits_ms):.1f} to {max(waits_ms):.1f} ms, "
        f"then {min(gaps_ms):.1f} to {max(gaps_ms):.1f} ms of this computer's time; by the server "
        f"{max(row['ms'] for row in rows):.1f} ms; the last edge {max(late_ms):.2f} ms after it"
    )
    assert [row["frames_between"] for row in rows[::kinds]] == [0] * len(rows[::kinds])
    assert max(waits_ms) < MOST_MS
    assert again <= cut_short  # on a computer that is too busy to simulate a board in time
    assert max(late_ms) < 6  # the board's round, and one step


@pytest.mark.parametrize("shop", [200], indirect=True)
def test_clients_that_are_killed_stall_nobody_and_no_line(shop):
    """One streams; others are killed at any moment, while they read or ask to write."""
    rng = random.Random(11)
    streamer = shop.client("stream", 200)
    streamer.line(lambda text: text == "running\n")
    board = Device(remote.find(Port(shop.port)))
    pixel, longest_s = patiently(lambda: board.axis(0))["pixel"], 0.0
    for _ in range(cases(10, 200)):
        victim = shop.client(rng.choice(("read", "wish")))
        time.sleep(0.2 * rng.random())
        victim.end(signal.SIGKILL)
        begun_s = time.monotonic()
        assert patiently(board.fault_name) == ""
        longest_s = max(longest_s, time.monotonic() - begun_s)
    print(f"{cases(10, 200)} clients killed: the longest answer afterwards took {longest_s:.2f} s")
    state = patiently(lambda: board.axis(0))
    assert (state["lines_done"], state["pixel"]) > (0, pixel)
    assert longest_s < QUEUE_S
    assert patiently(board.fault_name) == ""
    streamer.end(signal.SIGKILL)
    until(lambda: state_of(board) == "empty", "at rest")
    rows = shop.rows()
    assert [row["why"] for row in rows if row["event"] == "stopped"] == ["its client died"]
    assert not [row for row in rows if row["event"] == "NOT STOPPED"]


def test_the_line_of_a_client_that_is_killed_is_stopped(shop):
    """At any moment: while it asks, queues, or follows. The next one writes at once."""
    rng = random.Random(13)
    board = Device(remote.find(Port(shop.port)))
    for _ in range(cases(4, 60)):
        streamer = shop.client("stream", 100)
        if rng.random() < 0.7:
            streamer.line(lambda text: text == "running\n")
        time.sleep(0.3 * rng.random())
        streamer.end(signal.SIGKILL)
        until(lambda: state_of(board) in ("empty", "done"), "at rest")
        assert patiently(board.fault_name) == ""
    assert not [row for row in shop.rows() if row["event"] == "NOT STOPPED"]


def test_a_second_console_that_writes_is_refused_by_name(shop):
    streamer = shop.client("stream", 100)
    _, errors = shop.run("board", "set", "idle_off_ms=5", status=3)
    assert re.fullmatch(
        rf"pixstep: {shop.port}: not sent: server_client.py stream {shop.port} 100 \(pid "
        rf"{streamer.pid}\) has the right to write since \d\d:\d\d:\d\d\n",
        errors,
    )
    out, _ = shop.run("serve", "--status")
    assert f"writes: server_client.py stream {shop.port} 100 (pid {streamer.pid})\n" in out.replace(
        "; requests", "\nrequests"
    )
    assert "lines on 1.0" in out
    found = json.loads(shop.run("serve", "--status", "--json")[0])
    assert found["writer"].endswith(f"(pid {streamer.pid})") and found["bus"]["no_replies"] == 0
    streamer.end(signal.SIGKILL)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_server_that_ends_is_one_line_to_its_clients(shop, number):
    formats.write_csv(shop.folder / "long.csv", [9] * 60_000)
    words = ("board", "upload", shop.folder / "long.csv", "--decode", "plain", "--arm")
    runner = shop.console(*words)
    board = Device(remote.find(Port(shop.port)))
    until(lambda: regs.axis_state(seen(board, "axis_state")) == "running", "the line")
    watcher = shop.console("board", "watch", "--interval", "0.1s", "--json")
    watcher.line()
    pid = shop.server.pid
    status, _ = shop.server.end(number)
    assert status == (143 if number == signal.SIGTERM else -number)
    _, errors = runner.communicate(timeout=HANG_S)
    assert runner.returncode == 1 and errors.count("\n") == 1, errors
    assert f"the server of {shop.port} (pid {pid}) is gone: it has ended" in errors
    row = watcher.line(lambda text: "trouble" in text)
    assert f"the server of {shop.port} (pid {pid}) is gone" in row or "no server" in row
    shop.start()  # a socket that was left behind is no hindrance
    watcher.line(lambda text: "trouble" not in text)  # it goes on by itself
    watcher.end(signal.SIGINT)
    out, _ = shop.run("board", "stop")
    assert "at rest" in out


def test_a_stop_goes_beside_a_server_that_hangs(shop):
    formats.write_csv(shop.folder / "long.csv", [9] * 60_000)
    words = ("board", "upload", shop.folder / "long.csv", "--decode", "plain", "--arm", "--no-wait")
    shop.run(*words)
    shop.server.send_signal(signal.SIGSTOP)
    out, _ = shop.run("board", "stop", "--no-look")
    assert out == f"{shop.port}: in use by another program: stop sent to all boards beside it\n"
    _, errors = shop.run("board", "info", status=2)
    assert errors == f"pixstep: the server of {shop.port} is gone: it does not answer\n"
    shop.server.send_signal(signal.SIGCONT)
    assert state_of(Device(remote.find(Port(shop.port)))) == "empty"


def test_ctrl_c_in_a_console_stops_its_axes(shop):
    formats.write_csv(shop.folder / "long.csv", ([9] * 8 + [11] * 8) * 2000)  # streamed
    words = ("board", "upload", shop.folder / "long.csv", "--decode", "plain", "--arm")
    runner = shop.console(*words)
    board = Device(remote.find(Port(shop.port)))
    until(lambda: seen(board, "pixel") > 20, "the line")
    runner.send_signal(signal.SIGINT)
    _, errors = runner.communicate(timeout=HANG_S)
    assert runner.returncode == 130
    assert re.search(r"^pixstep: stopped by Ctrl-C: board 1 axis 0 at position \d+$", errors, re.M)
    assert state_of(board) == "empty"
    assert not [row for row in shop.rows() if row["event"] == "stopped"]


def test_a_line_without_wait_goes_on_after_its_console(shop):
    formats.write_csv(shop.folder / "long.csv", [9] * 60_000)
    words = ("board", "upload", shop.folder / "long.csv", "--decode", "plain", "--arm", "--no-wait")
    shop.run(*words)
    board = Device(remote.find(Port(shop.port)))
    until(lambda: seen(board, "pixel") > 200, "the line goes on")
    out, _ = shop.run("board", "stop")
    assert "axis 0 at position" in out
    assert not [row for row in shop.rows() if row["event"] == "stopped"]


def test_modbus_tcp_by_pymodbus_and_mbpoll(simulator, runtime, tmp_path, mbpoll):
    shop = Shop(tmp_path, "--modbus-tcp", "0")
    number = int(json.loads(shop.server.line())["modbus_tcp"].rpartition(":")[2])
    try:
        with ModbusTcpClient("127.0.0.1", port=number, timeout=60, retries=0) as plc:
            board = EveryFunction(remote.find(Port(shop.port)))
            head = plc.read_input_registers(0, count=4, device_id=1).registers
            assert head == board.read_inputs(0, 4)
            assert plc.read_holding_registers(0, count=20, device_id=1).registers == (
                board.read_holdings(0, 20)
            )
            assert plc.read_coils(0, count=14, device_id=1).bits[:14] == board.read_coils(0, 14)
            found = plc.read_device_information(read_code=1, device_id=1)
            assert found.information[0] == b"pixstep"
            assert plc.read_input_registers(0x7000, count=1, device_id=1).exception_code == 2
            for refused in (
                plc.write_register(6, 25, device_id=1),
                plc.write_registers(2, [0, 30], device_id=1),
                plc.write_coil(0, True, device_id=1),
                plc.write_registers(0x100, [1, regs.COMMANDS["permit_on"]], device_id=1),
                plc.mask_write_register(address=6, and_mask=0, or_mask=25, device_id=1),
            ):
                assert refused.isError() and refused.exception_code == 1
            assert board.setting("dir_setup_us") != 25
            stop = plc.write_registers(0x100, [15, regs.COMMANDS["stop"]], device_id=1)
            assert not stop.isError()
        words = ["mbpoll", "-m", "tcp", "-p", str(number), "-a", "1", "-1"]

        def poll(*more):
            done = subprocess.run([*words, *more], capture_output=True, text=True, timeout=HANG_S)
            return done.stdout + done.stderr

        text = poll("-t", "3", "-r", "1", "-c", "4", "127.0.0.1")
        found = re.findall(r"^\[\d\]:\s+(\d+)", text, re.M)
        assert [int(word) for word in found] == head, text
        assert "Illegal function" in poll("-t", "4", "-r", "7", "127.0.0.1", "25")
        with ModbusTcpClient("127.0.0.1", port=number, timeout=60, retries=0) as plc:
            assert plc.read_input_registers(0, count=1, device_id=9).exception_code == 11
            assert plc.read_input_registers(0, count=1, device_id=0).exception_code == 11
    finally:
        shop.close()


def test_modbus_tcp_writes_where_it_may_and_one_at_a_time(simulator, runtime, tmp_path):
    shop = Shop(tmp_path, "--modbus-tcp", "127.0.0.1:0", "--allow-writes")
    number = int(json.loads(shop.server.line())["modbus_tcp"].rpartition(":")[2])
    try:
        board = Device(remote.find(Port(shop.port)))
        board.write_setting("dir_hold_us", 31)
        with ModbusTcpClient("127.0.0.1", port=number, timeout=60, retries=0) as plc:
            assert plc.write_register(6, 25, device_id=1).exception_code == 6  # the console writes
            board.modbus.close()
            until(lambda: not plc.write_register(6, 25, device_id=1).isError(), "its turn")
            assert plc.read_holding_registers(6, count=1, device_id=1).registers == [25]
            _, errors = shop.run("board", "set", "dir_hold_us=32", status=3)
            assert re.search(r"not sent: 127\.0\.0\.1:\d+ has the right to write since", errors)
            plc.write_registers(0x100, [1, regs.COMMANDS["mark"]], device_id=0)  # to all
        shop.run("board", "set", "dir_hold_us=32")
    finally:
        shop.close()


def test_tcp_with_a_token(simulator, runtime, tmp_path, monkeypatch):
    file = tmp_path / "token"
    shop = Shop(tmp_path, "--tcp", "127.0.0.1:0", "--token-file", file)
    try:
        place = json.loads(shop.server.line())["tcp"]
        assert file.stat().st_mode & 0o777 == 0o600
        _, errors = shop.run("board", "info", status=2, port=place)
        assert errors == f"pixstep: {place}: its server: the token is not this server's\n"
        monkeypatch.setenv(remote.TOKEN, file.read_text().strip())
        out, _ = shop.run("board", "info", port=place)
        assert out.startswith("board 1: mega")
        assert file.read_text().strip() not in str(shop.rows())
    finally:
        shop.close()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--tcp", "0.0.0.0:7420"), "--tcp 0.0.0.0: on the loopback alone: 127.0.0.1 or localhost"),
        (("--tcp", "70000"), "a number from 0 to 65535 is wanted, as in 7420 or 127.0.0.1:7420"),
        (("--token-file", "x"), "--token-file: the token is for --tcp: add it"),
        (("--allow-writes",), "--allow-writes: it is about Modbus TCP: add --modbus-tcp"),
        (("--status",), "/dev/null: no server runs (`pixstep serve --port /dev/null`)"),
        ((), "/dev/null: not a serial port"),
    ],
)
def test_a_wrong_command_is_one_line(invoke, runtime, words, said):
    errors = invoke("serve", "--port", "/dev/null", *words, status=2).stderr
    assert errors.count("\n") == 1 and errors.startswith("pixstep: ") and said in errors
