# SPDX-License-Identifier: MIT
"""Operations with a board, by Python and by the console: the same requests, the same results."""

import json
from fractions import Fraction

import pytest

import pixstep as px
from console import Console
from pixstep import formats, natives, ops
from pixstep.board.errors import BoardError
from pixstep.errors import UserError
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

HZ = 100
COUNTS = [0, 2, 4, 6, 6, 6, 4, 2, 0]
PASSING = {"time_s", "edges", "pixel_edges", "counters", "rates_per_s", "measured_hz", "pixel"}


@pytest.fixture
def mega(monkeypatch, tmp_path, simulator):
    """Yield a bus with a simulated Mega, and a console on it."""
    monkeypatch.chdir(tmp_path)
    formats.write_csv(tmp_path / "line.csv", COUNTS)
    with SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(HZ))) as found:
        yield found, Console(monkeypatch, found.simulator, found.world)


def lasting(data):
    """Return data without what goes on between two looks."""
    if isinstance(data, dict):
        return {key: lasting(value) for key, value in data.items() if key not in PASSING}
    return [lasting(one) for one in data] if isinstance(data, list) else data


@pytest.mark.parametrize(
    ("words", "given", "options"),
    [
        ("scan", {"units": (1, 3)}, ("--unit", "1,3")),
        ("info", {}, ()),
        ("features", {"units": 1}, ()),
        ("get", {"names": ["dir_*", "axis1.position_steps"]}, ("dir_*", "axis1.position_steps")),
        ("settings diff", {}, ()),
        ("settings export", {"file": "a.toml"}, ("a.toml", "--force")),
        ("clear", {}, ()),
        ("enable", {"axes": 1}, ("--axis", 1)),
        ("permit", {"state": "on"}, ("on",)),
        ("stop", {"units": 1, "axes": (0, 2)}, ("--unit", 1, "--axis", 0, "--axis", 2)),
        ("stop", {"look": False}, ("--no-look",)),
        ("set", {"assigned": "dir_setup_us=20"}, ("dir_setup_us=20",)),
    ],
)
def test_function_and_command_say_the_same(mega, words, given, options):
    link, console = mega
    done = getattr(ops, f"board_{words.replace(' ', '_')}")(**given, link=link)
    printed = console.json(*words.split(), *options, status=done.status)
    if "port" in printed:
        assert (printed.pop("port"), done["port"]) == ("/dev/ttyTEST", link.port)
    del printed["schema"], printed["machine"]
    made = {key: value for key, value in done.to_dict().items() if key != "port"}
    assert lasting(json.loads(json.dumps(made))) == lasting(printed)
    assert done.page() or words == "stop"


def test_lines_are_queued_started_and_their_records_kept(mega):
    link, console = mega
    run = ops.board_upload("line.csv", decode="plain", pixel_hz=HZ, arm=True, link=link)
    (axis,) = run["axes"]
    assert axis["state"] == "done" and axis["position_steps"] == axis["steps"] == sum(COUNTS)
    assert axis["records"] == {
        "read": len(COUNTS), "missed": 0, "every_px": 1, "max_difference_steps": 0,
    }  # fmt: skip
    assert ops.board_upload("line.csv", decode="plain", link=link)["axes"][0]["state"] == "loaded"
    started = ops.board_start(wait=True, link=link)
    assert started["boards"][0]["axes"][0]["position_steps"] == 2 * sum(COUNTS)
    log = ops.board_log_records(axes=0, link=link)
    assert [row["pixel"] for row in log["rows"]] == list(range(1, len(COUNTS) + 1))
    assert log["axes"] == [{"axis": 0, "read": len(COUNTS), "missed": 0}] and log.fine
    lines = console.out("log", "records", "--axis", 0).splitlines()
    assert lines[1:] == [",".join(map(str, row.values())) for row in log["rows"]]


def test_a_program_is_told_of_events_and_looks(mega):
    link, console = mega
    log = ops.board_log_events(link=link)
    rows = [json.loads(row) for row in console.out("log", "events", "--json").splitlines()]
    assert [{"schema": 1, **event} for event in log["events"]] == rows
    assert log["events"][0]["name"] == "reset" and "power-on" in log.page()
    looks = ops.board_watch(count=3, interval=0.1, link=link)["boards"]
    assert len(looks) == 3 and looks[1]["rates_per_s"]["pixel_edges"] == pytest.approx(HZ, rel=0.2)
    assert len(ops.board_watch(once=True, link=link)["boards"]) == 1


def test_a_self_test_without_a_person_asks_nobody(mega):
    link, _ = mega
    first, second = (
        {one["name"]: one["verdict"] for one in done["checks"]}
        for done in (ops.board_selftest(axes=0, yes=yes, link=link) for yes in (False, True))
    )
    assert first == second and first["identity"] == "ok" and first["ESTOP"] == "skipped"


def test_a_move_ends_where_it_is_to_end(mega):
    link, _ = mega
    formats.write_csv("profile.csv", list(range(2, 42, 2)))
    moved = ops.board_move("profile.csv", steps=500, pixel_hz=HZ, link=link)
    assert moved["from_steps"] == 0 and moved["to_steps"] == moved["steps"] == 500
    with pytest.raises(UserError, match=r"^axis: 7 is not in the range 0<=x<=3"):
        ops.board_move("profile.csv", steps=500, axis=7, link=link)


def test_a_simulated_board_gives_what_was_seen(tmp_path, simulator):
    script = tmp_path / "s.txt"
    script.write_text("press home 1\nwait 20ms\nquit\n")
    bench = ops.board_simulate(board="mega", pixel_hz=HZ, script=script)
    assert [one["event"] for one in bench["events"]] == [
        "ready", "press home 1", "wait 20ms", "quit",
    ]  # fmt: skip
    assert bench["events"][1]["axes"][1]["closed"] == ["home"]
    assert bench["events"][2]["time_s"] - bench["events"][1]["time_s"] == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("name", "given", "said"),
    [
        ("scan", {"bauds": "1"}, "bauds 1: rates from 300 to 4000000 baud are wanted"),
        ("stop", {"axes": 1}, "axes needs units: a broadcast stops all axes of all boards"),
        ("get", {"names": "nothing"}, "no register 'nothing'"),
        ("start", {"record_file": "a.csv"}, "record_file: records are read while lines run"),
        ("settings_import", {"file": "a.toml", "skip": "x"}, "skip x: there is no such setting"),
        ("info", {"units": 300}, "units: 300 is not in the range 1<=x<=247"),
        ("info", {"units": "1-"}, "units: '1-': addresses are wanted"),
    ],
)
def test_errors_name_the_fields_of_python(mega, name, given, said):
    link, _ = mega
    ops.board_settings_export("a.toml", link=link)
    with pytest.raises(UserError) as raised:
        getattr(ops, f"board_{name}")(**given, link=link)
    assert str(raised.value).startswith(said)


def test_a_board_that_is_not_there_is_a_board_s_error(mega):
    link, _ = mega
    with pytest.raises(BoardError, match="board 9: no reply"):
        ops.board_info(units=9, link=link)


def test_an_open_bus_or_a_board_of_it_is_taken():
    with px.simulated_bus(["uno", "mega"], pixel_hz=HZ) as bus:
        kinds = [
            ops.board_info(link=place)["boards"][0]["board"]
            for place in (bus, bus.board(1), bus.board(2))
        ]
        assert kinds == ["uno", "uno", "mega"]
        ops.board_set(["dir_setup_us=21"], link=bus.board(2))
        read = [bus.board(unit).device.setting("dir_setup_us") for unit in (1, 2)]
        assert read[1] == 21 != read[0]
        both = ops.board_info(units=(1, 2), link=bus.board(2))["boards"]
        assert [one["unit"] for one in both] == [1, 2]


def test_the_document_s_example_runs(tmp_path, monkeypatch, capsys, simulator):
    monkeypatch.chdir(tmp_path)
    text = (natives.root() / "docs" / "OPERATIONS.md").read_text(encoding="utf-8")
    exec(text.partition("```python\n")[2].partition("```")[0], {})
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("720 line.csv: 40 pixels, 4 accelerating") and printed[1] == "done"
