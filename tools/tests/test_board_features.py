# SPDX-License-Identifier: MIT
"""What a board's image was built without: `pixstep board` names it, and sends nothing."""

import pytest

from console import put
from every_function import EveryFunction
from pixstep.board import boards, run, together
from pixstep.board.device import Device
from pixstep.board.errors import MissingFeatureError
from test_board_nonsense import PROFILE


def test_the_table_has_each_bit_once():
    bits = [item.bit for item in boards.features()]
    assert bits == list(range(len(bits)))
    assert boards.feature_names(0b101) == {"homing", "bits"}
    assert set(boards.FEATURE_OF_REGISTERS.values()) <= {item.name for item in boards.features()}


def test_features(two):
    two.boards[1].without("events", "files")
    found = two.json("features", "--unit", "1,2")["boards"]
    assert [item["board"] for item in found] == ["mega", "uno"]
    assert all(row["has"] for row in found[0]["features"])
    lacks = [row["name"] for row in found[1]["features"] if not row["has"]]
    assert lacks == ["events", "files"]
    (row,) = [
        row for row in two.out("features", "--unit", "1,2").splitlines() if "event log" in row
    ]
    assert row.split()[:3] == ["events", "yes", "no"]


@pytest.mark.parametrize(
    ("feature", "words"),
    [
        ("homing", ("home", PROFILE, "--search", 1000)),
        ("homing", ("get", "trip_ticks")),
        ("backlash", ("upload", "line.csv", "--decode", "smooth", "--backlash", "10")),
        ("backlash", ("upload", "line.csv", "--decode", "smooth", "--backlash-policy", "always")),
        ("store", ("settings", "store")),
        ("store", ("settings", "defaults", "--store")),
        ("store", ("set", "dir_hold_us=30", "--store")),
        ("store", ("settings", "import", "settings.toml", "--store")),
        ("tokens", ("arm", "--axis", "0", "--token", "5")),
        ("events", ("log", "events")),
        ("clock_statistics", ("get", "edge_error_ticks")),
        ("driver_timing", ("set", "idle_off_ms=100")),
        ("shared_switch", ("set", "home_is_limit=1")),
        ("shared_switch", ("home", PROFILE, "--search", 1000, "--home-is-limit", "plus")),
    ],
)
def test_what_a_board_lacks_is_refused_with_one_line(one, feature, words):
    put([4, 12, 12, 4])
    one.out("settings", "export", "settings.toml")
    one.board.without(feature)
    before, given = dict(one.board.holdings), len(one.board.commands)
    text = one.err(*words, status=3)
    bit = boards.feature_named(feature).bit
    assert text.startswith(
        f"board 1: its image is built without {feature} (bit {bit} of register features"
    )
    assert one.board.holdings == before and len(one.board.commands) == given
    assert not any(axis.entries for axis in one.board.axes)


def test_boards_are_started_together_only_if_all_know_tokens(two):
    two.boards[1].without("tokens")
    group = [run.LinesOfBoard(Device(two.client, unit), [0]) for unit in (1, 2)]
    with pytest.raises(MissingFeatureError, match=r"board 2: .* without tokens"):
        together.start(group, two.world)
    assert not two.boards[0].commands and not two.boards[1].commands


def test_records_of_a_board_without_clock_statistics_say_so(one):
    one.board.without("clock_statistics")
    assert "edge_error_ticks is always 0" in one.run("log", "records").stderr


def test_functions_that_are_not_served_name_the_feature(one):
    board = EveryFunction(one.client)
    one.board.without("bits", "diagnosis")
    for ask in (lambda: board.read_coils(0, 1), lambda: board.write_coil(0, True)):
        with pytest.raises(MissingFeatureError, match="without bits") as refused:
            ask()
        assert refused.value.code == 1
    for ask in (board.identify, board.identification, board.counters):
        with pytest.raises(MissingFeatureError, match="without diagnosis"):
            ask()


def test_a_stop_is_followed_without_coils(one):
    one.board.without("bits")
    assert "at rest" in one.out("stop")
