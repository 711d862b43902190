# SPDX-License-Identifier: MIT
"""Lines on a gated pixel clock: machine files, options, simulated runs, boards together."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from pixstep import formats, natives
from pixstep.board import boards, run, settings, snapshot, together
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError, NotPossibleError
from pixstep.board.run import LinesOfBoard
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.simulation import clock_judge
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import read_edges
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

MACHINE = """\
[clock]
pixel = "500 Hz"
gate_edges = 20
[boards.main]
kind = "mega"
port = "/dev/ttyTEST"
[motors.X]
axis = 0
kind = "plain"
"""
COUNTS = [2, 4, *[5] * 36, 4, 2]
BURST = 20 + len(COUNTS) + 1


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Put a machine with a gate, and a line, into the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE)
    formats.write_csv(Path("line.csv"), COUNTS)
    return tmp_path


@pytest.mark.parametrize(
    ("hz", "tick_hz", "started", "locked"),
    [(100, 16_000_000, 1, 4), (196, 16_000_000, 2, 5), (2000, 16_000_000, 11, 14),
     (2000, 20_000_000, 9, 12), (Fraction(1, 3), 16_000_000, 1, 4)],
)  # fmt: skip
def test_the_least_edges(hz, tick_hz, started, locked):
    assert boards.least_gate_edges(Fraction(hz), tick_hz, locked=False) == started
    assert boards.least_gate_edges(Fraction(hz), tick_hz, locked=True) == locked


def test_what_the_firmware_has():
    reference = natives.source("firmware/app/axes/reference.c").read_text()
    assert "#define PLACE_TICKS ((uint32_t)0x14000)" in reference
    header = natives.source("firmware/core/clock/clock_filter.h").read_text()
    assert "#define CLOCK_FILTER_FRESH_EDGES 3u" in header


@pytest.mark.usefixtures("here", "simulator")
@pytest.mark.parametrize("sync", ["start", "lock"])
def test_a_simulated_line_begins_on_its_edge_of_a_burst(pixstep, sync):
    edges = BURST if sync == "start" else BURST + 40  # 62 in a row are a measurement
    page = pixstep("sim", "line.csv", "--sync", sync, "--pixel-gate", f"{edges},30")
    assert "PASS  mega" in page and f"gate of {edges} edges" in page
    assert "judged for a clock without a gate" in page


@pytest.mark.usefixtures("here", "simulator")
def test_a_burst_that_is_too_short_fails(invoke):
    said = invoke("sim", "line.csv", "--pixel-gate", f"{BURST - 9},30", status=1).stdout
    assert "fault pixel_clock_missing on axis 0" in said


@pytest.mark.usefixtures("here", "simulator")
def test_a_simulated_board_without_gates_is_refused(invoke):
    words = ("--board", "uno", "--gate-edges", "20")
    said = invoke("sim", "line.csv", *words, status=2).stderr
    assert "gate_edges: board 1: its image is built without gate" in said


def test_a_line_elsewhere_in_its_burst_is_a_reason():
    job = LineExperiment(
        "mega", {0: Line((5,), PLAIN)}, Fraction(500), gate_edges=20,
        flaws=ClockFlaws(gate_edges=60, gate_rest_ms=9),
    )  # fmt: skip

    class Kept:
        first_edge = 141

    (reason,) = clock_judge.gate_reasons(job, Kept)
    assert reason == "line zero is 21 edges after the first edge of its burst, not 20"
    Kept.first_edge = 140
    assert clock_judge.gate_reasons(job, Kept) == []


@pytest.mark.usefixtures("here")
def test_too_few_edges_are_refused_with_the_number(invoke, one):
    words = ("--gate-edges", "4", "--sync", "lock")
    wanted = "gate_edges 4: at 500 Hz a line that is locked can begin 6 edges after the first edge"
    assert wanted in invoke("sim", "line.csv", *words, status=2).stderr
    assert wanted in one.run("upload", "line.csv", *words, status=2).stderr
    assert one.board.setting("gate_edges") == 0


@pytest.mark.usefixtures("here")
def test_an_upload_sets_the_gate(one):
    one.out("upload", "line.csv")
    assert one.board.setting("gate_edges") == 20
    one.out("disarm")
    one.out("upload", "line.csv", "--gate-edges", "0")
    assert one.board.setting("gate_edges") == 0


@pytest.mark.usefixtures("here")
def test_a_board_without_gates_is_refused(one):
    one.board.without("gate")
    assert "gate" in one.run("upload", "line.csv", status=3).stderr
    assert one.board.setting("gate_edges") == 0
    one.out("upload", "line.csv", "--gate-edges", "0")


@pytest.mark.usefixtures("here")
def test_a_machine_shows_its_gate(pixstep):
    assert "gated: line zero 20 edges after a burst's first" in pixstep("machine", "show")
    assert json.loads(pixstep("machine", "show", "--json"))["gate_edges"] == 20


class Boards:
    """Simulated boards on one gated clock."""

    def __init__(self, names, path, hz=500):
        images = [(name, natives.image(name)) for name in names]
        self.edges, self.hz = path, hz
        self.link = SimLink(SimOptions(images, Fraction(hz), edges=path, seed=5))
        self.sim, self.world = self.link.simulator, self.link.world
        self.boards = [self.link.board(unit) for unit in range(1, len(names) + 1)]

    def set(self, sync, gate_edges):
        """Set the boards."""
        for board in self.boards:
            board.who()
            board.set_pixel_hz(Fraction(self.hz))
            board.write_setting("sync", regs.SYNCS[sync])
            board.write_setting("gate_edges", gate_edges)

    def first_steps(self, after):
        """Cycle of each board's step number `after`."""
        self.sim.flush()
        found = read_edges(self.edges)
        return [int(found.axis(k, 0).rising[after]) for k in range(len(self.boards))]


@pytest.fixture
def boards_of(tmp_path):
    """Return a function that starts boards; they are ended afterwards."""
    started = []

    def start(*names):
        started.append(Boards(names, tmp_path / "edges.csv"))
        return started[-1]

    yield start
    for one in started:
        one.sim.kill()


# The marks meet the bursts and rests at another phase each. In the longer rests the boards have
# armed the second line when they are asked whether the first one has begun.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("sync", "rest_us", "later_s"),
    [("start", 300_000, 0.0), ("lock", 300_000, 0.0), ("start", 300_000, 0.041),
     ("lock", 300_000, 0.082), ("start", 1_600_000, 0.069), ("lock", 1_600_000, 0.0)],
)  # fmt: skip
def test_boards_begin_with_one_burst(boards_of, sync, rest_us, later_s):
    one = boards_of("mega", "m1284")
    one.set(sync, 30)
    one.world.wait(1)
    one.sim.clock(f"gate 71 {rest_us}")
    one.world.wait(later_s)
    group = []
    for board in one.boards:
        for _ in range(2):
            LineUpload(board, 0, queue_entries(Line((3,) * 40, PLAIN))).push()
        group.append(LinesOfBoard(board, [0]))
    started = together.start(group, one.world)
    run.follow(group, one.world)
    started.compare(one.world)
    for after in (0, 120):
        first, second = one.first_steps(after)
        assert abs(first - second) <= 2
    assert [board.axis(0)["lines_done"] for board in one.boards] == [2, 2]


@pytest.mark.usefixtures("simulator")
def test_boards_of_different_gates_do_not_begin(boards_of):
    one = boards_of("mega", "m1284")
    one.set("start", 30)
    one.boards[1].write_setting("gate_edges", 31)
    group = []
    for board in one.boards:
        LineUpload(board, 0, queue_entries(Line((3,) * 4, PLAIN))).push()
        group.append(LinesOfBoard(board, [0]))
    with pytest.raises(BoardError, match="board 1 has gate_edges 30 and board 2 31"):
        together.start(group, one.world)
    assert all(board.axis(0)["axis_state"] == 0 for board in one.boards)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("free", [0, 1])
def test_a_free_board_does_not_begin_with_one_on_the_clock(boards_of, free):
    one = boards_of("mega", "m1284")
    one.set("start", 0)
    one.boards[free].write_setting("sync", regs.SYNCS["free"])
    group = []
    for board in one.boards:
        LineUpload(board, 0, queue_entries(Line((3,) * 4, PLAIN))).push()
        group.append(LinesOfBoard(board, [0]))
    wanted = f"board {free + 1} has sync free and board {2 - free} begins on the pixel clock"
    with pytest.raises(BoardError, match=wanted):
        together.start(group, one.world)
    assert [regs.axis_state(board.axis(0)["axis_state"]) for board in one.boards] == ["loaded"] * 2


@pytest.mark.usefixtures("simulator")
def test_no_start_beside_locked_lines_of_a_divided_clock(boards_of):
    one = boards_of("mega", "m1284")
    one.set("lock", 0)
    for board in one.boards:
        board.write_setting("divider", 3)
    one.world.wait(1)
    group = []
    for board in one.boards:
        LineUpload(board, 0, queue_entries(Line((3,) * 400, PLAIN))).push()
        LineUpload(board, 1, queue_entries(Line((3,) * 4, PLAIN))).push()
        group.append(LinesOfBoard(board, [1]))
    run.arm(one.boards[1], [0])
    one.world.wait(1)
    assert regs.axis_state(one.boards[1].axis(0)["axis_state"]) == "running"
    wanted = "board 2: its other axes run locked to the clock with a divider of 3"
    with pytest.raises(BoardError, match=wanted):
        together.start(group, one.world)
    assert all(regs.axis_state(b.axis(1)["axis_state"]) == "loaded" for b in one.boards)


@pytest.mark.usefixtures("simulator")
def test_the_board_says_why_it_does_not_arm(boards_of):
    one = boards_of("mega")
    one.set("start", 2)
    (board,) = one.boards
    LineUpload(board, 0, queue_entries(Line((3,) * 4, PLAIN))).push()
    with pytest.raises(NotPossibleError, match="gate_edges 2: at 500 Hz a line can begin 3 edges"):
        run.arm(board, [0])
    with pytest.raises(UserError, match="gate_edges 2"):
        settings.set_clock(board, None, gate_edges=2)


@pytest.mark.usefixtures("simulator")
def test_a_lock_is_awaited_over_rests(boards_of):
    """The clock rests for longer than the edges last in which it must be measured."""
    one = boards_of("mega")
    one.sim.clock("off")
    one.set("lock", 30)
    one.world.wait(0.1)
    one.sim.clock("gate 100 3000000")
    one.sim.clock("on")
    one.world.wait(0.1)
    one.sim.clock("rest 3000000")
    settings.set_clock(one.boards[0], Fraction(500), "lock")
    snapshot.await_measured(one.boards[0], one.world, 1 / 500)
    assert one.world.now_s() > 3
