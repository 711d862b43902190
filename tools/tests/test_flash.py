# SPDX-License-Identifier: MIT
"""`pixstep flash`: its command line, its refusals, what it asks the board afterwards."""

import os
import pty
import re
import shlex
import shutil
import stat
import time

import pytest

from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep import natives
from pixstep.board import flash
from pixstep.board.boards import BOARD_NAMES
from pixstep.board.modbus import SerialClient
from pixstep.board.port import Port

_MASTER, _SLAVE = pty.openpty()
PORT = os.ttyname(_SLAVE)  # there, and nobody answers on it


def record(address, data, kind=0):
    row = bytes([len(data), address >> 8, address & 0xFF, kind]) + data
    return f":{(row + bytes([-sum(row) & 0xFF])).hex().upper()}\n"


def image(path, board="mega", version="0.1"):
    """Write a small image; the identity lies across two rows, as in a real one."""
    text = f"..pixstep {board} {version}\0".encode()
    rows = [text[start : start + 8] for start in range(0, len(text), 8)]
    body = "".join(record(8 * index, row) for index, row in enumerate(rows))
    path.write_text(body + record(0, b"", 1))
    return path


@pytest.fixture
def avrdude(tmp_path, monkeypatch):
    """Put an avrdude into the path that notes its arguments and ends with a given status."""

    def install(status=0, first=""):
        folder = tmp_path / "bin"
        folder.mkdir()
        program = folder / "avrdude"
        program.write_text(f'#!/bin/sh\n{first}\necho "$@" >{tmp_path}/called\nexit {status}\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")
        return tmp_path / "called"

    return install


@pytest.fixture
def board(make_console):
    """Put a fake Mega on the port."""
    world = FakeWorld()
    fake = FakeBoard(world)
    return make_console(FakeLine(world, fake), world), fake


@pytest.mark.parametrize("name", BOARD_NAMES)
def test_cmake_and_the_command_agree(name, avrdude):
    called = avrdude()
    script = natives.source("cmake/flash.cmake")
    words = ["-DIMAGE=a.hex", f"-DBOARD={name}", f"-DPORT={PORT}", "-P", script]
    done = natives.run([shutil.which("cmake"), *words])
    assert done.returncode == 0, done.stderr
    assert called.read_text().split() == flash.command(name, PORT, "a.hex")[1:]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("name", BOARD_NAMES)
def test_the_built_images_say_what_they_are(name):
    found = flash.read_image(flash.built_image(name))
    config = natives.source("firmware/config.h").read_text()
    version = [re.search(rf"VERSION_{part} (\d+)", config)[1] for part in ("MAJOR", "MINOR")]
    assert (found.board, found.version) == (name, ".".join(version))


def test_dry_run(pixstep, tmp_path):
    path = image(tmp_path / "a b.hex")
    words = ("flash", "--board", "mega", "--port", PORT, "--hex", path, "--dry-run")
    assert shlex.split(pixstep(*words)) == [
        "avrdude", "-p", "atmega2560", "-c", "wiring", "-b", "115200", "-P", PORT, "-D",
        "-U", f"flash:w:{path}:i",
    ]  # fmt: skip
    assert f"flash:v:{path}:i" in pixstep(*words, "--verify")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, "missing: build it with `tools/build`"),
        ("hello\n", ":1: not a row of an Intel HEX file"),
        (record(0, b"abc")[:-3] + "00\n", ":1: not a row of an Intel HEX file"),
        (record(0, b"nothing here"), "not a pixstep image"),
        ("\u00e9", "not an Intel HEX file"),
    ],
)
def test_what_is_no_image_is_refused(invoke, tmp_path, content, complaint):
    path = tmp_path / "a.hex"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    words = ("flash", "--board", "mega", "--port", PORT, "--hex", path, "--dry-run")
    text = invoke(*words, status=2).stderr
    assert complaint in text and text.count("\n") == 1


def test_a_port_that_cannot_be_opened_is_said_at_once_and_as_everywhere(invoke, avrdude, tmp_path):
    called = avrdude(first="sleep 9")
    path = image(tmp_path / "a.hex")
    for port in ("/dev/ttyNONE", "/dev/null"):
        begun = time.monotonic()
        words = ("flash", "--board", "mega", "--port", port, "--hex", path)
        told = invoke(*words, status=2).stderr
        assert time.monotonic() - begun < flash.ANSWER_LIMIT_S
        assert told == invoke("board", "get", "status", "--port", port, status=2).stderr
    assert not called.exists()


def test_flash_names_a_port_in_use(invoke, avrdude, tmp_path):
    called = avrdude()
    path = image(tmp_path / "a.hex")
    client = SerialClient(Port(PORT))
    client.connect()
    words = ("flash", "--board", "mega", "--port", PORT, "--hex", path)
    text = invoke(*words, status=2).stderr
    client.close()
    assert text.startswith(f"pixstep: {PORT}: in use by another program")
    assert not called.exists()


def test_an_image_of_another_board_is_refused(invoke, tmp_path, avrdude):
    called = avrdude()
    path = image(tmp_path / "a.hex", "mega")
    text = invoke("flash", "--board", "uno", "--port", PORT, "--hex", path, status=2).stderr
    assert "an image for the mega, not for the uno" in text
    assert not called.exists()


def test_without_avrdude(invoke, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    path = image(tmp_path / "a.hex")
    text = invoke("flash", "--board", "mega", "--port", PORT, "--hex", path, status=2).stderr
    assert text == (
        "pixstep: avrdude is missing: apt-get install avrdude (in a clone tools/setup does so)\n"
    )


def test_avrdude_fails(invoke, tmp_path, avrdude):
    avrdude(first='case "$*" in *flash:w:*) exit 1;; esac')
    path = image(tmp_path / "a.hex")
    text = invoke("flash", "--board", "mega", "--port", PORT, "--hex", path, status=1).stderr
    assert "avrdude failed (exit status 1)" in text and text.count("\n") == 1


def test_a_port_without_a_board(invoke, tmp_path, avrdude):
    called = avrdude(status=1, first="echo avrdude error: cannot open port >&2")
    path = image(tmp_path / "a.hex")
    text = invoke("flash", "--board", "mega", "--port", PORT, "--hex", path, status=1).stderr
    assert text.startswith(
        "pixstep: avrdude finds no boot loader (exit status 1: avrdude error: cannot open port), "
        "nothing was written: is this the board's port"
    )
    assert text.count("\n") == 1 and "flash:w" not in called.read_text()


def test_flash_asks_the_board(invoke, tmp_path, avrdude, board):
    called = avrdude()
    path = image(tmp_path / "a.hex")
    words = ("flash", "--board", "mega", "--port", PORT, "--hex", path)
    assert invoke(*words).stdout == f"{PORT}: unit 1 is pixstep mega 0.1\n"
    assert called.read_text().split()[-1] == f"flash:w:{path}:i"
    board[1].holdings[0] = 9
    assert "board 9" not in invoke(*words, "--unit", 9).stderr
    assert "no reply to read" in invoke(*words, status=1).stderr
    assert invoke(*words, "--no-ask").stdout == ""


def test_flash_notices_another_version(invoke, tmp_path, avrdude, board):
    avrdude()
    path = image(tmp_path / "a.hex", version="0.2")
    text = invoke("flash", "--board", "mega", "--port", PORT, "--hex", path, status=1).stderr
    assert "the board says 'pixstep mega 0.1', the image is 'pixstep mega 0.2'" in text


@pytest.mark.parametrize(
    ("limit", "first", "message"),
    [
        ("ANSWER_LIMIT_S", "exec cat /dev/zero >/dev/null", "no boot loader answers in 0.3 s, no"),
        ("LIMIT_S", 'case "$*" in *flash:w:*) exec cat /dev/zero >/dev/null;; esac',
         "avrdude is not done in 0.3 s and was ended: is there a board"),
    ],
)  # fmt: skip
def test_an_avrdude_that_goes_on_and_on_is_ended(
    invoke, avrdude, tmp_path, monkeypatch, limit, first, message
):
    called = avrdude(first=first)
    monkeypatch.setattr(flash, limit, 0.3)
    path = image(tmp_path / "a.hex")
    words = ("flash", "--board", "mega", "--port", PORT, "--hex", path)
    text = invoke(*words, status=1).stderr
    assert text.startswith(f"pixstep: {message}") and text.count("\n") == 1
    assert not called.exists() or "flash:w" not in called.read_text()
