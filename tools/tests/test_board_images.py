# SPDX-License-Identifier: MIT
"""`pixstep board` on the real images: what the fakes promise, the firmware does."""

import json
from fractions import Fraction

import pytest

from console import put
from every_function import EveryFunction
from pixstep import natives
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from pixstep_trials.wire import seal

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = boards.BOARD_NAMES


class Live:
    """Simulated boards and the console on their line."""

    def __init__(self, make, names, hz=100, **options):
        images = [(name, natives.image(name)) for name in names]
        link = SimLink(SimOptions(images, Fraction(hz), **options))
        self.sim, self.names = link.simulator, names
        self.console = make(self.sim, link.world)

    def __getattr__(self, name):
        return getattr(self.console, name)

    def pin(self, signal, level, axis=0, board=0, later_s=0):
        """Drive an input pin of a board, now or later."""
        pins = boards.load(self.names[board]).pins
        (found,) = (pin for pin in pins if (pin.signal, pin.axis) == (signal, axis))
        when = f" at {self.sim.cycle + int(later_s * self.sim.tick_hz)}" if later_s else ""
        self.sim.command(f"pin {board} {found.port} {found.bit} {level}{when}")

    def seconds(self, seconds):
        self.sim.run(int(seconds * self.sim.tick_hz))


@pytest.fixture
def live(make_console):
    """Return a function that starts boards; all are ended afterwards."""
    started = []

    def start(*names, **options):
        started.append(Live(make_console, names, **options))
        return started[-1]

    yield start
    for one in started:
        one.sim.kill()


@pytest.mark.parametrize("name", BOARDS)
def test_what_a_board_has_measured_of_its_clock(live, name):
    one = live(name, hz=100, pixel_ppm=-2000)
    one.out("set", "pixel_hz=100")
    assert one.json("info")["boards"][0]["pixel_clock"]["measured"] is None
    one.sim.wait_s(1)
    measured = one.json("info")["boards"][0]["pixel_clock"]["measured"]
    assert measured["offset_ppm"] == pytest.approx(-2000, abs=3)
    assert measured["period_us"] == pytest.approx(10_000 * 1.002004, abs=0.05)
    assert measured["mean_jitter_us"] < 0.2 and measured["missing_edges"] == 0
    text = one.out("info")
    assert "set to 100/1 Hz; period 10020." in text and "ppm), jitter 0." in text
    assert "edges, period 10020." in one.out("watch", "--once")


@pytest.mark.parametrize("name", BOARDS)
def test_a_line_of_many_clock_edges_a_pixel(live, invoke, name):
    """A board with another divider is refused in one line; --divider sets the setting."""
    one = live(name, hz=1000, pixel_ppm=500)
    make = ("line", "make", "--speed", "4000steps/s", "--max-acceleration", "200000steps/s2")
    invoke(*make, "--length", "400", "--clock-hz", "1000", "-o", "l.csv")
    one.out("set", "pixel_hz=1000", "sync=2")
    said = one.err("upload", "l.csv", "--decode", "smooth", status=3)
    assert "made for 250 Hz, used at 1000 Hz" in said and "--divider 4, not 1" in said
    one.sim.wait_s(1)
    upload = ("upload", "l.csv", "--decode", "smooth", "--divider", "4", "--no-check")
    done = one.json(*upload)["axes"][0]
    assert done["state"] == "loaded" and done["steps"] == 400
    one.sim.wait_s(1)
    one.out("start")
    one.sim.wait_s(1)
    assert one.json("info")["boards"][0]["axes"][0]["position_steps"] == 400
    assert "4 edges a pixel" in one.out("info")


@pytest.mark.parametrize("name", BOARDS)
def test_look_set_store(live, name):
    one = live(name)
    (found,) = one.json("info")["boards"]
    assert (found["board"], found["map_version"], found["reset_cause"]) == (name, 6, "power-on")
    assert found["server_id"] == f"pixstep {name} {found['firmware']}"
    assert found["pixel_clock"]["present"]
    text = one.out("set", "pixel_hz=100", "dir_hold_us=25", "idle_off_ms=700", "--store")
    assert "dir_hold_us: 20 -> 25 us" in text and "stored as record 1" in text
    one.out("settings", "export", "all.toml")
    one.out("settings", "defaults")
    assert "dir_hold_us = 20" in one.out("get", "dir_hold_us")
    assert "3 settings changed" in one.out("settings", "import", "all.toml")
    assert "no difference" in one.out("settings", "diff", "all.toml")
    stored = one.json("info")["boards"][0]["settings"]
    assert stored == {"record": 1, "stored": True, "differ": True}  # never stored since defaults


@pytest.mark.parametrize("name", BOARDS)
def test_every_range_is_the_boards_own(live, name):
    """What the tool would refuse the board refuses too: written behind the tool's back."""
    one = live(name)
    board = Device(one.client)
    for item in regs.settings():
        outside = [item.maximum + 1] if item.maximum < 0xFFFF else []
        outside += [item.minimum - 1] if item.minimum > 0 else []
        for value in outside if item.words == 1 else []:
            with pytest.raises(BoardError) as refused:
                board.write(item.address, [value])
            assert refused.value.code == 3, (item.name, value)


def with_feature(name):
    """Return the boards whose image has a feature by default, by the board file."""
    dropped = name in (
        "bits", "clock_out", "clock_statistics", "diagnosis", "events", "files", "gate",
        "line_divider", "line_ends", "short_curves", "shared_switch",
    )  # fmt: skip
    return [board for board in BOARDS if boards.load(board).all_features or not dropped]


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_says_what_it_has_by_default(live, name):
    has = Device(live(name).client).features()
    for feature in boards.features():
        if feature.name != "narrow_curves":
            assert (feature.name in has) == (name in with_feature(feature.name)), feature.name


# A request of each function that belongs to a feature, without unit and checksum.
REQUESTS = {
    1: ("bits", "0000 0001"), 2: ("bits", "0000 0001"), 5: ("bits", "0000 ff00"),
    15: ("bits", "000d 0001 01 01"), 8: ("diagnosis", "0000 a537"), 17: ("diagnosis", ""),
    22: ("diagnosis", "0006 fff0 0005"), 23: ("diagnosis", "0006 0001 0006 0001 02 001e"),
    43: ("diagnosis", "0e 01 00"), 20: ("files", "07 06 0003 0006 0002"),
}  # fmt: skip


@pytest.mark.parametrize("name", BOARDS)
def test_functions_of_missing_features_are_refused_and_change_nothing(live, name):
    one = live(name)
    board = Device(one.client)
    has = board.features()
    missing = {code: row for code, row in REQUESTS.items() if row[0] not in has}
    assert bool(missing) == (name not in with_feature("bits"))

    def state():
        outputs, faults = board.input("outputs"), board.input("fault_mask")
        return board.read_holdings(0, 18), board.read_holdings(0x100, 3), outputs, faults

    before = state()
    for function, (_, data) in missing.items():
        request = seal(bytes([1, function]) + bytes.fromhex(data))
        reply = one.sim.transmit(request, one.sim.cycles(0.05))
        assert reply == seal(bytes([1, function | 0x80, 1])), function
    assert state() == before


@pytest.mark.parametrize("name", with_feature("diagnosis"))
def test_every_function_that_the_client_has(live, name):
    board = EveryFunction(live(name).client)
    assert board.identification(1) == {
        "vendor": "pixstep", "product_code": name, "revision": board.who().firmware,
    }  # fmt: skip
    assert board.echo(0xA5A5) == 0xA5A5
    board.clear_counters()
    before = board.counters()
    board.read_inputs(0, 1)
    assert board.counters()["requests"] == before["requests"] + len(before) + 1
    board.mask_write(6, 0xFFF0, 0x0005)
    assert board.read_holdings(6, 2) == [0x15, 20]
    assert board.write_and_read(6, [30, 40], 6, 2) == [30, 40]
    board.write_one(6, 20)
    assert board.read_holdings(6, 1) == [20]


@pytest.mark.parametrize("name", with_feature("bits"))
def test_bits(live, name):
    one = live(name)
    board = EveryFunction(one.client)
    one.pin("LIMIT_PLUS", 0)
    one.seconds(0.02)
    bits = board.read_discretes(0, 32)
    assert bits[0] and bits[regs.DISCRETE_INPUTS + 2] and sum(bits) == 2
    board.write_coil(regs.COIL_DRIVER, True)
    board.write_coil(regs.COIL_PERMIT, True)
    assert board.read_coils(regs.COIL_DRIVER, 1) == [True]
    assert board.read_coils(regs.COIL_CLEAR, 2) == [False, True]
    assert board.input("outputs") == 0x0101
    one.pin("ESTOP", 0)
    one.seconds(0.02)
    assert board.read_coils(regs.COIL_CLEAR, 2) == [True, False]
    with pytest.raises(BoardError):
        board.write_coil(regs.COIL_CLEAR, True)
    one.pin("ESTOP", 1)
    one.seconds(0.02)
    board.write_coil(regs.COIL_CLEAR, True)
    assert not board.fault_name()
    with pytest.raises(BoardError) as refused:
        board.write_coil(regs.COIL_PERMIT + 1, True)
    assert refused.value.code == 2


def test_events_of_the_image(live):
    one = live("mega")
    one.pin("ESTOP", 0)
    one.seconds(0.02)
    lines = one.out("log", "events").splitlines()
    assert lines[0].endswith("reset: power-on")
    assert "estop: the emergency stop input was tripped" in lines[1]
    assert "built without events (bit 4" in live("uno").err("log", "events", status=3)


@pytest.mark.parametrize("name", with_feature("diagnosis"))
def test_a_silent_board_comes_back(live, name):
    one = live(name)
    board = EveryFunction(one.client)
    board.listen_only()
    with pytest.raises(BoardError):
        board.who()
    board.restart()
    board.who()


@pytest.mark.parametrize("name", BOARDS)
def test_upload_runs_and_is_logged(live, name):
    one = live(name)
    one.out("set", "pixel_hz=100")
    counts = [n % 9 + 1 for n in range(150)]
    found = one.json("upload", put(counts), "--decode", "plain", "--arm")
    (axis,) = found["axes"]
    assert (axis["state"], axis["position_steps"]) == ("done", sum(counts))
    assert one.sim.steps(0, 0) == sum(counts)
    records = axis["records"]
    assert (records["read"], records["missed"]) == (150 // records["every_px"], 0)
    assert records["max_difference_steps"] == 0
    rows = one.out("log", "--axis", 0, status=1).split()[1:]  # those that are still kept
    last = rows[-1].split(",")
    assert last[:5] == ["1", "0", "150", str(sum(counts)), str(sum(counts))]


@pytest.mark.parametrize("name", BOARDS)
def test_log_while_it_runs(live, name, tmp_path):
    one = live(name, hz=60)  # an Uno's eight records last longer than the command's first requests
    one.out("set", "pixel_hz=60")
    one.out("upload", put([7] * 80), "--decode", "plain", "--arm", "--no-wait")
    done = one.run("log", "--axis", 0, "-o", "log.csv")
    rows = [row.split(",") for row in (tmp_path / "log.csv").read_text().split()[1:]]
    first = int(rows[0][2])
    assert [(int(row[2]), int(row[4])) for row in rows] == [(n, 7 * n) for n in range(first, 81)]
    assert "none missed" in done.stderr and len(rows) > 60


@pytest.mark.parametrize("name", BOARDS)
def test_the_host_refuses_what_the_board_would(live, name):
    one = live(name)
    one.out("set", "pixel_hz=100")
    lone = "min_interval_1_ticks" if boards.load(name).axes > 1 else "min_interval_ticks"
    limit = one.json("get", lone)["boards"][0]["registers"][0]["value"]
    most = boards.load(name).tick_hz // 100 // limit
    assert "too_fast" in one.err("upload", put([most + 1] * 3), "--decode", "plain", status=3)
    text = one.err("upload", "line.csv", "--decode", "plain", "--no-check", status=3)
    assert "axis 0: line refused: too_fast at pixel 1" in text
    assert "beyond_guarantee" in one.err("upload", put([most] * 3), "--decode", "plain", status=3)
    one.out("upload", put([most] * 3), "--decode", "plain", "--beyond")


@pytest.mark.parametrize("name", BOARDS)
def test_a_line_behind_a_refused_one_is_judged_by_itself(live, name):
    one = live(name, hz=30)
    ramp, bad = put([2, 6, 8, 6, 2]), put([3, 3, 3], "bad.csv")
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    refused = ("upload", bad, "--decode", "smooth", "--no-check")
    for words in (
        ("upload", ramp, "--decode", "smooth", "--arm", "--pixel-hz", 30),
        ("move", profile, "--steps", 16),
    ):
        assert "axis 0: line refused: oscillates" in one.err(*refused, status=3)
        one.out(*words)
    assert one.sim.steps(0, 0) == 24 + 16


def test_start_together_on_one_clock_edge(live, tmp_path):
    two = live("mega", "uno", edges=tmp_path / "edges.csv")
    name = put([6] * 50)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit, "--pixel-hz", 100)
    found = two.json("start", "--unit", "1,2", "--wait")
    assert [row["axes"][0]["position_steps"] for row in found["boards"]] == [300, 300]
    two.sim.command("flush")
    rows = [row.split(",") for row in (tmp_path / "edges.csv").read_text().split()[1:]]
    steps = [row for row in rows if row[3].lower() == "step" and row[4] == "1"]
    first = [min(int(row[0]) for row in steps if row[1] == str(board)) for board in (0, 1)]
    assert abs(first[0] - first[1]) <= 2


def test_a_board_that_cannot_start_keeps_all_from_starting(live):
    two = live("mega", "uno")
    name = put([6] * 50)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit, "--pixel-hz", 100)
    two.pin("ESTOP", 0, board=1)
    two.seconds(0.05)
    assert "board 2: arm: the emergency stop is pressed" in two.err("start", "--unit", "1,2")
    two.seconds(0.2)
    assert two.sim.count(0, 0) == two.sim.count(1, 0) == 0


def test_stop_reaches_every_board(live):
    two = live("mega", "uno")
    name = put([6] * 200)
    for unit in (1, 2):
        two.out("upload", name, "--decode", "plain", "--unit", unit, "--pixel-hz", 100)
    two.out("start", "--unit", "1,2")
    two.out("stop")
    two.seconds(0.1)
    before = [two.sim.count(board, 0) for board in (0, 1)]
    two.seconds(0.3)
    assert [two.sim.count(board, 0) for board in (0, 1)] == before
    assert all(0 < count < 1200 for count in before)


@pytest.mark.parametrize("name", BOARDS)
def test_move(live, name):
    one = live(name)
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    for steps in (1, -4000, 12345):
        found = one.json("move", profile, "--steps", steps, "--pixel-hz", 30)
        assert found["to_steps"] - found["from_steps"] == steps
    assert one.sim.steps(0, 0) == 1 - 4000 + 12345
    assert "top" in one.out("move", profile, "--steps", 10)


@pytest.mark.parametrize(("name", "axis"), [("uno", 0), ("mega", 2), ("m1284", 1)])
def test_home(live, name, axis):
    one = live(name, plants={(0, axis): "home=900,hyst=8,travel=-2000..4000,start=100"})
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    one.out("set", "inputs_inverted=4")  # the emergency stop's, which homing must leave alone
    one.pin("ESTOP", 0)
    one.seconds(0.01)
    one.out("clear")
    words = ("home", profile, "--axis", axis, "--pixel-hz", 30, "--search", 3000)
    found = one.json(*words)
    assert found["found"] and found["position_steps"] == 0
    motor, load = one.sim.plant(0, axis)
    assert motor == load and abs(load - 900) <= 1
    shares = name in with_feature("shared_switch")
    if shares:
        one.out("set", "home_is_limit=255")  # of other axes, which homing must leave alone
    text = one.out(*words, "--inverted", "none", "--home-is-limit", "plus" if shares else "none")
    assert f"board 1 axis {axis}: home found" in text and "stands on 0" in text
    if shares:
        shared = 255 & ~(1 << 2 * axis)
        assert f"home_is_limit = {shared}" in one.out("get", "home_is_limit")
    assert "inputs_inverted = 4" in one.out("get", "inputs_inverted")


def test_home_that_finds_nothing(live):
    one = live("uno")
    profile = natives.source("tools/data/AccProf-fast-move.csv")
    words = ("home", profile, "--pixel-hz", 30, "--search", 800)
    text = one.err(*words)
    assert "board 1: axis 0: home_not_found: the home switch did not close within" in text
    one.out("clear")
    found = json.loads(one.run(*words, "--json", status=1).stdout)
    assert found["fault"] == "home_not_found" and found["legs"][0]["name"] == "approach"


def test_watch(live):
    one = live("mega")
    rows = [json.loads(row) for row in one.out("watch", "--count", 2, "--json").splitlines()]
    assert rows[1]["rates_per_s"]["pixel_edges"] == pytest.approx(100, abs=3)
    assert rows[1]["rates_per_s"]["frames_ok"] > 1


@pytest.mark.parametrize("name", BOARDS)
def test_a_line_that_is_followed_outlasts_the_bus_timeout(live, name):
    one = live(name)
    assert "bus_timeout_ms = 3000 ms" in one.out("get", "bus_timeout_ms")
    words = ("upload", put([3] * 400), "--decode", "plain", "--pixel-hz", 100, "--arm")
    assert "400 pixels, 1200 steps, 4 s: done, position 1200" in one.out(*words)


# A count of its own in each pixel, and a queue of 128 bytes: it is dry in a sixteenth of a second.
def test_a_kilohertz_line_is_fed_in_time(live):
    one = live("uno", hz=2000)
    counts = [14 + pixel * pixel % 3 for pixel in range(2000)]
    # Twice what is guaranteed for counts that are all different, which come over the bus.
    words = ("upload", put(counts), "--decode", "plain", "--pixel-hz", 2000, "--arm", "--beyond")
    steps = sum(counts)
    assert f"2000 pixels, {steps} steps, 1 s: done, position {steps}" in one.out(*words)


def test_a_line_left_alone_stops_with_a_fault(live):
    one = live("mega")
    words = ("upload", put([3] * 400), "--decode", "plain", "--pixel-hz", 100, "--arm")
    told = one.run(*words, "--no-wait").stderr
    assert told.startswith(
        "note: board 1 stops with fault bus_silent when no request comes for 3 s"
    )
    one.seconds(3.1)
    assert "fault bus_silent on axis 0" in one.out("info")
    one.out("clear")
    one.out("set", "bus_timeout_ms=0")
    assert one.run(*words, "--no-wait").stderr == ""
    one.seconds(4.1)
    assert "axis0.axis_state = 5 (done)" in one.out("get", "axis0.axis_state")


def test_watching_seldom_keeps_a_board_going(live):
    one = live("uno")
    words = ("upload", put([3] * 400), "--decode", "plain", "--pixel-hz", 100, "--arm")
    one.out(*words, "--no-wait")
    rows = one.out("watch", "--interval", 5, "--count", 2, "--json").splitlines()
    states = [json.loads(row)["axes"][0]["axis_state"] for row in rows]
    assert states == ["running", "done"]
