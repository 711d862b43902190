# SPDX-License-Identifier: MIT
"""`pixstep board run` and `Board.run_program`: programs that are planned while they run."""

import doctest
import importlib
import os
import re
import subprocess
import sys
import time
from fractions import Fraction
from itertools import pairwise

import numpy as np
import psutil
import pytest

import pixstep as px
from pixstep import natives
from pixstep.api.bus import Board
from pixstep.errors import PlainError
from pixstep.lines.runs import MARK_END, MARK_NEGATIVE, MARK_SMOOTH, MARK_START
from pixstep.machine.files import MachineFile
from pixstep.programs import plan, streaming
from pixstep.programs.language import KNOWN
from pixstep.programs.motors import of_machine
from pixstep.programs.plan import PlanProcess, PlanRequest
from pixstep.programs.plan_data import PlanOptions
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from programbench import setup

MACHINE = """\
[clock]
pixel = "200 Hz"
[boards.main]
kind = "mega"
port = "/dev/ttyTEST"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "500 mm/s2" }
[motors.stage]
word = "Y"
axis = 2
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "250 mm/s2" }
"""
CORNER = "ABS LINEAR TA10 TS0 F20\nX1\nY-2\nX2 Y1\n"
PAIRS = 120  # of moves: several times what the queue takes
LONG = "INC TS0 TA20 TM40\n" + "X0.05 Y0.1\nX0.1 Y-0.05\n" * PAIRS


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Go to a folder with a machine file and programs."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "corner.pmc").write_text(CORNER)
    (tmp_path / "long.pmc").write_text(LONG)
    return tmp_path


# On a fake board


def test_a_program_runs_on_a_board(one, folder):
    text = one.out("run", "corner.pmc")
    assert text == (
        "board 1 axis 0: motor X done, made 800 steps, from position 0 to 800\n"
        "board 1 axis 2: motor stage done, made 1960 steps, from position 0 to 400\n"
    )
    assert ("arm", 0b0101, 0) in one.board.commands
    assert one.board.setting("pixel_hz_num") == 200
    found = one.json("run", "corner.pmc", "--no-check")
    assert [row["moved_steps"] for row in found["axes"]] == [800, 400]
    assert [row["position_steps"] for row in found["axes"]] == [1600, 800]


def test_a_closed_path_says_how_many_steps_it_made(one, folder):
    (folder / "closed.pmc").write_text("ABS LINEAR TA10 TS0 F20\nX4\nX0\n")
    text = one.out("run", "closed.pmc")
    made = made_by(one.board.axes[0])
    assert 3100 < made <= 3200  # the blend at the turn takes a little of both moves
    assert f"axis 0: motor X done, made {made} steps, from position 0 to 0\n" in text
    row = one.json("run", "closed.pmc")["axes"][0]
    assert (row["made_steps"], row["moved_steps"]) == (made, 0)
    assert (row["from_steps"], row["position_steps"]) == (0, 0)


def made_by(axis):
    """Return the steps of the last line of a fake axis, there and back."""
    places = [0, *(steps for _, steps in axis.records)]
    return sum(abs(after - before) for before, after in pairwise(places))


def test_the_board_gets_the_clock_of_the_machine_file(one, folder):
    """Its edges, how many are a pixel, and what lines are to them: whatever it had before."""
    one.out("set", "divider=5")
    one.json("run", "corner.pmc")
    assert (one.board.setting("pixel_hz_num"), one.board.setting("divider")) == (200, 1)
    assert set(one.board.said) == {1}
    path = folder / "machine.toml"
    clock = "[clock]\npixel = 600\ndivider = 3\nsync = 'free'\n"
    text = re.sub(r"\[clock\]\npixel = .*\n", clock, path.read_text())
    assert clock in text
    path.write_text(text)
    found = one.json("run", "corner.pmc")
    assert [row["moved_steps"] for row in found["axes"]] == [800, 400]
    names = ("pixel_hz_num", "divider", "sync")
    assert [one.board.setting(name) for name in names] == [600, 3, 0]


def test_a_program_longer_than_the_queue_is_streamed(one, folder):
    found = one.json("run", "long.pmc")
    steps = PAIRS * 400
    assert [row["state"] for row in found["axes"]] == ["done", "done"]
    assert [row["moved_steps"] for row in found["axes"]] == [0.15 * steps, 0.05 * steps]


def test_a_mistake_is_found_before_anything_moves(one, folder):
    (folder / "long.pmc").write_text(LONG + "SPLINE1 X1\n")
    text = one.err("run", "long.pmc", status=3)
    place = f"long.pmc:{2 * PAIRS + 2}:1"
    assert text == f"{place}: unknown word 'SPLINE1', known are: {KNOWN}"
    assert one.board.commands == [] and one.board.axes[0].state == "empty"


def test_without_the_check_a_mistake_stops_the_motors(one, folder):
    text = LONG + "X0.1\n" * 4000  # the beginning is planned before the end is read
    (folder / "long.pmc").write_text(text + "SPLINE1 X1\n")
    text = one.err("run", "long.pmc", "--no-check", "--window", 100, status=3)
    place = f"long.pmc:{2 * PAIRS + 4002}:1"
    wrong = f"{place}: unknown word 'SPLINE1', known are: {KNOWN}"
    assert text.startswith(f"{wrong} (stopped: board 1 axis 0 at pos")
    assert one.board.commands[-1] == ("stop", 0b0101, 0)


def test_ctrl_c_stops_a_program(one, folder):
    def interrupt():
        raise KeyboardInterrupt

    one.world.later(5, interrupt)
    text = one.ended("run", "long.pmc")
    assert text.startswith("stopped by Ctrl-C: board 1 axis 0 at position ")
    assert one.board.commands[-1] == ("stop", 0b0101, 0)


def test_a_fault_ends_a_program(one, folder):
    one.world.later(5, lambda: one.board.latch("limit_plus", 0, 0, 12))
    assert "fault limit_plus on axis 0 at pixel 12" in one.err("run", "long.pmc")


def test_what_the_board_would_refuse_is_not_sent(one, folder):
    one.out("set", "start_stop_steps=2", "max_acceleration=8")
    (folder / "turn.pmc").write_text("INC TS0 TA1 TM100\nX1\nX-1\n")
    text = one.err("run", "turn.pmc", status=3)
    assert text.startswith("turn.pmc: motor X: line refused: reversal_without_ramp at pixel ")
    assert ("arm", 1, 0) not in one.board.commands


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('kind = "mega"', 'kind = "m1284"', "axis = 2"),
        ('pixel = "200 Hz"', 'pixel = "0.1 Hz"', "0.1"),
        ('word = "Y"', 'word = "X"', "motor X has this word"),
    ],
)
def test_a_machine_that_does_not_fit(one, folder, old, new, message):
    (folder / "machine.toml").write_text(MACHINE.replace(old, new))
    done = one.finish("run", "corner.pmc")
    assert done.exit_code in (2, 3) and done.stderr.count("\n") == 1
    assert message in done.stderr and one.board.commands == []


def test_another_board_than_the_machine_s(two, folder):
    text = two.err("run", "corner.pmc", "--unit", 2, status=2)
    assert text == "axis 2: board 2 (uno) has axis 0 only"
    (folder / "machine.toml").write_text(MACHINE.replace("axis = 2", "axis = 1"))
    (folder / "other.toml").write_text(
        MACHINE.replace("[motors.X]", '[boards.other]\nkind = "uno"\nunit = 2\n[motors.X]')
        .replace("axis = 0", 'board = "main"\naxis = 0')
        .replace("axis = 2", 'board = "other"\naxis = 0')
    )
    words = ("run", "corner.pmc", "--machine", "other.toml", "--motor", "X")
    assert "a program streams to one board" in two.err(*words, status=2)
    assert "no machine file" in two.err("run", "corner.pmc", "--machine", "none", status=2)


# On the simulated Mega


@pytest.fixture
def mega():
    """Yield a simulated Mega's link."""
    link = SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(200)))
    yield link
    link.close()


@pytest.mark.usefixtures("simulator")
def test_a_program_runs_on_the_simulated_mega(mega, make_console, folder):
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "corner.pmc").write_text(CORNER)
    console = make_console(mega.simulator, mega.world)
    found = console.json("run", folder / "corner.pmc", "--machine", folder / "machine.toml")
    assert [row["state"] for row in found["axes"]] == ["done", "done"]
    assert [mega.simulator.steps(0, axis) for axis in (0, 2)] == [800, 400]


@pytest.mark.usefixtures("simulator")
def test_a_program_by_the_library(mega, folder):
    machine = px.Machine.load("machine.toml")
    program = px.read_program("corner.pmc", machine)
    made = program.plan()
    assert made.exceeded == () and made.report["moves"] == 3
    assert {axis: sum(line.counts) for axis, line in made.lines.items()} == {0: 800, 2: 400}
    assert {line.pixels for line in made.lines.values()} == {made.pixels}
    assert not made.lines[0].check("mega").refused
    moved = Board(mega, 1).run_program(px.read_program("long.pmc", machine))
    assert [(one.axis, one.state) for one in moved] == [(0, "done"), (2, "done")]
    assert [mega.simulator.steps(0, axis) for axis in (0, 2)] == [60 * PAIRS, 20 * PAIRS]
    with pytest.raises(px.UserError, match=r"none.pmc"):
        px.read_program("none.pmc", machine).plan()


def test_the_example_of_the_docstring(folder):
    (folder / "square.pmc").write_text(CORNER)
    done = doctest.testmod(importlib.import_module("pixstep.api.programs"))
    assert done.attempted == 2 and not done.failed


# Entries


class Endless:
    """A source whose first motor stands still."""

    over = False

    def __init__(self):
        self.given = 0

    def more(self, *, wait):
        self.given += 1000
        return np.stack([np.zeros(1000, dtype=int), np.arange(1000) % 5], axis=1)


def test_a_motor_that_stands_still_does_not_make_the_plan_run_ahead():
    source = Endless()
    entries = streaming.Entries(source, setup(1, 2).motors)
    still = entries.take(0, 512, wait=True)
    assert sum(repeat for _, repeat in still) == source.given <= 21_000
    assert entries.take(0, 512, wait=True) == []  # the other one has not taken its own yet
    moving = entries.take(1, 512, wait=True)
    assert len(moving) == 512 and source.given <= 21_000


def test_entries_are_runs_between_marks():
    class Few:
        over = False

        def __init__(self):
            self.parts = [np.array([[3], [3]]), np.array([[3], [5]]), np.zeros((70_000, 1), int)]

        def more(self, *, wait):
            self.over = not self.parts
            return self.parts.pop(0) if self.parts else None

    entries = streaming.Entries(Few(), setup(1, 1).motors)
    taken = entries.take(0, 100, wait=True)
    assert taken[0][0] & MARK_START and taken[1] == (0, 0) and taken[-1] == (MARK_END, 0)
    assert taken[2:4] == [(3, 3), (5, 1)]
    assert sum(repeat for _, repeat in taken[4:-1]) == 70_000
    assert {count for count, _ in taken[4:-1]} == {0}


@pytest.mark.parametrize(("ways", "given"), [((), 2000), ((-1,), 0)])
def test_a_smooth_line_begins_when_its_direction_is_known(ways, given):
    class Late:
        over = False
        given = 0

        def more(self, *, wait):
            self.given += 1000
            return np.full((1000, 1), 0 if self.given < 2000 else -2)

    source = Late()
    entries = streaming.Entries(source, setup(1, 1, smooth=True).motors, ways)
    mark = entries.take(0, 2, wait=True)[0][0]
    assert mark & MARK_SMOOTH and mark & MARK_NEGATIVE and source.given == given


# The process


def test_the_planner_s_process_makes_the_same_plan(folder):
    made = of_machine(MachineFile.load("machine.toml"))
    request = PlanRequest("long.pmc", made, PlanOptions())
    with PlanProcess(request) as source:
        parts = []
        while (part := source.more(wait=True)) is not None:
            parts.append(part)
    assert source.over and source.more(wait=True) is None
    assert np.array_equal(np.vstack(parts), np.vstack(list(request.parts())))
    assert all(len(one) <= 2048 for one, _ in pairwise(parts))


def test_a_planner_that_is_done_ends_without_a_word(folder, capfd):
    """Its pipe is still open then, and somebody waits for the end of it."""
    (folder / "corner.pmc").write_text(CORNER)
    request = PlanRequest("corner.pmc", of_machine(MachineFile.load("machine.toml")), PlanOptions())
    with PlanProcess(request) as source:
        while source.more(wait=True) is not None:
            pass
        assert source._process.wait(timeout=30) == 0
    assert capfd.readouterr().err == ""


def test_a_planner_that_is_not_needed_any_more_ends(folder):
    (folder / "long.pmc").write_text(LONG * 50)
    request = PlanRequest("long.pmc", of_machine(MachineFile.load("machine.toml")), PlanOptions())
    with PlanProcess(request) as source:
        assert source.more(wait=True) is not None
    assert source._process.returncode is not None


KILLED = """\
import time
from pixstep.machine.files import MachineFile
from pixstep.programs.motors import of_machine
from pixstep.programs.plan import PlanProcess, PlanRequest
from pixstep.programs.plan_data import PlanOptions

setup = of_machine(MachineFile.load("machine.toml"))
with PlanProcess(PlanRequest("silent", setup, PlanOptions())) as source:
    print(source._process.pid, flush=True)
    time.sleep(60)
"""


def test_a_planner_ends_with_a_command_that_is_killed(folder):
    os.mkfifo("silent")  # a program that nobody writes: its planner waits without a word
    words = [sys.executable, "-c", KILLED]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as command:
        planner = psutil.Process(int(command.stdout.readline()))
        command.kill()
    left = 100
    while left and planner.is_running() and planner.status() != psutil.STATUS_ZOMBIE:
        left -= 1
        time.sleep(0.1)
    assert left, "the planner outlives its command"


def test_a_planner_that_cannot_be_asked_ends(folder, monkeypatch):
    started = []
    monkeypatch.setattr(
        plan.pickle, "dump", lambda *_: started.append(psutil.Process().children()) or 1 / 0
    )
    request = PlanRequest("long.pmc", of_machine(MachineFile.load("machine.toml")), PlanOptions())
    with pytest.raises(ZeroDivisionError), PlanProcess(request):
        pass
    assert started[0] and not any(child.is_running() for child in started[0])


def test_a_planner_that_dies_is_an_error(folder):
    request = PlanRequest("long.pmc", of_machine(MachineFile.load("machine.toml")), PlanOptions())
    with PlanProcess(request) as source:
        source._process.kill()
        with pytest.raises(PlainError, match=r"long.pmc: the planner has ended"):
            while True:
                source.more(wait=True)
