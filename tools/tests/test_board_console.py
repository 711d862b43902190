# SPDX-License-Identifier: MIT
"""`pixstep board` on fake boards: errors, scan, info, get, watch; help."""

import io
import json

import pytest
from click.testing import CliRunner
from rich.console import Console

from clock import TICK_HZ
from console import put
from pixstep.board import snapshot
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.cli.board import watchview
from pixstep.cli.main import main
from pixstep_trials.wire import seal

# Errors


def test_no_reply_names_unit_port_and_what_to_check(one):
    text = one.err("info", "--unit", 7)
    assert text.startswith("board 7 on /dev/ttyTEST (115200 baud, 8E1): no reply to read: check")
    assert "pixstep board scan" in text


def test_an_unreadable_reply_says_so(one):
    one.line.garble = b"\x01\x04\x99"
    assert "unreadable reply to read (3 bytes): another rate or parity" in one.err("info")


def test_another_map_version_names_both(one):
    one.board.values["map_version"] = 2
    text = one.err("get", "status")
    assert "board 1 has register map 2 (firmware 0.1), this tool knows map 6" in text


def test_exceptions_are_named(one):
    one.line.garble = seal(bytes([1, 0x84, 2]))
    text = one.err("set", "dir_setup_us=30", status=3)
    assert text == "board 1: read at 0x0000 answered with exception 2, illegal address"


def test_lost_replies_are_asked_for_again(one):
    one.line.lose = 1
    assert "status = 0 (none)" in one.out("get", "status")


def test_misuse_is_status_two(one):
    assert "addresses are 1 to 247" in one.run("info", "--unit", "0", status=2).output
    assert "as in 1 or 1,2,5-8" in one.run("info", "--unit", "x", status=2).output
    assert "no such option" in one.run("info", "--nothing", status=2).output.lower()
    assert not one.line.requests


def test_an_axis_that_a_board_has_not(two):
    assert two.err("enable", "--unit", 2, "--axis", 1, status=2) == (
        "axis 1: board 2 (uno) has axis 0 only"
    )


# Scan and info


def test_scan(two):
    text = two.out("scan", "--unit", "1-5")
    rows = [line.split() for line in text.splitlines() if line.split()[:1] in (["1"], ["2"])]
    assert rows[0][:5] == ["1", "mega", "0.1", "6", "4"]
    assert rows[1][:5] == ["2", "uno", "0.1", "6", "1"]
    found = two.json("scan", "--unit", "1-5")
    assert [item["unit"] for item in found["boards"]] == [1, 2]
    assert found["baud"] == 115200 and found["parity"] == "E"


def test_scan_tells_what_is_no_board_of_this_map(two):
    two.boards[1].values["map_version"] = 9
    assert "9 (this tool knows map 6)" in two.out("scan", "--unit", "1-3")
    two.boards[1].values = {}
    two.boards[1].input_words = lambda first: {}
    found = two.json("scan", "--unit", "2", status=1)
    assert found["boards"][0]["trouble"] == "another device (exception 2)"
    two.line.garble = b"\xff\xfe"
    found = two.json("scan", "--unit", "4", status=1)
    assert found["boards"][0]["trouble"].startswith("unreadable (2 bytes)")


def test_scan_finds_nothing(one):
    assert "nothing answers" in one.run("scan", "--unit", "9", status=1).stderr


def test_all_means_those_that_answer(two):
    assert [item["unit"] for item in two.json("get", "status", "--unit", "all")["boards"]] == [1, 2]


def test_info_of_those_that_answer_is_there_though_one_is_absent(two):
    done = two.run("info", "--unit", "1,2,3", status=1)
    assert "board 1: mega" in done.stdout and "board 2: uno" in done.stdout
    assert done.stderr.startswith("pixstep: board 3 on ") and done.stderr.count("\n") == 1
    done = two.run("info", "--unit", "9,1,3", "--json", status=1)
    assert [one["unit"] for one in json.loads(done.stdout)["boards"]] == [1]
    assert [row[:16] for row in done.stderr.splitlines()] == [
        "pixstep: board 9", "pixstep: board 3",
    ]  # fmt: skip
    assert not two.run("info", "--unit", "3", "--json", status=1).stdout


def test_info(two):
    two.board.clock, two.board.permit, two.board.inputs_bits = True, True, 0x20
    text = two.out("info", "--unit", "1,2")
    assert "board 1: mega, firmware 0.1, register map 6 (pixstep mega 0.1)" in text
    assert "pixel clock present, permit output on" in text
    assert "axis 1 minus limit tripped" in text
    assert "board 2: uno" in text
    found = two.json("info", "--unit", "1,2")["boards"]
    assert found[0]["identification"]["vendor"] == "pixstep"
    assert found[0]["reset_cause"] == "power-on"
    assert len(found[0]["axes"]) == 4 and len(found[1]["axes"]) == 1
    assert found[1]["settings"] == {"record": 0, "stored": False, "differ": True}


def test_info_of_a_board_without_the_optional_function(one):
    one.board.do_43 = None
    assert one.json("info")["boards"][0]["identification"] == {}


def test_info_of_a_board_without_diagnosis(one):
    one.board.without("diagnosis", "bits")
    (found,) = one.json("info")["boards"]
    assert found["server_id"] == "pixstep mega 0.1" and found["identification"] == {}
    assert "homing" in found["features"] and "bits" not in found["features"]


def test_info_names_the_fault(one):
    one.board.latch("limit_plus", 7, 2, 99)
    text = one.json("info")["boards"][0]["fault"]
    assert text.startswith("fault limit_plus on axis 2 at pixel 99: the plus limit switch tripped")


@pytest.mark.parametrize(
    "words",
    [["board"], ["board", "settings"], ["board", "log"]],
    ids=" ".join,
)
def test_help_of_every_command(words):
    text = CliRunner().invoke(main, [*words, "--help"]).output
    listed = text.partition("Commands:")[2].strip().splitlines()
    for row in listed:
        name, about = row.split(maxsplit=1)
        assert about.endswith(".") and not about.endswith("..."), row  # whole, on 80 columns
        done = CliRunner().invoke(main, [*words, name, "--help"])
        assert done.exit_code == 0 and "Usage" in done.output


# Measured beside set, positions behind a line


@pytest.mark.parametrize(
    ("hz", "text"),
    [(200, "measured 200 Hz, set to 30 Hz"), (4, "2 edges came in 0.5 s, set to 30 Hz"),
     (0, "no edge came in 0.5 s, set to 30 Hz")],
)  # fmt: skip
def test_a_clock_that_is_awaited_is_counted(one, hz, text):
    one.board.clock, one.board.clock_hz = hz > 0, hz
    assert snapshot.clock_beside(Device(one.client), one.world) == text
    with pytest.raises(BoardError, match=f"no steady pixel clock in 500 edges: {text}"):
        snapshot.await_measured(Device(one.client), one.world, 1 / 30)


def of_another_clock(one):
    """Let the board see a clock of 200 Hz, and be set to 30 Hz."""
    one.board.clock = True
    one.board.values["clock_interval"] = round(TICK_HZ / 256 / 200)


def test_another_clock_than_the_one_set_is_named_wherever_it_is_awaited(one):
    of_another_clock(one)
    wanted = "measured 200.3 Hz, set to 30 Hz"
    assert snapshot.clock_beside(Device(one.client)) == wanted
    assert wanted in one.out("watch", "--once")
    board = Device(one.client)
    now = snapshot.take(board, board.who(), 0.0)
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(watchview.page(now, None))
    assert wanted in console.export_text()
    with pytest.raises(BoardError, match=f"the pixel clock is another one: {wanted}"):
        snapshot.await_measured(board, one.world, 1 / 30)


def test_boards_that_do_not_get_ready_for_the_clock_say_its_frequency(two):
    two.boards[1].clock, two.boards[1].clock_hz = True, 200
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)
    value = two.boards[1].value
    two.boards[1].value = lambda name: 0 if name == "ready" else value(name)
    text = two.err("start", "--unit", "1,2")
    wanted = "its pixel clock is not measured: measured 200 Hz, set to 30 Hz"
    assert text == f"board 2: not ready after 10 s: {wanted}"


def test_watch_shows_no_expected_position_of_a_line_that_is_over(one):
    """Homing gives the axis a new zero after its last line."""
    value = one.board.axis_value
    one.board.axis_value = lambda axis, name: -56 if name == "expected_steps" else value(axis, name)
    one.board.axes[0].state, one.board.axes[1].state = "done", "running"
    one.board.axes[1].repeat = 1
    rows = one.out("watch", "--once").splitlines()
    assert rows[1].startswith("board 1 axis 0: done, position_steps 0, expected_steps -, pixel 0")
    assert ", expected_steps -56, " in rows[2]
    axes = one.json("watch", "--once")["axes"]
    assert [axis["expected_steps"] for axis in axes] == [None, -56, None, None]
