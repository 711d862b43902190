# SPDX-License-Identifier: MIT
"""The server of a bus: who may write, what goes first, and what it does when a client dies."""

import json
import os
import random
import socket
import struct
import sys
import threading
import time
from collections import Counter

import pytest
from pymodbus.client import ModbusTcpClient

from bad_bus import Terminal
from pixstep.board import registers as regs
from pixstep.board import run
from pixstep.board.device import Device
from pixstep.board.errors import BusTakenError, OvertakenError
from pixstep.board.link import WallClock
from pixstep.board.port import Port, PortBusyError
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.server import journal, modbus_tcp, places, remote, sessions
from pixstep.server.local import LocalModbus
from pixstep.server.messages import RequestMeaning, meaning_of
from serverbench import Desk, Raw, beside, until

STOP = regs.COMMANDS["stop"]


def is_stop(frame):
    return frame[1] == 16 and frame[2:4] == b"\x01\x00" and frame[9:11] == bytes([0, STOP])


def is_arm(frame):
    return frame[1] == 16 and frame[2:4] == b"\x01\x00" and frame[9:11] == bytes([0, 1])


def is_read(frame, count):
    return frame[1] == 4 and frame[4:6] == struct.pack(">H", count)


def hold(terminal, wanted, until_event=None):
    """Give no reply to requests that are wanted, or only when an event comes; return its begin."""
    begun = threading.Event()

    def plan(_number, frame, reply):
        if not wanted(frame):
            return [(0, reply)]
        begun.set()
        if until_event is None:
            return []
        until_event.wait()
        return [(0, reply)]

    terminal.plan = plan
    return begun


def load(board, axis=0, pixels=3000):
    upload = LineUpload(board, axis, queue_entries(Line([1] * pixels, PLAIN)))
    upload.push()


# What a request does


def command(name, mask=1):
    return struct.pack(">BHHBHH", 16, 0x100, 2, 4, mask, regs.COMMANDS[name])


@pytest.mark.parametrize(
    ("pdu", "means"),
    [
        (struct.pack(">BHH", 4, 0, 9), RequestMeaning(writes=False)),
        (struct.pack(">BHH", 3, 0, 9), RequestMeaning(writes=False)),
        (struct.pack(">BHH", 1, 0, 9), RequestMeaning(writes=False)),
        (bytes([17]), RequestMeaning(writes=False)),
        (bytes([43, 14, 1, 0]), RequestMeaning(writes=False)),
        (struct.pack(">BHH", 8, 11, 0), RequestMeaning(writes=False)),
        (struct.pack(">BHH", 8, 4, 0), RequestMeaning()),
        (struct.pack(">BHH", 8, 10, 0), RequestMeaning()),
        (struct.pack(">BHH", 6, 2, 9), RequestMeaning()),
        (bytes([99]), RequestMeaning()),
        (bytes([16]), RequestMeaning(void_after=0)),
        (bytes([5, 0]), RequestMeaning()),
        (command("stop", 0b1010), RequestMeaning(stops=0b1010)),
        (command("arm", 0b101), RequestMeaning(drives=0b101, void_after=0b101)),
        (command("mark"), RequestMeaning(marks=True)),
        (command("permit_on"), RequestMeaning()),
        (
            struct.pack(">BHHBHHH", 16, 0x1000, 3, 6, 7, 0x0502, 0),
            RequestMeaning(drives=0b100, void_after=0b100),
        ),
        (struct.pack(">BHHBHHH", 16, 0x1000, 3, 6, 7, 9, 0), RequestMeaning(void_after=0)),
        (struct.pack(">BHHBH", 16, 2, 1, 2, 9), RequestMeaning(void_after=0)),
        (struct.pack(">BHH", 5, 9, 0xFF00), RequestMeaning(stops=0b10)),
        (struct.pack(">BHH", 5, 9, 0), RequestMeaning()),
        (struct.pack(">BHH", 5, 7, 0xFF00), RequestMeaning(drives=0b1000, void_after=0b1000)),
        (struct.pack(">BHH", 5, 13, 0xFF00), RequestMeaning()),
    ],
)
def test_what_a_request_does(pdu, means):
    assert meaning_of(pdu) == means


# Found by itself


def test_a_port_has_one_server_under_both_of_its_names(desk, terminal, runtime):
    link = runtime / "link"
    link.symlink_to(terminal.name)
    for name in (terminal.name, str(link)):
        found = remote.open_bus(Port(name))
        assert found.board().input("axis_count") == 4
        found.close()
    assert len(desk.notes.of("connected")) == 2


def test_a_server_of_a_link_is_found_by_both_names(terminal, runtime):
    link = runtime / "link"
    link.symlink_to(terminal.name)
    terminal.name, real = str(link), terminal.name
    made = Desk(terminal)
    for name in (real, str(link)):
        assert Device(remote.find(Port(name))).input("axis_count") == 4
    link.unlink()  # the board comes back at another terminal
    link.symlink_to("/dev/null")
    assert remote.find(Port(str(link)))
    made.close()
    assert not list((runtime / "pixstep").iterdir())


def test_a_socket_that_was_left_behind_is_none_and_goes(terminal, runtime):
    folder = runtime / "pixstep"
    folder.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(folder / places.names(terminal.name)[0]))
    found = remote.open_bus(Port(terminal.name))
    assert found.board().input("axis_count") == 4  # by the port itself
    found.close()
    made = Desk(terminal)
    assert made.board().input("axis_count") == 4
    made.close()


def test_what_is_no_socket_stays(terminal, runtime):
    folder = runtime / "pixstep"
    folder.mkdir(mode=0o700)
    file = folder / places.names(terminal.name)[0]
    file.write_text("precious")
    with pytest.raises(UserError, match="there is something else of this name"):
        Desk(terminal)
    assert file.read_text() == "precious"


def test_a_folder_that_others_can_write_to_is_not_trusted(terminal, runtime):
    (runtime / "pixstep").mkdir()
    (runtime / "pixstep").chmod(0o777)
    with pytest.raises(UserError, match="another user can write there"):
        Desk(terminal)
    with socket.socket(socket.AF_UNIX) as strange:
        strange.bind(str(runtime / "pixstep" / places.names(terminal.name)[0]))
        strange.listen()
        assert remote.find(Port(terminal.name)) is None


def test_a_second_server_is_refused_by_name(desk, terminal):
    with pytest.raises(PortBusyError, match=rf"\(`pixstep serve`, pid {os.getpid()}\)"):
        Desk(terminal)


def test_past_the_server_the_port_is_busy(desk, terminal, monkeypatch):
    monkeypatch.setenv(remote.DIRECT, "1")
    with pytest.raises(PortBusyError):
        remote.open_bus(Port(terminal.name))


def test_another_rate_than_the_servers_is_refused(desk, terminal):
    with pytest.raises(UserError, match=r"its server \(pid \d+\) talks at .*115200 baud, 8N2"):
        desk.client(baud=9600)
    with pytest.raises(UserError, match="leave baud and parity out"):
        desk.client(parity="E")


# One writes, several read


def test_a_second_writer_is_refused_by_name_and_reads(desk):
    first, second = desk.board(), desk.board()
    first.write_setting("dir_hold_us", 21)
    with pytest.raises(BusTakenError) as refused:
        second.write_setting("dir_hold_us", 22)
    said = str(refused.value)
    assert f"(pid {os.getpid()}) has the right to write since " in said and "pytest" in said
    assert refused.value.status == 3
    assert second.setting("dir_hold_us") == 21
    first.modbus.close()
    until(lambda: desk.server.sessions.writer is None, "the first one lets go")
    second.write_setting("dir_hold_us", 23)
    assert second.setting("dir_hold_us") == 23


def test_the_right_to_write_lapses(desk, monkeypatch):
    first, second = desk.board(), desk.board()
    first.write_setting("dir_hold_us", 21)
    monkeypatch.setattr(sessions, "LAPSE_S", 0.0)
    second.write_setting("dir_hold_us", 22)
    monkeypatch.undo()
    with pytest.raises(BusTakenError):
        first.write_setting("dir_hold_us", 23)


def test_a_second_writer_stops_nothing_of_the_first(desk):
    first, second = desk.board(), desk.board()
    load(first)
    run.arm(first, [0])
    with pytest.raises(BusTakenError), run.stopped_on_failure([run.LinesOfBoard(second, [0])]):
        run.arm(second, [0])
    assert run.states(second, [0]) == {0: "running"}
    assert not any(map(is_stop, desk.frames()))


def test_everyone_may_stop(desk):
    first, second = desk.board(), desk.board()
    load(first)
    run.arm(first, [0])
    run.stop_axes(second, [0])
    assert run.rests(first, [0], WallClock())[0].state == "empty"
    load(first)
    run.arm(first, [0])
    second.stop_all()
    assert run.states(first, [0]) == {0: "empty"}


# A stop goes first


def test_a_stop_does_not_wait_for_a_reply_that_does_not_come(slow_desk, terminal):
    """The reply may take 5 s; the stop is the next frame, and is sent again after the quiet."""
    begun = hold(terminal, lambda frame: is_read(frame, 9))
    slow = beside(slow_desk.board().read_inputs, 0, 9)
    assert begun.wait(60)
    terminal.plan = lambda _number, _frame, reply: [(0, reply)]
    slow_desk.board().stop_all()
    frames = slow_desk.frames()
    at = next(i for i, frame in enumerate(frames) if is_read(frame, 9))
    stops = len(set(regs.AXIS_COUNTS))
    assert all(map(is_stop, frames[at + 1 : at + 1 + stops]))
    until(lambda: sum(map(is_stop, slow_desk.frames())) == 2 * stops, "the stops again")
    del slow  # it is asked once more when the line has been quiet for its time-out


@pytest.mark.parametrize("before", ["stop", "arm"])
def test_a_plc_gets_the_reply_to_its_stop_whatever_it_wrote_before(desk, before):
    """Its reply looks like that to another order of late: the stop is asked again, in order."""
    number = modbus_tcp.Door(desk.server.bus, desk.server.sessions, writes=True).listen(
        "127.0.0.1", 0
    )
    with ModbusTcpClient("127.0.0.1", port=number, timeout=60, retries=0) as plc:
        plc.write_registers(0x100, [1, regs.COMMANDS[before]], device_id=1)
        reply = plc.write_registers(0x100, [15, STOP], device_id=1)
        assert not reply.isError(), reply
    stops = [frame for frame in desk.frames() if is_stop(frame)]
    assert len(stops) > 1 and desk.board().axis(0)["axis_state"] == 0


def test_a_stop_by_address_does_not_wait_for_an_order_either(slow_desk, terminal):
    """Nobody knows whether the order was heard: it is not repeated, and its client is told so."""
    begun = hold(terminal, lambda frame: frame[0] == 2)
    raw = slow_desk.raw()
    raw.asked(1, command("enable").hex(), unit=2)
    assert begun.wait(60)
    run.stop_axes(slow_desk.board(1), [0, 1])
    assert raw.hear() == {"id": 1, "error": "no_reply", "heard": 0}
    assert [is_stop(frame) for frame in slow_desk.frames()] == [False, True]


def test_a_request_that_gave_way_is_made_afterwards(desk, terminal):
    lost = []

    def plan(_number, frame, reply):
        if is_read(frame, 9) and not lost:
            lost.append(frame)
            return []
        return [(0, reply)]

    terminal.plan = plan
    reader = desk.client()
    reading = beside(Device(reader).read_inputs, 0, 9)
    until(lambda: lost, "the request")
    Device(desk.client()).stop_all()
    assert reading()[:1] == [regs.MAP_VERSION]


def test_a_stop_goes_before_what_the_server_itself_asks(slow_desk, terminal):
    """The server looks at a board, as it does at that of a silent client, when a stop comes."""
    go_on = threading.Event()
    begun = hold(terminal, lambda frame: is_read(frame, 9), go_on)
    reading = beside(slow_desk.board().read_inputs, 0, 9)
    assert begun.wait(60)
    bus = slow_desk.server.bus
    looking = beside(Device(LocalModbus(bus), 1).read_inputs, 0, 8)
    until(lambda: bus.waiting() == 1, "the server's own request")
    stopping = beside(run.stop_axes, slow_desk.board(), [0])
    until(lambda: bus.waiting() == 2, "the stop")
    go_on.set()
    until(lambda: any(map(is_stop, slow_desk.frames())), "the stop's frame")
    stopping()
    assert looking()[:1] == [regs.MAP_VERSION]
    reading()
    orders = [frame for frame in slow_desk.frames() if is_stop(frame) or is_read(frame, 8)]
    assert is_stop(orders[0])


def test_an_order_that_waits_is_overtaken(slow_desk, terminal):
    """An order waits after a slow read. The stop that comes later goes first, the order never."""
    go_on = threading.Event()
    first, stopper = slow_desk.board(), slow_desk.raw()
    load(first)
    run.arm(first, [0])
    begun = hold(terminal, lambda frame: is_read(frame, 9), go_on)
    reading = beside(slow_desk.board(2).read_inputs, 0, 9)
    assert begun.wait(60)
    enabling = beside(first.command, "enable", [0])
    until(lambda: slow_desk.server.bus.waiting() == 1, "the order")
    stopper.say({"id": 7, "do": "tell", "unit": 0, "pdu": command("stop", 0b1111).hex()})
    with pytest.raises(OvertakenError, match="not sent: stopped by by hand"):
        enabling()
    go_on.set()
    reading()
    assert "error" not in stopper.hear()
    until(lambda: len(terminal.board.commands) > 1, "the stop")
    assert [name for name, *_ in terminal.board.commands][:2] == ["arm", "stop"]
    assert ("enable", 1, 0) not in terminal.board.commands


def test_what_other_axes_are_told_is_not_overtaken(slow_desk, terminal):
    """A stop of axis 3 comes while a line of axis 0 and a setting wait."""
    go_on = threading.Event()
    first = slow_desk.board()
    upload = LineUpload(first, 0, queue_entries(Line([1] * 30, PLAIN)))
    begun = hold(terminal, lambda frame: is_read(frame, 9), go_on)
    reading = beside(slow_desk.board(2).read_inputs, 0, 9)
    assert begun.wait(60)
    queueing = beside(upload.push)
    until(lambda: slow_desk.server.bus.waiting() == 1, "the block")
    stopper = slow_desk.raw()
    stopper.asked(7, command("stop", 0b1000).hex())
    until(lambda: slow_desk.notes.of("stop"), "the stop")
    go_on.set()
    reading(), queueing()
    assert terminal.board.axes[0].state == "loaded"


def test_an_order_for_another_board_is_not_overtaken(slow_desk, terminal):
    go_on = threading.Event()
    begun = hold(terminal, lambda frame: is_read(frame, 9), go_on)
    reading = beside(slow_desk.board(2).read_inputs, 0, 9)
    assert begun.wait(60)
    enabling = beside(slow_desk.board(2).command, "enable", [0])
    until(lambda: slow_desk.server.bus.waiting() == 1, "the order")
    stopping = beside(run.stop_axes, slow_desk.board(1), [0])
    until(lambda: slow_desk.notes.of("stop"), "the stop")
    go_on.set()
    reading(), stopping(), enabling()
    orders = [frame for frame in slow_desk.frames() if frame[1] == 16]
    assert [is_stop(frame) for frame in orders] == [True, False]


def test_nothing_goes_out_between_a_stop_and_what_was_on_the_wire(desk, terminal):
    """Four clients ask without pause; each of 50 stops is the frame after the one on the wire."""
    over = threading.Event()

    def read_on(count):
        board = desk.board(1 + count % 2)
        while not over.is_set():
            board.read_inputs(0, count)

    readers = [beside(read_on, count) for count in (5, 6, 7, 8)]
    stopper = Device(desk.client())
    for _ in range(50):
        stopper.stop_all()
        time.sleep(0.003)
    over.set()
    for reader in readers:
        reader()
    rows = desk.notes.of("stop")
    assert len(rows) == 50 * len(set(regs.AXIS_COUNTS))
    firsts = rows[:: len(set(regs.AXIS_COUNTS))]
    assert Counter(row["frames_between"] for row in firsts) == {0: 50}


def test_two_requests_that_belong_together_follow_each_other(desk, terminal):
    over = threading.Event()

    def read_on(count):
        board = desk.board()
        while not over.is_set():
            board.read_inputs(0, count)

    readers = [beside(read_on, count) for count in (5, 6, 7)]
    raw = desk.raw()
    for number in range(0, 40, 2):
        raw.asked(number, "0400000001", more=True)
        raw.asked(number + 1, "0400000002")
        assert [raw.hear()["id"], raw.hear()["id"]] == [number, number + 1]
    over.set()
    for reader in readers:
        reader()
    frames = [frame for frame in desk.frames() if frame[2:5] == bytes(3)]
    at = [i for i, frame in enumerate(frames) if is_read(frame, 1)]
    assert len(at) >= 20
    fences = [i for i in at if i + 1 < len(frames) and is_read(frames[i + 1], 2)]
    assert len(fences) >= 20


def test_a_board_that_is_not_there_keeps_no_stream(desk, terminal):
    """While a client moves axes, another one's request is made once, and waits for little.

    One to a board that has replied before is made again, after what others ask.
    """
    driver, raw = desk.board(), desk.raw()
    load(driver)
    run.arm(driver, [0])
    raw.asked(1, "0400000005", unit=99, retries=3)
    assert raw.hear() == {"id": 1, "error": "no_reply", "heard": 0}
    lost = []

    def plan(_number, frame, reply):
        if is_read(frame, 7) and not lost:
            lost.append(frame)
            return []
        return [(0, reply)]

    terminal.plan = plan
    raw.asked(3, "0400000007", unit=2, retries=1)
    assert raw.hear()["error"] == "no_reply"  # it has never been heard
    lost.clear()
    raw.asked(4, "0400000007", retries=1)
    assert raw.hear()["pdu"].startswith("040e")
    driver.modbus.close()
    until(lambda: not any(one.axes for one in desk.server.sessions.present()), "its end")
    raw.asked(2, "0400000005", unit=99, retries=3)
    assert raw.hear()["error"] == "no_reply"
    asked = [frame for frame in desk.frames() if frame[0] == 99]
    assert sum(is_read(frame, 5) for frame in asked[:1]) == 1 and len(asked) >= 4


def test_a_lost_reply_of_one_client_costs_a_stream_little(slow_desk, terminal):
    """After a lost reply the line is quiet for as long as that request waited: 0.1 s, not 2 s."""
    driver, raw = slow_desk.board(), slow_desk.raw()
    load(driver)
    run.arm(driver, [0])
    hold(terminal, lambda frame: is_read(frame, 9))
    raw.asked(1, "0400000009")
    assert raw.hear()["error"] == "no_reply"
    begun_s = time.monotonic()
    assert driver.room() == [508]
    assert time.monotonic() - begun_s < 1.5


def test_after_a_mark_nothing_follows_for_20_ms(desk, monkeypatch):
    sent = []  # (time, frame), as the line takes them
    write = desk.server.line.write

    def write_down(frame):
        write(frame)
        sent.append((time.monotonic(), frame))

    monkeypatch.setattr(desk.server.line, "write", write_down)
    over = threading.Event()

    def read_on():
        board = desk.board()
        while not over.is_set():
            board.read_inputs(0, 5)

    reading = beside(read_on)
    marker = desk.board()
    for _ in range(5):
        marker.mark()
        time.sleep(0.05)
    over.set()
    reading()
    marks = [i for i, (_, frame) in enumerate(sent) if frame[0] == 0]
    assert len(marks) == 5
    assert all(sent[at + 1][0] - sent[at][0] >= 0.02 for at in marks)


# Clients that die, fall silent, or misbehave


def drive(desk, raw):
    """Load a line by another client, and arm it by one that speaks by hand."""
    board = desk.board()
    load(board)
    board.modbus.close()
    until(lambda: desk.server.sessions.writer is None, "the loader lets go")
    raw.asked(1, command("arm").hex())
    assert "error" not in raw.hear()


def test_what_a_client_moves_is_stopped_when_it_dies(desk, terminal):
    raw = desk.raw()
    drive(desk, raw)
    assert terminal.board.axes[0].state == "running"
    raw.die()
    until(lambda: desk.notes.of("stopped"), "the stop")
    (row,) = desk.notes.of("stopped")
    assert (row["why"], row["unit"], row["axes"]) == ("its client died", 1, [0])
    assert row["client"].startswith("by hand (pid ")
    assert terminal.board.axes[0].state == "empty"
    assert ("stop", 1, 0) in terminal.board.commands


def test_what_a_client_has_started_goes_on_after_its_goodbye(desk, terminal):
    raw = desk.raw()
    drive(desk, raw)
    raw.say({"do": "bye", "id": 9})
    raw.die()
    until(lambda: len(desk.notes.of("disconnected")) == 2, "its end")
    assert run.states(desk.board(), [0]) == {0: "running"}
    assert not desk.notes.of("stopped")


def test_what_all_boards_were_told_to_do_is_stopped_on_all(desk, terminal):
    for unit in (1, 2):
        load(board := desk.board(unit))
        board.modbus.close()
        until(lambda: desk.server.sessions.writer is None, "the loader lets go")
    raw = desk.raw()
    raw.say({"id": 1, "do": "tell", "unit": 0, "pdu": command("arm").hex()})
    assert "error" not in raw.hear()
    until(lambda: [b.axes[0].state for b in terminal.boards] == ["running"] * 2, "both move")
    raw.die()
    until(lambda: [b.axes[0].state for b in terminal.boards] == ["empty"] * 2, "both rest")


def test_a_line_that_another_client_has_started_since_goes_on(desk, terminal):
    raw = desk.raw()
    drive(desk, raw)
    other = desk.board()
    run.stop_axes(other, [0])
    desk.server.sessions.writer.last_s -= 60  # it has lapsed
    load(other)
    run.arm(other, [0])
    raw.die()
    until(lambda: len(desk.notes.of("disconnected")) == 2, "its end")
    time.sleep(0.05)
    assert run.states(other, [0]) == {0: "running"}
    assert not desk.notes.of("stopped")


def test_a_part_of_a_line_goes_with_its_client(desk, terminal):
    raw = desk.raw()
    entries = queue_entries(Line([3, 5, 7], PLAIN))[:2]
    words = [0, 1, *(word & 0xFFFF for entry in entries for word in entry)]
    raw.asked(1, struct.pack(f">BHHB{len(words)}H", 16, 0x1000, len(words), 2 * len(words),
                             *words).hex())  # fmt: skip
    assert "error" not in raw.hear()
    assert terminal.board.axes[1].state != "empty"
    raw.die()
    until(lambda: desk.notes.of("stopped"), "the stop")
    assert terminal.board.axes[1].state == "empty"


def test_the_lines_of_a_silent_client_are_stopped_as_the_board_says(desk, terminal):
    """The board's bus is never silent: another client reads."""
    terminal.board.holdings[regs.register_map().holding("bus_timeout_ms").address] = 700
    raw = desk.raw()
    drive(desk, raw)
    reader = desk.board()
    end = time.monotonic() + 0.6
    while time.monotonic() < end:
        reader.input("status")
    assert terminal.board.axes[0].state == "running"
    until(lambda: reader.input("status") is not None and desk.notes.of("stopped"), "the stop")
    assert desk.notes.of("stopped")[0]["why"] == "silent for 0.7 s"
    assert terminal.board.axes[0].state == "empty"


def test_lines_go_on_where_the_board_may_be_left_alone(desk, terminal):
    terminal.board.holdings[regs.register_map().holding("bus_timeout_ms").address] = 0
    raw = desk.raw()
    drive(desk, raw)
    time.sleep(1.2)
    assert terminal.board.axes[0].state == "running" and not desk.notes.of("stopped")


def test_the_end_of_a_server_stops_what_its_clients_move(desk, terminal):
    raw = desk.raw()
    drive(desk, raw)
    desk.server.close()
    assert [row["why"] for row in desk.notes.of("stopped")] == ["the server ends"], desk.notes.rows
    assert terminal.board.axes[0].state == "empty"
    assert raw.lines.readline() == b""
    assert not list((places.folder()).iterdir())


def test_requests_of_a_dead_client_are_not_made(slow_desk, terminal):
    go_on = threading.Event()
    begun = hold(terminal, lambda frame: is_read(frame, 9), go_on)
    reading = beside(slow_desk.board(2).read_inputs, 0, 9)
    assert begun.wait(60)
    raw = slow_desk.raw()
    raw.asked(1, "0400000003")
    until(lambda: slow_desk.server.bus.waiting() == 1, "its request")
    raw.die()
    go_on.set()
    reading()
    slow_desk.board().read_inputs(0, 4)
    assert not any(is_read(frame, 3) for frame in slow_desk.frames())


def test_a_client_that_reads_no_answers_is_let_go(desk):
    raw = desk.raw()
    status = b'{"id":1,"do":"status"}\n'
    with pytest.raises(OSError):
        for _ in range(100_000):
            raw.link.sendall(status * 10)
    assert desk.board().input("axis_count") == 4


def test_answers_keep_the_numbers_of_their_requests(desk):
    raw = desk.raw()
    for number in range(1, 41):
        raw.asked(number, f"0400000{number % 9 + 1:03x}")
    found = {}
    for _ in range(40):
        answer = raw.hear()
        found[answer["id"]] = answer["pdu"]
    for number in range(1, 41):
        assert len(bytes.fromhex(found[number])) == 2 + 2 * (number % 9 + 1)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"hello", "not a line of JSON"),
        (b"[]", "not a JSON object"),
        (b"[" * 4000, "not a line of JSON"),
        (b'{"id":1,"do":"dance"}', "'dance' is not known"),
        (b'{"id":1}', "do: a text is wanted"),
        (b'{"do":"ask"}', "id: a whole number"),
        (b'{"id":true,"do":"ask"}', "id: a whole number"),
        (b'{"id":1,"do":"ask","unit":248,"pdu":"00"}', "unit: a whole number from 1 to 247"),
        (b'{"id":1,"do":"ask","unit":1,"pdu":"0"}', "pdu: 1 to 253 bytes"),
        (b'{"id":1,"do":"ask","unit":1,"pdu":""}', "pdu: 1 to 253 bytes"),
        (b'{"id":1,"do":"ask","unit":1,"pdu":"' + b"00" * 254 + b'"}', "pdu: 1 to 253 bytes"),
        (b'{"id":1,"do":"ask","unit":1,"pdu":"04","timeout_s":1e9,"retries":0}', "timeout_s"),
        (b'{"id":1,"do":"ask","unit":1,"pdu":"04","timeout_s":1,"retries":-1}', "retries"),
        (b'{"id":1,"do":"follow","baud":1,"parity":"E"}', "baud"),
        (b'{"id":1,"do":"follow","baud":9600,"parity":"X"}', "parity"),
    ],
)
def test_a_wrong_request_is_named_and_the_next_one_served(desk, line, reason):
    raw = desk.raw()
    raw.link.sendall(line + b"\n")
    answer = raw.hear()
    assert answer["error"] == "mistake" and reason in answer["text"]
    raw.asked(2, "0400000001")
    assert raw.hear()["pdu"] == f"0402{regs.MAP_VERSION:04x}"


def test_noise_ends_no_server(desk):
    rng = random.Random(1)
    for _ in range(200):
        raw = Raw(desk.path, greet=rng.random() < 0.5)
        noise = rng.randbytes(rng.randrange(1, 300))
        if rng.random() < 0.5:
            noise = noise.replace(b"\n", b"") * 40 + b"\n"
        raw.link.sendall(noise)
        raw.die()
    assert desk.board().input("axis_count") == 4


def test_another_version_of_the_protocol_is_refused(desk):
    raw = Raw(desk.path, greet=False)
    raw.say({"pixstep": 2, "pid": 1, "command": "of tomorrow"})
    answer = raw.hear()
    assert answer["text"] == "version 2 of the protocol: this server speaks version 1"
    assert raw.lines.readline() == b""


def test_a_log_that_nobody_reads_keeps_nobody_waiting(monkeypatch):
    end, output = os.pipe()
    monkeypatch.setattr(sys, "stdout", os.fdopen(output, "w"))
    log = journal.ServerJournal(as_json=True)
    for number in range(20_000):  # far more than a pipe takes
        log.tell("stop", number=number)
    assert log._writer.is_alive()
    with os.fdopen(end, "rb") as read:
        first = [json.loads(read.readline())["number"] for _ in range(1000)]
    assert first == [*range(1000)]
    log.close()


# The port


def test_another_rate_to_look_for_boards_only_alone(desk):
    first = desk.client()
    first.reconfigure(9600, "N")
    assert desk.server.line.port.baud == 9600
    second = desk.client(baud=9600)
    with pytest.raises(BusTakenError, match="a client that is alone, and 1 more use its server"):
        first.reconfigure(115_200, "N")
    second.close()
    first.close()
    until(lambda: desk.server.line.port.baud == 115_200, "its own rate again")


def test_a_board_that_is_set_to_another_rate_takes_the_server_along(desk):
    first = desk.client()
    first.follow(9600, "N")
    first.close()
    assert desk.client(baud=9600).place.endswith("(9600 baud, 8N2)")


def test_a_port_that_is_gone_is_said_and_looked_for_again(runtime):
    there = Terminal()
    link = runtime / "link"
    link.symlink_to(there.name)
    there.name, real = str(link), there.name
    del real
    made = Desk(there, timeout_s=0.2)
    board = made.board()
    assert board.input("axis_count") == 4
    there.close()
    with pytest.raises(Exception, match="is gone: was it unplugged"):
        board.input("axis_count")
    with pytest.raises(Exception, match=r"link: .*"):
        board.input("axis_count")
    again = Terminal()
    link.unlink()
    link.symlink_to(again.name)
    assert board.input("axis_count") == 4
    made.close()
    again.close()


# TCP


def test_tcp_wants_the_token(desk, monkeypatch):
    number = desk.server.listen_tcp("127.0.0.1", 0, "correct horse")
    port = Port(f"tcp://127.0.0.1:{number}")
    for wrong in ("", "wrong", "correct hors", "correct horse "):
        monkeypatch.setenv(remote.TOKEN, wrong)
        with pytest.raises(UserError, match="the token is not this server's"):
            remote.open_bus(port)
    monkeypatch.setenv(remote.TOKEN, "correct horse")
    found = remote.open_bus(port)
    assert found.board().input("axis_count") == 4
    found.close()
    assert "correct" not in str(desk.notes.rows)


@pytest.mark.parametrize("name", ["tcp://", "tcp://host", "tcp://host:x", "tcp://:1", "tcp://h:0"])
def test_a_wrong_place_on_the_network_is_named(name):
    with pytest.raises(UserError, match=r"expected tcp://HOST:NUMBER"):
        remote.find(Port(name))


def test_no_server_there_is_named(runtime):
    with pytest.raises(UserError, match="no server: Connection refused"):
        remote.find(Port("tcp://127.0.0.1:1"))
    with pytest.raises(UserError, match="no server: No such file"):
        remote.find(Port(f"unix:{runtime}/none"))
