# SPDX-License-Identifier: MIT
"""The virtual bench: its commands, what they do to a board, and a console that talks to it.

Verdicts are cycles and states of the simulated board; wall-clock time only guards against hanging.
"""

import itertools
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction

import pytest

from pixstep import formats
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.simulation import bench_script, virtual_bench
from pixstep.simulation.simulator import SimulatorError
from pixstep.simulation.virtual_bench import NotInTimeError, VirtualBench

MEGA, UNO = boards.load("mega"), boards.load("uno")
HZ = Fraction(100)
HANG_S = 1800
PATIENT = ("--timeout", "60s")  # of the console: a guard, no matter how busy this machine is
MS = MEGA.tick_hz // 1000


class Bench:
    """`board simulate` as a process, with commands on its standard input."""

    def __init__(self, link, *more):
        words = ["board", "simulate", "--board", "mega", "--pixel-hz", "100", "--json"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pixstep", *words, "--link", str(link), *more],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.ready = self.until("ready")

    def until(self, event):
        """Return the row of an event; rows that say how late this machine is pass by."""
        for text in self.process.stdout:
            row = json.loads(text)
            if row["event"] != "behind":
                assert row["event"] == event
                return row
        raise AssertionError(f"ended before {event!r}")

    def order(self, *texts):
        """Send commands in one piece: what they do happens in one cycle but for their waits."""
        self.process.stdin.write("".join(f"{text}\n" for text in texts))
        self.process.stdin.flush()

    def do(self, text):
        self.order(text)
        return self.until(text)

    def close(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def desk(simulator, tmp_path, monkeypatch):
    """Yield a bench whose port the console knows."""
    link = tmp_path / "mega"
    monkeypatch.setenv("PIXSTEP_PORT", str(link))
    bench = Bench(link)
    yield bench
    bench.close()


@pytest.fixture
def bench(simulator):
    """Yield the bench's own object."""
    with VirtualBench(virtual_bench.options("mega", HZ)) as found:
        yield found


def order(text, kind=MEGA):
    return bench_script.parse(text, kind, "here")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("pres home 0", "there is no command 'pres'"),
        ("press hoem 0", "'press hoem 0': expected press home|minus|plus AXIS"),
        ("press home", "expected press home|minus|plus AXIS"),
        ("press home -1", "expected press"),
        ("release plus 4", "axis 4: the mega has 4 axes: 0 to 3"),
        ("estop", "expected estop press|release"),
        ("clock", "expected clock"),
        ("clock 0Hz", "expected clock 30Hz|stop|start|+300ppm|drop N"),
        ("clock 61kHz", "at most 60000 Hz"),
        ("clock 100000ppm", "less than 100000 ppm"),
        ("clock drop x", "expected clock"),
        ("clock gate 3", "expected clock"),
        ("clock gate x 3ms", "expected clock"),
        ("clock rest soon", "time 'soon'"),
        ("clock rest 3601s", "at most 3600 s"),
        ("clock jitter 11ms", "at most 0.01 s"),
        ("clock jump 1", "expected clock"),
        ("load 0", "expected load AXIS PARAMETERS"),
        ("load 0 home", "expected load"),
        ("load 9 home=3", "axis 9: the mega has"),
        ("supply 12V", "expected supply 5V|off|brownout"),
        ("reset now", "expected reset"),
        ("wait", "expected wait TIME"),
        ("wait 3 s", "expected wait TIME"),
        ("wait 3parsecs", "time '3parsecs'"),
        ("wait 100000s", "at most 86400 s"),
        ("until", "expected until"),
        ("until edges 0", "expected until"),
        ("until permit high", "expected until"),
        ("until moves 7", "axis 7"),
        ("until moves 0 soon", "time 'soon'"),
        ("quit all", "expected quit"),
    ],
)
def test_a_wrong_command_is_named(text, reason):
    with pytest.raises(UserError) as error:
        order(text)
    assert str(error.value).startswith("here: ") and reason in str(error.value)


def test_comments_and_empty_lines_are_nothing():
    assert order("") is None and order("  # later") is None
    assert order(" wait  2ms # a moment").text == "wait 2ms"


def test_every_form_is_described():
    assert set(bench_script.FORMS) == set(bench_script._READERS)


def test_a_script_names_its_line():
    with pytest.raises(UserError, match=r"^x\.txt: line 3: 'wait': expected wait TIME$"):
        bench_script.parse_all(["wait 1s", "", "wait"], UNO, "x.txt")


def test_a_wrong_script_starts_nothing(invoke, put):
    put(b"wait 1ms\npress home 1\n", "x.txt")
    words = ("board", "simulate", "--board", "uno", "--pixel-hz", 30, "--script", "x.txt")
    said = invoke(*words, status=3).stderr
    assert said == ("pixstep: x.txt: line 2: 'press home 1': axis 1: the uno has 1 axis: 0\n")


def test_a_script_that_cannot_be_read_is_one_line(invoke, put):
    words = ("board", "simulate", "--board", "uno", "--pixel-hz", 30, "--script")
    said = invoke(*words, "no.txt", status=2).stderr
    assert said == "pixstep: no.txt: No such file or directory\n"
    put(b"wait \xff\n", "x.txt")
    assert invoke(*words, "x.txt", status=3).stderr == "pixstep: x.txt: not a text of UTF-8\n"


def test_without_a_simulator_it_is_one_line(invoke, monkeypatch, tmp_path):
    missing = tmp_path / "pixstep-sim"
    monkeypatch.setenv("PIXSTEP_SIM", str(missing))
    said = invoke("board", "simulate", "--board", "uno", "--pixel-hz", 30, status=2).stderr
    assert said == f"pixstep: {missing}: no such file (PIXSTEP_SIM)\n"


def test_without_pseudo_terminals_it_is_one_line(simulator, monkeypatch):
    real = virtual_bench.Simulator.wait_s

    def without_files(sim, seconds):
        real(sim, seconds)
        resource.prlimit(sim._process.pid, resource.RLIMIT_NOFILE, (3, 3))

    monkeypatch.setattr(virtual_bench.Simulator, "wait_s", without_files)
    with pytest.raises(SimulatorError, match=r"^simulator: pty: no pseudo terminal: .+$"):
        VirtualBench(virtual_bench.options("uno", HZ))


def test_a_link_replaces_nothing(simulator, invoke, put, tmp_path):
    put(b"quit\n", "x.txt")
    words = ("board", "simulate", "--board", "uno", "--pixel-hz", 30, "--script", "x.txt", "--link")
    assert invoke(*words, "x.txt", status=2).stderr == "pixstep: x.txt: already exists\n"
    (tmp_path / "old").symlink_to("/dev/pts/of-a-bench-that-was-killed")
    assert "uno at old" in invoke(*words, "old").stdout
    assert not (tmp_path / "old").is_symlink()


def test_a_script_does_the_same_in_every_cycle(simulator, invoke, put):
    put(b"wait 10ms\nestop press\nwait 7.5ms\nclock 41Hz\nwait 100ms\nquit\n", "x.txt")
    words = ("board", "simulate", "--board", "mega", "--pixel-hz", 100, "--script", "x.txt")
    rows = [json.loads(text) for text in invoke(*words, "--json").stdout.splitlines()]
    rows = [row for row in rows if row["event"] != "behind"]
    first = rows[0]["cycle"]
    assert [(row["event"], row["cycle"] - first) for row in rows] == [
        ("ready", 0), ("wait 10ms", 10 * MS), ("estop press", 10 * MS),
        ("wait 7.5ms", 17.5 * MS), ("clock 41Hz", 17.5 * MS), ("wait 100ms", 117.5 * MS),
        ("quit", 117.5 * MS),
    ]  # fmt: skip
    assert rows[-1]["clock"] == {"hz": 41, "ppm": 0, "runs": True, "own": False}
    assert [row["estop_pressed"] for row in rows] == [False] * 2 + [True] * 5


def test_switches_by_hand_and_of_mechanics(bench):
    def closed(axis):
        return bench.status()["axes"][axis]["closed"]

    for text, axis, wanted in (
        ("press minus 2", 2, ["minus"]),
        ("press home 2", 2, ["home", "minus"]),
        ("release minus 2", 2, ["home"]),
        ("load 1 home=100,start=50,active=high", 1, []),
        ("press home 1", 1, ["home"]),
        ("release home 1", 1, []),
        ("load 1 start=200", 1, ["home"]),
        ("press plus 1", 1, ["home", "plus"]),
    ):
        order(text).act(bench)
        bench.wait(0.002)
        assert closed(axis) == wanted, text


def test_a_clock_that_is_gated_rests_and_strays(simulator, tmp_path):
    log = tmp_path / "pins.csv"
    gated = virtual_bench.options("mega", HZ, gate=(4, 5))
    with VirtualBench(replace(gated, pin_log=log)) as bench:
        parts = ("clock gate 2 30ms", "clock gate off", "clock rest 40ms", "clock jitter 1ms")
        marks = [bench.simulator.cycle]
        for text in (*parts, "clock jitter 0us", "clock false"):
            order(text).act(bench)
            bench.wait(0.2)
            marks.append(bench.simulator.cycle)
        bench.simulator.quit()
    rows = [text.split(",") for text in log.read_text().splitlines()[1:]]
    edges = [int(cycle) for cycle, _, kind in rows if kind == "true"]
    gaps = [
        [(b - a) / MS for a, b in itertools.pairwise(edges) if begin <= a and b < end]
        for begin, end in itertools.pairwise([0, *marks])
    ]
    assert set(gaps[0]) == {10, 15} and gaps[0].index(15) == 3
    assert set(gaps[1][1:]) == {10, 40} and set(gaps[2][1:]) == {10}
    assert sorted(set(gaps[3])) == [10, 50] and gaps[3].count(50) == 1
    assert len(set(gaps[4])) > 10 and all(abs(gap - 10) <= 2 for gap in gaps[4])
    assert set(gaps[5][2:]) == {10} and set(gaps[6]) == {10}
    false = [int(cycle) for cycle, _, kind in rows if kind == "false"]
    assert len(false) == 1 and 0 <= false[0] - marks[5] < 1000


def test_what_a_script_waits_for(bench):
    began = bench.time_s
    with pytest.raises(NotInTimeError, match=r"^until moves 0: not within 0\.2 s$"):
        order("until moves 0 200ms").act(bench)
    assert bench.time_s - began == pytest.approx(0.2)
    with pytest.raises(NotInTimeError, match="permit on"):
        order("until permit on 10ms").act(bench)
    order("until permit off").act(bench)
    order("until rests 0").act(bench)
    assert bench.time_s - began == pytest.approx(0.31, abs=0.006)


def test_a_bench_that_falls_behind_says_by_how_much(bench):
    before = bench.lost_s
    time.sleep(0.2)  # a bench that is not served stands still
    bench.wait(0.002)
    assert bench.lost_s - before > 0.1


def test_the_terminal_has_the_bus_for_itself(bench):
    with pytest.raises(SimulatorError, match="the bus belongs to the pseudo terminal"):
        bench.simulator.transmit(b"\x01")


def test_an_emergency_stop_and_the_way_back(desk, pixstep, invoke, tmp_path):
    """The stop is ordered before the line runs, so that it comes however slow this machine is."""
    assert os.path.realpath(tmp_path / "mega") == desk.ready["port"]
    # A console that gets no processor for a while is not taken for a dead one.
    pixstep("board", "set", "pixel_hz=100", "bus_timeout_ms=0", *PATIENT)
    formats.write_csv(tmp_path / "a.csv", [9] * 250)
    upload = ("board", "upload", "a.csv", "--decode", "plain", "--arm", *PATIENT)
    pixstep("board", "permit", "on", *PATIENT)
    assert desk.do("status")["permit"] == 1
    stop = ("until edges 0 300 3600s", "estop press", "until rests 0")
    desk.order(*stop)
    pixstep(*upload, "--no-wait")
    moving, pressed, stopped = map(desk.until, stop)
    assert moving["cycle"] == pressed["cycle"] and moving["permit"] == 1
    assert 300 <= moving["axes"][0]["edges"] <= stopped["axes"][0]["edges"] < 400
    assert pressed["estop_pressed"] and stopped["permit"] == 0
    state = json.loads(pixstep("board", "watch", "--once", "--json", *PATIENT))
    assert state["fault"].startswith("estop")
    assert state["axes"][0]["position_steps"] == stopped["axes"][0]["steps"]
    assert "is pressed" in invoke("board", "clear", *PATIENT, status=1).stderr
    desk.do("estop release")
    desk.do("wait 100ms")
    pixstep("board", "clear", *PATIENT)
    pixstep(*upload)
    assert desk.do("status")["axes"][0]["steps"] == stopped["axes"][0]["steps"] + 2250


def test_clock_supply_and_reset_as_the_console_sees_them(desk, pixstep, invoke):
    def edges():
        return json.loads(pixstep("board", "watch", "--once", "--json", *PATIENT))["pixel_edges"]

    desk.do("clock stop")
    assert edges() == edges()
    desk.do("clock 200Hz")
    before = edges()
    desk.do("wait 200ms")
    assert edges() - before >= 40
    assert not desk.do("supply off")["powered"]
    assert "no reply to read" in invoke("board", "info", status=1).stderr
    desk.do("supply 5V")
    desk.do("wait 300ms")
    pixstep("board", "info", *PATIENT)
    desk.do("reset")
    desk.do("wait 300ms")
    assert "reset pin" in pixstep("board", "get", "reset_cause", *PATIENT)


def test_a_mistake_in_what_is_piped_in_is_told_and_left_out(simulator, tmp_path):
    (tmp_path / "x.txt").write_bytes(
        b"pres home 0\nwait 1ms\nuntil moves 0 5ms\nestop press\nquit\nstatus\n"
    )
    words = ["board", "simulate", "--board", "mega", "--pixel-hz", "100", "--json"]
    with (tmp_path / "x.txt").open("rb") as piped:
        made = subprocess.run(
            [sys.executable, "-m", "pixstep", *words],
            stdin=piped, capture_output=True, text=True, timeout=HANG_S, check=False,
        )  # fmt: skip
    rows = [json.loads(text) for text in made.stdout.splitlines()]
    events = [row["event"] for row in rows if row["event"] != "behind"]
    assert events == ["ready", "wait 1ms", "estop press", "quit"]
    told = [text for text in made.stderr.splitlines() if text.startswith("pixstep: ")]
    assert [text.split(": ")[1:4] for text in told] == [
        ["standard input", "line 1", "there is no command 'pres'"],
        ["standard input", "line 3", "until moves 0"],
    ]
    assert made.returncode == 2  # of the first
