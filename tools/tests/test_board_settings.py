# SPDX-License-Identifier: MIT
"""`pixstep board` on fake boards: get, set, settings."""

import pytest

from effort import cases
from pixstep.board import registers as regs

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
    assert "switching a driver on" in " ".join(one.out("get").split())


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
    assert "25 settings of board 1 (mega)" in one.out("settings", "export", "a.toml")
    text = (tmp_path / "a.toml").read_text()
    assert "# us, 1 to 1000, default 20\ndir_hold_us = 33\n" in text
    assert one.out("settings", "export", "-") == text
    one.out("settings", "defaults")
    assert one.board.setting("dir_hold_us") == 20
    assert one.out("settings", "diff", "a.toml", status=1).endswith("dir_hold_us: 33 -> 20 us\n")
    assert "1 setting would change" in one.out("settings", "import", "a.toml", "--dry-run")
    assert one.board.setting("dir_hold_us") == 20
    text = one.out("settings", "import", "a.toml", "--store")
    assert text == (
        "board 1: 1 setting changed\n  dir_hold_us: 20 -> 33 us\n  stored as record 1\n"
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
        ("map_version = 4\n", ": no table [settings]"),
        ("[settings]\npixel_hz_num = 60000\n", "the period must be 1024"),
        ("[settings]\nparity = " + 5000 * "1" + "\n", ":2: a number has too many digits"),
        ("[settings]\nparity = 0x" + 5000 * "1" + "\n", ":2: parity = a number of 19997 bits: 0"),
        ("[settings]\nparity = " + 3000 * "[" + 3000 * "]" + "\n", ": values are nested too"),
        ("[settings]\nparity = " + 100 * "[" + 100 * "]" + "\n", ":2: parity = [[[["),
        ("[settings]\nparity = 2024-01-01\n", ":2: parity = datetime.date(2024, 1, 1): a whole"),
        ("settings = 3\n", ": no table [settings]"),
        ('board = "uno"\n[settings]\nparity = 2\n', ": board = 'uno': board 1 is a mega"),
        (
            "board = 7\n[settings]\nparity = 2\n",
            ":1: board = 7: 'uno', 'mega'",
        ),
        (
            "board = []\n[settings]\nparity = 2\n",
            ":1: board = []: 'uno', 'mega'",
        ),
        ("map_version = true\n[settings]\nparity = 2\n", ":1: settings of register map True"),
        ("count = 2\n[settings]\nparity = 1\n", ": cut off: 1 of 2 settings"),
        ("count = 1\n[settings]\nparity = 1", ": cut off: 1 of 1 settings, or the end of the"),
    ],
)
def test_a_bad_file_writes_nothing(one, tmp_path, text, complaint):
    (tmp_path / "bad.toml").write_text(text)
    before = dict(one.board.holdings)
    assert complaint in one.err("settings", "import", "bad.toml", status=3)
    assert one.board.holdings == before


def test_an_export_that_is_cut_off_anywhere_is_refused(one, tmp_path):
    one.out("set", "enable_settle_ms=100")
    one.out("settings", "export", "a.toml")
    data = (tmp_path / "a.toml").read_bytes()
    before = dict(one.board.holdings)
    for size in range(0, len(data), cases(7, 1)):
        (tmp_path / "cut.toml").write_bytes(data[:size])
        assert one.err("settings", "import", "cut.toml", status=3).startswith("cut.toml:")
    assert one.board.holdings == before
    assert "0 settings changed" in one.out("settings", "import", "a.toml")


def test_a_number_of_thousands_of_digits_on_the_command_line(one):
    text = one.err("set", "parity=0x" + 5000 * "1", status=2)
    assert text.startswith("parity = a number of 19997 bits: 0 to 2")
    assert one.err("set", "parity=" + 5000 * "1", status=2).startswith("parity = 1111")
    assert "a number of 19997 bits" in one.err("set", "baud=0x" + 5000 * "1", status=2)


def test_import_to_several_boards_needs_the_address_left_out(two):
    two.out("settings", "export", "a.toml")
    words = ("settings", "import", "a.toml", "--unit", "1,2")
    assert "add --skip unit_address" in two.err(*words, status=2)
    two.out("set", "dir_hold_us=44")
    two.out("settings", "export", "a.toml", "--force")
    text = two.err(*words, "--skip", "unit_address", status=3)
    assert text.startswith("a.toml: board = 'mega': board 2 is a uno (--skip board imports it")
    assert two.boards[0].setting("dir_hold_us") == 44 != two.boards[1].setting("dir_hold_us")
    two.out(*words, "--skip", "unit_address", "--skip", "board")
    assert [board.setting("dir_hold_us") for board in two.boards] == [44, 44]
    assert [board.setting("unit_address") for board in two.boards] == [1, 2]
    assert "no such setting" in two.err(*words, "--skip", "x", status=2)


def test_store(one):
    assert one.out("settings", "store") == "board 1: stored as record 1\n"
    one.board.obey_store = lambda *_: None
    assert "were not stored (record 1)" in one.err("settings", "store")


def test_an_address_that_another_board_has_is_refused(two):
    said = "board 2: unit_address = 1: another board answers at this address already"
    assert two.err("set", "unit_address=1", "--unit", 2, status=2) == said
    two.out("settings", "export", "a.toml")
    words = ("settings", "import", "a.toml", "--skip", "board", "--unit", 2)
    assert two.err(*words, status=3) == f"a.toml: {said}"
    two.out(*words, "--skip", "unit_address")
    assert two.err("settings", "defaults", "--unit", 2, status=2) == said
    assert [board.setting("unit_address") for board in two.boards] == [1, 2]
