# SPDX-License-Identifier: MIT
"""Real serial ports: the simulator's pseudo terminal, and every way a port cannot be opened."""

import contextlib
import errno
import json
import os
import pty
import re
import signal
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from pixstep import formats
from pixstep.board import link
from pixstep.board.modbus import SerialClient
from pixstep.board.port import Port
from pixstep.errors import UserError
from sim_terminal import on_terminal

HANG_S = 1800
# Of the console, which asks four times: a guard for a busy machine. A request that runs into the
# rest of one that a signal broke off is lost and costs this time.
PATIENT = ("--timeout", "2s")
SILENT = ("--timeout", "1s")  # where nobody answers; a port must take the bytes in this time too
# A host that gets no processor for a while is not taken for a dead one.
SETTINGS = ("board", "set", "pixel_hz=100", "bus_timeout_ms=0", *PATIENT)


@pytest.fixture
def sim_port(simulator):
    """Start a simulated Mega behind a pseudo terminal; yield the terminal's name."""
    with on_terminal("mega", 100) as (name, _process):
        yield name


@pytest.fixture
def terminal():
    """Yield the name of a pseudo terminal on which nobody answers, and its other end."""
    master, slave = pty.openpty()
    yield os.ttyname(slave), master
    os.close(master)
    os.close(slave)


def test_a_session_over_a_terminal(pixstep, invoke, sim_port, tmp_path, monkeypatch):
    monkeypatch.setenv("PIXSTEP_PORT", sim_port)
    found = json.loads(pixstep("board", "scan", "--unit", "1", "--json", *PATIENT))
    assert [item["board"] for item in found["boards"]] == ["mega"] and found["parity"] == "N"
    assert "pixel_hz_num: 30 -> 100 Hz" in pixstep(*SETTINGS)
    formats.write_csv(tmp_path / "a.csv", [9] * 250)
    words = (
        "board",
        "upload",
        "a.csv",
        "--decode",
        "plain",
        "--axis",
        1,
        "--arm",
        "--json",
        *PATIENT,
    )
    (axis,) = json.loads(pixstep(*words))["axes"]
    assert (axis["state"], axis["position_steps"]) == ("done", 2250)
    assert "axis 1: done, position_steps 2250" in pixstep("board", "watch", "--once", *PATIENT)
    assert "map_version = 6" in pixstep("board", "get", "map_version", "--baud", 9600, *PATIENT)
    assert "board 1: at rest: axis 0 at" in pixstep("board", "stop", "--unit", 1, *PATIENT)
    text = invoke("board", "get", "status", "--parity", "E", status=2).stderr
    assert text == f"pixstep: {sim_port}: a pseudo terminal has no parity E: --parity N\n"


def start_lines(pixstep, tmp_path, *axes):
    """Start lines of ten minutes that go on alone."""
    pixstep(*SETTINGS)
    formats.write_csv(tmp_path / "long.csv", [9] * 60_000)
    for axis in axes:
        words = ("board", "upload", "long.csv", "--decode", "plain", "--axis", axis, *PATIENT)
        pixstep(*words)
    pixstep("board", "arm", *(word for axis in axes for word in ("--axis", axis)), *PATIENT)


def axis_states(pixstep):
    (row,) = pixstep("board", "watch", "--once", "--json", *PATIENT).splitlines()
    return [axis["axis_state"] for axis in json.loads(row)["axes"]]


def test_a_broadcast_stop_reaches_every_axis(pixstep, sim_port, tmp_path, monkeypatch):
    monkeypatch.setenv("PIXSTEP_PORT", sim_port)
    start_lines(pixstep, tmp_path, 0, 1, 3)
    assert axis_states(pixstep)[1] in ("armed", "running")
    assert pixstep("board", "stop", "--no-look") == f"{sim_port}: stop sent to all boards\n"
    assert axis_states(pixstep) == ["empty"] * 4


@pytest.fixture
def moving(pixstep, sim_port, tmp_path, monkeypatch):
    """Run a command on a terminal of its own until its bar shows a share of the line.

    Returns its process number and the terminal's other end.
    """
    monkeypatch.setenv("PIXSTEP_PORT", sim_port)
    pixstep(*SETTINGS)
    formats.write_csv(tmp_path / "long.csv", ([9] * 8 + [11] * 8) * 750)  # streamed
    words = ("board", "upload", "long.csv", "--decode", "plain", "--arm", *PATIENT)
    pid, master = pty.fork()
    if pid == 0:
        os.execve(
            sys.executable, [sys.executable, "-m", "pixstep", *words],
            os.environ | {"TERM": "xterm", "COLUMNS": "80"},
        )  # fmt: skip
    seen = b""
    while not re.search(rb"\d:\d\d:\d\d", seen):  # what is left, as soon as that is known
        seen += os.read(master, 4096)
    return pid, master


def rest_of(master):
    """Return what is still written on a terminal, to its end."""
    text = b""
    with contextlib.suppress(OSError):  # how a terminal ends
        while data := os.read(master, 4096):
            text += data
    os.close(master)
    return text.decode(errors="replace")


def exit_status(pid):
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


@pytest.mark.parametrize(
    ("number", "name", "status"),
    [
        (signal.SIGINT, "Ctrl-C", 130),
        (signal.SIGTERM, "SIGTERM", 143),
        (signal.SIGHUP, "SIGHUP", 129),
    ],
)
def test_a_signal_stops_the_motor(pixstep, moving, number, name, status):
    pid, master = moving
    os.kill(pid, number)
    text = rest_of(master)
    assert exit_status(pid) == status
    assert f"pixstep: stopped by {name}: board 1 axis 0 at position " in text
    assert axis_states(pixstep)[0] == "empty"


def test_a_terminal_that_is_closed_stops_the_motor(pixstep, moving):
    pid, master = moving
    os.close(master)
    assert exit_status(pid) == 129
    assert axis_states(pixstep)[0] == "empty"


def test_watch_is_live_on_a_terminal_and_ends_by_ctrl_c(sim_port):
    master, slave = pty.openpty()
    words = ("board", "watch", "--port", sim_port, "--interval", "0.1", *PATIENT)
    process = subprocess.Popen(
        [sys.executable, "-m", "pixstep", *words],
        stdout=slave, stderr=slave, stdin=slave,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100", "LINES": "40"},
    )  # fmt: skip
    os.close(slave)
    seen = b""
    while seen.count(b"queue free") < 3:
        seen += os.read(master, 4096)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=HANG_S) == 0
    os.close(master)
    text = seen.decode(errors="replace")  # the last read may end in a character
    assert "Traceback" not in text
    assert "Ctrl-C ends" in text and "board 1  mega 0.2" in text and " Hz, " in text
    assert "\x1b[" in text  # redrawn in its place


def test_nobody_answers(terminal, invoke):
    name, _ = terminal
    words = ("board", "info", "--port", name, "--unit", 3, *SILENT)
    text = invoke(*words, status=1).stderr
    assert text.startswith(
        f"pixstep: board 3 on {name} (115200 baud, 8N2): no reply to read: check its power"
    )


def test_a_scan_at_several_rates_goes_through_them_all(terminal, invoke):
    name, master = terminal
    os.set_blocking(master, False)
    words = ("board", "scan", "--port", name, "--unit", 1, *SILENT)
    assert "nothing answers" in invoke(*words, "--bauds", "9600,19200", status=1).stderr
    sent = os.read(master, 1000)
    assert len(sent) == 8 * 2  # without parity; a pseudo terminal has no other


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("/dev/ttyNONE", "there is no such port: is the board plugged in?"),
        ("/dev/null", "not a serial port"),
        ("/etc/hostname", "not a serial port"),
    ],
)
def test_ports_that_cannot_be_opened(invoke, name, complaint):
    text = invoke("board", "get", "status", "--port", name, status=2).stderr
    assert text.startswith(f"pixstep: {name}: {complaint}") and text.count("\n") == 1


def test_a_port_that_is_not_allowed_is_not_a_file_that_is_not(invoke, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("serial.Serial", refuse)
    file = tmp_path / "file"
    file.touch()
    for name, complaint in ((file, "not a serial port"), ("/dev/tty", "not allowed: add yourself")):
        text = invoke("board", "get", "status", "--port", name, status=2).stderr
        assert text.startswith(f"pixstep: {name}: {complaint}") and text.count("\n") == 1


def test_a_port_in_use(terminal):
    name, _ = terminal
    client = SerialClient(Port(name))
    client.connect()
    try:
        with pytest.raises(UserError, match=r"in use by another program, .*, Ctrl-C there stops"):
            SerialClient(Port(name)).connect()
    finally:
        client.close()


@pytest.mark.parametrize(
    ("error", "complaint"),
    [
        (PermissionError(13, "x"), "not allowed: add yourself to the group dialout"),
        (OSError(16, "x"), "in use by another program"),
        (ValueError("baud"), "cannot do 115200 baud with parity E"),
        (OSError(5, "x"), "not a serial port"),
        (OSError(28, "x"), "No space left on device"),
    ],
)
def test_why_a_port_cannot_be_opened(monkeypatch, error, complaint):
    def refuse(*_, **__):
        raise error

    monkeypatch.setattr("serial.Serial", refuse)
    with pytest.raises(UserError, match=complaint):
        Port("/dev/ttyX", 115_200, "E").open(0.1)


def test_opening_keeps_dtr_so_that_the_next_opening_resets_nothing(terminal):
    name, _ = terminal
    opened, has_reset = Port(name, 115_200, "N").open(0.1)
    flags = termios.tcgetattr(opened.fileno())
    assert not flags[2] & termios.HUPCL
    assert has_reset is False  # a pseudo terminal resets nothing
    opened.close()


def test_the_first_opening_of_a_real_port_waits_for_the_boot_loader(terminal, monkeypatch):
    name, _ = terminal
    monkeypatch.setattr("pixstep.board.port.is_pty", lambda _: False)
    with Path(name).open("rb", buffering=0) as opened:  # as every port is at first
        flags = termios.tcgetattr(opened)
        flags[2] |= termios.HUPCL
        termios.tcsetattr(opened, termios.TCSANOW, flags)
    waited, said = [], []
    monkeypatch.setattr("pixstep.board.link.time.sleep", waited.append)
    for _ in range(2):
        link.open_port(Port(name, parity="N"), said.append).close()
    assert waited == [2.0]
    assert len(said) == 1 and "waiting 2 s for its boot loader" in said[0]
