# SPDX-License-Identifier: MIT
"""`pixstep board` on fake boards: what commands say and send, and every way they fail."""

import json

import pytest
from click.testing import CliRunner

from console import make_console  # noqa: F401 (a fixture)
from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep import formats
from pixstep.board import registers as regs
from pixstep.cli.board import group
from pixstep.cli.main import main


class Rig:
    """A line with fake boards and the console on it."""

    def __init__(self, make, *kinds):
        self.world = FakeWorld()
        self.boards = [FakeBoard(self.world, unit, kind) for unit, kind in enumerate(kinds, 1)]
        self.line = FakeLine(self.world, *self.boards)
        self.console = make(self.line, self.world)
        self.board = self.boards[0]

    def __getattr__(self, name):
        return getattr(self.console, name)


@pytest.fixture
def one(make_console):  # noqa: F811
    return Rig(make_console, "mega")


@pytest.fixture
def two(make_console):  # noqa: F811
    return Rig(make_console, "mega", "uno")


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
    assert "board 1 has register map 2 (firmware 0.1), this tool knows map 3" in text


def test_exceptions_are_named(one):
    one.board.axes[0].entries = [(1, 0)]
    text = one.err("set", "dir_setup_us=30")
    assert text == "board 1: write at 0x0006 answered with exception 6, busy"


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
    assert rows[0][:5] == ["1", "mega", "0.1", "3", "4"]
    assert rows[1][:5] == ["2", "uno", "0.1", "3", "1"]
    found = two.json("scan", "--unit", "1-5")
    assert [item["unit"] for item in found["boards"]] == [1, 2]
    assert found["baud"] == 115200 and found["parity"] == "E"


def test_scan_tells_what_is_no_board_of_this_map(two):
    two.boards[1].values["map_version"] = 9
    assert "9 (this tool knows map 3)" in two.out("scan", "--unit", "1-3")
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


def test_info(two):
    two.board.clock, two.board.permit, two.board.inputs_bits = True, True, 0x20
    text = two.out("info", "--unit", "1,2")
    assert "board 1: mega, firmware 0.1, register map 3 (pixstep mega 0.1)" in text
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


def test_info_names_the_fault(one):
    one.board.latch("limit_plus", 7, 2, 99)
    text = one.json("info")["boards"][0]["fault"]
    assert text.startswith("fault limit_plus on axis 2 at pixel 99: the plus limit switch tripped")


# Get and set


def test_get_by_name_wild_card_and_axis(one):
    one.board.axes[2].position = -5
    assert one.out("get", "dir_*", "axis2.position_steps") == (
        "dir_setup_us = 20 us\ndir_hold_us = 20 us\naxis2.position_steps = -5 steps\n"
    )
    assert len(one.out("get", "axis_state").splitlines()) == 4
    assert one.out("get", "parity", "firmware_version") == (
        "parity = 2 (even)\nfirmware_version = 1 (0.1)\n"
    )


def test_get_everything(one):
    rows = one.json("get")["boards"][0]["registers"]
    table = regs.register_map()
    assert len(rows) == len(regs.settings()) + len(table.inputs) + 4 * len(table.axis_inputs)
    hold = next(row for row in rows if row["name"] == "dir_hold_us")
    assert (hold["value"], hold["unit"], hold["minimum"], hold["maximum"], hold["default"]) == (
        20, "us", 1, 1000, 20,
    )  # fmt: skip
    assert "driver's switching on" in " ".join(one.out("get").split())


def test_get_of_an_unknown_name_asks_nothing(one):
    assert one.err("get", "statsu", status=2) == "no register 'statsu'; do you mean status?"
    assert not one.line.requests


def test_set_shows_old_and_new_in_one_request(one):
    text = one.out("set", "dir_setup_us=25", "idle_off_ms=0x1F4", "dir_hold_us=20")
    assert text == (
        "dir_setup_us: 20 -> 25 us\nidle_off_ms: 0 -> 500 ms\ndir_hold_us is 20 already\n"
    )
    assert one.board.setting("idle_off_ms") == 500 and one.board.setting("dir_setup_us") == 25
    writes = [item for item in one.line.requests if item[1] == 16]
    assert len(writes) == 1


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("dir_hold_us=0", "dir_hold_us = 0: 1 to 1000 us, default 20"),
        ("dir_hold_us", "'dir_hold_us': NAME=VALUE is wanted"),
        ("dir_hold_us=x", "dir_hold_us = x: a whole number is wanted"),
        ("dir_hold=3", "no setting 'dir_hold'; do you mean dir_hold_us?"),
        ("status=1", "status is what the board measures: it cannot be set"),
        ("baud=115210", "baud = 115210: a multiple of 100 is wanted"),
        ("pixel_hz=0", "pixel frequency '0': must be above 0 Hz"),
        ("command=1", "no setting 'command'"),
    ],
)
def test_set_refuses_before_anything_is_sent(one, text, complaint):
    assert complaint in one.err("set", "dir_setup_us=30", text, status=2)
    assert not one.line.requests


def test_set_pixel_hz(one):
    one.out("set", "pixel_hz=30000/1001")
    assert one.board.setting("pixel_hz_num") == 30000
    assert one.board.setting("pixel_hz_den") == 1001
    assert "the period must be" in one.err("set", "pixel_hz=60000", status=2)


def test_set_follows_the_address(one):
    assert "unit_address: 1 -> 9" in one.out("set", "unit_address=9", "--store")
    assert "no reply" in one.err("get", "status")
    assert "status" in one.out("get", "status", "--unit", 9)
    assert one.board.stored[0] == 9


def test_several_boards_cannot_have_one_address(two):
    assert "cannot have one address" in two.err("set", "unit_address=9", "--unit", "1,2", status=2)


# Settings


def test_export_and_import(one, tmp_path):
    one.out("set", "dir_hold_us=33")
    assert "16 settings of board 1 (mega)" in one.out("settings", "export", "a.toml")
    text = (tmp_path / "a.toml").read_text()
    assert "# us, 1 to 1000, default 20\ndir_hold_us = 33\n" in text
    assert one.out("settings", "export", "-") == text
    one.out("settings", "defaults")
    assert one.board.setting("dir_hold_us") == 20
    assert one.out("settings", "diff", "a.toml", status=1).endswith("dir_hold_us: 33 -> 20 us\n")
    assert "1 settings would change" in one.out("settings", "import", "a.toml", "--dry-run")
    assert one.board.setting("dir_hold_us") == 20
    text = one.out("settings", "import", "a.toml", "--store")
    assert text == (
        "board 1: 1 settings changed\n  dir_hold_us: 20 -> 33 us\n  stored as record 1\n"
    )
    assert "no difference" in one.out("settings", "diff", "a.toml")
    assert one.board.stored == one.board.holdings


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[settings]\ndir_hold_us = 5\n\ndir_setup_us = 0\n", ":4: dir_setup_us = 0: 1 to 1000 us"),
        ("[settings]\ndir_hold_us = 5\nnot_there = 1\n", ":3: no setting 'not_there'"),
        ("[settings]\ndir_hold_us = '5'\n", ":2: dir_hold_us = '5': a whole number"),
        ("[settings]\ndir_hold_us = true\n", ":2: dir_hold_us = True: a whole number"),
        ("[settings]\ndir_hold_us = \n", ":2:15: Invalid value"),
        ("[settings]\nparity = 1\nparity = 2\n", ":3:11: Cannot overwrite a value"),
        ("map_version = 2\n[settings]\nparity = 1\n", ":1: settings of register map 2"),
        ("what = 2\n[settings]\nparity = 1\n", ":1: unknown key 'what'"),
        ("map_version = 3\n", ": no table [settings]"),
        ("[settings]\npixel_hz_num = 60000\n", "the period must be 1024"),
    ],
)
def test_a_bad_file_writes_nothing(one, tmp_path, text, complaint):
    (tmp_path / "bad.toml").write_text(text)
    before = dict(one.board.holdings)
    assert complaint in one.err("settings", "import", "bad.toml", status=2)
    assert one.board.holdings == before


def test_import_to_several_boards_needs_the_address_left_out(two):
    two.out("settings", "export", "a.toml")
    words = ("settings", "import", "a.toml", "--unit", "1,2")
    assert "add --skip unit_address" in two.err(*words, status=2)
    two.out("set", "dir_hold_us=44")
    two.out("settings", "export", "a.toml")
    two.out(*words, "--skip", "unit_address")
    assert [board.setting("dir_hold_us") for board in two.boards] == [44, 44]
    assert [board.setting("unit_address") for board in two.boards] == [1, 2]
    assert "no such setting" in two.err(*words, "--skip", "x", status=2)


def test_store(one):
    assert one.out("settings", "store") == "board 1: stored as record 1\n"
    one.board.obey_store = lambda *_: None
    assert "were not stored (record 1)" in one.err("settings", "store")


# Commands


def test_commands_and_their_masks(one):
    one.out("enable", "--axis", 1, "--axis", 3)
    one.out("disable", "--axis", 1)
    one.out("permit", "on")
    one.out("permit", "off")
    assert one.board.commands == [
        ("enable", 0b1010, 0), ("disable", 0b0010, 0), ("permit_on", 1, 0), ("permit_off", 1, 0),
    ]  # fmt: skip


def test_stop_is_a_broadcast_that_every_kind_of_board_understands(two):
    assert "stop sent to all boards" in two.out("stop")
    for board, most in zip(two.boards, (0b1111, 0b0001), strict=True):
        assert ("stop", most, 0) in board.commands
    assert "--axis needs --unit" in two.err("stop", "--axis", 0, status=2)
    two.out("stop", "--unit", 1, "--axis", 2)
    assert two.board.commands[-1] == ("stop", 0b0100, 0)


def test_a_refused_command_says_why(one):
    assert one.err("arm", "--axis", 1) == ("board 1: arm: not possible now: axis 1 is empty")
    one.board.press_estop()
    assert "the emergency stop is pressed" in one.err("arm", "--axis", 1)
    assert "the emergency stop is pressed" in one.err("clear")
    one.board.press_estop(False)
    text = one.err("permit", "on")
    assert "fault estop on axis 0" in text and "`pixstep board clear`" in text
    assert "cleared: fault estop" in one.out("clear")
    assert "no fault was latched" in one.out("clear")


# Upload and start


def put(counts, name="line.csv"):
    formats.write_csv(name, counts)
    return name


def test_upload_arm_and_wait(one):
    text = one.out("upload", put([5] * 40), "--decode", "plain", "--axis", 2, "--arm")
    assert text == (
        "board 1 axis 2: line.csv, plain, 40 pixels, 200 steps, 1.333 s: done, position 200\n"
    )
    assert ("arm", 0b0100, 0) in one.board.commands


def test_upload_of_two_lines(one):
    found = one.json(
        "upload", put([5, 5]), put([4, 12, 8], "b.csv"), "--decode", "plain", "--decode", "smooth"
    )
    assert [row["state"] for row in found["axes"]] == ["loaded", "loaded"]
    assert [axis.state for axis in one.board.axes[:2]] == ["loaded", "loaded"]


def test_upload_streams_a_long_line(one):
    counts = [n % 7 + 1 for n in range(400)]
    name = put(counts)
    text = one.err("upload", name, "--decode", "plain", status=2)
    assert "line.csv takes 403 queue entries, axis 0 has room for 128" in text
    assert not one.board.axes[0].entries
    found = one.json("upload", name, "--decode", "plain", "--arm")
    assert found["axes"][0]["state"] == "done"
    assert one.board.axes[0].position == sum(counts)


def test_upload_checks_with_the_boards_limits(one):
    name = put([700, 700])
    one.out("set", "pixel_hz=100")
    text = one.err("upload", name, "--decode", "plain", status=2)
    assert (
        "line refused: too_fast at pixel 1" in text and "266" in text and "nothing was sent" in text
    )
    assert one.board.axes[0].state == "empty"
    one.out("upload", name, "--decode", "plain", "--pixel-hz", 30)
    assert one.board.setting("pixel_hz_num") == 30 and one.board.axes[0].state == "loaded"


def test_upload_checks_what_the_settings_forbid(one):
    one.out("set", "start_stop_steps=4", "max_acceleration=8")
    name = put([9, -9])
    assert "reversal_without_ramp at pixel 2" in one.err(
        "upload", name, "--decode", "plain", status=2
    )
    smooth = put([20, 20], "s.csv")
    assert "acceleration at pixel 1" in one.err("upload", smooth, "--decode", "smooth", status=2)
    assert one.board.axes[0].state == "empty"


def test_a_fault_ends_the_waiting(one):
    one.world.later(0.5, lambda: one.board.latch("limit_plus", 0, 0, 12))
    text = one.err("upload", put([5] * 60), "--decode", "plain", "--arm")
    assert "board 1: fault limit_plus on axis 0 at pixel 12" in text


def test_a_stop_ends_the_waiting(one):
    one.world.later(0.5, lambda: one.board.obey("stop", 1, 0))
    text = one.err("upload", put([5] * 60), "--decode", "plain", "--arm")
    assert text == "board 1: axis 0 is empty: stopped before its end"


def test_ctrl_c_stops_what_moves(one):
    def interrupt():
        raise KeyboardInterrupt

    one.world.later(0.5, interrupt)
    text = one.err("upload", put([5] * 60), "--decode", "plain", "--arm")
    assert text.startswith("stopped by Ctrl-C: board 1 axis 0 at position ")
    assert one.board.commands[-1] == ("stop", 1, 0)


def test_start_of_one_board_needs_no_token(one):
    one.out("upload", put([5] * 5), "--decode", "plain", "--axis", 1)
    found = one.json("start", "--wait")
    assert found["token"] is None
    assert found["boards"] == [
        {"unit": 1, "axes": [{"axis": 1, "state": "done", "position_steps": 25}]}
    ]
    assert "no axis has a line loaded" in one.err("start", status=2)


def test_start_together(two):
    name = put([5] * 90)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit)
    found = two.json("start", "--unit", "1,2")
    token = found["token"]
    assert 1 <= token <= 0xFFFF
    for board in two.boards:
        assert ("arm", 1, token) in board.commands and ("go", 1, token) in board.commands
        assert board.axes[0].state == "running"
    assert abs(two.boards[0].axes[0].started_s - two.boards[1].axes[0].started_s) < 1e-9


def test_start_together_or_not_at_all(two):
    name = put([5] * 90)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit)
    two.boards[1].press_estop()
    text = two.err("start", "--unit", "1,2")
    assert "board 2: arm: the emergency stop is pressed" in text
    assert two.boards[0].axes[0].state == "empty" and not two.boards[0].axes[0].records
    assert all(name != "go" for name, _, _ in two.boards[0].commands)


def test_start_with_a_wrong_token_names_the_fault(two):
    name = put([5] * 90)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit)
    two.boards[1].obey_go = lambda *_: two.boards[1].latch("wrong_token", 5)
    assert "board 2: fault wrong_token" in two.err("start", "--unit", "1,2")


# Log and watch


def test_log_has_every_pixel_once(one, tmp_path):
    one.out("upload", put([3] * 90), "--decode", "plain", "--arm", "--no-wait")
    done = one.run("log", "--axis", 0, "-o", "log.csv")
    rows = (tmp_path / "log.csv").read_text().splitlines()
    assert rows[0] == "line,axis,pixel,expected_steps,actual_steps,edge_error_ticks"
    first = int(rows[1].split(",")[2])
    assert rows[1:] == [f"1,0,{n},{3 * n},{3 * n},0" for n in range(first, 91)]
    assert f"{91 - first} records, none missed" in done.stderr


def test_log_says_what_it_missed(one, tmp_path):
    one.board.values["pixel_period_ticks"] = 48_000_000  # as if there were ten seconds' time
    one.board.values["record_capacity"] = 2
    one.out("upload", put([3] * 90), "--decode", "plain", "--arm", "--no-wait")
    done = one.run("log", "--axis", 0, "-o", "log.csv", status=1)
    pixels = [int(row.split(",")[2]) for row in (tmp_path / "log.csv").read_text().split()[1:]]
    missed = pixels[-1] - pixels[0] + 1 - len(pixels)
    assert missed > 20 and f"missed: {missed} of axis 0" in done.stderr


def test_log_tells_lines_apart(one):
    one.out("upload", put([3] * 4), "--decode", "plain", "--arm")
    one.out("upload", put([2] * 4), "--decode", "plain", "--arm", "--no-wait")
    rows = one.out("log", "records", "--axis", 0).split()[1:]
    assert {row.split(",")[0] for row in rows} == {"2"}
    assert rows[-1] == "2,0,4,20,20,0"


def test_events(one):
    one.board.latch("limit_minus", 3, 1, 77)
    one.board.events.append((2, 0x0108, 0, 0, 0, 5000))
    lines = one.out("log", "events").splitlines()
    assert lines[0].split(maxsplit=3)[3].startswith("limit_minus: the minus limit switch tripped")
    assert lines[0].endswith("(axis 1, pixel 77, argument 3)")
    assert lines[1].endswith("5.000 s  reset: watchdog")
    rows = [json.loads(line) for line in one.out("log", "events", "--json").splitlines()]
    assert [row["name"] for row in rows] == ["limit_minus", "reset"]
    one.board.events += [(n, 1, 0, 0, 0, 0) for n in range(3, 9)]
    done = one.run("log", "events")
    assert "4 older events are no longer kept" in done.stderr and len(done.stdout.split("\n")) == 5


def test_a_board_without_an_event_log(two):
    two.boards[1].values["event_capacity"] = 0
    assert "board 2 (uno) has no event log" in two.err("log", "events", "--unit", 2, status=2)


def test_watch(two):
    two.board.clock = True
    two.board.latch("starved", 0, 1, 5)
    text = two.out("watch", "--once", "--unit", "1,2")
    assert "board 1 mega: clock, fault; fault starved (axis 1, pixel 5, argument 0)" in text
    assert "board 2 axis 0: empty, position_steps 0" in text
    rows = [json.loads(row) for row in two.out("watch", "--count", 2, "--json").splitlines()]
    assert len(rows) == 2 and rows[0]["rates_per_s"] == {}
    assert rows[1]["rates_per_s"]["pixel_edges"] == pytest.approx(30, abs=2)
    assert rows[1]["status"]["clock"] is True and len(rows[1]["axes"]) == 4


def test_watch_goes_on_when_a_board_falls_silent(two):
    two.world.later(0.5, lambda: setattr(two.line, "lose", 2))  # the request and its repetition
    rows = [json.loads(row) for row in two.out("watch", "--count", 3, "--json").splitlines()]
    assert ["no reply" in row.get("trouble", "") for row in rows] == [False, True, False]
    assert rows[2]["rates_per_s"] == {}  # nothing to compare with


def test_help_of_every_command():
    for name, command in group.board.commands.items():
        nested = getattr(command, "commands", {})
        for words in ([name], *([name, item] for item in nested)):
            done = CliRunner().invoke(main, ["board", *words, "--help"])
            assert done.exit_code == 0 and "Usage" in done.output
