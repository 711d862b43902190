# SPDX-License-Identifier: MIT
"""`pixstep board` on fake boards: commands, upload, start, log, watch."""

import json

import pytest

from console import put
from fake_board import FakeAxis
from fake_modbus import FAILURE, RefusalError
from pixstep import natives
from test_board_stop import BROADCAST

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
    assert "stop sent to all boards" in two.out("stop", "--no-look")
    mega, uno = (board.commands for board in two.boards)
    assert mega == [("stop", mask, 0) for mask in BROADCAST]
    assert ("stop", 0b0001, 0) in uno
    assert "--axis needs --unit" in two.err("stop", "--axis", 0, status=2)
    two.out("stop", "--unit", 1, "--axis", 2)
    assert two.board.commands[-1] == ("stop", 0b0100, 0)


def test_a_refused_command_says_why(one):
    text = one.err("arm", "--axis", 1, status=3)
    assert text == "board 1: arm: not possible now: axis 1 is empty"
    one.board.press_estop()
    assert "the emergency stop is pressed" in one.err("arm", "--axis", 1)
    assert "the emergency stop is pressed" in one.err("clear")
    one.board.press_estop(False)
    text = one.err("permit", "on")
    assert "fault estop on axis 0" in text and "`pixstep board clear`" in text
    assert "cleared: fault estop" in one.out("clear")
    assert "no fault was latched" in one.out("clear")


# Upload and start


@pytest.mark.parametrize("pixels", [40, 400])
def test_a_reset_during_a_line_is_named(one, pixels):
    def reset():
        one.board.axes[0] = FakeAxis()
        one.board.values["reset_cause"] = 2

    counts = [5, 6] * (pixels // 2)  # the longer one is streamed
    one.world.later(1, reset)
    assert one.err("upload", put(counts), "--decode", "plain", "--arm") == (
        "board 1: it was reset (reset pin) during the line of axis 0: lines are lost, positions "
        "count from 0 again"
    )


def test_a_line_that_ends_before_another_one_is_loaded_has_ended(one):
    one.out("upload", put([5] * 40), "--decode", "plain")
    axis = one.board.axes[0]

    def end():
        axis.state, axis.entries, axis.position = "loaded", [(1, 0)], 200

    one.world.later(1, end)
    assert one.out("start", "--wait") == "board 1 axis 0: loaded, position 200\n"


def test_upload_arm_and_wait(one):
    text = one.out("upload", put([5] * 40), "--decode", "plain", "--axis", 2, "--arm")
    assert text == (
        "board 1 axis 2: line.csv, plain, 40 pixels, 200 steps, 1.333 s: done, position 200\n"
    )
    assert ("arm", 0b0100, 0) in one.board.commands


def test_a_line_that_did_not_know_its_play_is_named(one):
    counts, ramp = put([0, 4, 12, 8, 0]), ("--decode", "smooth", "--backlash", 4)
    assert one.run("upload", counts, *ramp, "--arm").stderr == ""
    one.board.plays_unknown = 0b0101
    said = one.run("upload", counts, *ramp, "--arm").stderr
    assert said.startswith("note: board 1 axis 0: how much of the play was taken up was not known")
    assert said.count("\n") == 1
    assert "play" not in one.run("upload", counts, "--decode", "smooth", "--arm").stderr
    for words in (("start", "--wait"), ("arm",)):
        one.run("upload", counts, *ramp)
        assert "note: board 1 axis 0: how much of the play" in one.run(*words).stderr
        one.run("stop")


def test_upload_of_two_lines(one):
    found = one.json(
        "upload", put([5, 5]), put([4, 12, 8], "b.csv"), "--decode", "plain", "--decode", "smooth"
    )
    assert [row["state"] for row in found["axes"]] == ["loaded", "loaded"]
    assert [axis.state for axis in one.board.axes[:2]] == ["loaded", "loaded"]


def test_upload_says_the_divider_with_each_line(one):
    lines = (put([5, 5]), put([5, 5], "b.csv"))
    one.out("upload", *lines, "--decode", "plain", "--divider", 4)
    assert one.board.said == [4, 4]
    one.out("disarm")
    one.out("upload", lines[0], "--decode", "plain", "--no-check")
    assert one.board.said == [4, 4, 4]  # the board's own
    one.out("disarm")
    one.board.without("line_divider")
    one.out("upload", lines[0], "--decode", "plain", "--divider", 3)
    assert one.board.said == [4, 4, 4]
    assert one.board.setting("divider") == 3


def test_upload_streams_a_long_line(one):
    counts = [n % 7 + 1 for n in range(400)]
    name = put(counts)
    text = one.err("upload", name, "--decode", "plain", status=2)
    assert "line.csv takes 404 queue entries, axis 0 has room for 128" in text
    assert not one.board.axes[0].entries
    found = one.json("upload", name, "--decode", "plain", "--arm")
    assert found["axes"][0]["state"] == "done"
    assert one.board.axes[0].position == sum(counts)


def test_upload_checks_with_the_boards_limits(one):
    name = put([3000, 3000])
    one.out("set", "pixel_hz=100")
    text = one.err("upload", name, "--decode", "plain", status=3)
    assert (
        "line refused: too_fast at pixel 1" in text and "64" in text and "nothing was sent" in text
    )
    assert one.board.axes[0].state == "empty"
    one.out("upload", name, "--decode", "plain", "--pixel-hz", 30)
    assert one.board.setting("pixel_hz_num") == 30 and one.board.axes[0].state == "loaded"


def test_upload_checks_what_the_settings_forbid(one):
    one.out("set", "start_stop_steps=4", "max_acceleration=8")
    name = put([9, -9])
    assert "reversal_without_ramp at pixel 2" in one.err(
        "upload", name, "--decode", "plain", status=3
    )
    smooth = put([5, 10, 5], "s.csv")
    assert "acceleration at pixel 1" in one.err("upload", smooth, "--decode", "smooth", status=3)
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
    text = one.ended("upload", put([5] * 60), "--decode", "plain", "--arm")
    assert text.startswith("stopped by Ctrl-C: board 1 axis 0 at position ")
    assert one.board.commands[-1] == ("stop", 1, 0)


def test_start_of_one_board_needs_no_token(one):
    one.out("upload", put([5] * 5), "--decode", "plain", "--axis", 1)
    found = one.json("start", "--wait")
    assert found["token"] is None
    records = {"read": 5, "missed": 0, "every_px": 1, "max_difference_steps": 0}
    row = {"axis": 1, "state": "done", "position_steps": 25, "records": records}
    assert found["boards"] == [{"unit": 1, "axes": [row]}]
    assert "no axis has a line loaded" in one.err("start", status=2)


def test_start_together(two):
    two.boards[0].clock = two.boards[1].clock = True
    name = put([5] * 90)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit)
    found = two.json("start", "--unit", "1,2")
    token = found["token"]
    assert 1 <= token <= 0xFFFF
    for board in two.boards:
        assert ("arm", 1, token) in board.commands and ("go", 1, token) in board.commands
        assert board.axes[0].state == "running"
    assert abs(two.boards[0].axes[0].started_s - two.boards[1].axes[0].started_s) < 1e-6


def test_start_together_or_not_at_all(two):
    name = put([5] * 90)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit)
    two.boards[1].press_estop()
    text = two.err("start", "--unit", "1,2")
    assert "board 2: arm: the emergency stop is pressed" in text
    assert two.boards[0].axes[0].state == "empty" and not two.boards[0].axes[0].records
    assert all(name != "go" for name, _, _ in two.boards[0].commands)


def test_arm_survives_a_lost_reply(one):
    one.out("upload", put([5] * 90), "--decode", "plain")
    arm = one.board.obey_arm

    def arm_and_lose_the_reply(*arguments):
        one.board.obey_arm = arm
        arm(*arguments)
        one.line.lose = 1

    one.board.obey_arm = arm_and_lose_the_reply
    assert "axis 0 armed" in one.out("arm")
    assert [name for name, _, _ in one.board.commands].count("arm") == 1
    assert one.board.axes[0].state == "running"


def test_a_board_that_may_be_armed_is_disarmed(two):
    for unit in (1, 2):
        two.out("upload", put([5] * 90), "--decode", "plain", "--unit", unit)
    arm = two.boards[1].obey_arm

    def arm_and_fall_silent(*arguments):
        arm(*arguments)
        two.line.lose = 3  # the reply, and those to the two looks at the axes

    two.boards[1].obey_arm = arm_and_fall_silent
    assert "board 2 on /dev/ttyTEST" in two.err("start", "--unit", "1,2")
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


def test_a_board_that_does_not_hear_go_is_named(two):
    two.boards[0].clock = two.boards[1].clock = True
    for unit in (1, 2):
        two.out("upload", put([5] * 200), "--decode", "plain", "--unit", unit)
    two.boards[1].begin = lambda _axis: None
    text = two.err("start", "--unit", "1,2")
    assert "board 2: axis 0 is still armed while the clock runs" in text
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


def loaded_boards(two, pixels=200):
    two.boards[0].clock = two.boards[1].clock = True
    for unit in (1, 2):
        two.out("upload", put([5] * pixels), "--decode", "plain", "--unit", unit)


def test_ctrl_c_near_the_edge_tells_each_board_before_it_asks_one_again(two):
    loaded_boards(two)
    go, told = two.boards[1].obey_go, []

    def go_and_press(*arguments):
        go(*arguments)
        told.append(len(two.line.requests))
        two.line.lose = 3  # the reply to the first board's stop, and to what is asked of it then
        raise KeyboardInterrupt

    two.boards[1].obey_go = go_and_press
    assert "stopped by Ctrl-C" in two.ended("start", "--unit", "1,2")
    assert [request[0] for request in two.line.requests[told[0] :][:2]] == [1, 2]
    assert [board.commands[-1][0] for board in two.boards] == ["stop", "stop"]
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


def test_boards_begin_on_one_edge_each_by_its_own_count(two):
    loaded_boards(two)
    two.boards[1].first_edge = 0xFFFF - two.boards[1].edge() + two.boards[1].first_edge  # wraps
    two.out("start", "--unit", "1,2")
    begun = [board.axes[0].started_s for board in two.boards]
    assert begun[0] == pytest.approx(begun[1], abs=1e-6)


def test_an_edge_that_one_board_misses_behind_go_stops_all(two):
    loaded_boards(two)
    go = two.boards[1].obey_go

    def go_and_miss_an_edge(*arguments):
        go(*arguments)
        two.boards[1].first_edge -= 1

    two.boards[1].obey_go = go_and_miss_an_edge
    text = two.err("start", "--unit", "1,2")
    assert "boards 1 and 2 have counted different numbers of clock edges" in text
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


def test_counts_of_edges_are_compared_at_the_end(two):
    loaded_boards(two, 30)
    two.world.later(1.5, lambda: setattr(two.boards[0], "first_edge", 60_000 + 977 + 1))
    text = two.err("start", "--unit", "1,2", "--wait")
    assert "counted different numbers of clock edges since line zero" in text
    assert "board 1 3" in text and "board 2 3" in text


def test_a_board_that_refuses_go_is_named_and_none_moves(two):
    loaded_boards(two)

    def refuse(*_):
        raise RefusalError(FAILURE)

    two.boards[1].obey_go = refuse
    text = two.err("start", "--unit", "1,2")
    assert "board 2: it refuses to go" in text
    assert [board.axes[0].state for board in two.boards] == ["empty", "empty"]


def test_boards_on_different_clocks_are_not_started(two):
    loaded_boards(two)
    mark = two.boards[1].obey_mark

    def mark_half_a_period_off(*arguments):
        mark(*arguments)
        count, at_s = two.boards[1].mark
        two.boards[1].mark = (count, at_s + 0.5 / 30)

    two.boards[1].obey_mark = mark_half_a_period_off
    assert "boards 1 and 2 see clock edges 0.50 periods apart" in two.err("start", "--unit", "1,2")


def test_a_board_that_hears_no_broadcast_is_named(two):
    loaded_boards(two)
    two.boards[1].obey_mark = lambda *_: None
    assert "board 2: it does not hear broadcasts" in two.err("start", "--unit", "1,2")


def test_start_with_a_wrong_token_names_the_fault(two):
    two.boards[0].clock = two.boards[1].clock = True
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
    two.boards[1].without("events")
    assert "board 2: its image is built without events (bit 4 of register features" in two.err(
        "log", "events", "--unit", 2, status=3
    )


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


# Nothing is sent before everything is checked


@pytest.mark.parametrize(
    "words",
    [
        (3, "upload", "line.csv", "--decode", "plain", "--pixel-hz", 100),
        (2, "upload", "long.csv", "--decode", "plain", "--pixel-hz", 20),
        (3, "upload", "line.csv", "--decode", "plain", "--pixel-hz", 100, "--backlash-policy",
         "on_reversal"),
        (3, "move", natives.root() / "tools/data/AccProf-fast-move.csv", "--steps", 40_000,
         "--pixel-hz", 3000),
        (2, "home", natives.root() / "tools/data/AccProf-fast-move.csv", "--pixel-hz", 100_000),
        (3, "home", natives.root() / "tools/data/AccProf-fast-move.csv", "--pixel-hz", 3000),
    ],
)  # fmt: skip
def test_a_line_that_is_refused_leaves_the_settings_as_they_were(one, words):
    put([3000, 3000])
    put([n % 7 + 1 for n in range(400)], "long.csv")
    before = dict(one.board.holdings)
    status, *words = words
    one.run(*words, status=status)
    assert one.board.holdings == before
    assert not [request for request in one.line.requests if request[1] not in (3, 4)]


# Busy, and why


@pytest.mark.parametrize(
    ("state", "reason"),
    [
        ("loaded", "axis 2 has a line loaded (`pixstep board disarm` forgets it)"),
        ("running", "axis 2 is running (`pixstep board stop` stops it)"),
        ("armed", "axis 2 is armed (`pixstep board disarm` takes it back)"),
        ("fault", "axis 2 has stopped with a fault (`pixstep board clear` clears it)"),
        ("done", "a line is queued, or an axis is not at rest yet: try again"),
    ],
)
def test_settings_that_cannot_be_changed_now_say_why(one, state, reason):
    one.board.axes[2].entries = [(7, 7)] * 4
    one.board.axes[2].state = state
    one.board.tick = lambda: None
    assert one.err("set", "dir_hold_us=30", status=3) == f"board 1: busy: {reason}"
    words = ("upload", put([4, 4]), "--decode", "plain", "--pixel-hz", 50)
    assert one.err(*words, status=3) == f"board 1: busy: {reason}"


def test_disarm_cures_a_line_that_was_left_loaded(one):
    one.out("upload", put([4, 4]), "--decode", "plain")
    assert "axis 0 has a line loaded" in one.err("set", "dir_hold_us=30", status=3)
    one.out("disarm")
    assert "dir_hold_us: 20 -> 30 us" in one.out("set", "dir_hold_us=30")
