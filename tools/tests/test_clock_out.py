# SPDX-License-Identifier: MIT
"""The clock that a board makes itself, on the real images: pin, wire, capture, lines on it."""

import itertools
import json
from pathlib import Path

import pytest

from pixstep import formats
from pixstep.board import boards, run, settings
from pixstep.board.device import Device
from pixstep.board.errors import MissingFeatureError
from pixstep.board.selftest import FAILED, OK, SKIPPED, SelfTest
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.machine.files import MachineFile
from pixstep.simulation.logs import read_edges
from test_board_images import Live
from test_board_images import live as live

pytestmark = pytest.mark.usefixtures("simulator")
BUILT = [board.name for board in boards.all_boards() if board.all_features]
WIRE = ("--clock-wire", "0:0")
STEPS = 10  # a pixel


class Wired:
    """A board whose own clock is wired to its input, and the edges of its outputs."""

    def __init__(self, live, folder, name, *more, wire=WIRE):
        self.path = Path(folder) / "edges.csv"
        self.one: Live = live(name, *more, edges=self.path, extra=wire)
        self.sim, self.board = self.one.sim, Device(self.one.client)
        self.kind = boards.load(name)

    def set_clock(self, hz):
        """Let the board make a clock; return its period in cycles."""
        self.one.out("set", f"clock_out_hz={hz}")
        made = boards.clock_out_hz(hz, self.kind.tick_hz)
        period = self.kind.tick_hz / made
        assert period.denominator == 1
        return int(period)

    def clock(self):
        """Return the cycles of the clock's rising edges."""
        self.sim.flush()
        edges = read_edges(self.path).axis(0, 0)
        return edges.clock_out_cycles[edges.clock_out_levels == 1].tolist()

    def edges(self, axis):
        return read_edges(self.path).axis(0, axis)


def differences(cycles):
    return {after - before for before, after in itertools.pairwise(cycles)}


@pytest.mark.parametrize("name", BUILT)
@pytest.mark.parametrize("hz", [2, 30, 500, 977, 2000])
def test_every_edge_comes_to_the_cycle(live, tmp_path, name, hz):
    wired = Wired(live, tmp_path, name)
    period = wired.set_clock(hz)
    assert abs(period * hz / wired.kind.tick_hz - 1) <= hz * 64 / wired.kind.tick_hz / 2
    wired.sim.wait_s(0.1)
    began, first = wired.sim.cycle, wired.board.input("pixel_edges")
    wired.sim.wait_s(0.2 + 4 / hz)
    ended, last = wired.sim.cycle, wired.board.input("pixel_edges")
    came = wired.clock()
    assert differences(came) == {period}
    assert last - first - len([edge for edge in came if began < edge <= ended]) in (-1, 0, 1)
    levels = read_edges(wired.path).axis(0, 0).clock_out_cycles
    assert {int(b - a) for a, b in itertools.pairwise(levels)} <= {
        period // 2 // 64 * 64, period - period // 2 // 64 * 64,
    }  # fmt: skip


@pytest.mark.parametrize("name", BUILT)
def test_lines_run_on_it(live, tmp_path, name):
    """All axes at once: each step is in its place after an edge, none disturbs the clock."""
    wired = Wired(live, tmp_path, name)
    period = wired.set_clock(200)
    made = boards.clock_out_hz(200, wired.kind.tick_hz)
    wired.one.out("set", f"pixel_hz={made.numerator}/{made.denominator}")
    wired.sim.wait_s(0.5)
    axes = list(range(wired.kind.axes))
    line = Line((STEPS,) * 40, PLAIN, name="on its own clock")
    uploads = [LineUpload(wired.board, axis, queue_entries(line)) for axis in axes]
    for one in uploads:
        one.push()
    group = [run.LinesOfBoard(wired.board, axes, uploads)]
    run.arm_queued(group[0])
    run.follow(group, wired.one.console.world)
    came = wired.clock()
    assert differences(came) == {period}
    for axis in axes:
        steps = wired.edges(axis).rising.tolist()
        assert len(steps) == 40 * STEPS and not wired.board.axis(axis)["underruns"]
        zero = max(edge for edge in came if edge <= steps[0])
        late = [step - zero - (k + 1) * period / STEPS for k, step in enumerate(steps)]
        assert max(map(abs, late)) <= 1, f"axis {axis}"


@pytest.mark.parametrize("name", BUILT)
def test_a_stored_clock_goes_on_after_a_reset(live, tmp_path, name):
    wired = Wired(live, tmp_path, name)
    wired.one.out("set", "clock_out_hz=100", "--store")
    wired.sim.wait_s(0.1)
    wired.sim.reset(0)
    wired.sim.wait_s(0.5)
    assert wired.board.setting("clock_out_hz") == 100
    assert wired.board.input("pixel_edges") in (49, 50, 51)
    wired.one.out("set", "clock_out_hz=0")
    wired.sim.wait_s(0.1)
    came = len(wired.clock())
    wired.sim.wait_s(0.1)
    assert len(wired.clock()) == came


def test_an_image_without_it_refuses_by_name(live):
    one = live("uno")
    said = one.err("set", "clock_out_hz=30", status=3)
    assert "built without clock_out (bit 0 of register features_high is 0)" in said
    assert "another image makes one (docs/WIRING.md, A clock to try with)" in said
    assert "`--sync free` needs no clock" in said
    with pytest.raises(MissingFeatureError):
        Device(one.client).require("clock_out")


class Agreeing:
    """Someone who says yes to what is about the clock, and no to all else."""

    def agrees(self, question, *, default=True):
        del default
        return "No pixel clock comes" in question

    def says(self, text):
        raise AssertionError(text)


def clock_check(wired, person=None):
    test = SelfTest(wired.board, wired.board.who(), wired.one.console.world, person, [0])
    (found,) = [result for result in test.go() if result.name == "pixel clock"]
    return found.verdict, found.text


PINS = {"mega": ("D4", "D48 and D49"), "m1284": ("PB4", "PB5")}


@pytest.mark.parametrize("name", BUILT)
def test_the_selftest_measures_it(live, tmp_path, name):
    wired = Wired(live, tmp_path, name)
    out, _ = PINS[name]
    verdict, text = clock_check(wired)
    assert verdict == FAILED
    assert text.endswith(f"`pixstep board set clock_out_hz=30` makes a clock on CLOCK_OUT on {out}")
    verdict, text = clock_check(wired, Agreeing())
    assert verdict == OK and f"the board's own on CLOCK_OUT on {out}: measured " in text
    assert text.endswith(f"set {float(boards.clock_out_hz(30, wired.kind.tick_hz)):.6g} Hz")
    assert wired.board.setting("clock_out_hz") == 0
    wired.one.out("set", "clock_out_hz=100", "pixel_hz=100")
    assert clock_check(wired)[0] == OK
    wired.one.out("set", "pixel_hz=50")
    verdict, text = clock_check(wired)
    assert verdict == FAILED and text.endswith("set 100 Hz; but pixel_hz is 50 Hz")


@pytest.mark.parametrize("name", BUILT)
def test_the_selftest_names_the_missing_wire(live, tmp_path, name):
    wired = Wired(live, tmp_path, name, wire=())
    out, into = PINS[name]
    wired.sim.clock("off")
    wired.one.out("set", "clock_out_hz=30")
    verdict, text = clock_check(wired)
    assert verdict == FAILED and "no edge on the clock input" in text
    assert text.endswith(f"is CLOCK_OUT on {out} wired to PIXEL_CLOCK on {into}?")


def test_an_image_that_makes_none_asks_whether_a_clock_is_wired(live, tmp_path):
    wired = Wired(live, tmp_path, "uno", wire=())
    wired.sim.clock("off")
    verdict, text = clock_check(wired)
    assert verdict == FAILED and text.startswith("no edge on PIXEL_CLOCK on D8")
    assert text.endswith("a line with --sync free needs no clock")
    assert clock_check(wired, Agreeing()) == (SKIPPED, "not wired: run lines with --sync free")


def test_a_second_board_makes_the_clock(live, tmp_path):
    """A Mega for an Uno, whose oscillator is another: the Uno follows what comes."""
    wire = ("--clock-wire", "0:1")
    wired = Wired(live, tmp_path, "mega", "uno", wire=wire)
    period = wired.set_clock(30)
    wired.sim.wait_s(2)
    uno = Device(wired.one.client, 2)
    first = uno.input("pixel_edges")
    wired.sim.wait_s(2)
    assert uno.input("pixel_edges") - first in (60, 61)
    assert uno.input("clock_period_ticks") in range(period - 40, period + 41)


MACHINE = """\
[clock]
pixel = "{pixel}"
[boards.main]
kind = "{kind}"
clock_out_hz = {out}
[boards.other]
kind = "mega"
unit = 2
{other}
[motors.X]
axis = 0
kind = "plain"
board = "main"
"""


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """Return a function that puts a machine file into the current folder."""
    monkeypatch.chdir(tmp_path)

    def put(pixel="30 Hz", kind="mega", out='"30 Hz"', other=""):
        text = MACHINE.format(pixel=pixel, kind=kind, out=out, other=other)
        Path("machine.toml").write_text(text)

    return put


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({"out": 2001}, r"machine.toml:5: boards.main.clock_out_hz = 2001: .*1 to 2,000 Hz"),
        ({"out": '"2.5 Hz"'}, r":5: boards.main.clock_out_hz = '2.5 Hz': .*whole number.*Hz"),
        ({"out": 0}, r":5: boards.main.clock_out_hz = 0: .*above 0 Hz"),
        ({"out": '"30 mm"'}, r":5: boards.main.clock_out_hz = '30 mm': .*expected Hz"),
        ({"out": "true"}, r":5: boards.main.clock_out_hz = True: "),
        ({"out": 100}, r":5: boards.main.clock_out_hz = 100: the pixel clock .* has 30 Hz$"),
        ({"other": "clock_out_hz = 30"},
         r":9: boards.other.clock_out_hz = 30: board main makes the clock already"),
    ],
)  # fmt: skip
def test_a_machine_file_says_which_clock_a_board_makes(machine, values, wrong):
    machine(**values)
    with pytest.raises(UserError, match=wrong):
        MachineFile.load("machine.toml")


@pytest.mark.parametrize(("hz", "pixel"), [(1, "1 Hz"), (2000, "2 kHz"), (30, "30000/1001 Hz")])
def test_a_machine_may_have_a_clock_that_a_board_can_make(machine, hz, pixel):
    machine(pixel=pixel, out=hz)
    assert MachineFile.load("machine.toml").boards["main"].clock_out_hz == hz


def test_a_machine_shows_it(machine, pixstep):
    machine()
    assert "30" in pixstep("machine", "show").split("main", 1)[1].splitlines()[0]
    shown = json.loads(pixstep("machine", "show", "--json"))["boards"]
    assert (shown["main"]["clock_out_hz"], shown["other"]["clock_out_hz"]) == (30, None)


@pytest.mark.parametrize("name", BUILT)
def test_a_line_of_a_machine_runs_on_the_clock_of_its_board(live, machine, tmp_path, name):
    """No clock but the board's own: the file switches it on, --clock-out-hz 0 off again."""
    machine(pixel="200 Hz", kind=name, out=200)
    formats.write_csv(Path("line.csv"), [STEPS] * 40)
    wired = Wired(live, tmp_path, name)
    wired.one.out("upload", "line.csv", "--arm")
    assert wired.board.setting("clock_out_hz") == 200
    wired.sim.flush()
    assert len(wired.edges(0).rising) == 40 * STEPS
    told = wired.one.json("info")["boards"][0]["pixel_clock"]
    assert told["clock_out_hz"] == 200
    assert "200 Hz made by the board itself" in wired.one.out("info")
    wired.one.out("upload", "line.csv", "--clock-out-hz", "0")
    assert wired.board.setting("clock_out_hz") == 0


@pytest.mark.parametrize("name", BUILT)
def test_the_selftest_takes_the_clock_of_the_machine(live, machine, tmp_path, name):
    machine(kind=name)
    wired = Wired(live, tmp_path, name)
    checks = wired.one.json("selftest", "--yes", status=0)["checks"]
    (found,) = [check for check in checks if check["name"] == "pixel clock"]
    assert found["verdict"] == OK and "the board's own" in found["text"]


def test_a_machine_of_an_image_without_it_is_refused_by_name(live, machine):
    machine(kind="uno")
    formats.write_csv(Path("line.csv"), [STEPS] * 4)
    one = live("uno")
    said = one.err("upload", "line.csv", status=3)
    assert "built without clock_out (bit 0 of register features_high is 0)" in said
    settings.set_clock(Device(one.client), None, clock_out_hz=0)


def test_a_simulated_board_has_the_wire_of_its_machine(machine, pixstep):
    """The board to practise on has no other clock: its edges come by the wire."""
    machine()
    Path("hands").write_text("status\nquit\n")
    assert "pixel clock by a wire from CLOCK_OUT" in pixstep(
        "board", "simulate", "--script", "hands"
    )
    outside = pixstep("board", "simulate", "--script", "hands", "--no-clock-wire")
    assert "pixel clock 30 Hz" in outside
